"""The XML schemas of SSP: those of 1.0 come with fmpy, those of 2.0 are the same with what 2.0 added."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Literal

import fmpy
from lxml import etree

Kind = Literal["ssd", "ssv", "ssm"]
Version = Literal["1.0", "2.0"]

_BASE = "http://ssp-standard.org/SSP1/SystemStructure"
NAMESPACES = {
    "ssc": f"{_BASE}Common",
    "ssd": f"{_BASE}Description",
    "ssv": f"{_BASE}ParameterValues",
    "ssm": f"{_BASE}ParameterMapping",
}
"""SSP 2.0 has kept the namespaces of 1.0."""
ROOTS: dict[Kind, str] = {"ssd": "SystemStructureDescription", "ssv": "ParameterSet", "ssm": "ParameterMapping"}

_FOLDER = Path(fmpy.__file__).parent / "ssp" / "schema"
_FILES = {kind: f"{namespace.rpartition('/')[2]}.xsd" for kind, namespace in NAMESPACES.items()}
_XS = "http://www.w3.org/2001/XMLSchema"
_INTEGERS = {
    "Int8": "byte",
    "UInt8": "unsignedByte",
    "Int16": "short",
    "UInt16": "unsignedShort",
    "Int32": "int",
    "UInt32": "unsignedInt",
    "Int64": "long",
    "UInt64": "unsignedLong",
}


@cache
def schema(kind: Kind, version: Version) -> etree.XMLSchema:
    """Return the schema of `.ssd`, `.ssv` or `.ssm` documents."""
    if version == "1.0":
        return etree.XMLSchema(etree.parse(str(_FOLDER / _FILES[kind])))
    parser = etree.XMLParser()
    parser.resolvers.add(_Amended())
    return etree.XMLSchema(etree.fromstring(_amended(_FILES[kind]), parser))


def source(kind: str, version: Version) -> bytes:
    """Return the text of the schema of `ssc`, `ssd`, `ssv`, `ssm` or, of signal dictionaries, `ssb` documents."""
    file = f"{_BASE.rpartition('/')[2]}SignalDictionary.xsd" if kind == "ssb" else _FILES[kind]
    return (_FOLDER / file).read_bytes() if version == "1.0" or kind == "ssb" else _amended(file)


class _Amended(etree.Resolver):  # type: ignore[misc]
    """Gives the amended file where a schema imports another."""

    def resolve(self, url: str, identifier: str, context: object) -> object:
        return self.resolve_string(_amended(Path(url).name), context)


@cache
def _amended(file: str) -> bytes:
    root = etree.parse(str(_FOLDER / file)).getroot()
    for pattern in _find(root, "//xs:attribute[@name='version']//xs:pattern"):
        pattern.set("value", "2[.]0")
    _AMENDMENTS[file](root)
    return bytes(etree.tostring(root))


def _amend_common(root: etree._Element) -> None:
    """Wider integers, the types of FMI 3.0, dimensions, metadata and signatures."""
    integer = (
        '<xs:simpleType name="TGenericInteger"><xs:restriction base="xs:integer">'
        '<xs:minInclusive value="-9223372036854775808"/><xs:maxInclusive value="18446744073709551615"/>'
        "</xs:restriction></xs:simpleType>"
    )
    content = (
        '<xs:complexType name="ContentType" mixed="true"><xs:sequence>'
        '<xs:any namespace="##any" processContents="lax" minOccurs="0" maxOccurs="unbounded"/></xs:sequence>'
        '<xs:attributeGroup ref="ssc:ABaseElement"/></xs:complexType>'
    )
    signature = _group("GSignature", "Signature", "", "role", ("authenticity", "suitability"), "metaData")
    metadata = _group("GMetaData", "MetaData", '<xs:group ref="ssc:GSignature"/>', "kind", ("general", "quality"))
    dimensions = (
        '<xs:group name="GDimensions"><xs:sequence><xs:element name="Dimension" minOccurs="0" maxOccurs="unbounded">'
        '<xs:complexType><xs:attribute name="size" type="xs:unsignedLong"/>'
        '<xs:attribute name="sizeConnector" type="xs:string"/></xs:complexType></xs:element></xs:sequence></xs:group>'
    )
    for text in (integer, content, signature, metadata, dimensions):
        root.append(_element(text))
    _one(root, "//xs:complexType[@name='TEnumeration']//xs:attribute[@name='value']").set("type", "xs:long")
    for value in _find(root, "//xs:element[@name='IntegerMappingTransformation']//xs:attribute"):
        value.set("type", "ssc:TGenericInteger")
    _one(root, "//xs:element[@name='Annotation']/xs:complexType").set("mixed", "true")
    choice = _one(root, "//xs:group[@name='GTypeChoice']/xs:choice")
    for name in ("Float64", "Float32"):
        choice.append(_element(f'<xs:element name="{name}"><xs:complexType>{_UNIT}</xs:complexType></xs:element>'))
    for name in _INTEGERS:
        choice.append(_element(f'<xs:element name="{name}"><xs:complexType/></xs:element>'))
    choice.append(_element(_CLOCK))


def _amend_description(root: etree._Element) -> None:
    """Array connectors, elements of them in connections, more kinds, components without a source."""
    for place in ("//xs:element[@name='SystemStructureDescription']", "//xs:element[@name='ParameterBinding']"):
        _metadata_before_annotations(_one(root, f"{place}/xs:complexType/xs:sequence"))
    element = _one(root, "//xs:complexType[@name='TElement']/xs:sequence")
    for group in _METADATA:
        element.append(_element(group))
    component = _one(root, "//xs:complexType[@name='TComponent']")
    _one(component, ".//xs:attribute[@name='source']").set("use", "optional")
    _one(component, ".//xs:attribute[@name='implementation']//xs:restriction").append(
        _element('<xs:enumeration value="ScheduledExecution"/>')
    )
    connection = _one(root, "//xs:element[@name='Connection']/xs:complexType")
    for name in ("startIndices", "endIndices"):
        connection.append(_element(f'<xs:attribute name="{name}">{_list("unsignedLong")}</xs:attribute>'))
    connector = _one(root, "//xs:element[@name='Connector']/xs:complexType")
    geometry = _one(connector, ".//xs:element[@name='ConnectorGeometry']")
    geometry.addprevious(_element('<xs:group ref="ssc:GDimensions"/>'))
    geometry.addprevious(
        _element(
            '<xs:element name="Clock" minOccurs="0" maxOccurs="unbounded"><xs:complexType>'
            '<xs:attribute name="name" type="xs:string" use="required"/></xs:complexType></xs:element>'
        )
    )
    for name in ("systemInnerX", "systemInnerY"):
        _one(geometry, "xs:complexType").append(_element(f'<xs:attribute name="{name}" type="xs:double"/>'))
    kinds = _one(connector, "xs:attribute[@name='kind']//xs:restriction")
    for name in ("structuralParameter", "constant", "local", "unspecified"):
        kinds.append(_element(f'<xs:enumeration value="{name}"/>'))


def _amend_values(root: etree._Element) -> None:
    """The types of FMI 3.0 and arrays of values."""
    _metadata_before_annotations(_one(root, "//xs:element[@name='ParameterSet']/xs:complexType/xs:sequence"))
    choice = _one(root, "//xs:complexType[@name='TParameter']//xs:choice")
    for name, kind in {"Real": "double", "Integer": "int", "Boolean": "boolean"}.items():
        value = _one(choice, f"xs:element[@name='{name}']//xs:attribute[@name='value']")
        del value.attrib["type"]
        value[:] = [_element(_list(kind))]
    for name in ("String", "Enumeration", "Binary"):
        content = _one(choice, f"xs:element[@name='{name}']/xs:complexType")
        value = _one(content, "xs:attribute[@name='value']")
        del value.attrib["use"]
        content.insert(
            0,
            _element(
                '<xs:sequence><xs:element name="Value" minOccurs="0" maxOccurs="unbounded"><xs:complexType>'
                f'<xs:attribute name="value" type="{value.get("type")}" use="required"/>'
                "</xs:complexType></xs:element></xs:sequence>"
            ),
        )
    for name, kind in {"Float64": "double", "Float32": "float", **_INTEGERS}.items():
        unit = _UNIT if name.startswith("Float") else ""
        choice.append(
            _element(
                f'<xs:element name="{name}"><xs:complexType><xs:attribute name="value" use="required">{_list(kind)}'
                f"</xs:attribute>{unit}</xs:complexType></xs:element>"
            )
        )
    choice.addnext(_element('<xs:group ref="ssc:GDimensions"/>'))


def _amend_mapping(root: etree._Element) -> None:
    """Metadata and signatures."""
    _metadata_before_annotations(_one(root, "//xs:element[@name='ParameterMapping']/xs:complexType/xs:sequence"))


_AMENDMENTS: dict[str, Callable[[etree._Element], None]] = {
    _FILES["ssc"]: _amend_common,
    _FILES["ssd"]: _amend_description,
    _FILES["ssv"]: _amend_values,
    _FILES["ssm"]: _amend_mapping,
}
_METADATA = ('<xs:group ref="ssc:GMetaData"/>', '<xs:group ref="ssc:GSignature"/>')
_UNIT = '<xs:attribute name="unit" type="xs:string"/>'
_CLOCK = (
    '<xs:element name="Clock"><xs:complexType><xs:attribute name="intervalVariability"><xs:simpleType>'
    '<xs:restriction base="xs:normalizedString">'
    + "".join(
        f'<xs:enumeration value="{v}"/>' for v in ("constant", "fixed", "tunable", "changing", "countdown", "triggered")
    )
    + "</xs:restriction></xs:simpleType></xs:attribute>"
    + "".join(
        f'<xs:attribute name="{name}" type="xs:{kind}"/>'
        for name, kind in {
            "intervalDecimal": "double",
            "shiftDecimal": "double",
            "supportsFraction": "boolean",
            "resolution": "unsignedLong",
            "intervalCounter": "unsignedLong",
            "shiftCounter": "unsignedLong",
            "priority": "unsignedInt",
        }.items()
    )
    + "</xs:complexType></xs:element>"
)


def _group(name: str, element: str, more: str, role: str, roles: tuple[str, ...], *bases: str) -> str:
    """An element with content inside or in a file, and what it is for."""

    def choice(values: tuple[str, ...]) -> str:
        items = "".join(f'<xs:enumeration value="{value}"/>' for value in values)
        return f'<xs:simpleType><xs:restriction base="xs:string">{items}</xs:restriction></xs:simpleType>'

    return (
        f'<xs:group name="{name}"><xs:sequence><xs:element name="{element}" minOccurs="0" maxOccurs="unbounded">'
        '<xs:complexType><xs:sequence><xs:element name="Content" type="ssc:ContentType" minOccurs="0"/>'
        f'{more}</xs:sequence><xs:attribute name="{role}" use="required">{choice(roles)}</xs:attribute>'
        '<xs:attribute name="type" type="xs:string" use="required"/>'
        '<xs:attribute name="source" type="xs:anyURI"/>'
        f'<xs:attribute name="sourceBase">{choice(("file", "resource", *bases))}</xs:attribute>'
        '<xs:attributeGroup ref="ssc:ABaseElement"/></xs:complexType></xs:element></xs:sequence></xs:group>'
    )


def _list(kind: str) -> str:
    return f'<xs:simpleType><xs:list itemType="xs:{kind}"/></xs:simpleType>'


def _metadata_before_annotations(sequence: etree._Element) -> None:
    annotations = _one(sequence, "xs:element[@name='Annotations']")
    for group in _METADATA:
        annotations.addprevious(_element(group))


def _element(text: str) -> etree._Element:
    return etree.fromstring(f'<x xmlns:xs="{_XS}" xmlns:ssc="{NAMESPACES["ssc"]}">{text}</x>')[0]


def _find(root: etree._Element, path: str) -> list[etree._Element]:
    return list(root.xpath(path, namespaces={"xs": _XS}))


def _one(root: etree._Element, path: str) -> etree._Element:
    (found,) = _find(root, path)
    return found
