"""Times as people give them: a number of seconds, or a text with a unit."""

from __future__ import annotations

import re
from contextlib import suppress
from decimal import Decimal, InvalidOperation
from math import isfinite, nan

from fmus.errors import shown

Seconds = float | str
"""A time [s], or a text with its unit: 20, "20s", "2min"."""

UNITS = {"us": "1e-6", "ms": "1e-3", "s": "1", "min": "60", "h": "3600"}
"""What a time may be given in, in s."""

_TIME = re.compile(r"\s*(?P<number>[-+]?[.\d]+(?:[eE][-+]?\d+)?)\s*(?P<unit>[^\s\d.]*)\s*", re.ASCII)


def seconds(text: str) -> float:
    """Read a time [s] with or without a unit; ValueError if it is none."""
    match = _TIME.fullmatch(text)
    found = nan
    if match is not None:
        with suppress(InvalidOperation):
            found = float(Decimal(match["number"]) * Decimal(UNITS.get(match["unit"], "1")))
    if match is None or not isfinite(found):
        raise ValueError(f"{shown(repr(text))} is not a time, write 120s, 0.1s, 5ms, 2min or 1h")
    if match["unit"] and match["unit"] not in UNITS:
        raise ValueError(f"{shown(repr(text))} is not a time: {no_unit(match['unit'])}")
    return found


def no_unit(word: str) -> str:
    """Say that a word is no unit of time, and which there are."""
    return f"{shown(repr(word), 40)} is no unit, use {' or '.join(UNITS)}"
