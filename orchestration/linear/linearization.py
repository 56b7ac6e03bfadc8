"""Linear state spaces of components and of whole systems of them, by differentiating each component where it stands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from fmus.catalog import components
from fmus.errors import AdcsError
from orchestration import expected
from orchestration.coupled import CoupledModel
from orchestration.coupled.solution import Solution
from orchestration.fmu.file import FmiVersion, Port, is_path
from orchestration.linear.jacobian import jacobian
from orchestration.linear.state_space import Mode, StateSpace
from orchestration.linear.unit_quaternions import minimal, unit_quaternions, with_notes
from orchestration.named import as_system
from orchestration.plan.lowering import Floats
from orchestration.running.method import ModelExchange
from orchestration.single import single
from orchestration.system import Connection, End, System
from orchestration.times import Seconds

__all__ = ["Mode", "StateSpace", "linearize"]

Element = tuple[str, str, int]
"""An element of a variable: component, variable, flat index."""


def linearize(
    system: System | str | Path,
    time: float = 0.0,
    *,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    open_at: Sequence[str] = (),
    minimal_coordinates: bool = False,
    start: Mapping[str, Any] | None = None,
    start_time: Seconds = 0.0,
    fmi_version: FmiVersion = "2.0",
    method: ModelExchange = ModelExchange(),
) -> StateSpace:
    """Linearise a system, or one FMU by name or path, where it is at a time.

    The system is integrated from `start_time` to `time` by coupled Model Exchange, as `method` says, and differentiated
    there: by the FMUs' directional derivatives, or central differences of those that have none. Times are numbers of
    seconds, or texts as "20s".

    `inputs` and `outputs` name variables, `component.variable`, or elements of them; by default all inputs that are not
    connected, and all outputs. An input that is connected may be named too: what is put in there is added to what the
    connection brings. Connections into the inputs in `open_at` are cut, after the operating point has been found with
    them; these are inputs then. With `minimal_coordinates` each unit quaternion counts as the three angles of a small
    rotation, NAME.angle[1..3], instead of its four elements. `start` gives start values to a single FMU. Raises
    AdcsError.
    """
    time, start_time = expected.seconds("time", time), expected.seconds("start_time", start_time)
    if not isinstance(method, ModelExchange):
        raise expected.refused("method", method, "adcs.ModelExchange(...): a linearisation is made of derivatives")
    for name, given in {"inputs": inputs, "outputs": outputs, "open_at": open_at}.items():
        if given is not None or name == "open_at":
            expected.texts(name, given)
    if isinstance(system, str | Path) and _is_component(system):
        system = single(system, start)
    elif start:
        raise AdcsError("start values of a system are set in the system: use system.set(...)")
    else:
        system = as_system(system)
    if not start_time <= time < inf:
        raise AdcsError(f"time = {time} s: expected a time from the start time {start_time} s on")
    _refuse_delays(system)
    for component in system.components.values():
        fmu = component.open(fmi_version)
        if fmu.model.coSimulation is not None and fmu.model.modelExchange is None:
            raise AdcsError(
                f"{component.name} ({fmu.path.name}) is for co-simulation only, and a linearisation needs its "
                "derivatives: export it for Model Exchange"
            )
    with CoupledModel(system, start_time, fmi_version=fmi_version, record=[], loops=method.loops) as model:
        solution = Solution(model, start_time, 1e-9 * max(time - start_time, 1e-3), *method.integrator)
        solution.reach(time)
        if model.ended is not None:
            raise AdcsError(f"{model.ended}; linearise at a time before that")
        model.set_point(time, solution.x)
        found = _Linear(model, solution, open_at).assemble(time, inputs, outputs)
        sizes = np.maximum(np.abs(solution.x), model.nominals)
    quaternions = unit_quaternions(found)
    turning = [i for q in quaternions for i in range(q.where.start, q.where.stop)] if minimal_coordinates else []
    found = replace(found, notes=(*found.notes, *_no_equilibrium(found, sizes, turning)))
    return minimal(found, quaternions) if minimal_coordinates else with_notes(found, quaternions)


def _refuse_delays(system: System) -> None:
    for connection in system.connections:
        if connection.delayed:
            raise AdcsError(
                f"the connection from {connection.source} to {connection.target} is delayed: a delay has no state "
                "space of finite order, remove it"
            )


@dataclass(frozen=True)
class _Part:
    """A component's Float inputs and outputs that vary continuously, and its place among the states."""

    inputs: list[Port]
    outputs: list[Port]
    states: slice


