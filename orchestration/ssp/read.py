"""From an `.ssp` file to a flat system that runs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fmus.errors import AdcsError
from orchestration import expected
from orchestration.fmu.file import Port, open_fmu
from orchestration.fmu.seeds import seeds_of
from orchestration.ssp.archive import Home, SspArchive
from orchestration.ssp.documents import tag, version_of, whole_number
from orchestration.ssp.experiment import read_experiment
from orchestration.ssp.flat import connect, make_wires
from orchestration.ssp.names import STRUCTURE, named_structure
from orchestration.ssp.parameters import Bindings, nested
from orchestration.ssp.parts import Part, Place
from orchestration.ssp.structural import configured, given_to, settled
from orchestration.ssp.structure import ComponentElement, read_structure
from orchestration.ssp.wiring import Wiring
from orchestration.system import NUMERIC, System


@dataclass(frozen=True)
class SspFile:
    """What an `.ssp` file holds: the system, and of the experiment what the file says; times in seconds.

    `step` is the exchange step, for which SSP has no place: it stands in an annotation of ours or of OMSimulator.
    """

    path: Path
    version: str
    system: System
    start_time: float | None
    stop_time: float | None
    step: float | None
    structure: str = STRUCTURE
    structures: tuple[str, ...] = (STRUCTURE,)
    """The `.ssd` file that was read, and all those of which it was one."""


def read_ssp(path: str | Path, *, structure: str | None = None, ignore_unknown_parameters: bool = False) -> SspFile:
    """Read a system from an `.ssp` file (SSP 1.0 or 2.0); nested systems become one flat one, names `sub/component`.

    `structure` chooses one of several `.ssd` files in it, as `theirs.ssp#Variant.ssd` does, too; else it is
    `SystemStructure.ssd`. A parameter that nothing in the system has a use for is refused, for it is most likely
    misspelt, unless `ignore_unknown_parameters`. Raises AdcsError, in one line, for anything that cannot be run as the
    file says.
    """
    expected.path("path", path)
    path, named = named_structure(path)
    if structure is not None and named is not None and structure != named:
        raise AdcsError(f"{path.name}#{named}: structure={structure!r} is another one: leave one of them out")
    structure = structure or named or STRUCTURE
    with SspArchive(path) as archive:
        try:
            return _read(path, archive, structure, refuse_unknown=not ignore_unknown_parameters)
        except AdcsError as error:
            text = " ".join(str(error).split()).removeprefix(f"{path}: ")
            raise AdcsError(f"{path.name}: {text}") from error


def _read(path: Path, archive: SspArchive, structure: str, *, refuse_unknown: bool) -> SspFile:
    home = Home(archive, archive.structure(structure))
    document = home.document()
    root = read_structure(home)
    plain = {part.element.path: part for part in map(_part, root.components())}
    names = _names(plain)
    parts = configured(root, plain, names)
    wiring = Wiring(root, parts)
    values = Bindings(parts, wiring.shapes, wiring.relative).read(root, refuse_unknown=refuse_unknown)
    wiring.check_sizes(values.given)
    starts, links = settled(wiring.routes(values.units), parts, values.given)

    xml = document.find(tag("ssd", "System"))
    system = System(document.get("name"), xml.get("description") or document.get("description") or "")
    wires = make_wires(links, parts, names)
    overridden = {(wire.path, wire.port) for wire in wires if wire.whole and not wire.delayed}
    given, connected = _by_component(starts), _by_component(link.target for link in links)
    for key, part in _ordered(parts):
        late = given_to(part, starts).keys() - part.structural.keys()
        if late:
            raise AdcsError(
                f"{part.element.name}.{min(late)} is a structural parameter and gets its value by connectors that are "
                "not of kind structuralParameter or constant: correct their kind"
            )
        start = _start_values(part, starts, given.get(key, []), connected.get(key, []), overridden)
        every = whole_number(part.element.notes.get("every", "1"), f"component {part.element.name}: every", least=1)
        system.add(names[key], part.path, start, every=every)
    for wire in wires:
        connect(system, wire)
    start_time, stop_time, step = read_experiment(document)
    version = version_of(document, structure)
    return SspFile(path, version, system, start_time, stop_time, step, structure, archive.structures)


def _part(component: ComponentElement) -> Part:
    member = component.home.locate(component.source, f"the FMU of component {component.name}")
    file = component.home.archive.fmu(member)
    try:
        part = Part(component, member, file, open_fmu(file))
        part.check()
    except AdcsError as error:
        text = str(error).replace(str(file), member)
        raise AdcsError(text if text.startswith("connector ") else f"component {component.name}: {text}") from error
    return part


def _names(parts: Mapping[tuple[str, ...], Part]) -> dict[tuple[str, ...], str]:
    """Names of the flat system, where a dot ends the component's name and a slash separates systems."""
    names: dict[tuple[str, ...], str] = {}
    taken: set[str] = set()
    for path in parts:
        name = "/".join(part.replace(".", "_").replace("/", "_") for part in path)
        if name in taken:
            raise AdcsError(f"two components would have the name {name!r} in the flat system: rename one of them")
        names[path] = name
        taken.add(name)
    return names


def _ordered(parts: Mapping[tuple[str, ...], Part]) -> list[tuple[tuple[str, ...], Part]]:
    """Return the components in the order that our annotations give, else in that of the document."""

    def order(item: tuple[Any, Part]) -> int:
        return whole_number(item[1].element.notes.get("order", "0"), f"component {item[1].element.name}: order")

    return sorted(parts.items(), key=order)


def _by_component(places: Iterable[Place]) -> dict[tuple[str, ...], list[Place]]:
    found: dict[tuple[str, ...], list[Place]] = {}
    for place in places:
        found.setdefault(place.path, []).append(place)
    return found


def _start_values(
    part: Part,
    values: Mapping[Place, Any],
    given: Iterable[Place],
    connected: Iterable[Place],
    overridden: set[tuple[Any, str]],
) -> dict[str, Any]:
    """Return the start values of a component's variables as arrays, without those that a connection overrides.

    An input for which there is neither a connection nor a value keeps the FMU's own, as SSP has it; and so does a
    seed, which a system would otherwise choose: the noise is that of any other tool that reads the file.
    """
    path = part.element.path
    names = dict.fromkeys(place.name for place in given if (path, place.name) not in overridden)
    for seed in seeds_of(part.ports):
        names.setdefault(seed.name)
    reached = {(place.name, place.index) for place in connected}
    for port in part.ports:
        open_ = any((port.name, i) not in reached for i in range(port.size))
        if port.causality == "input" and open_ and port.type.startswith(NUMERIC):
            names.setdefault(port.name)
    return {name: _array(part, part.fmu.ports[name], values) for name in names}


def _array(part: Part, port: Port, given: Mapping[Place, Any]) -> Any:
    path = part.element.path
    values = [given.get(Place(path, port.name, i)) for i in range(port.size)]
    for i, value in enumerate(values):
        if value is None and port.name in part.clocks:
            values[i] = False  # it waits for a trigger that nothing gives
        elif value is None:
            if port.start is None:
                raise AdcsError(f"{part.element.name}.{port.elements[i]} has no value: bind a parameter to it")
            values[i] = port.start[i]
    return nested(values, port.shape)
