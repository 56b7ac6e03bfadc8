"""An FMU file as the orchestrator sees it: a checked archive, its variables united to arrays, its dependencies."""

from __future__ import annotations

import hashlib
import logging
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import product
from math import inf, prod
from pathlib import Path, PurePosixPath
from typing import Any, Literal

import fmpy
from fmpy.model_description import ModelDescription, ModelVariable, ValidationError

from fmus.archive import LARGEST_XML, Archive
from fmus.catalog import find, is_header
from fmus.demand import fmu_of, ready_made, warn_if_old
from fmus.errors import AdcsError, Unsupported, shown
from fmus.nearby import not_opened
from fmus.readable import read_model
from fmus.references import unresolved
from fmus.versions import major_version, newer_minor
from fmus.xml import parse
from orchestration.fmu.description import (
    Clock,
    DisplayUnit,
    Extras,
    check_structure,
    directional_derivatives,
    display_units,
    read_extras,
)
from orchestration.fmu.feedthrough import Feedthrough
from orchestration.fmu.nodes import Nodes
from orchestration.process.temporary import temporary_folder

FmiVersion = Literal["2.0", "3.0"]
Kind = Literal["co-simulation", "model-exchange"]

# FMI 2 names of types -> FMI 3 names; an enumeration is an integer of the version's width.
_FMI2_TYPES = {"Real": "Float64", "Integer": "Int32", "Enumeration": "Int32"}
_FMI3_TYPES = {"Enumeration": "Int64"}

_log = logging.getLogger("adcs")
_OURS = "adcs-fmus "  # generationTool of the components built here
_NOT_FOR_RUNNING = ("sources/", "documentation/", "terminalsAndIcons/")
_AGAIN = "build or download it again"
_MOST_ELEMENTS = 1_000_000  # of an array
_ELEMENT = re.compile(r"(der\()?(?P<base>.+)\[(?P<index>\d+(?:\s*,\s*\d+)*)\](?(1)\))")


@dataclass(frozen=True)
class Port:
    """One variable of an FMU; scalars `x[1]..x[n]`, `J[1,1]..` of FMI 2 are united to one array, as FMI 3 has them.

    `references` holds one value reference per element in FMI 2 and one per array in FMI 3; elements are row-major.
    `start` is flat, `None` where the FMU gives no value. `type` is the FMI 3 name (`Float64`, `Int32`, `Boolean` ...).
    `declared_type` names the type definition that the variable refers to, if any.
    An enumeration is an integer with `items`, pairs of name and number. A clock is a Boolean: whether it has ticked
    since the communication point before; a clock that is ticked at known times is local, as no one else may tick it.
    """

    name: str
    shape: tuple[int, ...]
    type: str
    unit: str | None
    causality: str
    variability: str
    initial: str | None
    references: tuple[int, ...]
    start: tuple[Any, ...] | None
    description: str
    items: tuple[tuple[str, int], ...] = ()
    declared_type: str | None = None
    limits: tuple[int | None, int | None] = (None, None)
    """The least and the largest value of a structural parameter, where the FMU declares them."""
    alias_of: str | None = None
    """Of which variable it is another name (`<Alias>` of FMI 3.0)."""
    relative: bool = False
    """Whether it is a difference (relativeQuantity), of temperatures say: the offset of a unit is none of it."""
    max_size: int | None = None
    """Of a Binary variable, how many bytes a value may have."""
    set_once: bool = False
    """Whether it may be set only once at an instant, and so be in no loop that is solved by trying."""

    @property
    def size(self) -> int:
        """Number of elements."""
        return prod(self.shape)

    @property
    def elements(self) -> list[str]:
        """The names of the elements in row-major order, as FMI 2 writes them."""
        return element_names(self.name, self.shape)

    @property
    def structural(self) -> bool:
        """Whether it is set in configuration mode, before everything else: a size of arrays, or what else it may be."""
        return self.causality == "structuralParameter"

    @property
    def settable(self) -> bool:
        """Whether a start value may be given."""
        return self.variability != "constant" and (self.causality == "input" or self.initial in ("exact", "approx"))


