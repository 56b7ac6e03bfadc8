"""The components of a system as one differential equation x' = f(t, x), and their events."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from ctypes import POINTER, c_double
from functools import partial
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.errors import AdcsError
from orchestration import expected
from orchestration.engine import Engine
from orchestration.engine.overstepping import overstepped
from orchestration.engine.walk import Walk
from orchestration.fmu.file import FmiVersion, Port
from orchestration.instances.instance import CallFailed, EndRequested, Instance, failing_at
from orchestration.named import as_system
from orchestration.plan.changing import checked_change
from orchestration.plan.loops import LoopMethod, Loops, LoopSolver, loop_solver
from orchestration.plan.lowering import Floats, Plan, make_plan
from orchestration.plan.opening import initialised
from orchestration.plan.outside import Lines, Source, lines_of
from orchestration.process.guard import Guard
from orchestration.process.where import Where
from orchestration.results.result import Recording
from orchestration.system import System, Value
from orchestration.times import Seconds

_MAX_EVENT_ITERATIONS = 100


class CoupledModel:
    """The system as x' = f(t, x), initialised, in continuous-time mode. A context manager.

        with CoupledModel(system) as model:
            model.rhs(0.0, model.x0)

    `ended` is the wish of a component to end the simulation, at whose time the values are valid, but none after it.
    `state_names` names the elements of x, `x0` is the state after initialisation, `nominals` are the states' nominal
    values. Between two events `rhs`, `indicators` and
    `outputs` are functions of (t, x) alone. Algebraic loops are refused unless `loops` says how to solve them.
    """

    def __init__(
        self,
        system: System | str | Path,
        start_time: Seconds | None = None,
        stop_time: Seconds = inf,
        fmi_version: FmiVersion = "2.0",
        record: Sequence[str] | None = None,
        *,
        loops: LoopSolver | LoopMethod | None = None,
        source: Source | None = None,
        where: Where | None = None,
        guard: Guard | None = None,
    ) -> None:
        """`record` names the variables of a row (None: all outputs); `source` gives values to unconnected inputs.

        `system` may be a name or the path of a file where `adcs` is imported; its own start time counts if none is
        given.
        """
        system = as_system(system)
        start_time, stop_time, _ = system.run_times(start_time, stop_time, 0.0)
        solver = loop_solver(loops)
        if source is not None and not isinstance(source, Source):
            raise expected.refused("source", source, "what has names, at(times) and jump(after)")
        refuse(system, fmi_version)
        recording = Recording(system, record, 1)
        self.system = system
        self.ports = recording.ports
        with ExitStack() as stack:
            self.external = () if source is None else tuple(source.names)
            opened = initialised(
                system,
                "model-exchange",
                start_time,
                stop_time,
                fmi_version,
                external=self.external,
                solver=solver,
                where=where,
                guard=guard,
            )
            self._where, self._guard = where, guard
            self._engines: list[Engine] = []
            self.instances = stack.enter_context(opened)
            fmus = {name: instance.fmu for name, instance in self.instances.items()}
            # in continuous-time mode only inputs of continuous variability may be set
            continuous = [c for c in system.connections if system.port(c.target)[1].variability == "continuous"]
            flowing = [name for name in self.external if system.port(name)[1].variability == "continuous"]
            sizes = {name: len(system.end(name).elements) for name in self.external}
            self._source = source
            lines = lines_of(source)
            self._flows = np.repeat([name in flowing for name in self.external], list(sizes.values()))
            self._asked = source if lines is None else None  # for each point of time between two events
            self._loops: list[Loops] = []
            lower = partial(
                make_plan,
                fmus,
                starts={c.name: c.start for c in system.components.values()},
                solve_loops=solver is not None,
            )
            self._at_events = lower(system.connections, external=self.external)
            self._sets = [call for call in self._at_events.calls if call.kind == "set"]
            self._sets += [call for loop in self._at_events.loops for call in loop.sets]
            self._propagate = self._bind(self._at_events, solver).propagate
            between = (
                lower(continuous, external=flowing),
                lower(continuous, recording.names, external=flowing).only_read(),
            )
            self._flowing = [plan.signals[: plan.n_external] for plan in between]
            followed = _only(lines or (), self._flows)
            self._derivatives, self._outputs = (self._bind(plan, solver, followed) for plan in between)
            self.state_names = [f"{name}.{state}" for name, fmu in fmus.items() for state in fmu.states]
            self._row_size = sum(port.size for port in self.ports.values())
            self._watchers = [i for i in self.instances.values() if _needs_completed_step(i)]
            self._indicators = _Indicators(self.instances.values())
            self.ended: EndRequested | None = None
            self.x0 = self._settle(start_time)
            self._stack = stack.pop_all()

    def _bind(self, plan: Plan, solver: LoopSolver | None, lines: Sequence[Lines] = ()) -> Engine:
        loops = Loops(plan, self.instances, solver or LoopSolver())
        self._loops.append(loops)
        self._engines.append(Engine(plan, self.instances, lines=lines, solve=loops.solve, where=self._where))
        return self._engines[-1]

    def __enter__(self) -> CoupledModel:
        return self

    def __exit__(self, *error: Any) -> None:
        self._stack.__exit__(*error)

    @property
    def warnings(self) -> list[str]:
        """What the FMUs warned of, and what they changed that was not theirs."""
        told = [f"{i.name}: {text}" for i in self.instances.values() for text in i.warnings]
        return told + overstepped(self.instances, self._guard, self._engines)

    @property
    def loop_reports(self) -> list[dict[str, Any]]:
        """What solving algebraic loops has taken between events, for the manifest."""
        return self._loops[1].reports

    @property
    def watched(self) -> bool:
        """Whether any component wants to know of each step of the integrator."""
        return bool(self._watchers)

    def walk(self, **terms: Any) -> Walk:
        """Return a compiled walk along the solution; for `terms` see Walk."""
        return Walk(
            self._derivatives,
            self._outputs,
            len(self.state_names),
            self._row_size,
            watched=self.watched,
            outside=None if self._asked is None else self._flow,
            **terms,
        )

    def stop(self) -> None:
        """Let walks return before their next step; to be called from another thread."""
        self._derivatives.stop()

    def rhs(self, t: float, x: Floats) -> Floats:
        """Return x' (n,) at time t and state x (n,)."""
        derivatives = np.empty(len(self.state_names))
        self._flow(t)
        self._derivatives.evaluate(t, np.ascontiguousarray(x, np.float64), derivatives)
        return derivatives

    def row(self, t: float, x: Floats, row: Floats) -> None:
        """Write the recorded variables at (t, x) into a contiguous row."""
        self._flow(t)
        self._outputs.evaluate(t, np.ascontiguousarray(x, np.float64), None, row)

    def outputs(self, t: float, x: Floats) -> dict[str, Floats]:
        """Return the recorded variables at (t, x) by name."""
        row = np.empty(self._row_size)
        self.row(t, x, row)
        cuts = np.cumsum([port.size for port in self.ports.values()])[:-1]
        parts = np.split(row, cuts)
        return {n: part.reshape(p.shape) for (n, p), part in zip(self.ports.items(), parts, strict=True)}

    def set_point(self, t: float, x: Floats) -> None:
        """Bring all components to (t, x), their inputs included."""
        self._flow(t)
        self._derivatives.evaluate(t, np.ascontiguousarray(x, np.float64), None)

    def _flow(self, t: float) -> None:
        """Take what comes from outside at time t into what is a function of (t, x) between two events."""
        if self._asked is not None:
            values = self._asked.at(np.array([t]))[0, self._flows]
            for signals in self._flowing:
                signals[:] = values

    @property
    def n_indicators(self) -> int:
        """How many event indicators all components have."""
        return len(self._indicators.owners)

    def indicators(self, t: float, x: Floats) -> Floats:
        """Return the event indicators of all components at (t, x), (number of indicators,).

        An event is where one of them passes from z > 0 to z <= 0 or back.
        """
        self.set_point(t, x)
        with failing_at(t):
            return self._indicators.get()

    def indicator(self, number: int) -> tuple[str, str]:
        """Return the component to which the event indicator of this index belongs, and its name there."""
        return self._indicators.owners[number]

    @property
    def next_event(self) -> float:
        """The time of the next time event [s]; inf if there is none."""
        return min(self.next_events.values(), default=inf)

    @property
    def next_event_of(self) -> str:
        """The component that has the next time event."""
        return min(self.next_events, key=self.next_events.__getitem__)

    def completed_step(self, t: float, x: Floats) -> str | None:
        """Tell the components that want to know that the integrator accepted a step; return who asks for an event."""
        if not self._watchers:
            return None
        self.set_point(t, x)
        asking = None
        with failing_at(t):
            for instance in self._watchers:
                event, terminate = instance.call("completedIntegratorStep", "completedIntegratorStep")
                if terminate:
                    self.ended = self.ended or instance.ended(t)
                if event:
                    asking = instance.name
        return asking

    def event(self, t: float, x: Floats, changes: Sequence[tuple[str, Value]] = ()) -> Floats:
        """Handle an event at (t, x) in all components, at which `changes` are set; return the state after it."""
        self.set_point(t, x)
        with failing_at(t):
            for instance in self.instances.values():
                instance.call("entering event mode", "enterEventMode")
            for name, value in changes:
                component, port, values = self.check_change(name, value)
                instance = self.instances[component]
                instance.set_start(instance.fmu.ports[port.name], values)
            after = self._settle(t)
            if self.ended is None and not self.next_event > t:
                late = f"its next event, at t = {self.next_event!r} s, does not lie ahead of this one"
                raise CallFailed(self.next_event_of, late)
        return after

    def check_change(self, name: str, value: Value) -> tuple[str, Port, tuple[Any, ...]]:
        """Return component, port and flat value of a variable that may be set during a run; refuse any other."""
        return checked_change(self.system, self.external, name, value)

    def _settle(self, time: float) -> Floats:
        """In event mode: propagate and update discrete states until nothing changes; return the continuous states."""
        self.next_events: dict[str, float] = {}
        """The time events ahead, by whose they are."""
        if self._source is not None:
            self._at_events.signals[: self._at_events.n_external] = self._source.at(np.array([time]))[0]
            self.next_events["the table of inputs"] = self._source.jump(time)
        unsettled = set(self.instances)
        self._propagate()
        for _ in range(_MAX_EVENT_ITERATIONS):
            before = self._at_events.signals.copy()
            unsettled = {name for name in self.instances if name in unsettled and self._update(name, time)}
            self._propagate()
            changed = self._at_events.signals != before
            unsettled |= {call.component for call in self._sets if changed[call.where].any()}
            if not unsettled or self.ended is not None:
                break
        else:
            names = ", ".join(name for name in self.instances if name in unsettled)
            raise AdcsError(f"the event does not settle in {_MAX_EVENT_ITERATIONS} iterations: {names} keep changing")
        states, nominals = [], []
        for instance in self.instances.values():
            instance.call("entering continuous-time mode", "enterContinuousTimeMode")
            _check_dimension(instance)
            states.append(_vector(instance, "getContinuousStates"))
            nominals.append(_nominals(instance))
        self.nominals: Floats = np.concatenate(nominals)
        return np.concatenate(states)

    def _update(self, name: str, now: float) -> bool:
        """Update discrete states once; note the next time event; return whether another update is needed."""
        instance = self.instances[name]
        method = "newDiscreteStates" if instance.major == 2 else "updateDiscreteStates"
        needed, terminate, _, _, defined, time = instance.call("updating discrete states", method)
        if terminate:
            self.ended = self.ended or instance.ended(now)
        self.next_events[instance.name] = time if defined else inf
        if not self.next_events[instance.name] >= -inf:
            raise CallFailed(instance.name, f"its next event is at t = {time!r} s: expected a time ahead")
        return bool(needed)


