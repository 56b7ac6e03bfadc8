"""Follows every input of every component back to where its value comes from, through all systems on the way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import prod
from typing import Any

from fmus.errors import AdcsError
from orchestration.fmu.units import Unit
from orchestration.ssp.clocks import ClockType, connection_holds, of_fmu
from orchestration.ssp.parts import Part, Place, items_of
from orchestration.ssp.structure import Connector, Element, Link, LinkEnd, SystemElement
from orchestration.ssp.transformation import Items, Transformation, transformation_in
from orchestration.ssp.units import scale
from orchestration.ssp.wording import has, hint, sizes

_GIVING = ("output", "calculatedParameter", "constant", "local")
_LARGEST = 1_000_000  # elements of a system's connector, which no FMU backs
_TAKING = ("input", "parameter", "structuralParameter")


@dataclass(frozen=True)
class Feed:
    """Where the value of a place comes from, over one connection."""

    source: Place
    link: Link
    label: str
    position: int


@dataclass(frozen=True)
class Route:
    """The whole way of a value: from an output, or a system's connector, to a component's input or parameter.

    `explicit` says that more happens on the way than conversion of units; `unit` is that at the beginning.
    """

    source: Place
    target: Place
    transformation: Transformation
    explicit: bool
    notes: Mapping[str, str]
    position: int
    label: str


class Wiring:
    """The connections of all systems, element by element."""

    def __init__(self, root: SystemElement, parts: Mapping[tuple[str, ...], Part], *, structural: bool = False) -> None:
        """With `structural` only connections that give values to structural parameters are looked at."""
        self.root = root
        self.parts = parts
        self.systems = {system.path: system for system in root.systems()}
        self.links = [
            (system, link)
            for system in self.systems.values()
            for link in system.links
            if not structural or self._structural(system, link)
        ]
        self.shapes = self._shapes()
        self.feeds: dict[Place, Feed] = {}
        for system, link in self.links:
            self._add(system, link)
        self.relative = self._relative()
        """The places of systems' connectors through which differences pass (relativeQuantity)."""

    def routes(self, units: Mapping[Place, Unit | None]) -> list[Route]:
        """Return the ways into all components, in the order of the document.

        `units` are those of the values that parameters give to systems' connectors.
        """
        for place in self.feeds:  # also where no component is reached, to find cycles
            self._follow(place)
        return [self._route(place, units) for place in self.feeds if place.path in self.parts]

    def connector(self, system: SystemElement, end: LinkEnd, label: str) -> tuple[tuple[str, ...], Connector]:
        """Return the owner and the connector that an end names."""
        if end.element is None or (end.element == "" and "" not in system.elements):
            owner: Element = system
            known = f"system {system.name!r}" if system.path else "the root system"
        elif end.element in system.elements:
            owner = system.elements[end.element]
            known = f"{end.element!r}"
        else:
            raise AdcsError(f"{label}: there is no element {end.element!r}{hint(end.element, system.elements)}")
        if end.connector not in owner.connectors:
            raise AdcsError(
                f"{label}: {known} has no connector {end.connector!r}{hint(end.connector, owner.connectors)}"
            )
        return owner.path, owner.connectors[end.connector]

    def _shapes(self) -> dict[tuple[tuple[str, ...], str], tuple[int, ...]]:
        """Shapes of all connectors; those left open are taken from connectors they are connected to."""
        shapes: dict[tuple[tuple[str, ...], str], tuple[int, ...]] = {}
        for system in self.systems.values():
            for connector in system.connectors.values():
                if connector.shape is not None:
                    shapes[system.path, connector.name] = connector.shape
        for path, part in self.parts.items():
            for name in part.element.connectors:
                shapes[path, name] = part.shape(name)
        changed = True
        while changed:
            changed = False
            for system, link in self.links:
                if link.ends[0].indices or link.ends[1].indices:
                    continue
                label = _label(system, link)
                keys = [(path, c.name) for path, c in (self.connector(system, end, label) for end in link.ends)]
                for here, there in (keys, keys[::-1]):
                    if here in shapes and there not in shapes:
                        shapes[there] = shapes[here]
                        changed = True
        return shapes

    def check_sizes(self, given: Mapping[Place, Any]) -> None:
        """Check that systems' connectors have the sizes that other connectors of theirs are given by these values."""
        for path, system in self.systems.items():
            for connector in system.connectors.values():
                where = f"connector {Place(path, connector.name, 0)}"
                said = [self._said(system, d, given, where) if isinstance(d, str) else d for d in connector.dimensions]
                shape = self.shapes.get((path, connector.name), tuple(said))
                if len(said) != len(shape) or any(d not in (None, n) for d, n in zip(said, shape, strict=True)):
                    raise AdcsError(
                        f"{where} has the dimensions {sizes(said)}, what it is connected to {has(shape)}: correct them"
                    )

    def _said(self, system: SystemElement, name: str, given: Mapping[Place, Any], where: str) -> int | None:
        """Return the size that a connector of a system has been given, None if it is not known here."""
        if name not in system.connectors:
            raise AdcsError(
                f"{where} takes its size from the connector {name!r}, which its system does not have"
                f"{hint(name, system.connectors)}: correct its sizeConnector"
            )
        place = Place(system.path, name, 0)
        way = self._follow(place)
        value: int | None = given.get(way[0].source if way else place)
        return value

    def _structural(self, system: SystemElement, link: Link) -> bool:
        """Whether a connection is one that only structural parameters and constants have."""
        label = _label(system, link)
        kinds = [self._kind(*self.connector(system, end, label)) for end in link.ends]
        return "structuralParameter" in kinds and set(kinds) <= {"structuralParameter", "constant"}

    def _kind(self, path: tuple[str, ...], connector: Connector) -> str:
        """Return the kind of a connector as the FMU has it, where it is one of a component."""
        if path not in self.parts:
            return connector.kind
        port, _ = self.parts[path].variables[connector.name]
        return "constant" if port.variability == "constant" else port.causality

    def _clock(self, path: tuple[str, ...], connector: Connector) -> ClockType | None:
        if path not in self.parts:
            return connector.clock
        part = self.parts[path]
        clock = part.clocks.get(part.variables[connector.name][0].name)
        return None if clock is None else of_fmu(clock)

    def _add(self, system: SystemElement, link: Link) -> None:
        label = _label(system, link)
        ends = [self.connector(system, end, label) for end in link.ends]
        names = [str(Place(path, connector.name, 0)) for path, connector in ends]
        if connection_holds([self._clock(*end) for end in ends], names, label):
            return
        gives = [self._gives(system, end, owner, label) for end, owner in zip(link.ends, ends, strict=True)]
        if gives[0] == gives[1]:
            kinds = f"{ends[0][1].kind} and {ends[1][1].kind}"
            what = "give a value, none takes one" if gives[0] else "take a value, none gives one"
            raise AdcsError(f"{label}: both ends {what} ({kinds}): connect an output to an input")
        source, target = (0, 1) if gives[0] else (1, 0)
        places = [self._places(end, owner, label) for end, owner in zip(link.ends, ends, strict=True)]
        if len(places[0]) != len(places[1]) or self._shape(link, ends, 0) != self._shape(link, ends, 1):
            shapes = f"{sizes(self._shape(link, ends, 0))} and {sizes(self._shape(link, ends, 1))}"
            raise AdcsError(f"{label}: sizes differ, {shapes}: connect elements by their indices")
        for from_, to in zip(places[source], places[target], strict=True):
            if to in self.feeds:
                raise AdcsError(f"{label}: {to} has another source already, {self.feeds[to].label}: drop one of them")
            self.feeds[to] = Feed(from_, link, label, len(self.feeds))

    def _shape(self, link: Link, ends: list[tuple[tuple[str, ...], Connector]], which: int) -> tuple[int, ...]:
        path, connector = ends[which]
        return () if link.ends[which].indices else self.shapes[path, connector.name]

    def _gives(self, system: SystemElement, end: LinkEnd, owner: tuple[tuple[str, ...], Connector], label: str) -> bool:
        """Whether a value comes out of this end: seen from inside, a system's own inputs give values."""
        path, connector = owner
        kind = connector.kind
        if kind == "unspecified" and path in self.parts:
            kind = self.parts[path].variables[connector.name][0].causality
        if connector.type in ("String", "Binary"):
            raise AdcsError(f"{label}: {end} is of type {connector.type}, which cannot be connected: drop it")
        if kind not in _GIVING + _TAKING:
            raise AdcsError(f"{label}: {end} is of kind {kind!r}, which is not supported: make it input or output")
        return (kind in _GIVING) != (path == system.path)

    def _places(self, end: LinkEnd, owner: tuple[tuple[str, ...], Connector], label: str) -> list[Place]:
        path, connector = owner
        if (path, connector.name) not in self.shapes:
            raise AdcsError(f"{label}: the dimensions of {end} are not known: give them in its connector")
        shape = self.shapes[path, connector.name]
        if path in self.parts:
            port, elements = self.parts[path].variables[connector.name]
            places = [Place(path, port.name, i) for i in elements or (0,)]  # lest a connection of size 0 be lost
        else:
            if prod(shape) > _LARGEST:
                raise AdcsError(f"{label}: {end} has {prod(shape)} elements, more than {_LARGEST}: refused")
            places = [Place(path, connector.name, i) for i in range(prod(shape) or 1)]
        if not end.indices:
            return places
        if len(end.indices) != len(shape) or not all(1 <= i <= n for i, n in zip(end.indices, shape, strict=True)):
            raise AdcsError(f"{label}: {end} does not exist, {end.connector} {has(shape)}, counted from 1")
        flat = 0
        for i, n in zip(end.indices, shape, strict=True):
            flat = flat * n + i - 1
        return [places[flat]]

    def _follow(self, target: Place) -> list[Feed]:
        """Return the feeds from the beginning to the target."""
        way: list[Feed] = []
        seen = [target]
        while seen[-1] in self.feeds:
            way.insert(0, self.feeds[seen[-1]])
            source = way[0].source
            if source in seen:
                ring = [source, *reversed(seen[seen.index(source) :])]
                raise AdcsError(f"connectors of systems form a cycle, {' -> '.join(map(str, ring))}: open it")
            seen.append(source)
        return way

    def _route(self, target: Place, units: Mapping[Place, Unit | None]) -> Route:
        way = self._follow(target)
        transformation, explicit = Transformation(), False
        notes: Mapping[str, str] = {}
        unit = self._unit(way[0].source, units)
        for feed, next_ in zip(way, [*(f.source for f in way[1:]), target], strict=True):
            there = self._unit(next_, {})
            own = transformation_in(feed.link.xml, self._items(feed.source), self._items(next_))
            try:
                if not feed.link.suppress and unit is not None and there is not None:
                    transformation = transformation.then(Transformation(**vars(scale(unit, there))))
                if own is not None:
                    transformation = transformation.then(own)
            except AdcsError as error:
                raise AdcsError(f"{feed.label}: {error}") from None
            explicit = explicit or feed.link.suppress or own is not None
            unit = there if there is not None or feed.link.suppress else unit
            notes = {**notes, **feed.link.notes}
        return Route(way[0].source, target, transformation, explicit, notes, way[-1].position, way[-1].label)

    def _unit(self, place: Place, units: Mapping[Place, Unit | None]) -> Unit | None:
        if place.path in self.parts:
            return self.parts[place.path].unit(place)
        own = self.systems[place.path].connectors[place.name].unit
        unit = own if own is not None else units.get(place)
        return unit.of_difference() if unit is not None and place in self.relative else unit

    def _relative(self) -> set[Place]:
        found: set[Place] = set()
        for target in self.feeds:
            if target.path in self.parts:
                places = [*(feed.source for feed in self._follow(target)), target]
                ends = [self.parts[p.path].fmu.ports[p.name] for p in places if p.path in self.parts]
                if any(port.relative for port in ends):
                    found.update(places)
        return {place for place in found if place.path not in self.parts}

    def _items(self, place: Place) -> Items | None:
        if place.path in self.parts:
            part = self.parts[place.path]
            return items_of(part.fmu.ports[place.name])
        return self.systems[place.path].connectors[place.name].items


def _label(system: SystemElement, link: Link) -> str:
    inside = f" in {system.name}" if system.path else ""
    return f"connection {link.ends[0]} -> {link.ends[1]}{inside}"
