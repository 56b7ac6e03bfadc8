"""Times as they are written, with a unit or as a plain number of seconds."""

from __future__ import annotations

import re
from contextlib import suppress
from math import isfinite, nan

from fmus.errors import shown

UNITS = {"us": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0}
"""What a time may be given in, in s."""

_TIME = re.compile(r"\s*(?P<number>[-+]?[.\d]+(?:[eE][-+]?\d+)?)\s*(?P<unit>[^\s\d.]*)\s*", re.ASCII)


def time(text: str) -> float:
    """Read a time [s] with or without a unit; ValueError if it is none."""
    match = _TIME.fullmatch(text)
    found = nan
    if match is not None:
        with suppress(ValueError):
            found = float(match["number"]) * UNITS.get(match["unit"], 1.0)
    if match is None or not isfinite(found):
        raise ValueError(f"{shown(repr(text))} is not a time, write 120s, 0.1s, 5ms, 2min or 1h")
    if match["unit"] and match["unit"] not in UNITS:
        raise ValueError(f"{shown(repr(text))} is not a time: {no_unit(match['unit'])}")
    return found


def no_unit(word: str) -> str:
    """Say that a word is no unit of time, and which there are."""
    return f"{shown(repr(word), 40)} is no unit, use {' or '.join(UNITS)}"
