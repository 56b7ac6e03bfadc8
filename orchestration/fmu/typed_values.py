"""Values that are no plain numbers: enumerations by the names of their items, binary values as text."""

from __future__ import annotations

import base64
import binascii
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.errors import AdcsError
from fmus.spelling import some
from orchestration.fmu.file import Port

_BASE64 = "base64:"


def item_numbers(name: str, port: Port, value: Any) -> Any:
    """Return a value for an enumeration with the names of items replaced by their numbers; refuse numbers of none."""
    if not port.items:
        return value
    numbers = dict(port.items)
    known = f"use {some(f'{item!r} or {number}' for item, number in port.items)}"

    def number(entry: Any) -> Any:
        if isinstance(entry, list | tuple):
            return [number(e) for e in entry]
        if isinstance(entry, str) and entry in numbers:
            return numbers[entry]
        if isinstance(entry, str | bool) or entry not in numbers.values():
            raise AdcsError(f"{name} = {entry!r} is no item of this enumeration: {known}")
        return int(entry)

    return number(value.tolist() if isinstance(value, np.ndarray | np.generic) else value)


def item_name(port: Port, number: float) -> str:
    """Return the name of an item of an enumeration, or the number where none has it."""
    return next((name for name, value in port.items if value == number), f"{number:g}")


def binary_values(name: str, port: Port, value: Any) -> tuple[bytes, ...]:
    """Return values of type Binary flat: bytes, or text in hexadecimal digits or, after `base64:`, in base64."""

    def one(entry: Any) -> list[bytes]:
        if isinstance(entry, list | tuple):
            return [content for e in entry for content in one(e)]
        if isinstance(entry, bytes | bytearray):
            return [bytes(entry)]
        if not isinstance(entry, str):
            raise AdcsError(f"{name} = {entry!r}: expected bytes, or a text in hexadecimal digits or as base64:...")
        try:
            if entry.startswith(_BASE64):
                return [base64.b64decode(entry.removeprefix(_BASE64), validate=True)]
            return [bytes.fromhex(entry)]
        except (ValueError, binascii.Error):
            raise AdcsError(
                f"{name} = {entry!r} is neither hexadecimal digits, two for a byte, nor base64:... with valid base64"
            ) from None

    value = value.tolist() if isinstance(value, np.ndarray) else value
    found = tuple(one(value))
    try:
        shape = np.shape(_places(value))
    except ValueError:  # rows of different lengths
        raise AdcsError(f"{name} = {value!r}: expected {size_text(port.shape)}") from None
    if shape != port.shape:
        raise AdcsError(f"{name}: expected {size_text(port.shape)}, got {size_text(shape)}")
    longest = max(map(len, found), default=0)
    if port.max_size is not None and longest > port.max_size:
        raise AdcsError(f"{name} has {longest} bytes: expected at most {port.max_size} (maxSize)")
    return found


def size_text(shape: tuple[int, ...]) -> str:
    """`(2, 3)` -> `2 x 3 values`."""
    return f"{' x '.join(map(str, shape))} values" if shape else "a single value"


def _places(value: Any) -> Any:
    """Return the same lists with a number in every place, of which numpy knows the shape."""
    return [_places(entry) for entry in value] if isinstance(value, list | tuple) else 0


def typed(values: NDArray[np.float64], port: Port) -> Any:
    """Return numbers as what they are: Boolean values as bool, integers as int64."""
    if port.type == "Boolean":
        return values != 0
    return values if port.type.startswith("Float") else values.astype(np.int64)
