"""Builds the elements of SSP documents."""

from __future__ import annotations

from typing import Any

from lxml import etree

from fmus.errors import AdcsError
from fmus.model_description import version as package_version
from orchestration.ssp.documents import ADCS, ANNOTATION, tag
from orchestration.ssp.schemas import NAMESPACES


def root_element(prefix: str, name: str, version: str, title: str) -> etree._Element:
    """Return the root element of a document."""
    namespaces = {p: NAMESPACES[p] for p in ("ssc", prefix)}
    root = etree.Element(tag(prefix, name), nsmap=namespaces)
    tool = f"adcs-fmus {package_version()}"
    for key, value in {"version": version, "name": title, "generationTool": tool}.items():
        set_attribute(root, key, value)
    return root


def add(parent: etree._Element, prefix: str, name: str, /, **attributes: Any) -> etree._Element:
    """Add an element; attributes that are None are left out."""
    element = etree.SubElement(parent, tag(prefix, name))
    for key, value in attributes.items():
        if value is not None:
            set_attribute(element, key, value)
    return element


def set_attribute(element: etree._Element, key: str, value: Any) -> None:
    """Set an attribute; AdcsError if XML cannot hold it."""
    try:
        element.set(key, text(value))
    except ValueError:
        raise AdcsError(f"{value!r} has characters that XML cannot hold: change them") from None


def add_texts(parameter: etree._Element, kind: str, texts: list[str], **attributes: Any) -> None:
    """Add one text or several to a parameter."""
    if len(texts) == 1:
        add(parameter, "ssv", kind, value=texts[0], **attributes)
        return
    element = add(parameter, "ssv", kind, **attributes)
    for text in texts:
        add(element, "ssv", "Value", value=text)


def annotate(parent: etree._Element, name: str, /, **attributes: Any) -> None:
    """Say in an annotation of ours what SSP has no place for."""
    annotation = add(annotations_of(parent), "ssc", "Annotation", type=ANNOTATION)
    note = etree.SubElement(annotation, f"{{{ADCS}}}{name}", nsmap={"adcs": ADCS})
    for key, value in attributes.items():
        if value is not None:
            note.set(key, text(value))


def annotations_of(parent: etree._Element) -> etree._Element:
    """Return the annotations of an element of the structure, added when there are none."""
    found = parent.find(tag("ssd", "Annotations"))
    return add(parent, "ssd", "Annotations") if found is None else found


def text(value: Any) -> str:
    """Write numbers with all their digits."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(int(value)) if value == int(value) and abs(value) < 1e15 and str(value) != "-0.0" else repr(value)
    return str(value)
