"""What the XML schemas of the standards have: every element, and every attribute of each.

An element is named by its tag, or by as much of its path as tells it from others of that tag that are of another type:
`Real` in a `SimpleType` of FMI 2.0 is not the `Real` of a `ScalarVariable`. Where a schema has `xs:any`, what stands
there is not the standard's.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import fmpy
from lxml import etree

from orchestration.ssp import schemas as ssp

ITSELF = ""
"""The attribute that stands for an element itself: that it is there, and what it has between its tags."""

_XS = "{http://www.w3.org/2001/XMLSchema}"
_FMI = Path(fmpy.__file__).parent / "schema"
_FILES = {
    "fmi2": ("fmi2ModelDescription.xsd",),
    "fmi3": ("fmi3ModelDescription.xsd", "fmi3TerminalsAndIcons.xsd", "fmi3BuildDescription.xsd"),
    "ssp1": ("Description", "ParameterValues", "ParameterMapping", "SignalDictionary"),
    "ssp2": ("Description", "ParameterValues", "ParameterMapping", "SignalDictionary"),
}
STANDARDS = tuple(_FILES)

Identity = tuple[str, Any]
Path_ = tuple[str, ...]


@cache
def attributes(standard: str) -> dict[str, list[str]]:
    """Return the attributes of each element of a standard's documents; `ITSELF` is the first of all."""
    found: dict[Identity, tuple[dict[Path_, None], list[str]]] = {}
    for file in _FILES[standard]:
        roots = _read(standard, file)
        for element in roots[0].iterfind(f"{_XS}element"):
            _walk(_Schema(roots), element, (), found)
    paths = {identity: list(found[identity][0]) for identity in found}
    return {_name(identity, paths): names for identity, (_, names) in found.items()}


class _Schema:
    """The top-level definitions of a document's schema and of those that it includes, by kind and name."""

    def __init__(self, roots: list[etree._Element]) -> None:
        self._known = {(child.tag, child.get("name")): child for root in roots for child in root}

    def get(self, kind: str, name: str) -> etree._Element | None:
        """Return the definition of a name, with or without prefix; None for the types of XML Schema itself."""
        return self._known.get((f"{_XS}{kind}", name.rpartition(":")[2]))


def _walk(schema: _Schema, element: etree._Element, above: Path_, found: dict[Identity, Any]) -> None:
    if element.get("ref") is not None:
        target = schema.get("element", element.get("ref"))
        assert target is not None
        element = target
    tag = f"{_prefix(element)}{element.get('name')}"
    named = element.get("type")
    kind = schema.get("complexType", named) if named else element.find(f"{_XS}complexType")
    identity = (tag, kind if kind is not None else named)
    path = (*above, tag)
    paths, names = found.setdefault(identity, ({}, [ITSELF]))
    known = bool(paths)
    paths[path] = None
    if kind is None:
        return
    if not known:
        names += dict.fromkeys(_attributes(schema, kind))  # a restriction repeats some
    if tag not in above:  # an element inside of itself
        for child in _children(schema, kind):
            _walk(schema, child, path, found)


def _attributes(schema: _Schema, node: etree._Element) -> list[str]:
    found = []
    for child in node:
        if child.tag == f"{_XS}attribute":
            found.append(child.get("name") or child.get("ref"))
        elif child.tag == f"{_XS}attributeGroup":
            group = schema.get("attributeGroup", child.get("ref"))
            assert group is not None
            found += _attributes(schema, group)
        elif child.tag in (f"{_XS}complexContent", f"{_XS}extension", f"{_XS}restriction"):
            base = schema.get("complexType", child.get("base")) if child.get("base") else None
            found += [*([] if base is None else _attributes(schema, base)), *_attributes(schema, child)]
    return found


def _children(schema: _Schema, node: etree._Element) -> Iterator[etree._Element]:
    for child in node:
        if child.tag == f"{_XS}element":
            yield child
        elif child.tag == f"{_XS}group":
            group = schema.get("group", child.get("ref"))
            assert group is not None
            yield from _children(schema, group)
        elif child.tag in {
            f"{_XS}{n}" for n in ("sequence", "choice", "all", "complexContent", "extension", "restriction")
        }:
            if child.tag == f"{_XS}extension":
                base = schema.get("complexType", child.get("base"))
                assert base is not None
                yield from _children(schema, base)
            yield from _children(schema, child)


def _prefix(element: etree._Element) -> str:
    """SSP's documents have elements of several namespaces, which are known by their prefixes."""
    space = element.getroottree().getroot().get("targetNamespace")
    known = {**ssp.NAMESPACES, "ssb": ssp.NAMESPACES["ssc"].replace("Common", "SignalDictionary")}
    return next((f"{prefix}:" for prefix, uri in known.items() if uri == space), "")


def _name(identity: Identity, paths: dict[Identity, list[Path_]]) -> str:
    own = paths[identity][0]
    others = [path for other, some in paths.items() if other != identity for path in some]
    for n in range(1, len(own) + 1):
        if not any(path[-n:] == own[-n:] for path in others):
            return "/".join(own[-n:])
    return "/".join(own)


@cache
def _parsed(folder: Path, file: str) -> tuple[etree._Element, ...]:
    root = etree.parse(str(folder / file)).getroot()
    included = [e.get("schemaLocation") for e in root.iter(f"{_XS}include")]
    return root, *(other for name in included for other in _parsed(folder, name))


def _read(standard: str, file: str) -> list[etree._Element]:
    if standard.startswith("fmi"):
        return list(_parsed(_FMI / standard, file))
    return [_ssp(standard, file), _ssp(standard, "Common")]


@cache
def _ssp(standard: str, part: str) -> etree._Element:
    """One of SSP's schemas; that of signal dictionaries is the same in both but for what is common to all."""
    version: ssp.Version = "1.0" if standard == "ssp1" else "2.0"
    kind = {"Common": "ssc", "Description": "ssd", "ParameterValues": "ssv", "ParameterMapping": "ssm"}.get(part, "ssb")
    return etree.fromstring(ssp.source(kind, version))