class _Indicators:
    """The event indicators of some instances, one after the other."""

    def __init__(self, instances: Any) -> None:
        self.owners: list[tuple[str, str]] = []
        self._calls: list[tuple[Instance, Any, int]] = []
        numbers = [(instance, instance.fmu.event_indicators) for instance in instances]
        self._values: Floats = np.empty(sum(n for _, n in numbers))
        for instance, n in numbers:
            if n == 0:
                continue
            place = self._values[len(self.owners) :].ctypes.data_as(POINTER(c_double))
            self._calls.append((instance, place, n))
            self.owners += [(instance.name, f"event indicator {i + 1} of {n}") for i in range(n)]

    def get(self) -> Floats:
        for instance, place, n in self._calls:
            instance.call("getEventIndicators", "getEventIndicators", place, n)
        bad = np.flatnonzero(~np.isfinite(self._values))
        if len(bad):
            component, name = self.owners[bad[0]]
            raise CallFailed(component, f"{name} is not finite")
        return self._values.copy()


def _only(lines: Sequence[Lines], which: NDArray[np.bool_]) -> list[Lines]:
    """Return some of the values that lines have side by side."""
    ends = np.cumsum([line.values.shape[1] for line in lines])
    return [line.only(part) for line, part in zip(lines, np.split(which, ends[:-1]), strict=True)] if lines else []


