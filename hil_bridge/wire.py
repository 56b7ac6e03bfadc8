"""Numbers as the fields of a message can hold them: clamped, wrapped, or said to be unknown."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

U16_UNKNOWN = 65535
FLOAT32_MOST = 3.4028234e38

_NAME = 10  # characters of DEBUG_VECT, NAMED_VALUE_FLOAT, DEBUG_FLOAT_ARRAY


def clamped(value: float, bits: int, unknown: int = 0) -> int:
    """Round to a signed integer of so many bits, at its limit if it is beyond; `unknown` for what is not a number."""
    if value != value:
        return unknown
    most = (1 << (bits - 1)) - 1
    return most if value >= most else -most if value <= -most else round(value)


def float32(value: float) -> float:
    """A number that a float32 field takes: at the largest if it is beyond. What is not finite stays so."""
    if not isfinite(value):
        return value
    return max(-FLOAT32_MOST, min(FLOAT32_MOST, value))


def floats(values: Sequence[float]) -> list[float]:
    """Numbers that float32 fields take."""
    return [float32(value) for value in values]


def milliseconds(t: float) -> int:
    """Time since start [s] for `time_boot_ms`, which wraps after 49.7 days."""
    return round(t * 1e3) & 0xFFFFFFFF


def microseconds(t: float) -> int:
    """Time [s] for fields of 64 bits."""
    return max(0, round(t * 1e6))


def name10(text: str) -> bytes:
    """A name of at most ten characters."""
    return text.encode("ascii", "replace")[:_NAME]


def texts(text: str) -> list[bytes]:
    """A text in pieces of the 50 bytes that a STATUSTEXT holds."""
    data = text.encode("utf-8", "replace")
    return [data[i : i + 50] for i in range(0, len(data), 50)] or [b""]