class _Linear:
    """The components of a model at its present point, differentiated, and how they are connected."""

    def __init__(self, model: CoupledModel, solution: Solution, open_at: Sequence[str]) -> None:
        self._model, self._system = model, model.system
        self._x, self._time = solution.x, solution.time
        self._notes: list[str] = []
        self._parts: dict[str, _Part] = {}
        first = 0
        for name, instance in model.instances.items():
            ports = [p for p in instance.fmu.ports.values() if _continuous(p) and p.alias_of is None]
            last = first + len(instance.fmu.states)
            inputs, outputs = ([p for p in ports if p.causality == kind] for kind in ("input", "output"))
            self._parts[name] = _Part(inputs, outputs, slice(first, last))
            first = last
        self._inputs = _elements({name: part.inputs for name, part in self._parts.items()})
        self._outputs = _elements({name: part.outputs for name, part in self._parts.items()})
        self._cut = {element for name in open_at for element in self._ends(name, "input")}
        self._connect()
        for name in open_at:
            if not self._cut & self._connected & set(self._ends(name, "input")):
                raise AdcsError(f"{name} is not connected: there is nothing to open")

    def assemble(self, time: float, inputs: Sequence[str] | None, outputs: Sequence[str] | None) -> StateSpace:
        """Connect the components' Jacobians: u = K y + E w, y = C x + D u, so that y = (I - D K)^-1 (C x + D E w)."""
        A, B, C, D = self._blocks()
        K = np.zeros((len(self._inputs), len(self._outputs)))
        for target, source, factor in self._links:
            if target not in self._cut:
                K[self._inputs[target], self._outputs[source]] = factor
        external = self._external(inputs)
        E = np.zeros((len(self._inputs), len(external)))
        E[[self._inputs[e] for e in external], np.arange(len(external))] = 1.0
        wanted = self._wanted(outputs)
        S = np.zeros((len(wanted), len(self._outputs)))
        S[np.arange(len(wanted)), [self._outputs[e] for e in wanted]] = 1.0
        through = np.eye(len(self._outputs)) - D @ K
        if len(through) and np.linalg.cond(through) > 1e12:
            raise AdcsError("an algebraic loop has no unique solution here: I - D K is singular")
        Y, W = np.linalg.solve(through, C), np.linalg.solve(through, D @ E)
        dx = self._model.rhs(self._time, self._x)
        return StateSpace(
            system=self._system.name,
            time=time,
            A=A + B @ K @ Y,
            B=B @ (E + K @ W),
            C=S @ Y,
            D=S @ W,
            states=tuple(self._model.state_names),
            inputs=tuple(self._name(e) for e in external),
            outputs=tuple(self._name(e) for e in wanted),
            x=self._x,
            u=self._values(external),
            y=self._values(wanted),
            dx=dx,
            notes=(*self._notes, *self._events()),
        )

    def _blocks(self) -> tuple[Floats, Floats, Floats, Floats]:
        n, m, p = len(self._x), len(self._inputs), len(self._outputs)
        A, B, C, D = np.zeros((n, n)), np.zeros((n, m)), np.zeros((p, n)), np.zeros((p, m))
        row = column = 0
        for name, part in self._parts.items():
            x = part.states
            found = jacobian(
                self._model.instances[name], part.inputs, part.outputs, self._x[x], self._model.nominals[x]
            )
            u = slice(column, column + found.B.shape[1])
            y = slice(row, row + found.C.shape[0])
            A[x, x], B[x, u], C[y, x], D[y, u] = found.A, found.B, found.C, found.D
            row, column = y.stop, u.stop
            if not found.exact and (x.stop > x.start or u.stop > u.start):
                self._notes.append(f"{name} has no directional derivatives: central differences were taken")
        return A, B, C, D

    def _connect(self) -> None:
        """Find the links (input, output, factor) between elements, and all inputs that are connected."""
        self._links: list[tuple[Element, Element, float]] = []
        self._connected: set[Element] = set()
        for connection in self._system.connections:
            source, target = self._system.end(connection.source), self._system.end(connection.target)
            into, out = _each(target), _each(source)
            self._connected.update(into)
            if all(e in self._inputs for e in into) and all(e in self._outputs for e in out):
                self._links += [(i, o, connection.factor) for i, o in zip(into, out, strict=True)]
            else:
                self._notes.append(_held(connection))

    def _external(self, names: Sequence[str] | None) -> list[Element]:
        if names is None:
            return [e for e in self._inputs if e not in self._connected or e in self._cut]
        return [e for name in names for e in self._ends(name, "input")]

    def _wanted(self, names: Sequence[str] | None) -> list[Element]:
        return list(self._outputs) if names is None else [e for name in names for e in self._ends(name, "output")]

    def _ends(self, name: str, kind: str) -> list[Element]:
        end = self._system.end(name)
        if end.port.causality != kind:
            raise AdcsError(f"{name} is no {kind} but has causality {end.port.causality!r}")
        if not _continuous(end.port):
            raise AdcsError(
                f"{name} is a {end.port.variability} {end.port.type}: only Float variables that vary continuously can "
                "be linearised"
            )
        return _each(end)

    def _name(self, element: Element) -> str:
        component, variable, i = element
        return f"{component}.{self._model.instances[component].fmu.ports[variable].elements[i]}"

    def _values(self, elements: Sequence[Element]) -> Floats:
        """Return the present values of inputs or outputs."""
        self._model.set_point(self._time, self._x)
        known: dict[tuple[str, str], list[float]] = {}
        for component, variable, _ in elements:
            if (component, variable) not in known:
                instance = self._model.instances[component]
                port = instance.fmu.ports[variable]
                known[component, variable] = instance.get(port.references, port.size, f"getting {variable}", port.type)
        return np.array([known[component, variable][i] for component, variable, i in elements])

    def _events(self) -> list[str]:
        notes = []
        if self._model.next_event < inf:
            notes.append(
                f"{self._model.next_event_of} has a time event at {self._model.next_event:.9g} s: this holds until then"
            )
        return notes