def refuse(system: System, version: FmiVersion) -> None:
    """Refuse by name what no differential equation can hold."""
    for connection in system.connections:
        if connection.delayed:
            raise AdcsError(
                f"{connection.target} gets {connection.source} with a delay, which coupled Model Exchange does not "
                "support: use the method 'co-simulation', or remove the delay"
            )
    for component in system.components.values():
        if component.every > 1:
            raise AdcsError(
                f"{component.name} communicates at some exchange steps only (every = {component.every}), and coupled "
                "Model Exchange has none: use the method 'co-simulation'"
            )
        component.open(version).check_clocks("model-exchange", component.name)


def _needs_completed_step(instance: Instance) -> bool:
    return bool(instance.fmu.interface("model-exchange").needsCompletedIntegratorStep)


def _vector(instance: Instance, method: str) -> Floats:
    """Return what a method writes into an array with an element per continuous state."""
    values = np.empty(len(instance.fmu.states))
    if len(values):
        instance.call(method, method, values.ctypes.data_as(POINTER(c_double)), len(values))
    return values


def _nominals(instance: Instance) -> Floats:
    """Return the states' nominal values; 1 for one that is of no use, and for all if the FMU does not tell them."""
    try:
        nominals = np.abs(_vector(instance, "getNominalsOfContinuousStates"))
    except CallFailed:
        return np.ones(len(instance.fmu.states))
    return np.where(np.isfinite(nominals) & (nominals > 0), nominals, 1.0)


def _check_dimension(instance: Instance) -> None:
    """Refuse an FMU whose state vector is not of the size that its description gives."""
    if instance.major == 2:  # where the description settles it
        return
    described = len(instance.fmu.states)
    try:
        number = int(instance.call("getNumberOfContinuousStates", "getNumberOfContinuousStates"))
    except CallFailed:  # not every exporter has it
        return
    if number != described:
        raise CallFailed(
            instance.name,
            f"it has {number} continuous states, but {described} in its modelDescription.xml: states that change "
            "dimension are not supported in coupled Model Exchange, use the method 'co-simulation'",
        )
