"""The schedule in numbers: value references, places in the signal buffer, the columns of a row."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.errors import AdcsError
from orchestration.fmu.file import Fmu, Port
from orchestration.fmu.number_types import BEYOND, first_beyond
from orchestration.plan.schedule import Name, Operation, schedule
from orchestration.system import Connection, End, Ends

Floats = NDArray[np.float64]
Places = NDArray[np.intp]
Starts = Mapping[str, Mapping[str, tuple[Any, ...]]]
"""Start values by component and variable."""


@dataclass(frozen=True)
class Call:
    """One get or set call, or a loop to be solved.

    `where` says which signals it writes (get) or reads (set), in the order of its values; a get call has a contiguous
    place. A set call hands on `factor * signal + offset`, or what the element's mapping says. `loop` is the number of
    the loop. It is made at every `every`-th exchange step.
    """

    kind: str
    component: str
    elements: tuple[str, ...] = ()
    references: tuple[int, ...] = ()
    where: Places = field(default_factory=lambda: np.empty(0, np.intp))
    type: str = "Float64"
    factor: Floats | None = None
    offset: Floats | None = None
    mappings: tuple[tuple[tuple[float, float], ...], ...] = ()
    loop: int = -1
    every: int = 1
    links: tuple[Connection, ...] = ()
    """Of a set call, the connection from which each value comes; one without a source where there is none."""

    @property
    def plain(self) -> bool:
        """Whether signals are handed on as they are."""
        return self.factor is None and not self.mappings


@dataclass(frozen=True)
class Loop:
    """An algebraic loop: the calls that set its inputs and those that then get the outputs that feed them."""

    sets: tuple[Call, ...]
    gets: tuple[Call, ...]


@dataclass(frozen=True)
class Delay:
    """Signals from `source` arrive at `target` (slices of the buffer) `steps` exchange steps later."""

    source: slice
    target: slice
    steps: int


@dataclass(frozen=True)
class Plan:
    """All calls of one propagation, their common signal buffer, and the signals that make up a recorded row.

    The first `n_external` signals are given from outside, those of `external` one after the other.
    """

    calls: tuple[Call, ...]
    signals: Floats
    row: Places
    loops: tuple[Loop, ...] = ()
    delays: tuple[Delay, ...] = ()
    n_external: int = 0
    every: Mapping[str, int] = field(default_factory=dict)

    def only_read(self) -> Plan:
        """Return it without the calls of which nothing comes into the row, for who wants the row alone."""
        kept: list[Call] = []
        read: set[str] = set()  # components, by the calls that come after
        wanted = set(self.row.tolist())  # signals
        for call in reversed(self.calls):
            if call.kind == "get" and wanted.isdisjoint(call.where.tolist()):
                continue
            if call.kind == "set" and call.component not in read:
                continue
            kept.append(call)
            inside = (*self.loops[call.loop].sets, *self.loops[call.loop].gets) if call.kind == "solve" else (call,)
            for each in inside:
                if each.kind == "get":
                    read.add(each.component)
                else:
                    wanted.update(each.where.tolist())
        return replace(self, calls=tuple(reversed(kept)))


def make_plan(
    fmus: Mapping[str, Fmu],
    connections: Sequence[Connection],
    record: Collection[Name] = (),
    initial: bool = False,
    *,
    external: Sequence[str] = (),
    starts: Starts | None = None,
    every: Mapping[str, int] | None = None,
    solve_loops: bool = False,
) -> Plan:
    """Lower the schedule of the given connections, whose delays are in steps.

    `initial` takes the dependencies of initialisation mode, in which delayed values have not arrived. `external` names
    inputs, `component.variable`, whose values come from outside.
    """
    return _Builder(fmus, connections, initial, external, starts or {}).plan(record, every or {}, solve_loops)


class _Builder:
    def __init__(
        self,
        fmus: Mapping[str, Fmu],
        connections: Sequence[Connection],
        initial: bool,
        external: Sequence[str],
        starts: Starts,
    ) -> None:
        self._fmus, self._starts = fmus, starts
        self._ends = Ends(fmus)
        self._depends = {name: fmu.initial_feedthrough if initial else fmu.feedthrough for name, fmu in fmus.items()}
        self._size = 0
        self._values: list[tuple[slice, Sequence[float]]] = []  # signals that are there from the beginning
        self._place: dict[Name, Places] = {}  # of the elements of each variable that is fetched
        self._sources: dict[Name, dict[Name, None]] = {}
        self._now: list[Connection] = []
        self._later: list[tuple[Connection, slice]] = []
        self._origin: dict[Name, dict[int, tuple[int, Connection | None]]] = {}  # of the values of a node
        for name in external:
            self._reserve_external(name)
        self.n_external = self._size
        for connection in connections:
            if connection.delayed and initial:
                continue
            self._add(connection)

    def plan(self, record: Collection[Name], every: Mapping[str, int], solve_loops: bool) -> Plan:
        recorded = [(component, node) for component, v in record for node in self._nodes(component, v)]
        wanted = [node for connection, _ in self._later for node in self._source_nodes(connection)]
        self._every = {name: every.get(name, 1) for name in self._fmus}
        operations = schedule(
            self._sources, lambda name: self._depends[name[0]](name[1]), recorded, wanted, solve_loops
        )
        for operation in operations:
            for get in operation.inside or (operation,):
                if get.kind == "get":
                    self._place_outputs(get)
        for connection in self._now:
            self._connect(connection)
        loops: list[Loop] = []
        calls: list[Call] = []
        for operation in operations:
            if operation.kind == "solve":
                inside = [call for each in operation.inside for call in self._calls(each)]
                calls.append(Call("solve", "", loop=len(loops), every=self._common(operation)))
                loops.append(
                    Loop(
                        tuple(c for c in inside if c.kind == "set"),
                        tuple(c for c in inside if c.kind == "get"),
                    )
                )
            else:
                calls += self._calls(operation)
        nothing = np.empty(0, np.intp)
        delays = tuple(d for connection, target in self._later for d in self._delays(connection, target))
        plan = Plan(
            calls=tuple(calls),
            signals=np.zeros(self._size),
            row=np.concatenate([nothing, *(self._place_of(component, v) for component, v in record)]),
            loops=tuple(loops),
            delays=delays,
            n_external=self.n_external,
            every=self._every,
        )
        for where, values in self._values:
            plan.signals[where] = values
        return plan

    def _reserve(self, n: int, values: Sequence[float] | None = None) -> slice:
        where = slice(self._size, self._size + n)
        self._size += n
        if values is not None:
            self._values.append((where, values))
        return where

    def _reserve_external(self, name: str) -> None:
        end = self._ends(name)
        start = self._start(end.component, end.port)
        where = self._reserve(len(end.elements), [_double(end.component, end.port, start, i) for i in end.elements])
        for element, signal in zip(end.elements, range(where.start, where.stop), strict=True):
            self._feed(end.component, end.port, element, signal, None)

    def _feed(self, component: str, port: Port, element: int, signal: int, connection: Connection | None) -> None:
        node, place = self._fmus[component].nodes.place(port, element)
        self._origin.setdefault((component, node), {})[place] = signal, connection
        self._sources.setdefault((component, node), {})

    def _add(self, connection: Connection) -> None:
        target = self._ends(connection.target)
        if connection.delayed:
            start = self._start(target.component, target.port)
            values = [_before(connection, _double(target.component, target.port, start, i)) for i in target.elements]
            where = self._reserve(len(target.elements), values)
            self._later.append((connection, where))
            for element, signal in zip(target.elements, range(where.start, where.stop), strict=True):
                self._feed(target.component, target.port, element, signal, connection)
            return
        self._now.append(connection)
        source = self._ends(connection.source)
        for element, out in zip(target.elements, source.elements, strict=True):
            node = target.component, self._node(target.component, target.port, element)
            self._sources.setdefault(node, {})[source.component, self._node(source.component, source.port, out)] = None

    def _connect(self, connection: Connection) -> None:
        source, target = self._ends(connection.source), self._ends(connection.target)
        for element, signal in zip(target.elements, self._place_of_end(source), strict=True):
            self._feed(target.component, target.port, element, int(signal), connection)

    def _delays(self, connection: Connection, target: slice) -> Iterable[Delay]:
        """One for each contiguous part of what leaves."""
        place = self._place_of_end(self._ends(connection.source))
        cuts = [0, *(np.flatnonzero(np.diff(place) != 1) + 1), len(place)]
        for i, j in itertools.pairwise(cuts if len(place) else ()):
            leaves = slice(int(place[i]), int(place[j - 1]) + 1)
            yield Delay(leaves, slice(target.start + int(i), target.start + int(j)), connection.delay_steps)

    def _source_nodes(self, connection: Connection) -> list[Name]:
        end = self._ends(connection.source)
        return [(end.component, self._node(end.component, end.port, i)) for i in end.elements]

    def _place_outputs(self, operation: Operation) -> None:
        """Give each get call, one for each type, a contiguous place."""
        self._place |= {(operation.component, name): np.empty(0, np.intp) for name in operation.variables}
        for _, names in self._by_type(operation):
            for name in names:
                n = self._node_port(operation.component, name)[1]
                where = self._reserve(len(n))
                self._place[operation.component, name] = np.arange(where.start, where.stop, dtype=np.intp)

    def _place_of_end(self, end: End) -> Places:
        """Where the elements of an output are; others of the same array may be nowhere."""
        found = [self._fmus[end.component].nodes.place(end.port, i) for i in end.elements]
        return np.array([self._place[end.component, node][i] for node, i in found], np.intp)

    def _place_of(self, component: str, variable: str) -> Places:
        return np.concatenate([self._place[component, node] for node in self._nodes(component, variable)])

    def _calls(self, operation: Operation) -> list[Call]:
        return [self._call(operation, type_, names) for type_, names in self._by_type(operation)]

    def _call(self, operation: Operation, type_: str, names: Sequence[str]) -> Call:
        component = operation.component
        found = [self._node_port(component, name) for name in names]
        elements = tuple(port.elements[i] for port, indices in found for i in indices)
        references = tuple(port.references[indices[0] if len(port.references) > 1 else 0] for port, indices in found)
        if operation.kind == "get":
            where = np.concatenate([self._place[component, name] for name in names])
            return Call("get", component, elements, references, where, type_, every=self._every[component])
        origins = [
            self._origin_of(component, name, i)
            for name, (_, of) in zip(names, found, strict=True)
            for i in range(len(of))
        ]
        where = np.array([signal for signal, _ in origins], np.intp)
        links = [connection or _DIRECT for _, connection in origins]
        if all(link.plain for link in links):
            every = self._every[component]
            return Call("set", component, elements, references, where, type_, every=every, links=tuple(links))
        return Call(
            "set",
            component,
            elements,
            references,
            where,
            type_,
            np.array([link.factor for link in links]),
            np.array([link.offset for link in links]),
            tuple(link.mapping for link in links) if any(link.mapping for link in links) else (),
            every=self._every[component],
            links=tuple(links),
        )

    def _common(self, loop: Operation) -> int:
        """How often the components of a loop communicate, which must be the same."""
        rates = {each.component: self._every[each.component] for each in loop.inside}
        (name, first), *others = rates.items()
        for other, every in others:
            if every != first:
                raise AdcsError(
                    f"{name} and {other} are in one algebraic loop, but communicate at every {first} and every {every} "
                    "steps: give them the same rate, or put a delay between them"
                )
        return first

    def _origin_of(self, component: str, node: str, place: int) -> tuple[int, Connection | None]:
        """The signal that feeds a value; its start value, where only other elements of an array are connected."""
        fed = self._origin[component, node]
        if place not in fed:
            port, elements = self._node_port(component, node)
            value = _double(component, port, self._start(component, port), elements[place])
            fed[place] = self._reserve(1, [value]).start, None
        return fed[place]

    def _start(self, component: str, port: Port) -> Sequence[Any]:
        main = self._fmus[component].nodes.main(port)
        given = self._starts.get(component, {}).get(main.name, port.start)
        return given if given is not None else (0.0,) * port.size

    def _by_type(self, operation: Operation) -> list[tuple[str, list[str]]]:
        groups: dict[str, list[str]] = {}
        for name in operation.variables:
            port, elements = self._node_port(operation.component, name)
            if elements:  # of an array of size 0 nothing is to be had
                groups.setdefault(port.type, []).append(name)
        return list(groups.items())

    def _nodes(self, component: str, variable: str) -> list[str]:
        fmu = self._fmus[component]
        return fmu.nodes.of(fmu.ports[variable])

    def _node(self, component: str, port: Port, element: int) -> str:
        return self._fmus[component].nodes.place(port, element)[0]

    def _node_port(self, component: str, node: str) -> tuple[Port, list[int]]:
        """The variable to which a node belongs, and the elements that it has."""
        return self._fmus[component].nodes[node]


_DIRECT = Connection("", "")


def _double(component: str, port: Port, start: Sequence[Any], element: int) -> float:
    """One start value as it travels with those of a connection; refuse an integer that it could not hand on."""
    value = start[element]
    if isinstance(value, int) and first_beyond([value]) is not None:
        raise AdcsError(f"{component}.{port.elements[element]} = {value}{BEYOND}")
    return float(value)


def _before(connection: Connection, start: float) -> float:
    """What would have had to leave for the input's start value to arrive."""
    if not connection.mapping:
        return start if connection.plain else (start - connection.offset) / connection.factor
    for here, there in connection.mapping:
        if there == start:
            return here
    raise AdcsError(
        f"{connection.target} starts with {start:g}, which the mapping of its delayed connection from "
        f"{connection.source} never gives: add a pair for it or give another start value"
    )
