"""Which numbers the types of FMI hold, and which a double hands on whole. The compiled loop has its own twin of it."""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

EXACT = 2**53
"""Above, a double does not hold every integer, and one that is there may have been another."""

RANGES = {"Boolean": (0, 1)} | {
    f"{sign}Int{bits}": (0, 2**bits - 1) if sign else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    for bits in (8, 16, 32, 64)
    for sign in ("", "U")
}
_FLOAT32_END = 2.0**128 - 2.0**103  # from here on rounding to a Float32 gives infinity

BEYOND = " is beyond 2^53, and cannot be handed on or recorded exactly"


def first_misfit(type_: str, values: NDArray[Any] | Iterable[Any]) -> tuple[int, str] | None:
    """Return the index of the first number that is no value of a numeric type, and why not; None if all are.

    The reason is to be put behind the number.
    """
    if isinstance(values, np.ndarray):
        if type_ == "Float64" and values.dtype.kind == "f" and np.isfinite(values).all():
            return None  # as nearly always
        values = values.ravel().tolist()
    return next(((i, why) for i, value in enumerate(values) if (why := _misfit(type_, value))), None)


def _misfit(type_: str, value: Any) -> str:
    """Say why a number is no value of a type; nothing if it is one.

    An integer is judged as it is; a floating-point number beyond 2^53 may have been another one, and is refused for a
    type of integers.
    """
    if isinstance(value, int | np.integer | np.bool_):
        low, high = RANGES.get(type_, (value, value))
        return "" if low <= value <= high else _outside(type_)
    number = float(value)
    if not isfinite(number):
        return " is not finite"
    if type_ == "Float32":
        return "" if abs(number) < _FLOAT32_END else _outside(type_)
    if type_ == "Float64":
        return ""
    low, high = RANGES[type_]
    if not number.is_integer():
        return ": expected an integer"
    if not low <= number <= high:
        return _outside(type_)
    return BEYOND if abs(number) > EXACT else ""


def first_beyond(values: Iterable[Any]) -> int | None:
    """Return the index of the first integer that a double may not hold; None if all can be handed on as doubles."""
    return next((i for i, value in enumerate(values) if abs(value) > EXACT), None)


def _outside(type_: str) -> str:
    return f" is outside the range of {type_}"
