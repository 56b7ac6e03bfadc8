"""Declared types: what a type definition says, each variable of that type says, where it says nothing itself."""

from __future__ import annotations

from typing import Any

from fmus.versions import major_version

_OF_THE_TYPE = ("name", "description")
_UNFIT_BESIDE = {
    "displayUnit": "unit",
    "intervalCounter": "intervalDecimal",
    "intervalDecimal": "intervalCounter",
    "shiftCounter": "shiftDecimal",
    "shiftDecimal": "shiftCounter",
}
"""What of a type does not count beside what the variable says: display units of another unit, other forms of times."""


def give_defaults(root: Any) -> bool:
    """Give each variable of a modelDescription.xml the attributes of its type that it does not have; say if any were.

    ValueError names a variable whose type is of another kind; one that is not there is no business of this.
    """
    fmi2 = major_version(root.get("fmiVersion")) == 2
    types = {element.get("name"): carrier(element) for element in _elements(root.find("TypeDefinitions"))}
    given = False
    for element in _elements(root.find("ModelVariables")):
        variable = carrier(element)
        declared = None if variable is None else variable.get("declaredType")
        kind = types.get(declared)
        if kind is None:
            continue
        expected = variable.tag if fmi2 else f"{variable.tag}Type"
        if kind.tag != expected:
            raise ValueError(
                f"line {element.sourceline}: {element.get('name')} has the type {declared!r}, "
                f"which is of the kind {kind.tag}, expected {expected}"
            )
        own = set(variable.attrib)
        for name, value in kind.attrib.items():
            if (fmi2 or name not in _OF_THE_TYPE) and name not in own and _UNFIT_BESIDE.get(name) not in own:
                variable.set(name, value)
                given = True
    return given


def carrier(element: Any) -> Any:
    """Return the element of a variable or type that has the attributes of its kind: in FMI 2 it is inside."""
    if element.tag in ("ScalarVariable", "SimpleType"):
        return next((child for child in _elements(element) if child.tag != "Annotations"), None)
    return element


def _elements(parent: Any) -> list[Any]:
    return [] if parent is None else [child for child in parent if isinstance(child.tag, str)]


def without_what_fmpy_lacks(root: Any) -> bool:
    """Take out what fmpy does not know of a type: the attributes of Binary ones. `give_defaults` comes before."""
    found = False
    for element in root.iterfind("TypeDefinitions/BinaryType"):
        for name in ("mimeType", "maxSize"):
            found = element.attrib.pop(name, None) is not None or found
    return found
