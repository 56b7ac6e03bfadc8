"""A system: components, their start values, and the connections between them. A description only; `run` runs it."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.catalog import is_header
from fmus.errors import AdcsError, shown
from fmus.spelling import hint
from orchestration import expected, overview
from orchestration.fmu.beside import beside
from orchestration.fmu.file import FmiVersion, Fmu, Port, is_path, locate, open_fmu
from orchestration.fmu.nodes import Place
from orchestration.fmu.number_types import BEYOND, first_beyond, first_misfit
from orchestration.fmu.seeds import default_seed, seeds_of
from orchestration.fmu.typed_values import binary_values, item_numbers, size_text
from orchestration.fmu.units import Scale, conversion
from orchestration.times import Seconds

Value = Any
"""What a start value may be: a number, bool or str, or nested sequences or an array of them."""


NUMERIC = ("Float", "Int", "UInt", "Boolean")
"""Beginnings of the types whose values can be connected and recorded."""


@dataclass
class Component:
    """A named FMU with the start values that it was given (flat, row-major).

    It communicates at every `every`-th exchange step, and its outputs hold in between.
    """

    name: str
    source: str | Path
    fmu: Fmu
    start: dict[str, tuple[Any, ...]]
    every: int = 1

    def open(self, version: FmiVersion) -> Fmu:
        """Return the FMU in the FMI version asked for; a component given by path has only one."""
        return open_fmu(locate(self.source, version)).configured(self.start)

    def has_start(self, port: Port) -> bool:
        """Whether start values were given for all of a variable, by whatever names it has."""
        nodes = self.fmu.nodes
        return nodes.main(port).name in self.start or all(
            any(name in self.start for name in nodes.mains(node)) for node in nodes.of(port)
        )


@dataclass(frozen=True)
class Connection:
    """A value that flows from an output to an input; both ends are `component.variable`, or one element of it.

    What arrives is `factor * value + offset`, from the units unless `given`; or what `mapping` says, pairs
    (from, to). It arrives without delay unless `delay_steps` exchange steps or `delay` seconds are asked for; until
    the first value arrives the input keeps its start value.
    """

    source: str
    target: str
    factor: float = 1.0
    offset: float = 0.0
    mapping: tuple[tuple[float, float], ...] = ()
    delay_steps: int = 0
    delay: float = 0.0  # s
    given: bool = False

    @property
    def delayed(self) -> bool:
        """Whether values arrive later than they leave."""
        return self.delay_steps > 0 or self.delay > 0

    @property
    def plain(self) -> bool:
        """Whether values arrive as they leave."""
        return not self.mapping and (self.factor, self.offset) == (1.0, 0.0)


@dataclass(frozen=True)
class End:
    """One end of a connection: which elements (flat indices) of a component's variable."""

    component: str
    port: Port
    elements: tuple[int, ...]
    shape: tuple[int, ...]


class Ends:
    """Finds what `component.variable` or `component.variable[i,j]` names in these FMUs."""

    def __init__(self, fmus: Mapping[str, Fmu]) -> None:
        self._fmus = fmus
        self._found: dict[str, End] = {}

    def __call__(self, name: str) -> End:
        """Return it; AdcsError if there is no such variable or element."""
        if name not in self._found:
            self._found[name] = self._find(name)
        return self._found[name]

    def _find(self, name: str) -> End:
        component, _, variable = name.partition(".")
        fmu = self._fmus[component]
        base, bracket, index = variable.rpartition("[")
        if variable in fmu.ports or not bracket or base not in fmu.ports:
            port = _port(component, fmu, variable)
            return End(component, port, tuple(range(port.size)), port.shape)
        port = fmu.ports[base]
        element = f"{base}[{index.replace(' ', '')}"
        if element not in port.elements:
            raise AdcsError(f"{name} does not exist: {component}.{base} has {size_text(port.shape)}, counted from 1")
        return End(component, port, (port.elements.index(element),), ())


