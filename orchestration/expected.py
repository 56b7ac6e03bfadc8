"""Refuses arguments of a wrong type in one line, with what was expected instead."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from math import isnan
from os import PathLike
from typing import Any, get_args

import numpy as np

from fmus.errors import AdcsError, shown
from orchestration import times


def refused(name: str, value: object, expected: str) -> AdcsError:
    """Return the refusal of a value for an argument."""
    return AdcsError(f"{name} = {shown(repr(value))}: expected {expected}")


def number(name: str, value: object) -> float:
    """Return a real number; refuse what is none. Whether it is a sensible one is for others to say."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            raise AdcsError(f"{name} is beyond the range of numbers: expected one below 1e308") from None
    quoted = isinstance(value, str) and not isnan(_as_number(value))
    raise refused(name, value, f"a number, {shown(str(value))} without quotes" if quoted else "a number")


def seconds(name: str, value: object) -> float:
    """Return a time [s]: a number, or a text with its unit; refuse anything else."""
    if not isinstance(value, str) or not isnan(_as_number(value)):
        return number(name, value)
    try:
        return times.seconds(value)
    except ValueError as error:
        raise AdcsError(f"{name}: {error}") from None


def count(name: str, value: object, what: str, least: int = 1) -> int:
    """Return a whole number; refuse what is none, too small, or beyond what a double counts. `what` was expected."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise refused(name, value, f"{what} from {least}")
    if not least <= value <= _MOST:
        raise refused(name, int(value), f"{what} from {least}" + (" to 2^53" if value > _MOST else ""))
    return int(value)


def text(name: str, value: object) -> None:
    """Refuse what is no text."""
    if not isinstance(value, str):
        raise refused(name, value, "a text")


def texts(name: str, value: object) -> None:
    """Refuse what is no list of texts; a single text, too, as its letters would be taken for texts."""
    if isinstance(value, str):
        raise refused(name, value, f"a list, [{shown(repr(value))}]")
    for entry in collection(name, value):
        if not isinstance(entry, str):
            raise AdcsError(f"{name}: {shown(repr(entry))} is no text: expected a list of texts")


def collection(name: str, value: object) -> Collection[Any]:
    """Return a list or what is like one; refuse what is not, or can be gone through only once."""
    if isinstance(value, str | bytes | Mapping) or not isinstance(value, Collection):
        raise refused(name, value, "a list")
    return value


def path(name: str, value: object) -> None:
    """Refuse what is no name of a file."""
    if not isinstance(value, str | PathLike):
        raise refused(name, value, "the name of a file")


def by_name(name: str, value: object) -> None:
    """Refuse what does not map texts to something."""
    if not isinstance(value, Mapping):
        raise refused(name, value, "a dict, {name: value}")
    texts(name, list(value))


def choice(name: str, value: object, options: Any) -> None:
    """Refuse what is none of the options, a `Literal`."""
    if not isinstance(value, str) or value not in get_args(options):
        raise AdcsError(f"{name} = {value!r} is unknown: use {' or '.join(map(repr, get_args(options)))}")


_MOST = 2**53  # beyond, not every whole number is a double


def _as_number(value: str) -> float:
    try:
        return float(value)
    except ValueError:
        return float("nan")
