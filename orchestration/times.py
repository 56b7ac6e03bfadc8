"""Times as people give them: a number of seconds, or a text with a unit."""

from __future__ import annotations

import re
from decimal import Decimal
from math import isfinite

from fmus.errors import shown

Seconds = float | str
"""A time [s], or a text with its unit: 20, "20s", "2min"."""

_UNITS = {"": "1", "us": "1e-6", "ms": "1e-3", "s": "1", "min": "60", "h": "3600"}  # s


def seconds(text: str) -> float:
    """Read a time [s] with or without a unit; ValueError if it is none."""
    match = re.fullmatch(r"\s*(?P<number>[-+.\deE]+)\s*(?P<unit>us|ms|s|min|h|)\s*", text, re.ASCII)
    try:
        found = float(Decimal(match["number"]) * Decimal(_UNITS[match["unit"]]))  # type: ignore[index]
        if not isfinite(found):
            raise ValueError
        return found
    except (TypeError, ValueError, ArithmeticError):
        raise ValueError(f"{shown(repr(text))} is not a time, write 120s, 0.1s, 5ms, 2min or 1h") from None