def _no_equilibrium(system: StateSpace, sizes: Floats, besides: Sequence[int]) -> list[str]:
    """Say that states move, if any do but those of quaternions that are seen in their own frames."""
    speeds = np.abs(system.dx) / sizes
    speeds[list(besides)] = 0.0
    if not len(speeds) or speeds.max() <= 1e-6:
        return []
    fastest = int(np.argmax(speeds))
    return [
        f"this is no equilibrium, {system.states[fastest]} changes by {system.dx[fastest]:.3g} per second: "
        "unless the system is linear, eigenvalues say what deviations do at first, not whether they die out"
    ]


def _continuous(port: Port) -> bool:
    return port.type.startswith("Float") and port.variability == "continuous"


def _each(end: End) -> list[Element]:
    return [(end.component, end.port.alias_of or end.port.name, i) for i in end.elements]


def _elements(ports: Mapping[str, Sequence[Port]]) -> dict[Element, int]:
    """Number the elements of variables."""
    every = [(component, port.name, i) for component, of in ports.items() for port in of for i in range(port.size)]
    return {element: number for number, element in enumerate(every)}


def _held(connection: Connection) -> str:
    return f"{connection.target} gets {connection.source} at events only: it is held in the linear system"


def _is_component(name: str | Path) -> bool:
    """Whether this is one FMU, by its path or as one that is built here."""
    return is_path(name) or any(component.name == str(name) for component in components())
