"""The system structure as the document has it: systems, components, connectors, connections."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from lxml import etree

from fmus.errors import AdcsError
from orchestration.fmu.units import Unit
from orchestration.ssp.archive import Home
from orchestration.ssp.clocks import ClockType, clock_type
from orchestration.ssp.documents import local_name, notes, tag
from orchestration.ssp.names import STRUCTURE
from orchestration.ssp.transformation import Items
from orchestration.ssp.units import named, of_document

FMU_TYPE = "application/x-fmu-sharedlibrary"
PACKAGE_TYPE = "application/x-ssp-package"
DEFINITION_TYPE = "application/x-ssp-definition"
_MOST = 1000  # references to systems, lest thirty files that each use the next one twice become 10^9 systems


@dataclass(frozen=True)
class Connector:
    """A connector; `type` is the SSP name, `dimensions` are empty where there are none.

    A dimension is a number, the name of the connector that holds it, or None where it is left open. `clock` is there
    if the connector is a clock; `clocks` are those to which the document says its values belong.
    """

    name: str
    kind: str
    type: str | None
    unit: Unit | None
    items: Items | None
    dimensions: tuple[int | str | None, ...]
    clock: ClockType | None = None
    clocks: tuple[str, ...] = ()

    @property
    def shape(self) -> tuple[int, ...] | None:
        """The dimensions where all of them are numbers, else None."""
        numbers = tuple(d for d in self.dimensions if isinstance(d, int))
        return numbers if len(numbers) == len(self.dimensions) else None


@dataclass(frozen=True)
class LinkEnd:
    """One end of a connection; `element` None is the enclosing system, `indices` count from 1."""

    element: str | None
    connector: str
    indices: tuple[int, ...]

    def __str__(self) -> str:
        indices = f"[{','.join(map(str, self.indices))}]" if self.indices else ""
        return f"{self.element}.{self.connector}{indices}" if self.element else f"{self.connector}{indices}"


@dataclass(frozen=True)
class Link:
    """A connection between two connectors of one system; which way the value flows, the connectors say."""

    ends: tuple[LinkEnd, LinkEnd]
    suppress: bool
    xml: etree._Element
    notes: Mapping[str, str]


@dataclass(frozen=True)
class Binding:
    """A parameter binding, the structure to which its sources are relative, and what that defines."""

    xml: etree._Element
    home: Home
    units: Mapping[str, Unit]
    enumerations: Mapping[str, Items]


@dataclass
class Element:
    """What systems and components have in common; `path` are the names from the root system's elements down."""

    path: tuple[str, ...]
    connectors: dict[str, Connector]
    bindings: list[Binding]
    notes: Mapping[str, str]

    @property
    def name(self) -> str:
        """The names of the path, as messages and the flat system have them."""
        return "/".join(self.path)


@dataclass
class ComponentElement(Element):
    """A component with its FMU."""

    home: Home
    source: str
    implementation: str


@dataclass
class SystemElement(Element):
    """A system; the root has an empty path."""

    elements: dict[str, Element] = field(default_factory=dict)
    links: list[Link] = field(default_factory=list)

    def systems(self) -> Iterator[SystemElement]:
        """This system and those in it, at every depth."""
        yield self
        for element in self.elements.values():
            if isinstance(element, SystemElement):
                yield from element.systems()

    def components(self) -> Iterator[ComponentElement]:
        """The components at every depth, in the order of the document."""
        for element in self.elements.values():
            if isinstance(element, SystemElement):
                yield from element.components()
            elif isinstance(element, ComponentElement):
                yield element


@dataclass(frozen=True)
class _Context:
    """The document that is being read: where it is, what its connectors refer to, and how it was come to."""

    home: Home
    units: Mapping[str, Unit]
    enumerations: Mapping[str, Items]
    way: tuple[tuple[Home, str], ...]
    """The systems that are being read, each because of the one before."""
    references: list[str]
    """All references followed so far."""


def read_structure(home: Home) -> SystemElement:
    """Read a system structure, and those that it refers to."""
    root = home.document()
    return _system(root.find(tag("ssd", "System")), (), _context(home, ((home, ""),), []))


def _context(home: Home, way: tuple[tuple[Home, str], ...], references: list[str]) -> _Context:
    root = home.document()
    return _Context(home, of_document(root, "ssd"), enumerations_in(root, "ssd"), way, references)


def enumerations_in(root: etree._Element, prefix: str) -> dict[str, Items]:
    """Return the enumerations that a document defines."""
    return {
        element.get("name"): {item.get("name"): int(item.get("value")) for item in element.iterfind(tag("ssc", "Item"))}
        for element in root.iterfind(f"{tag(prefix, 'Enumerations')}/{tag('ssc', 'Enumeration')}")
    }


def _system(xml: etree._Element, path: tuple[str, ...], context: _Context) -> SystemElement:
    system = SystemElement(path, *_common(xml, path, context), notes(xml, "System"))
    for child in _children(xml, "Elements"):
        name = child.get("name")
        where = (*path, name)
        if name in system.elements:
            raise AdcsError(f"two elements have the name {'/'.join(where)!r}: rename one of them")
        if child.tag == tag("ssd", "System"):
            system.elements[name] = _system(child, where, context)
        elif child.tag == tag("ssd", "Component"):
            system.elements[name] = _component(child, where, context)
        else:
            raise AdcsError(
                f"{'/'.join(where)} is a {local_name(child)}, which is not supported: connect the components directly"
            )
    for child in _children(xml, "Connections"):
        ends = (_end(child, "start"), _end(child, "end"))
        suppress = child.get("suppressUnitConversion", "false").strip() in ("true", "1")
        system.links.append(Link(ends, suppress, child, notes(child, "Connection")))
    return system