@dataclass(frozen=True)
class Fmu:
    """A checked FMU file.

    `places` gives the port, and the element of it, that each variable of the model description is. `states` names the
    elements of the continuous state vector in the FMU's own order. `directional` holds the interfaces with directional
    derivatives.
    """

    path: Path
    sha256: str
    model: ModelDescription
    ports: Mapping[str, Port]
    places: Mapping[str, tuple[str, int]]
    states: tuple[str, ...]
    directional: frozenset[str] = frozenset()
    clocks: tuple[Clock, ...] = ()
    clocked: Mapping[int, frozenset[int]] = field(default_factory=dict)
    """The clocks (references) to which a clocked variable (reference) belongs: it has no value of its own between."""
    resized: frozenset[str] = frozenset()
    """The arrays whose size a structural parameter was given for: the values that the FMU has for them are invalid."""
    display_units: Mapping[str, tuple[DisplayUnit, ...]] = field(default_factory=dict)
    """By the name of the unit, those in which values may be given instead."""

    @cached_property
    def nodes(self) -> Nodes:
        """What has a value of its own, by one of its names."""
        return Nodes(self.ports.values())

    def node_of(self, variable: ModelVariable) -> str:
        """Return the node of a variable of the model description."""
        name, element = self.places[variable.name]
        return self.nodes.place(self.ports[name], element)[0]

    @cached_property
    def ours(self) -> bool:
        """Whether it was built here: it leaves alone what is not its own, and never discards a step."""
        return (self.model.generationTool or "").startswith(_OURS)

    @cached_property
    def event_indicators(self) -> int:
        """How many there are."""
        if self.major_version == 2:
            return int(self.model.numberOfEventIndicators or 0)
        return sum(self.ports[unknown.variable.name].size for unknown in self.model.eventIndicators)

    @cached_property
    def feedthrough(self) -> Feedthrough:
        """Direct dependencies while running."""
        return Feedthrough(self, initial=False)

    @cached_property
    def initial_feedthrough(self) -> Feedthrough:
        """Direct dependencies in initialisation mode."""
        return Feedthrough(self, initial=True)

    def configured(self, start: Mapping[str, Sequence[Any]]) -> Fmu:
        """Return the FMU with the array sizes that the structural parameters among these start values ask for."""
        of_dimensions = {d.valueReference for v in self.model.modelVariables for d in v.dimensions}
        sizes = {}
        for name, values in start.items():
            port = self.ports[name]
            if port.references[0] in of_dimensions:  # a structural parameter need not be a size
                sizes[port.references[0]] = _size(port, values[0])
        if not sizes:
            return self
        ports, resized = dict(self.ports), set()
        for variable in self.model.modelVariables:
            if any(d.valueReference in sizes for d in variable.dimensions):
                old = self.ports[variable.name]
                shape = tuple(
                    sizes.get(d.valueReference, n) for d, n in zip(variable.dimensions, old.shape, strict=True)
                )
                if prod(shape) > _MOST_ELEMENTS:
                    given = next(n for n, v in start.items() if self.ports[n].references[0] in sizes)
                    raise AdcsError(
                        f"{given} = {start[given][0]}: {variable.name} would have {prod(shape):,} elements, more than "
                        f"{_MOST_ELEMENTS:,}, choose a smaller size"
                    )
                values = tuple(set(old.start or ()))
                same = values * prod(shape) if len(values) == 1 or not prod(shape) else None
                ports[old.name] = replace(old, shape=shape, start=old.start if shape == old.shape else same)
                resized.add(old.name)
        return replace(self, ports=ports, states=_states(self.model, ports), resized=frozenset(resized))

    @cached_property
    def platforms(self) -> tuple[str, ...]:
        """The folders of its binaries, named as its standard names platforms."""
        with Archive(self.path) as archive:
            return _platforms(archive.names)

    @property
    def major_version(self) -> int:
        """2 or 3."""
        return int(self.model.fmiMajorVersion)

    def interface(self, kind: Kind) -> Any:
        """Return the description of the interface type; refuse an FMU that does not have it."""
        found = self.model.coSimulation if kind == "co-simulation" else self.model.modelExchange
        if found is None and not (self.model.coSimulation or self.model.modelExchange or self.model.scheduledExecution):
            raise AdcsError(
                f"{self.path.name} has neither a co-simulation nor a model-exchange interface: export it so"
            )
        if found is None and not (self.model.coSimulation or self.model.modelExchange):
            raise Unsupported(
                f"{self.path.name} has scheduled execution only, which is not supported: export it otherwise"
            )
        if found is None:
            self.check_clocks(kind)
            other = "model-exchange" if kind == "co-simulation" else "co-simulation"
            raise AdcsError(f"{self.path.name} has no {kind} interface: run the system with method {other!r}")
        return found

    def check_clocks(self, kind: Kind, name: str = "") -> None:
        """Refuse an FMU with clocks, as a component of this name, where nobody would tick them."""
        event_mode = self.model.coSimulation is not None and self.model.coSimulation.hasEventMode
        if not self.clocks or (kind == "co-simulation" and event_mode):
            return
        what = f"{name} ({self.path.name})" if name else self.path.name
        way = "run the system with method 'co-simulation'" if event_mode else "it has none, export it with event mode"
        clocks = ", ".join(c.name for c in self.clocks)
        raise Unsupported(
            f"{what} has clocks ({clocks}), which are supported in co-simulation with event mode only: {way}"
        )

    def ticks(self, port: Port) -> bool:
        """Whether a variable is a clock that nobody else may tick, because it does so at known times."""
        return any(clock.time_based and clock.reference in port.references for clock in self.clocks)

    def called(self, port: Port) -> str:
        """Say what a variable is, for messages."""
        if self.ticks(port):
            return "a time-based clock, which ticks by itself"
        return f"a {port.variability} {port.causality}"

    def binaries(self, kind: Kind) -> list[PurePosixPath]:
        """Where this platform's binary may be inside the archive, best first."""
        folders = [fmpy.platform_tuple]  # FMI 3, and FMI 2 since 2.0.4
        if self.major_version == 2 and fmpy.platform_tuple != "aarch64-linux":  # which is not FMI 2's linux64
            folders.insert(0, fmpy.platform)
        file = self.interface(kind).modelIdentifier + fmpy.sharedLibraryExtension
        return [PurePosixPath("binaries", folder, file) for folder in folders]


