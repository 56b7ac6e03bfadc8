"""What the variables of a modelDescription.xml refer to: other variables, declared types, sizes, units."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any


def unresolved(root: Any) -> Iterator[str]:
    """Name what refers to nothing, or to what cannot be meant; the schema, which is applied later, does not see it."""
    third = str(root.get("fmiVersion")).startswith("3")
    variables = [element for element in root.iterfind("ModelVariables/*") if isinstance(element.tag, str)]
    numbers = (_number(e.get("valueReference")) for e in variables) if third else range(1, len(variables) + 1)
    known = dict(zip(numbers, variables, strict=True))
    definitions = (e for e in root.iterfind("TypeDefinitions/*") if isinstance(e.tag, str))
    types = {element.get("name"): element for element in definitions}
    what = "value reference" if third else "index"
    for variable in variables:
        where = f"{variable.get('name')} (line {variable.sourceline})"
        for attribute, text in _references(variable):
            if _number(text) is not None and _number(text) not in known:
                yield f"{where}: {attribute} refers to the {what} {text}, which no variable has"
            elif attribute == "clocks" and _number(text) is not None and known[_number(text)].tag != "Clock":
                yield f"{where}: clocks refers to {known[_number(text)].get('name')}, which is no clock"
        for element in variable.iter():
            declared = element.get("declaredType") if isinstance(element.tag, str) else None
            if declared is not None and declared not in types:
                yield f"{where}: declaredType refers to {declared!r}, which TypeDefinitions does not define"
        for dimension in variable.iterfind("Dimension"):
            if dimension.get("start") is None:
                yield from (f"{where}: {text}" for text in _size(dimension, known))
        yield from _display_units(variable, types)


def _references(variable: Any) -> Iterator[tuple[str, str]]:
    """Yield the attributes of a variable, and of what is in it, that name other variables, with each name."""
    for element in variable.iter():
        if not isinstance(element.tag, str):
            continue
        for attribute in ("derivative", "previous", "clocks"):
            for text in element.get(attribute, "").split():
                yield attribute, text
        if element.tag == "Dimension" and element.get("valueReference") is not None:
            yield "Dimension", element.get("valueReference")


def _size(dimension: Any, known: dict[int | None, Any]) -> Iterator[str]:
    number = dimension.get("valueReference")
    if number is None:
        yield "a Dimension has neither start nor valueReference"
    elif (size := known.get(_number(number))) is not None and _number(start := size.get("start", "")) is None:
        yield f"its size {size.get('name')} starts at {start or 'nothing'}, expected a whole number"


def _display_units(variable: Any, types: dict[str, Any]) -> Iterator[str]:
    of_fmi2 = variable.tag == "ScalarVariable"
    carrier = variable[0] if of_fmi2 and len(variable) else variable
    declared = types.get(carrier.get("declaredType"))
    definition = declared[0] if of_fmi2 and declared is not None and len(declared) else declared
    if carrier.get("unit") is None and (definition is None or definition.get("unit") is None):
        named = [(carrier, variable.get("name")), *((a, a.get("name")) for a in variable.iter("Alias"))]
        for element, name in named:
            if element.get("displayUnit") is not None:
                yield f"{name}: display unit {element.get('displayUnit')}, but no unit is given"


def _number(text: str | None) -> int | None:
    stripped = (text or "").strip()
    return int(stripped) if stripped.isdecimal() else None