@dataclass(frozen=True)
class Times:
    """How a system is run where nothing else is said: from `start` to `stop` in exchange steps of `step` (s).

    `assumed` names those, `stop_time` or `step`, that its file does not give.
    """

    start: float
    stop: float
    step: float
    assumed: Sequence[str] = ()


class System:
    """Components and their wiring; everything that can be checked without running is checked at once.

    `times` are those of a run that is given none, as `stop_time`, `step` and `start_time` say.
    """

    def __init__(
        self,
        name: str,
        description: str = "",
        *,
        stop_time: Seconds | None = None,
        step: Seconds | None = None,
        start_time: Seconds = 0.0,
    ) -> None:
        expected.text("name", name)
        expected.text("description", description)
        self.name = name
        self.description = description
        self.times: Times | None = None
        if (stop_time is None) != (step is None):
            raise AdcsError(f"{'step' if step is None else 'stop_time'}: give both times of a run, or none")
        if stop_time is not None:
            self.times = Times(*self.run_times(start_time, stop_time, step))
        self.components: dict[str, Component] = {}
        self._connections: list[Connection] = []
        self._incoming: dict[tuple[str, str], list[Connection]] = {}  # by component and node

    def __repr__(self) -> str:
        return overview.text(self)

    def _repr_html_(self) -> str:
        return overview.html(self)

    @property
    def connections(self) -> Sequence[Connection]:
        """All connections; `connect` and `disconnect` change them."""
        return tuple(self._connections)

    def run_times(
        self, start: Seconds | None, stop: Seconds | None, step: Seconds | None
    ) -> tuple[float, float, float]:
        """Return start, stop and step [s] of a run: the system's own where none is given, and a start of 0 without."""
        if self.times is None and (stop is None or step is None):
            raise AdcsError(f"{'stop_time' if stop is None else 'step'}: {self.name} has none of its own, give it")
        own = self.times or Times(0.0, 0.0, 0.0)
        return (
            own.start if start is None else expected.seconds("start_time", start),
            own.stop if stop is None else expected.seconds("stop_time", stop),
            own.step if step is None else expected.seconds("step", step),
        )

    def add(self, name: str, fmu: str | Path, start: Mapping[str, Value] | None = None, every: int = 1) -> None:
        """Add a component.

        `fmu` is the name of a component, or the path of a header or of any `.fmu`, which the code of a mission file has
        relative to that file or to the present folder. `start` maps variables (parameters, inputs, states and
        outputs with a start value) to values of the variable's shape, in the variable's unit. The component
        communicates at every `every`-th exchange step. `/` in a name separates the names of nested systems.

        A seed (an integer of the declared type `adcs.Seed`) that `start` does not give gets one that follows from the
        component's name, so that no two sensors have the same noise unasked. It is a start value like any other: `set`
        replaces it, and it is exported. Systems with the same names have the same seeds, and so the same noise.
        """
        expected.text("name", name)
        expected.path(f"component {name!r}: fmu", fmu)
        if start is not None:
            expected.by_name(f"component {name!r}: start", start)
        if not all(name.split("/")) or "." in name or not name.isprintable():
            raise AdcsError(f"component name {name!r} is not usable: give a name without dots")
        if name in self.components:
            raise AdcsError(f"system {self.name!r} already has a component {name!r}: give another name")
        every = expected.count(f"component {name!r}: every", every, "a whole number of exchange steps")
        if is_path(fmu) and (found := beside(fmu)) is not None:
            fmu = str(found)
        elif is_header(fmu):  # which is meant from here, wherever it is asked for later
            fmu = str(Path(fmu).absolute())
        # Both files of a component built here say the same: the wiring is checked on whichever exists.
        component = Component(name, fmu, open_fmu(_any_version(fmu)), {}, every)
        given = dict(start or {})
        structural = {
            v: given.pop(v) for v in list(given) if v in component.fmu.ports and component.fmu.ports[v].structural
        }
        component.start.update(_starts(name, component.fmu, structural))
        component.fmu = _configured(name, component.fmu, component.start)
        component.start.update(_starts(name, component.fmu, given))
        _give_defaults(component)
        for port in seeds_of(component.fmu.ports.values()):
            component.start.setdefault(port.name, default_seed(name, port))
        self.components[name] = component

    def set(self, name: str, value: Value) -> None:
        """Set one start value, `component.variable`; replaces one given before.

        A structural parameter gives arrays their size: start values of theirs that were not given here follow it.
        """
        component, port = self.port(name)
        fmu = self.components[component].fmu
        if port.structural:
            self._resize(component, fmu.nodes.main(port), value)
            return
        for connected in self._into(component, port):
            if not connected.delayed:
                raise AdcsError(f"{name} is connected to {connected.source}: a start value would have no effect")
        main, values = fmu.nodes.main(port).name, _start(component, fmu, port.name, value)
        start = self.components[component].start
        start[main] = values
        given = fmu.nodes.spread(port, values)
        for other in {name for node in given for name in fmu.nodes.mains(node)} & start.keys() - {main}:
            start[other] = tuple(
                (fmu.nodes.spread(fmu.ports[other], start[other]) | given)[n] for n in fmu.nodes.of(fmu.ports[other])
            )

    def _resize(self, name: str, parameter: Port, value: Value) -> None:
        """Set a structural parameter; refuse what makes given start values or connections not fit any more."""
        component = self.components[name]
        old, plain = component.fmu, open_fmu(component.fmu.path)
        start = {**component.start, parameter.name: _start(name, plain, parameter.name, value)}
        new = _configured(name, plain, {n: v for n, v in start.items() if plain.ports[n].structural})
        reason = f"{name}.{parameter.name} = {start[parameter.name][0]}"
        for variable, values in component.start.items():
            if new.ports[variable].shape == old.ports[variable].shape:
                continue
            default = old.ports[variable].start
            if values != default and (default is not None or any(values)):
                raise AdcsError(
                    f"{reason}: {name}.{variable} was given {size_text(old.ports[variable].shape)} and has "
                    f"{size_text(new.ports[variable].shape)} then: set {parameter.name} first"
                )
            follows = new.ports[variable].start
            if default is None:
                follows = values[:1] * new.ports[variable].size
            if follows is None:
                del start[variable]
            else:
                start[variable] = follows
        for connection in self._connections:
            for end in (self.end(connection.source), self.end(connection.target)):
                if end.component == name and new.ports[end.port.name].shape != end.port.shape:
                    raise AdcsError(
                        f"{reason}: {name}.{end.port.name} is connected ({connection.source} to {connection.target}) "
                        f"and has {size_text(new.ports[end.port.name].shape)} then: set {parameter.name} before"
                    )
        component.start, component.fmu = start, new
        _give_defaults(component)

    def connect(
        self,
        source: str,
        target: str,
        *,
        factor: float | None = None,
        offset: float | None = None,
        mapping: Sequence[tuple[float, float]] | None = None,
        delay_steps: int = 0,
        delay: Seconds = 0.0,
    ) -> None:
        """Connect an output to an input of the same shape: `component.variable`, or an element as in `plant.q_BN[2]`.

        Values are converted from the unit of one end to that of the other; an end without a unit goes with any. With
        `factor` or `offset` the input gets `factor * value + offset` instead; `mapping` gives the input's value for
        each value of a Boolean, integer or enumeration output. `delay_steps` (exchange steps) or `delay` (a time as
        0.1 [s] or "100ms", a whole number of exchange steps) lets values arrive later.
        """
        output, input_ = self.end(source), self.end(target)
        link = f"cannot connect {source} to {target}: "
        for name, value in {"factor": factor, "offset": offset}.items():
            if value is not None:
                expected.number(f"{link}{name}", value)
        delay = expected.seconds(f"{link}delay", delay)
        if output.port.causality != "output":
            raise AdcsError(f"{link}{source} is not an output but {self._called(output)}")
        if input_.port.causality != "input":
            raise AdcsError(f"{link}{target} is not an input but {self._called(input_)}")
        for name, end in ((source, output), (target, input_)):
            if not end.port.type.startswith(NUMERIC):
                raise AdcsError(f"{link}{name} is of type {end.port.type}, only numbers and Booleans can be connected")
        if output.shape != input_.shape:
            raise AdcsError(f"{link}sizes differ, {size_text(output.shape)} and {size_text(input_.shape)}")
        given = factor is not None or offset is not None
        pairs = _pairs(link, input_.port, () if mapping is None else mapping)
        if pairs and given:
            raise AdcsError(f"{link}it has a mapping as well as a factor or offset: give one of them")
        scale = self._scale(link, output, input_) if not (given or pairs) else Scale(factor or 1.0, offset or 0.0)
        if factor == 0 or not (isfinite(scale.factor) and isfinite(scale.offset)):
            raise AdcsError(f"{link}factor = {factor}, offset = {offset}: expected finite numbers, the factor not zero")
        if not pairs and _loses(output.port.type, input_.port.type, scale):
            raise AdcsError(
                f"{link}types {output.port.type} and {input_.port.type} do not go together: give a mapping, or connect "
                "something else"
            )
        if not isinstance(delay_steps, int) or delay_steps < 0 or not (isfinite(delay) and delay >= 0):
            raise AdcsError(f"{link}delay_steps = {delay_steps}, delay = {delay} s: expected a whole number, a time")
        if delay_steps and delay:
            raise AdcsError(f"{link}it has a delay in steps and one in seconds: give one of them")
        for other in self._into(input_.component, input_.port):
            if self.places(other.target) & self.places(target):
                raise AdcsError(f"{link}{other.source} is already connected to it, an input has one source")
        connection = Connection(
            source, target, scale.factor, scale.offset, pairs, delay_steps, delay, given or bool(pairs)
        )
        component = self.components[input_.component]
        if component.has_start(input_.port) and not connection.delayed and len(input_.elements) == input_.port.size:
            raise AdcsError(f"{link}{target} has a start value that the connection would override: drop one of them")
        self._append(connection)

    def disconnect(self, target: str) -> Connection:
        """Remove the connection into an input and return it."""
        end = self.end(target)
        for connection in self._into(end.component, end.port):
            if self.places(connection.target) == self.places(target):
                self._connections.remove(connection)
                for node in self._nodes(end):
                    self._incoming[node].remove(connection)
                return connection
        raise AdcsError(f"nothing is connected to {target}")

    def delay(self, target: str, *, steps: int = 0, seconds: Seconds = 0.0) -> None:
        """Delay the connection into an input by so many exchange steps, or by a time, as 0.1 [s] or "100ms"."""
        old = self.disconnect(target)
        scale = {"factor": old.factor, "offset": old.offset} if old.given and not old.mapping else {}
        try:
            self.connect(old.source, target, **scale, mapping=old.mapping or None, delay_steps=steps, delay=seconds)
        except AdcsError:
            self._append(old)
            raise

    def refined(self) -> System:
        """Return the system for half the exchange step: what counts steps counts twice as many."""
        finer = System(self.name, self.description)
        for component in self.components.values():
            every = 2 * component.every if component.every > 1 else 1
            finer.components[component.name] = replace(component, every=every)
        for connection in self._connections:
            finer._append(replace(connection, delay_steps=2 * connection.delay_steps))
        return finer

    def port(self, name: str) -> tuple[str, Port]:
        """Return the component's name and the variable that `component.variable` (or an element of it) names."""
        end = self.end(name)
        return end.component, end.port

    def end(self, name: str) -> End:
        """Return what `component.variable` or `component.variable[i,j]` (counted from 1) names."""
        if not isinstance(name, str):
            raise AdcsError(f"{shown(repr(name))} names no variable: give a text as 'component.variable'")
        component, _, _ = name.partition(".")
        if component not in self.components:
            raise AdcsError(
                f"{name!r}: system {self.name!r} has no component {component!r}: {hint(component, self.components)}"
            )
        return Ends({component: self.components[component].fmu})(name)

    def places(self, name: str) -> frozenset[tuple[str, Place]]:
        """Return where the values of `component.variable` or an element of it are: the same for all its names."""
        end = self.end(name)
        nodes = self.components[end.component].fmu.nodes
        return frozenset((end.component, nodes.place(end.port, i)) for i in end.elements)

    def among(self, names: Iterable[str], name: str) -> str | None:
        """Return which of these names is that of the same variable, if any is."""
        wanted = self.places(name)
        return next((other for other in names if other == name or self.places(other) == wanted), None)

    def outputs(self) -> list[str]:
        """Name all outputs that can be recorded, `component.variable`; those with several names in FMI 3.0 once."""
        return [
            f"{component.name}.{port.name}"
            for component in self.components.values()
            for port in component.fmu.ports.values()
            if port.causality == "output" and port.type.startswith(NUMERIC) and port.alias_of is None
        ]

    def check(self, external: Sequence[str] = ()) -> None:
        """Refuse an input that is neither connected nor given a start value.

        Values of those in `external` come from outside; a String, Binary or Clock has none to be given.
        """
        for component in self.components.values():
            expected.count(f"component {component.name!r}: every", component.every, "a whole number of exchange steps")
        outside: dict[tuple[str, Place], str] = {}
        for name in external:
            end = self.end(name)
            if end.port.causality != "input" or not end.port.type.startswith(NUMERIC):
                fmu = self.components[end.component].fmu
                what = fmu.called(end.port) if fmu.ticks(end.port) else f"a {end.port.type} {end.port.causality}"
                raise AdcsError(f"{name} is {what}: values from outside go to inputs")
            if self._into(end.component, end.port):
                raise AdcsError(f"{name} is connected to {self._into(end.component, end.port)[0].source} already")
            for other in (outside[place] for place in self.places(name) if place in outside):
                twice = f"{name} gets" if name == other else f"{name} and {other} are names of one variable, which gets"
                raise AdcsError(f"{twice} its values from outside twice: leave one of them out")
            outside.update(dict.fromkeys(self.places(name), name))
        if not self.components:
            raise AdcsError(f"system {self.name!r} has no components: add one")
        for component in self.components.values():
            for port in _resized(component):
                if port.name not in component.start:
                    raise AdcsError(
                        f"{component.name}.{port.name} has {size_text(port.shape)} by its structural parameters, and "
                        "the FMU has no start values for so many: give it a start value"
                    )
            _refuse_own_misfits(component)
            nodes = component.fmu.nodes
            for port in component.fmu.ports.values():
                if port.causality != "input" or not port.type.startswith(NUMERIC) or port is not nodes.main(port):
                    continue
                if component.has_start(port) or not port.size:
                    continue
                name = f"{component.name}.{port.name}"
                places = [(component.name, nodes.place(port, i)) for i in range(port.size)]
                connected = {place for c in self._into(component.name, port) for place in self.places(c.target)}
                reached = {i for i, place in enumerate(places) if place in connected or place in outside}
                if not reached:
                    raise AdcsError(f"input {name} is not connected: connect it or give it a start value")
                missing = [port.elements[i] for i in range(port.size) if i not in reached]
                if missing:
                    raise AdcsError(
                        f"input {component.name}.{missing[0]} is not connected: connect it or give {name} a start value"
                    )

    def _called(self, end: End) -> str:
        fmu = self.components[end.component].fmu
        return fmu.called(end.port) if fmu.ticks(end.port) else f"has causality {end.port.causality!r}"

    def _append(self, connection: Connection) -> None:
        end = self.end(connection.target)
        self._connections.append(connection)
        for node in self._nodes(end):
            self._incoming.setdefault(node, []).append(connection)

    def _nodes(self, end: End) -> list[tuple[str, str]]:
        nodes = self.components[end.component].fmu.nodes
        return list(dict.fromkeys((end.component, nodes.place(end.port, i)[0]) for i in end.elements))

    def _into(self, component: str, port: Port) -> list[Connection]:
        nodes = self.components[component].fmu.nodes.of(port)
        return list(dict.fromkeys(c for node in nodes for c in self._incoming.get((component, node), ())))

    def _scale(self, link: str, output: End, input_: End) -> Scale:
        here, there = (self.components[end.component].fmu for end in (output, input_))
        relative = output.port.relative, input_.port.relative
        try:
            return conversion(here, output.port.unit, there, input_.port.unit, relative)
        except AdcsError as error:
            raise AdcsError(f"{link}{error}") from None