def _size(port: Port, size: int) -> int:
    """Check a size of arrays against the limits that the FMU sets, of which the lowest is 0 only where it says so."""
    least, most = port.limits
    low = 1 if least is None else least
    if size < low or (most is not None and size > most):
        raise AdcsError(f"{port.name} = {size}: expected a size from {low}{'' if most is None else f' to {most}'}")
    return size


def is_path(source: str | Path) -> bool:
    """Whether a component is given by the path of its FMU or header, not by the name of one of this project's."""
    return Path(source).suffix == ".fmu" or is_header(source)


_found: ContextVar[dict[tuple[str, FmiVersion], Path] | None] = ContextVar("found", default=None)


@contextmanager
def found_once() -> Iterator[None]:
    """Within it, what a component's FMU is made of is looked at once, however often it is asked for."""
    token = _found.set({})
    try:
        yield
    finally:
        _found.reset(token)


def locate(name: str | Path, version: FmiVersion = "2.0") -> Path:
    """Find the file of an FMU: a path that ends in `.fmu`, or that of a component, which is built if need be."""
    if Path(name).suffix == ".fmu":
        warn_if_old(Path(name))
        return Path(name)
    found = _found.get()
    if found is None:
        return _component(name, version)
    key = str(name), version
    if key not in found:
        found[key] = _component(name, version)
    return found[key]


def _component(name: str | Path, version: FmiVersion) -> Path:
    ready = ready_made(str(name), version)
    if ready is not None:
        return ready
    try:
        component = find(str(name))
    except AdcsError as error:
        joined = " Or" if str(error).endswith("?") else ", or"
        raise AdcsError(f"{error}{joined} give the path of an .fmu") from None
    return fmu_of(component, version)


def open_fmu(path: Path) -> Fmu:
    """Read and check an FMU; raises AdcsError when it is missing, corrupt or invalid."""
    try:
        stat = path.stat()
    except OSError as error:
        raise not_opened(path, error) from error
    try:
        return _open(path.resolve(), stat.st_mtime_ns, stat.st_size)
    except AdcsError as error:
        if str(path).isprintable():
            raise
        raise AdcsError(shown(str(error), most=1000)) from error  # a path may have line breaks


