"""Attributes that the schema of FMI allows one by one, and that make no sense: ranges, scales, items, sizes."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from typing import Any

from fmus.declared_types import carrier
from fmus.spelling import some

_RANGE = ("min", "max")


def check_attributes(root: Any) -> Iterator[str]:
    """Look at units, types and variables; what a variable has from its type is said of the type.

    The variables have the attributes of their types by now (`give_defaults`).
    """
    units = {unit.get("name") for unit in root.iterfind("UnitDefinitions/Unit")}
    for unit in root.iterfind("UnitDefinitions/Unit"):
        for element in (*unit.iterfind("BaseUnit"), *unit.iterfind("DisplayUnit")):
            factor = float(element.get("factor", "1"))
            name = f"display unit {element.get('name')}" if element.tag == "DisplayUnit" else "base unit"
            if factor == 0 or not math.isfinite(factor):
                yield f"unit {unit.get('name')}: its {name} has the factor {factor:g}, expected a number that is not 0"
            if not math.isfinite(offset := float(element.get("offset", "0"))):
                yield f"unit {unit.get('name')}: its {name} has the offset {offset:g}, expected a number"
    types = _carriers(root, "TypeDefinitions/*")
    variables = _carriers(root, "ModelVariables/*")
    used = {element.get("declaredType") for element in variables.values()}
    for name, element in types.items():
        yield from (f"type {name}: {text}" for text in (*_range(element), *_nominal(element), *_items(element)))
        if name not in used and element.get("unit") is not None and element.get("unit") not in units:
            yield f"type {name}: unit {element.get('unit')} is not defined"
    for name, element in variables.items():
        declared = types.get(element.get("declaredType"), {})
        if any(element.get(limit) != declared.get(limit) for limit in _RANGE):
            yield from (f"{name}: {text}" for text in _range(element))
        if element.get("nominal") != declared.get("nominal"):
            yield from (f"{name}: {text}" for text in _nominal(element))
        yield from (f"{name}: {text}" for text in (*_too_long(element), *_no_item(element, declared)))


def _carriers(root: Any, path: str) -> dict[str, Any]:
    """Return the elements with the attributes of each kind, by name."""
    found = ((e.get("name"), carrier(e)) for e in root.iterfind(path) if isinstance(e.tag, str))
    return {name: element for name, element in found if element is not None}


def _range(element: Any) -> Iterator[str]:
    low, high = (float(element.get(limit, default)) for limit, default in zip(_RANGE, ("-inf", "inf"), strict=True))
    for limit, value in zip(_RANGE, (low, high), strict=True):
        if math.isnan(value):
            yield f"{limit} is not a number"
    if low > high:
        yield f"min {element.get('min')} is above max {element.get('max')}"


def _nominal(element: Any) -> Iterator[str]:
    nominal = float(element.get("nominal", "1"))
    if not (nominal > 0 and math.isfinite(nominal)):
        yield f"nominal {element.get('nominal')}, expected a positive number"


def _items(element: Any) -> Iterator[str]:
    """Equal names, and equal numbers, of the items of an enumeration."""
    items = element.findall("Item")
    for what in ("name", "value"):
        for text, count in Counter((item.get(what) or "").strip() for item in items).items():
            if count > 1:
                yield f"{count} items have the {what} {text}"


def _no_item(element: Any, declared: Any) -> Iterator[str]:
    """Start values of an enumeration that are the value of none of its items within min and max."""
    if element.tag != "Enumeration" or not len(declared):
        return
    low, high = (float(element.get(limit, default)) for limit, default in zip(_RANGE, ("-inf", "inf"), strict=True))
    values = [v for item in declared.findall("Item") if low <= (v := int(item.get("value"))) <= high]
    for start in dict.fromkeys(map(int, element.get("start", "").split())):
        if start not in values:
            yield f"start {start} is the value of no item, expected one of {some(values)}"


def _too_long(element: Any) -> Iterator[str]:
    """Start values of a Binary variable with more bytes than it may have."""
    most = element.get("maxSize")
    if element.tag != "Binary" or most is None:
        return
    for start in element.findall("Start"):
        size = len("".join(start.get("value", "").split())) // 2
        if size > int(most):
            yield f"start has {size} bytes, its maxSize is {most}"
