"""The connections of the flat system: elements united to arrays again, with what our annotations say of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from fmus.errors import AdcsError
from orchestration.fmu.file import Port
from orchestration.fmu.units import conversion
from orchestration.ssp.documents import number, whole_number
from orchestration.ssp.parts import Part, Place
from orchestration.ssp.wiring import Route
from orchestration.system import System


@dataclass(frozen=True)
class _Remarks:
    """What our annotations say of a connection."""

    order: int
    element: bool
    complete: bool
    delay_steps: int
    delay: float  # s

    @classmethod
    def of(cls, route: Route) -> _Remarks:
        found = route.notes
        return cls(
            whole_number(found.get("order", "0"), f"{route.label}: order"),
            "element" in found,
            found.get("others") == "refused",
            whole_number(found.get("delaySteps", "0"), f"{route.label}: delaySteps"),
            number(found.get("delay", "0"), f"{route.label}: delay"),
        )


@dataclass(frozen=True)
class Wire:
    """A connection of the flat system; `whole` means that it covers all elements of the input."""

    path: tuple[str, ...]
    port: str
    source: str
    target: str
    whole: bool
    route: Route
    remarks: _Remarks

    @property
    def delayed(self) -> bool:
        """Whether the input's start value counts."""
        return bool(self.remarks.delay_steps or self.remarks.delay)


def make_wires(
    routes: Iterable[Route], parts: Mapping[tuple[str, ...], Part], names: Mapping[tuple[str, ...], str]
) -> list[Wire]:
    """Return the connections of the flat system, whose components have these names, in the order of the document."""
    groups: dict[tuple[Any, str], list[Route]] = {}
    for route in routes:
        groups.setdefault((route.target.path, route.target.name), []).append(route)
    wires = [wire for group in groups.values() for wire in _of_one_input(group, parts, names)]
    return sorted(wires, key=lambda wire: (wire.remarks.order, wire.route.position))


def _of_one_input(
    routes: list[Route], parts: Mapping[tuple[str, ...], Part], names: Mapping[tuple[str, ...], str]
) -> Iterator[Wire]:
    """One connection for a whole array where each element comes from its counterpart, else one for each element."""
    first = routes[0]
    remarks = _Remarks.of(first)
    source, target = _port(parts, first.source), _port(parts, first.target)
    ends = (f"{names[first.source.path]}.", f"{names[first.target.path]}.")
    place = (first.target.path, first.target.name)
    counterparts = [
        (r.source.path, r.source.name, r.source.index, r.target.index)
        for r in sorted(routes, key=lambda r: r.target.index)
    ]
    expected = [(first.source.path, first.source.name, i, i) for i in range(target.size or 1)]
    alike = all(
        (r.transformation, r.explicit, r.notes) == (first.transformation, first.explicit, first.notes) for r in routes
    )
    if source.shape == target.shape and counterparts == expected and alike and not remarks.element:
        yield Wire(*place, f"{ends[0]}{source.name}", f"{ends[1]}{target.name}", True, first, remarks)
        return
    for route in routes:
        source = _port(parts, route.source)
        yield Wire(
            *place,
            f"{names[route.source.path]}.{source.elements[route.source.index]}",
            f"{ends[1]}{target.elements[route.target.index]}",
            not target.shape,
            route,
            _Remarks.of(route),
        )


def connect(system: System, wire: Wire) -> None:
    """Make a connection."""
    transformation = wire.route.transformation
    how: dict[str, Any] = {"delay_steps": wire.remarks.delay_steps, "delay": wire.remarks.delay}
    if transformation.table:
        ports = [system.port(end)[1] for end in (wire.source, wire.target)]
        how["mapping"] = transformation.table if wire.remarks.complete else _completed(transformation.table, *ports)
    elif wire.route.explicit or not _by_units(system, wire):
        how |= {"factor": transformation.factor, "offset": transformation.offset}
    try:
        system.connect(wire.source, wire.target, **how)
    except AdcsError as error:
        raise AdcsError(f"{wire.route.label}: {error}") from error


def _completed(table: tuple[tuple[float, float], ...], source: Port, target: Port) -> tuple[tuple[float, float], ...]:
    """Add the values that a table leaves as they are, where all are known: of a Boolean or an enumeration."""
    values = [0, 1] if source.type == "Boolean" else list(dict(source.items).values())
    if target.items:
        values = [value for value in values if value in dict(target.items).values()]
    return (*table, *((float(v), float(v)) for v in values if float(v) not in dict(table)))


def _by_units(system: System, wire: Wire) -> bool:
    """Whether the units that the FMUs themselves declare give the same conversion as the document."""
    (source, output), (target, input_) = system.port(wire.source), system.port(wire.target)
    fmus = system.components[source].fmu, system.components[target].fmu
    try:
        scale = conversion(fmus[0], output.unit, fmus[1], input_.unit, (output.relative, input_.relative))
    except AdcsError:
        return False
    wanted = wire.route.transformation
    return _close((scale.factor, scale.offset), (wanted.factor, wanted.offset))


def _close(a: tuple[float, float], b: tuple[float, float]) -> bool:
    return all(abs(x - y) <= 1e-14 * max(abs(x), abs(y)) for x, y in zip(a, b, strict=True))


def _port(parts: Mapping[tuple[str, ...], Part], place: Place) -> Port:
    return parts[place.path].fmu.ports[place.name]