@lru_cache(maxsize=64)
def _open(path: Path, modified: int, size: int) -> Fmu:
    with Archive(path) as archive:
        if "modelDescription.xml" not in archive.names:
            raise AdcsError(f"{path} has no modelDescription.xml: it is no FMU")
        content = archive.read("modelDescription.xml", LARGEST_XML)
    xml = parse(content, f"modelDescription.xml of {path}")
    version = xml.get("fmiVersion")
    try:
        major_version(version)
    except ValueError as error:
        raise AdcsError(f"{path} {error}") from None
    if (more := newer_minor(version)) is not None:
        _log.warning(f"{path.name} {more}")
    try:
        check_structure(xml)
        for problem in unresolved(xml):
            raise ValueError(problem)
        model = read_model(content, xml)
        extras = read_extras(xml)
        ports, places = _unite(model, extras)
        return Fmu(
            path=path,
            sha256=_sha256(path),
            model=model,
            ports=ports,
            places=places,
            states=_states(model, ports),
            directional=directional_derivatives(xml),
            clocks=extras.clocks,
            clocked=extras.clocked,
            display_units=display_units(xml),
        )
    except ValidationError as error:
        raise AdcsError(f"{path} is not valid: {_one_line(error.problems[0])}") from error
    except OSError as error:
        raise not_opened(path, error) from error
    except ValueError as error:
        raise AdcsError(f"{path} is not valid: {_one_line(error)}") from error
    except Exception as error:  # what fmpy lets out, and what is wrong in a way that no check here has thought of
        raise AdcsError(f"cannot read modelDescription.xml of {path} ({_one_line(error)}): {_AGAIN}") from error


def _platforms(names: Sequence[str]) -> tuple[str, ...]:
    parts = (PurePosixPath(name).parts for name in names if name.startswith("binaries/") and not name.endswith("/"))
    return tuple(sorted({part[1] for part in parts if len(part) > 2}))


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _states(model: ModelDescription, ports: Mapping[str, Port]) -> tuple[str, ...]:
    """Name the elements of the state vector; a scalar of FMI 2 has its own name, `x[1]`, also where it is united."""
    return tuple(
        name
        for unknown in model.derivatives
        for name in element_names(
            unknown.variable.derivative.name,
            ports[unknown.variable.name].shape if model.fmiMajorVersion == 3 else (),
        )
    )


def element_names(name: str, shape: tuple[int, ...]) -> list[str]:
    """`q` of shape (2,) -> `q[1]`, `q[2]`; a scalar keeps its name."""
    if not shape:
        return [name]
    return [f"{name}[{','.join(map(str, index))}]" for index in product(*(range(1, n + 1) for n in shape))]


@contextmanager
def extracted(fmu: Fmu, kind: Kind) -> Iterator[tuple[Path, Path]]:
    """Extract an FMU into a temporary folder that is removed at the end; yields the folder and the binary in it."""
    with temporary_folder("fmu") as folder:
        with Archive(fmu.path) as archive:
            names = archive.names
            found = [binary for binary in fmu.binaries(kind) if str(binary) in names]
            if not found:
                raise Unsupported(
                    f"{fmu.path.name} has no binary for this platform ({fmu.binaries(kind)[0]} is missing, it has: "
                    f"{', '.join(_platforms(names)) or 'none'}): build it for this platform"
                )
            archive.extract(folder, [n for n in names if not n.startswith(_NOT_FOR_RUNNING)])
        yield folder, folder / found[0]


def _unite(model: ModelDescription, extras: Extras) -> tuple[dict[str, Port], dict[str, tuple[str, int]]]:
    """Return the ports by name, and of each model variable the port and the element that it is."""
    fmi2 = model.fmiMajorVersion == 2
    taken = {v.name for v in model.modelVariables}
    groups: dict[str, list[ModelVariable]] = {}
    for variable in model.modelVariables:
        match = _ELEMENT.fullmatch(variable.name) if fmi2 else None
        base = variable.name if match is None else f"der({match['base']})" if match[1] else match["base"]
        groups.setdefault(base, []).append(variable)
    ports: dict[str, Port] = {}
    places: dict[str, tuple[str, int]] = {}
    for base, members in groups.items():
        shape = members[0].shape if not fmi2 else _shape(members, extras)
        if 0 in (shape or ()):
            raise ValueError(f"{base} has a dimension of size 0, which FMI 3.0 allows only where it is set so later")
        scalars = shape is None or (base in taken and len(members) > 1)
        if prod(shape or ()) > _MOST_ELEMENTS:
            raise ValueError(f"{base} has {prod(shape or ()):,} elements, more than {_MOST_ELEMENTS:,}: not supported")
        for name, variables in [(v.name, [v]) for v in members] if scalars else [(base, members)]:
            ports[name] = _port(name, () if shape is None or scalars else shape, variables, fmi2, extras)
            places.update({v.name: (name, i) for i, v in enumerate(variables)})
    return ports, places