def _component(xml: etree._Element, path: tuple[str, ...], context: _Context) -> Element:
    name = "/".join(path)
    kind = xml.get("type", FMU_TYPE)
    if kind not in (FMU_TYPE, PACKAGE_TYPE, DEFINITION_TYPE):
        raise AdcsError(
            f"component {name} has the type {kind!r}, which is not supported: only FMUs and SSP systems are"
        )
    source = xml.get("source")
    if not source:
        raise AdcsError(f"component {name} has no source: name its FMU")
    if kind != FMU_TYPE:
        return _reference(xml, path, context, kind, source)
    implementation = xml.get("implementation", "any")
    if implementation == "ScheduledExecution":
        raise AdcsError(f"component {name} asks for ScheduledExecution, which is not supported: use CoSimulation")
    common = _common(xml, path, context)
    return ComponentElement(path, *common, notes(xml, "Component"), context.home, source, implementation)


def _reference(xml: etree._Element, path: tuple[str, ...], context: _Context, kind: str, source: str) -> SystemElement:
    """Read the system that stands elsewhere and is used as a component; the component's bindings come after its own."""
    name = "/".join(path)
    context.references.append(name)
    if len(context.references) > _MOST:
        raise AdcsError(f"component {name} is the reference to a system number {_MOST + 1}: refused, put FMUs there")
    file, _, fragment = source.partition("#")
    home, what = context.home, f"the system of component {name}"
    if kind == PACKAGE_TYPE:
        home = Home(home.archive.package(home.locate(file, what)), fragment or STRUCTURE)
        home.locate(home.structure, what)
    elif file:
        home = Home(home.archive, home.locate(file, what))
    here = (home, fragment if kind == DEFINITION_TYPE else "")
    if here in context.way:
        raise AdcsError(f"component {name} refers to a system in which it is itself, {source}: break the circle")
    found = home.document().find(tag("ssd", "System"))
    if kind == DEFINITION_TYPE and fragment:
        systems = home.document().iter(tag("ssd", "System"))
        found = next((element for element in systems if element.get("id") == fragment), None)
        if found is None:
            raise AdcsError(f"{what} is missing: {home.structure} has no system with the id {fragment!r}")
    system = _system(found, path, _context(home, (*context.way, here), context.references))
    connectors, bindings = _common(xml, path, context)
    for connector in connectors.values():
        inner = system.connectors.get(connector.name)
        if inner is None or inner.kind != connector.kind:
            raise AdcsError(f"connector {name}.{connector.name}: {source} has none such of kind {connector.kind}")
    system.bindings += bindings
    return system


def _common(
    xml: etree._Element, path: tuple[str, ...], context: _Context
) -> tuple[dict[str, Connector], list[Binding]]:
    connectors: dict[str, Connector] = {}
    for child in _children(xml, "Connectors"):
        connector = _connector(child, path, context)
        if connector.name in connectors:
            raise AdcsError(f"two connectors have the name {_dotted(path, connector.name)}: rename one of them")
        connectors[connector.name] = connector
    return connectors, [
        Binding(child, context.home, context.units, context.enumerations)
        for child in _children(xml, "ParameterBindings")
    ]


def _connector(xml: etree._Element, path: tuple[str, ...], context: _Context) -> Connector:
    name = xml.get("name")
    found = next((c for c in xml if etree.QName(c).namespace == etree.QName(tag("ssc", "x")).namespace), None)
    kind = None if found is None or local_name(found) in ("Dimension", "Annotations") else local_name(found)
    unit = items = None
    if found is not None and kind in ("Real", "Float64", "Float32"):
        unit = named(context.units, found.get("unit"))
    elif found is not None and kind == "Enumeration":
        items = context.enumerations.get(found.get("name"))  # if not defined here, the FMUs know
    clock = clock_type(found, f"connector {_dotted(path, name)}") if found is not None and kind == "Clock" else None
    dimensions: list[int | str | None] = []
    for dimension in xml.iterfind(tag("ssc", "Dimension")):
        size, holder = dimension.get("size"), dimension.get("sizeConnector")
        if size is not None and holder is not None:
            raise AdcsError(
                f"connector {_dotted(path, name)} has a Dimension with size {size} and sizeConnector {holder!r}: "
                "drop one of them"
            )
        dimensions.append(holder if size is None else int(size))
    clocks = tuple(clock.get("name") for clock in xml.iterfind(tag("ssd", "Clock")))
    return Connector(name, xml.get("kind"), kind, unit, items, tuple(dimensions), clock, clocks)


def _end(xml: etree._Element, which: str) -> LinkEnd:
    indices = tuple(int(i) for i in xml.get(f"{which}Indices", "").split())
    return LinkEnd(xml.get(f"{which}Element"), xml.get(f"{which}Connector"), indices)


def _children(xml: etree._Element, name: str) -> list[etree._Element]:
    found = xml.find(tag("ssd", name))
    return [] if found is None else [child for child in found if isinstance(child.tag, str)]


def _dotted(path: tuple[str, ...], name: str) -> str:
    return f"{'/'.join(path)}.{name}" if path else name
