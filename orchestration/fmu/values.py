"""Start values written as text: numbers, true or false, arrays of them; in any unit that the FMU declares."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from fmus.errors import AdcsError, shown
from fmus.spelling import some
from orchestration.fmu.description import DisplayUnit
from orchestration.fmu.file import Fmu, Port

_WITH_A_UNIT = re.compile(r"(?P<value>[-+\d.,eE\s\[\]]*[\d\]])\s*(?P<unit>[^\d\s,.\[\]][^,\[\]]*)")
_DEEPEST = 30  # lists in each other, which is as many dimensions as anybody has


def parse_value(fmu: Fmu, port: Port, text: str) -> Any:
    """`0.05deg` -> 0.000872.., `1,2,3` and `[[1,2],[3,4]]` -> arrays. Without a unit the value is in the port's own.

    A text stands as it is, an array of texts (or of binary values) as `["a","b"]`. Of an array of one element, the
    value of that is enough.
    """
    value = _texts(port, text) if port.type in ("String", "Binary") else _numbers(fmu, port, text)
    if port.size == 1 and not isinstance(value, list) and np.ndim(value) < len(port.shape):
        return np.full(port.shape, value, dtype=object).tolist()
    return value


def _texts(port: Port, text: str) -> Any:
    if not port.shape:
        return text
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):  # no JSON, or brackets without end
        value = None
    if isinstance(value, list) and _all_texts(value):
        return value
    if port.size == 1 and not isinstance(value, list):
        return text
    raise AdcsError(f"""{port.name} = {shown(repr(text))} cannot be read: write a list of texts, '["a","b"]'""")


def _all_texts(value: Any, depth: int = _DEEPEST) -> bool:
    if isinstance(value, list):
        return depth > 0 and all(_all_texts(entry, depth - 1) for entry in value)
    return isinstance(value, str)


def _numbers(fmu: Fmu, port: Port, text: str) -> Any:
    words = text.strip()
    names = {name for name, _ in port.items}
    if names.issuperset(entries := [entry.strip() for entry in words.split(",")]):
        return entries if port.shape else entries[0]
    unit = None
    units = _units(fmu, port)
    for name in sorted(units, key=len, reverse=True):
        if words.endswith(name) and not _is_json(words):
            words = words.removesuffix(name).strip()
            unit = units[name]
            break
    if not _is_json(words):
        raise _unreadable(port, text, words, units)
    value = json.loads(words) if _is_json(words, bare=True) else json.loads(f"[{words}]")
    return value if unit is None or unit.plain else _converted(value, unit, port, text)


def _unreadable(port: Port, text: str, words: str, units: Iterable[str]) -> AdcsError:
    """Say what is wrong with a text: if it is the unit alone, which there are."""
    known = " or ".join(units)
    odd = _WITH_A_UNIT.fullmatch(words)
    if odd and _is_json(odd["value"]) and (known or not port.items):
        way = f"is no unit of it: use {known}" if known else "is taken for a unit, and it has none: leave that out"
        return AdcsError(f"{port.name} = {shown(repr(text))}: {shown(repr(odd['unit']), 40)} {way}")
    known = f", in {known}" if known else ""
    known += f", or {some(repr(name) for name, _ in port.items)}" if port.items else ""
    return AdcsError(
        f"{port.name} = {shown(repr(text))} cannot be read: write a number, or 1,2,3, or [[1,2],[3,4]]{known}"
    )


def _units(fmu: Fmu, port: Port) -> dict[str, DisplayUnit]:
    """Return the units in which a value may be given, by name; its own is the first."""
    if port.unit is None:
        return {}
    others = (replace(u, offset=0.0) if port.relative else u for u in fmu.display_units.get(port.unit, ()))
    return {port.unit: DisplayUnit(port.unit), **{unit.name: unit for unit in others}}


def _converted(value: Any, unit: DisplayUnit, port: Port, text: str) -> Any:
    """Return in its own unit what is given in a display unit of it."""
    try:
        array = np.asarray(value, float)
        with np.errstate(all="ignore"):  # what comes of it is looked at
            own = unit.factor / array if unit.inverse else (array - unit.offset) / unit.factor
            own = np.where(unit.sound & np.isfinite(array), own, np.nan)  # else it might be 0, as 1 / inf is
    except (ValueError, TypeError, OverflowError):  # rows of different lengths, or no numbers
        raise AdcsError(f"{port.name} = {shown(repr(text))}: expected numbers before {unit.name!r}") from None
    if not np.isfinite(own).all():
        raise AdcsError(f"{port.name} = {shown(repr(text))} is not finite in {port.unit}: expected a finite number")
    return own


def _is_json(text: str, bare: bool = False) -> bool:
    try:
        json.loads(text if bare else f"[{text}]")
    except (ValueError, RecursionError):  # no JSON, or brackets without end
        return False
    return bool(text.strip())
