"""XML documents of SSP: parsed without any outside influence, and valid by their schema, or refused."""

from __future__ import annotations

import re

from lxml import etree

from fmus.errors import AdcsError
from fmus.xml import parse as read_xml
from orchestration.ssp.schemas import NAMESPACES, ROOTS, Kind, Version, schema

ADCS = "urn:adcs-fmus:ssp"
"""Namespace of our annotations, for what SSP has no place for."""
ANNOTATION = "adcs-fmus"
"""Type of our annotations."""
OMS = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd"
"""Namespace of OMSimulator's annotations, which carry its step size."""
OMS_ANNOTATION = "org.openmodelica"


def tag(prefix: str, name: str) -> str:
    """`tag("ssd", "System")` -> the name with its namespace."""
    return f"{{{NAMESPACES[prefix]}}}{name}"


def local_name(element: etree._Element) -> str:
    """Return the name without namespace."""
    return str(etree.QName(element).localname)


def parse(content: bytes, name: str, kind: Kind) -> etree._Element:
    """Parse a document that has a file of its own; AdcsError names the file."""
    root = read_xml(content, name, utf8_only=True, bare=True)
    check(root, name, kind)
    return root


def check(root: etree._Element, name: str, kind: Kind) -> Version:
    """Check a document, or the part of one that stands in another, against the schema of its version."""
    if root.tag != tag(kind, ROOTS[kind]):
        raise AdcsError(f"{name} is no {ROOTS[kind]} of SSP 1.0 or 2.0 but has the root element {root.tag}")
    version = version_of(root, name)
    found = schema(kind, version)
    if not found.validate(root):
        error = found.error_log[0]
        message = re.sub(r"\{[^}]*\}", "", _line(error.message)).rstrip(".")
        raise AdcsError(f"{name} is not valid SSP {version}, line {error.line}: {message}")
    return version


def version_of(root: etree._Element, name: str) -> Version:
    """Return the version of SSP that a document follows."""
    version = root.get("version", "")
    if re.fullmatch(r"1[.]\d+(-.*)?", version):
        return "1.0"
    if version == "2.0":
        return "2.0"
    raise AdcsError(f"{name} is of SSP version {version!r}: only 1.0 and 2.0 are supported")


def notes(element: etree._Element, name: str) -> dict[str, str]:
    """Return the attributes that our annotation `<adcs:NAME ...>` of an element has."""
    for annotation in element.iterfind(f"{{*}}Annotations/{tag('ssc', 'Annotation')}"):
        if annotation.get("type") == ANNOTATION:
            for found in annotation.iterfind(f"{{{ADCS}}}{name}"):
                return dict(found.attrib)
    return {}


def whole_number(text: str, where: str, least: int = 0) -> int:
    """Read a whole number of an annotation."""
    if not text.isdecimal() or len(text) > 9 or int(text) < least:
        raise AdcsError(f"{where} = {text[:40]!r}, expected a whole number from {least}")
    return int(text)


def number(text: str, where: str) -> float:
    """Read a number of an annotation."""
    try:
        return float(text)
    except ValueError:
        raise AdcsError(f"{where} = {text[:40]!r}, expected a number") from None


def _line(text: object) -> str:
    return " ".join(str(text).split())
