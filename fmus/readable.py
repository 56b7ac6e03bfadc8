"""What fmpy can read of a modelDescription.xml, and references that it would stumble over."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from typing import Any

from lxml import etree


def for_fmpy(content: bytes, root: Any) -> io.BytesIO:
    """Return an archive of what fmpy can read of a description: without what it stumbles over though it is valid.

    That is a declared type of a clock, and more than one space between the entries of a list.
    """
    cleaned = False
    for element in root.iter("Clock"):
        cleaned = element.attrib.pop("declaredType", None) is not None or cleaned
    for element in root.iter():
        for name in ("dependencies", "dependenciesKind", "clocks"):
            text = element.get(name)
            if text is not None and text != " ".join(text.split()):
                element.set(name, " ".join(text.split()))
                cleaned = True
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as writer:
        writer.writestr("modelDescription.xml", etree.tostring(root) if cleaned else content)
    archive.seek(0)
    return archive


def unresolved(root: Any) -> Iterator[str]:
    """Name the variables whose display unit has no unit, and in FMI 3 sizes and clocks that are not there."""
    yield from _display_units(root)
    if not root.get("fmiVersion", "").startswith("3."):
        return
    variables = [element for element in root.iterfind("ModelVariables/*") if isinstance(element.tag, str)]
    known = {element.get("valueReference"): element for element in variables}
    for element in variables:
        for number in element.get("clocks", "").split():
            if number not in known:
                yield f"{element.get('name')}: no variable has the value reference {number} of its clocks"
        for number in (d.get("valueReference") for d in element.findall("Dimension") if d.get("start") is None):
            if number is None:
                yield f"{element.get('name')}: a Dimension has neither start nor valueReference"
            elif number not in known:
                yield f"{element.get('name')}: no variable has the value reference {number} of its dimension"
            elif not (text := known[number].get("start", "")).strip().isdecimal():
                name = known[number].get("name")
                yield f"{element.get('name')}: its size {name} starts at {text or 'nothing'}, expected a whole number"


def _display_units(root: Any) -> Iterator[str]:
    types = {element.get("name"): element for element in root.iterfind("TypeDefinitions/*")}
    for variable in root.iterfind("ModelVariables/*"):
        of_fmi2 = variable.tag == "ScalarVariable"
        carrier = variable[0] if of_fmi2 and len(variable) else variable
        declared = types.get(carrier.get("declaredType"))
        definition = declared[0] if of_fmi2 and declared is not None and len(declared) else declared
        if carrier.get("unit") is None and (definition is None or definition.get("unit") is None):
            for element, name in [
                (carrier, variable.get("name")),
                *((a, a.get("name")) for a in variable.iter("Alias")),
            ]:
                if element.get("displayUnit") is not None:
                    yield f"{name}: display unit {element.get('displayUnit')}, but no unit is given"
