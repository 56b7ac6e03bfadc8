"""A modelDescription.xml as fmpy can read it."""

from __future__ import annotations

import io
import zipfile
from typing import TYPE_CHECKING, Any

from lxml import etree

from fmus.declared_types import give_defaults, without_what_fmpy_lacks
from fmus.versions import major_version, newer_minor

if TYPE_CHECKING:
    from fmpy.model_description import ModelDescription


def read_model(content: bytes, root: Any, *, validate: bool = True) -> ModelDescription:
    """Read a modelDescription.xml by fmpy; `root`, its XML, gets what declared types say of variables.

    ValueError names what is wrong with versions and types; fmpy has errors of its own.
    """
    import fmpy  # not at the top: most commands read none

    version = root.get("fmiVersion")
    if newer := major_version(version) == 3 and newer_minor(version) is not None:
        root.set("fmiVersion", "3.0")  # beyond which fmpy checks less
    if any((newer, give_defaults(root), without_what_fmpy_lacks(root))):
        content = etree.tostring(root)
    model = fmpy.read_model_description(_for_fmpy(content, root), validate=validate)
    model.fmiVersion = version
    _give_ranges(model, root)
    return model


def _for_fmpy(content: bytes, root: Any) -> io.BytesIO:
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


def _give_ranges(model: Any, root: Any) -> None:
    """Give the variables of unsigned types the min and max that fmpy reads of all other types."""
    known = {e.get("name"): e for e in root.find("ModelVariables") if str(e.tag).startswith("UInt")}
    for variable in model.modelVariables:
        element = known.get(variable.name if variable.alias is None else variable.alias.name)
        if element is not None:
            variable.min, variable.max = element.get("min"), element.get("max")
