"""A flat system as the tree that SSP has: nested systems, connectors on their way in and out, connections in each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from fmus.errors import AdcsError
from orchestration.fmu.file import Fmu, Port
from orchestration.system import Component, Connection, System


@dataclass(frozen=True)
class Pin:
    """A connector: an element of a port, or the whole of it (`index` None), as its owner shows it."""

    name: str
    kind: str
    fmu: Fmu
    port: Port
    index: int | None
    owner: str = ""  # the component whose variable it is

    @property
    def shape(self) -> tuple[int, ...]:
        """Dimensions of the connector."""
        return self.port.shape if self.index is None else ()


@dataclass
class Wire:
    """A connection inside one system; an element None is the system itself. `by` is there on the last of a way."""

    start: tuple[str | None, str]
    end: tuple[str | None, str]
    start_indices: tuple[int, ...] = ()
    end_indices: tuple[int, ...] = ()
    by: Connection | None = None
    order: int = 0
    element: bool = False
    points: tuple[tuple[float, float], ...] = ()


@dataclass
class Box:
    """A component or a system with what is in it; positions in mm are filled in by the layout."""

    name: str
    component: Component | None = None
    order: int = 0
    pins: dict[str, Pin] = field(default_factory=dict)
    boxes: dict[str, Box] = field(default_factory=dict)
    wires: list[Wire] = field(default_factory=list)
    ways: set[object] = field(default_factory=set)
    places: dict[str, tuple[float, float]] = field(default_factory=dict)
    rectangle: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    canvas: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    def everything(self) -> Iterator[Box]:
        """This box and those in it, at every depth."""
        yield self
        for box in self.boxes.values():
            yield from box.everything()


def make_tree(system: System, fmus: dict[str, Fmu]) -> Box:
    """Return the root system. `fmus` are the FMUs that are packed, by component."""
    root = Box(system.name)
    for order, component in enumerate(system.components.values(), 1):
        *path, name = component.name.split("/")
        holder = root
        for part in path:
            holder = holder.boxes.setdefault(part, Box(part))
            if holder.component is not None:
                raise AdcsError(f"{holder.component.name!r} is a component and a nested system: rename one of them")
        if name in holder.boxes:
            raise AdcsError(f"{component.name!r} is a component and a nested system: rename one of them")
        holder.boxes[name] = box = Box(name, component, order)
        fmu = fmus[component.name]
        for port in fmu.ports.values():
            if port.causality == "output":
                for pin in _pins(fmu, port, "output"):
                    box.pins[pin.name] = pin
    for order, connection in enumerate(system.connections, 1):
        _connect(root, system, fmus, connection, order)
    return root


def _pins(fmu: Fmu, port: Port, kind: str) -> list[Pin]:
    """Connectors of a variable: of FMI 2 one for each element, of FMI 3 one."""
    if fmu.major_version == 3 or not port.shape:
        return [Pin(port.name, kind, fmu, port, None)]
    return [Pin(name, kind, fmu, port, i) for i, name in enumerate(port.elements)]


def _connect(root: Box, system: System, fmus: dict[str, Fmu], connection: Connection, order: int) -> None:
    ends = [system.end(connection.source), system.end(connection.target)]
    owners = [fmus[end.component] for end in ends]
    ports = [fmu.ports[end.port.name] for fmu, end in zip(owners, ends, strict=True)]
    whole = [end.shape == port.shape for end, port in zip(ends, ports, strict=True)]
    element = not all(whole)
    from_, into = (end.component.split("/") for end in ends)
    for pin in _pins(owners[1], ports[1], "input"):
        if pin.index is None or pin.index in ends[1].elements:
            _box(root, into).pins[pin.name] = pin
    if all(whole) and all(fmu.major_version == 3 for fmu in owners):
        pieces: list[tuple[int | None, int | None]] = [(None, None)]
    else:
        pieces = list(zip(ends[0].elements, ends[1].elements, strict=True))
    for source, target in pieces:
        start, start_indices = _name(owners[0], ports[0], source)
        end, end_indices = _name(owners[1], ports[1], target)
        pin = Pin("", "", owners[0], ports[0], source if ports[0].shape else None, ends[0].component)
        name, taken = _through(root, from_, into, start, start_indices, pin)
        last = Wire(name, (into[-1], end), taken, end_indices, connection, order, element)
        _box(root, into[:-1]).wires.append(last)


def _through(
    root: Box, source: list[str], target: list[str], start: str, indices: tuple[int, ...], pin: Pin
) -> tuple[tuple[str | None, str], tuple[int, ...]]:
    """Lead a value out of the source's systems and into those of the target; return where the last wire starts."""
    common = 0
    while common < min(len(source), len(target)) - 1 and source[common] == target[common]:
        common += 1
    here: tuple[str | None, str] = (source[-1], start)
    variable = [start, *map(str, indices)]
    for depth in range(len(source) - 1, common, -1):  # out of one system after the other
        system = _box(root, source[:depth])
        name = _connector(system, "output", pin, "_".join([*source[depth:], *variable]))
        _once(system, Wire(here, (None, name), indices))
        here, indices = (source[depth - 1], name), ()
    for depth in range(common + 1, len(target)):  # and into one after the other
        outside, system = _box(root, target[: depth - 1]), _box(root, target[:depth])
        name = _connector(system, "input", pin, "_".join([*source[common:], *variable]))
        _once(outside, Wire(here, (target[depth - 1], name), indices))
        here, indices = (None, name), ()
    return here, indices


def _once(system: Box, wire: Wire) -> None:
    """Add a wire on the way, unless an earlier value has gone the same way."""
    if (wire.start, wire.end) not in system.ways:
        system.ways.add((wire.start, wire.end))
        system.wires.append(wire)


def _connector(system: Box, kind: str, pin: Pin, label: str) -> str:
    """Return the name of the system's connector for a value; made when first needed."""
    wanted = Pin(label, kind, pin.fmu, pin.port, pin.index, pin.owner)
    number = 1
    while True:
        name = f"{label}_{number}" if number > 1 else label
        if system.pins.setdefault(name, replace(wanted, name=name)) == replace(wanted, name=name):
            return name
        number += 1


def _name(fmu: Fmu, port: Port, element: int | None) -> tuple[str, tuple[int, ...]]:
    """Return connector and indices of an element."""
    if element is None or not port.shape:
        return port.name, ()
    if fmu.major_version == 2:
        return port.elements[element], ()
    indices: list[int] = []
    for n in reversed(port.shape):
        element, rest = divmod(element, n)
        indices.insert(0, rest + 1)
    return port.name, tuple(indices)


def _box(root: Box, path: list[str]) -> Box:
    """Return the component or system at a path; the root for an empty one."""
    for part in path:
        root = root.boxes[part]
    return root
