"""What the variables of a modelDescription.xml refer to: other variables, and declared types."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any


def check_references(root: Any) -> None:
    """Refuse by name (ValueError) a variable that refers to a variable or type that is not there.

    What the schema sees, which is applied later, is not looked at here.
    """
    third = str(root.get("fmiVersion")).startswith("3")
    variables = [element for element in root.iterfind("ModelVariables/*") if isinstance(element.tag, str)]
    known = {_number(e.get("valueReference")) for e in variables} if third else set(range(1, len(variables) + 1))
    definitions = root.iterfind("TypeDefinitions/*")
    types = {element.get("name") for element in definitions if isinstance(element.tag, str)}
    what = "value reference" if third else "index"
    for variable in variables:
        where = f"{variable.get('name')} (line {variable.sourceline})"
        for attribute, text in _references(variable):
            if _number(text) is not None and _number(text) not in known:
                raise ValueError(f"{where}: {attribute} refers to the {what} {text}, which no variable has")
        for element in variable.iter():
            declared = element.get("declaredType") if isinstance(element.tag, str) else None
            if declared is not None and declared not in types:
                raise ValueError(f"{where}: declaredType refers to {declared!r}, which TypeDefinitions does not define")


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


def _number(text: str | None) -> int | None:
    stripped = (text or "").strip()
    return int(stripped) if stripped.isdecimal() else None