def _shape(members: list[ModelVariable], extras: Extras) -> tuple[int, ...] | None:
    """Shape of the array that the scalars form in row-major order; None when they form none."""
    matches = [_ELEMENT.fullmatch(v.name) for v in members]
    if len(members) == 1 and matches[0] is None:
        return ()
    indices = [tuple(int(i) for i in m["index"].split(",")) for m in matches if m is not None]
    shape = indices[-1] if indices else ()
    if prod(shape) != len(members):  # before as many are counted as an index says
        return None
    first = members[0]
    alike = all(
        (v.type, v.unit, v.causality, v.variability, v.initial, v.start is None)
        == (first.type, first.unit, first.causality, first.variability, first.initial, first.start is None)
        and (v.name in extras.relative) == (first.name in extras.relative)
        and _items(v) == _items(first)
        for v in members
    )
    return shape if alike and indices == list(product(*(range(1, n + 1) for n in shape))) else None


def _port(name: str, shape: tuple[int, ...], variables: list[ModelVariable], fmi2: bool, extras: Extras) -> Port:
    first = variables[0]
    kind = (_FMI2_TYPES if fmi2 else _FMI3_TYPES).get(first.type, first.type)
    texts = [v.start for v in variables] if fmi2 else list(extras.starts.get(name, [first.start]))
    try:
        start = _start(texts, kind, prod(shape))
    except ValueError as error:
        raise ValueError(f"the start value of {name} {error}") from error
    # of the clocks, only those that wait for a trigger have to be connected
    timed = kind == "Clock" and first.intervalVariability != "triggered"
    return Port(
        name=name,
        shape=shape,
        type="Boolean" if kind == "Clock" else kind,
        unit=first.unit,
        causality="local" if timed else first.causality,
        variability=first.variability,
        initial=None if timed else first.initial,
        references=tuple(v.valueReference for v in variables),
        start=start,
        description=first.description or "",
        items=_items(first) if first.type == "Enumeration" else (),
        declared_type=None if first.declaredType is None else first.declaredType.name,
        alias_of=first.alias.name if first.alias is not None else None,
        relative=first.name in extras.relative,
        max_size=extras.largest.get(first.name),
        set_once=first.name in extras.set_once,
        limits=_limits(first),
    )


def _limits(variable: ModelVariable) -> tuple[int | None, int | None]:
    """Return the range of a structural parameter that may be a size."""
    if variable.causality != "structuralParameter" or variable.type != "UInt64":
        return None, None
    low, high = variable.min, variable.max
    return None if low is None else int(low), None if high is None else int(high)


def _items(variable: ModelVariable) -> tuple[tuple[str, int], ...]:
    """Return names and numbers of an enumeration's items, of those that min and max allow."""
    if variable.declaredType is None:
        return ()
    low, high = float(variable.min or -inf), float(variable.max or inf)
    numbers = ((item.name, int(item.value)) for item in variable.declaredType.items)
    return tuple((name, number) for name, number in numbers if low <= number <= high)


def _start(texts: list[str | None], kind: str, size: int) -> tuple[Any, ...] | None:
    if any(t is None for t in texts):
        return None
    given = [t for t in texts if t is not None]
    words = given if kind in ("String", "Binary") else [w for t in given for w in t.split()]
    if len(words) == 1:
        words *= size  # FMI 3: one value stands for all elements
    if len(words) != size:
        raise ValueError(f"has {len(words)} elements, the variable {size}")
    return tuple(_CONVERT[kind](w) for w in words)


def _boolean(word: str) -> bool:
    return word in ("true", "1")


_CONVERT: dict[str, Any] = {
    "String": str,
    "Binary": bytes.fromhex,
    "Boolean": _boolean,
    **dict.fromkeys(("Float32", "Float64"), float),
    **{f"{sign}Int{bits}": int for sign in ("", "U") for bits in (8, 16, 32, 64)},
}


def _one_line(error: object) -> str:
    return " ".join(str(error).split())
