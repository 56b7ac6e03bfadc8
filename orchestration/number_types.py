"""Which numbers the types of FMI hold, and which a double hands on whole. The compiled loop has its own twin of it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

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

    The reason is to be put behind the number. Integers are judged as they are; a floating-point number beyond 2^53 may
    have been another integer, and is refused for a type of integers.
    """
    if type_.startswith("Float") or (isinstance(values, np.ndarray) and values.dtype.kind == "f"):
        return _first_wrong(type_, np.asarray(values, float))
    low, high = RANGES[type_]
    for i, value in enumerate(np.asarray(values, object).ravel().tolist()):  # numpy makes doubles of mixed integers
        if isinstance(value, float):
            if (misfit := _first_wrong(type_, np.array([value]))) is not None:
                return i, misfit[1]
        elif not low <= value <= high:
            return i, _outside(type_)
    return None


def _first_wrong(type_: str, values: Floats) -> tuple[int, str] | None:
    size = np.abs(values)
    rules = [(~np.isfinite(values), " is not finite")]
    if type_ == "Float32":
        rules.append((size >= _FLOAT32_END, _outside(type_)))
    elif type_ in RANGES:
        low, high = RANGES[type_]
        rules.append((values != np.trunc(values), ": expected an integer"))
        rules.append(((values < low) | (values > high), _outside(type_)))
        rules.append((size > EXACT, BEYOND))
    wrong = np.flatnonzero(np.logical_or.reduce([found for found, _ in rules]))
    if not len(wrong):
        return None
    first = int(wrong[0])
    return first, next(why for found, why in rules if found.flat[first])


def first_beyond(values: Iterable[Any]) -> int | None:
    """Return the index of the first integer that a double may not hold; None if all can be handed on as doubles."""
    return next((i for i, value in enumerate(values) if abs(value) > EXACT), None)


def _outside(type_: str) -> str:
    return f" is outside the range of {type_}"