def _any_version(fmu: str | Path) -> Path:
    try:
        return locate(fmu)
    except AdcsError as error:
        try:
            return locate(fmu, "3.0")
        except AdcsError:
            raise error from None


def _configured(component: str, fmu: Fmu, start: Mapping[str, Sequence[Any]]) -> Fmu:
    try:
        return fmu.configured(start)
    except AdcsError as error:
        raise AdcsError(f"{component}.{error}") from None


def _resized(component: Component) -> list[Port]:
    """Return what needs start values, since those that the FMU has are invalid once a size is given; inputs aside."""
    ports = (component.fmu.ports[name] for name in sorted(component.fmu.resized))
    of_its_own = (port for port in ports if port is component.fmu.nodes.main(port))
    return [port for port in of_its_own if port.size and port.settable and port.causality != "input"]


def _give_defaults(component: Component) -> None:
    """Give arrays of another size the start value of the FMU where one value stands for all elements."""
    for port in _resized(component):
        if port.start is not None:
            component.start.setdefault(port.name, port.start)


def _pairs(link: str, target: Port, mapping: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Check that every pair leads to a value that the input's type has."""
    try:
        pairs = tuple((float(here), float(there)) for here, there in mapping)
    except (TypeError, ValueError):
        raise AdcsError(f"{link}mapping = {mapping!r}: expected pairs of numbers, (from, to)") from None
    for here, there in pairs:
        if first_misfit(target.type, [there]) is not None or not isfinite(here):
            raise AdcsError(f"{link}the mapping leads from {here:g} to {there:g}, which is no {target.type}")
    integers = [value for pair in mapping for value in pair if isinstance(value, int)]
    if (beyond := first_beyond(integers)) is not None:
        raise AdcsError(f"{link}{integers[beyond]} in the mapping{BEYOND}")
    return pairs


def _loses(source: str, target: str, scale: Scale) -> bool:
    """Whether values of one type cannot be taken for values of the other: Booleans for numbers, fractions for integers.

    Ranges of integers are checked when values come.
    """
    if (source == "Boolean") != (target == "Boolean"):
        return True
    whole = "Int" in source and scale.factor == round(scale.factor) and scale.offset == round(scale.offset)
    return "Int" in target and not whole


def _port(component: str, fmu: Fmu, variable: str) -> Port:
    if variable not in fmu.ports:
        raise AdcsError(
            f"component {component!r} ({fmu.path.name}) has no variable {variable!r}: {hint(variable, fmu.ports)}"
        )
    return fmu.ports[variable]


def _start(component: str, fmu: Fmu, variable: str, value: Value) -> tuple[Any, ...]:
    """Check a start value and return it flat."""
    port = _port(component, fmu, variable)
    name = f"{component}.{variable}"
    if not port.settable:
        raise AdcsError(f"{name} cannot be given a start value: it is {fmu.called(port)}")
    return checked_value(name, port, value)


def _starts(component: str, fmu: Fmu, given: Mapping[str, Value]) -> dict[str, tuple[Any, ...]]:
    """Check start values; refuse different ones for two names of a variable."""
    found: dict[str, tuple[Any, ...]] = {}
    by: dict[str, tuple[str, Any]] = {}
    for variable, value in given.items():
        values = _start(component, fmu, variable, value)
        port = fmu.ports[variable]
        for node, own in fmu.nodes.spread(port, values).items():
            other, before = by.setdefault(node, (variable, own))
            if before != own:
                raise AdcsError(
                    f"{component}.{other} and {component}.{variable} are names of one variable, and are given "
                    "different start values: give one of them"
                )
        found[fmu.nodes.main(port).name] = values
    return found


def _refuse_own_misfits(component: Component) -> None:
    """Refuse values that the FMU itself starts with and that its types do not hold, unless others were given."""
    for port in component.fmu.ports.values():
        own = port.start if port.settable and port.initial == "exact" and port.causality != "input" else None
        if own is None or not port.type.startswith("Float") or component.has_start(port):
            continue
        misfit = first_misfit(port.type, np.asarray(own))
        if misfit is not None:
            name = f"{component.name}.{port.name}"
            raise AdcsError(
                f"{name} = {own[misfit[0]]!r} by its FMU{misfit[1]}: give it another value (--set {name}=...)"
            )


def check_system(value: object) -> None:
    """Refuse what is no System."""
    if not isinstance(value, System):
        way = 'a System, as adcs.System("name") or adcs.systems()[name].build() gives it'
        raise expected.refused("system", value, way)


def checked_value(name: str, port: Port, value: Value) -> tuple[Any, ...]:
    """Check a value for a variable, by shape, type and range, and return it flat (row-major).

    An enumeration takes the names of its items, too; Binary takes bytes, hexadecimal digits, or base64:...
    """
    if port.type == "Binary":
        return binary_values(name, port, value)
    value = item_numbers(name, port, value.tolist() if isinstance(value, np.ndarray) else value)
    try:
        array = np.asarray(value)
    except ValueError:  # rows of different lengths
        raise AdcsError(f"{name} = {shown(repr(value))}: expected {size_text(port.shape)}") from None
    if array.dtype == object:
        if not all(isinstance(v, int) for v in array.flat):
            raise AdcsError(f"{name} = {shown(repr(value))}: expected {size_text(port.shape)}")
        try:  # some of them are beyond 64 bits, which only a Float may hold
            array = np.asarray(value, float if port.type.startswith("Float") else np.int64)
        except OverflowError:
            raise AdcsError(f"{name} = {shown(repr(value))} is outside the range of {port.type}") from None
    if array.shape != port.shape:
        if isinstance(value, str) and port.type != "String":
            raise _no_number(name, port, value)
        raise AdcsError(f"{name}: expected {size_text(port.shape)}, got {size_text(array.shape)}")
    flat = array.ravel()
    if port.type.startswith("Float"):
        if array.dtype.kind not in "fiu":
            raise _no_number(name, port, value)
        _refuse_misfit(name, port, value, flat)
        return tuple(float(v) for v in flat)
    if port.type == "Boolean":
        if array.dtype.kind not in "biu" or not np.isin(flat, (0, 1)).all():
            raise AdcsError(f"{name} = {value!r}: expected True or False")
        return tuple(bool(v) for v in flat)
    if port.type == "String":
        if array.dtype.kind != "U":
            raise AdcsError(f"{name} = {value!r}: expected a text")
        return tuple(str(v) for v in flat)
    if "Int" in port.type:
        if array.dtype.kind not in "fiu":
            raise AdcsError(f"{name} = {value!r}: expected an integer")
        flat = np.asarray(value, object).ravel()  # of mixed integers, numpy makes doubles
        _refuse_misfit(name, port, value, flat)
        return tuple(int(v) for v in flat)
    raise AdcsError(f"{name} is of type {port.type}: setting these is not supported")


def _no_number(name: str, port: Port, value: Value) -> AdcsError:
    """Refuse what is no number where one is expected; a text that the command line would read is told how to be given.

    A unit has to be converted, a list written as a list.
    """
    way = f"a number{f', in {port.unit}' if port.unit and port.unit != '1' else ''}"
    if isinstance(value, str):
        with suppress(ValueError, RecursionError):  # which is none of these
            read = json.loads(value if value.lstrip().startswith("[") or not port.shape else f"[{value}]")
            way = f"a list, {read}" if isinstance(read, list) else f"{way}, {read} without quotes"
    return AdcsError(f"{name} = {shown(repr(value))}: expected {way}")


def _refuse_misfit(name: str, port: Port, value: Value, flat: NDArray[Any]) -> None:
    misfit = first_misfit(port.type, flat)
    if misfit is not None:
        raise AdcsError(f"{name} = {value!r}{misfit[1]}")
