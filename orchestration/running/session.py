"""A co-simulation that is under way: where it is, what goes on in it, how to change it, save it and go back."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from math import inf, isfinite
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fmus.errors import AdcsError
from orchestration import expected
from orchestration.engine import Engine
from orchestration.engine.overstepping import overstepped
from orchestration.engine.python_loop import PythonLoop
from orchestration.expected import choice
from orchestration.fmu.file import FmiVersion, Port
from orchestration.grid import SNAP, Grid, whole_steps
from orchestration.instances.instance import CallFailed, EndRequested, Instance, failing_at
from orchestration.named import as_system
from orchestration.plan.changing import checked_change
from orchestration.plan.loops import LoopMethod, Loops, LoopSolver, loop_solver
from orchestration.plan.lowering import Floats, make_plan
from orchestration.plan.opening import initialised
from orchestration.plan.outside import Source
from orchestration.plan.propagation import Ring, depends_on, execute, gets_of
from orchestration.process.guard import Guard
from orchestration.process.where import Where
from orchestration.results.result import Recording
from orchestration.running import arguments
from orchestration.system import Connection, System, Value
from orchestration.times import Seconds

Stepping = Literal["compiled", "python"]

ENDLESS = 2**53
"""Number of steps of a co-simulation without an end."""


@dataclass
class Snapshot:
    """Everything that a co-simulation remembers, to go back to in the same session."""

    k: int
    signals: Floats
    rings: tuple[Floats, ...]
    states: Mapping[str, Any]


class Session:
    """A system in co-simulation, at communication point `k` of `last`; a context manager.

        with Session(system, step=0.01) as simulation:
            for time, values in simulation:
                simulation.set("controller.k_p", 2.0)

    What is set after a point acts from there on: an input over the following step, and all that depends on it in other
    components from the next point.

    The components live in this process: one that crashes takes it along. `run(..., isolated=True)` has them in one of
    their own.
    """

    def __init__(
        self,
        system: System | str | Path,
        *,
        step: Seconds | None = None,
        start_time: Seconds | None = None,
        steps: int = ENDLESS,
        stop_time: Seconds | None = None,
        fmi_version: FmiVersion = "2.0",
        stepping: Stepping = "compiled",
        record: Sequence[str] | None = None,
        record_every: int = 1,
        external: Sequence[str] = (),
        may_go_on: bool = False,
        loops: LoopSolver | LoopMethod | None = None,
        where: Where | None = None,
        guard: Guard | None = None,
    ) -> None:
        """`record` names the variables of a row (None: all outputs); `external` inputs whose values come with steps.

        `system` may be a name or the path of a file where `adcs` is imported. The system's own step and start time
        count where none is given.

        It has so many `steps`, or as many as there are until `stop_time`, or no end; given with `steps`, `stop_time` is
        the time of the last point, if the step to it is shorter than the others. The FMUs are told a stop time that is
        beyond it by roundings, unless it `may_go_on` after it.
        """
        system = as_system(system, step)
        arguments.check(Session, locals())
        start_time, _, step = system.run_times(start_time, 0.0, step)
        if stop_time is not None:
            stop_time = expected.seconds("stop_time", stop_time)
            if steps == ENDLESS:
                points = Grid.make(start_time, stop_time, step, partial(rigid, system, fmi_version))
                steps, stop_time = points.steps, points.stop
        solver = loop_solver(loops)
        choice("fmi_version", fmi_version, FmiVersion)
        choice("stepping", stepping, Stepping)
        if not (isfinite(step) and step > 0 and isfinite(start_time)):
            raise AdcsError(f"step = {step} s, start_time = {start_time} s: expected finite times, the step positive")
        self.grid = Grid(start_time, step, steps, stop_time)
        if stop_time is not None and not 0 < self.grid.shorter <= (1 + SNAP) * step:
            begin, end = start_time + (steps - 1) * step, start_time + steps * step
            raise AdcsError(
                f"stop_time = {stop_time} s: step {steps} ends after {begin:g} and at {end:g} s at the latest"
            )
        self.system, self.start, self.step, self.last = system, start_time, step, steps
        self.recording = Recording(system, record)
        self.ended: EndRequested | None = None
        """The wish of a component to end the simulation, once it has come about: nothing comes after that."""
        self.states: Floats = np.empty((0, 0))
        self.state_names: list[str] = []
        self.notes: list[str] = []
        """What there is to be told of the run, besides what its components say."""
        self._shortened = False
        bound = inf if may_go_on or steps == ENDLESS else self.grid.bound
        with ExitStack() as stack:
            opened = initialised(
                system,
                "co-simulation",
                start_time,
                bound,
                fmi_version,
                external=external,
                solver=solver,
                where=where,
                guard=guard,
            )
            self.instances: dict[str, Instance] = stack.enter_context(opened)
            components = system.components.values()
            self._plan = make_plan(
                {name: instance.fmu for name, instance in self.instances.items()},
                [_in_steps(c, step) for c in system.connections],
                self.recording.names,
                external=external,
                starts={c.name: c.start for c in components},
                every={c.name: c.every for c in components},
                solve_loops=solver is not None,
            )
            self._gets = gets_of(self._plan)
            self._shown: dict[str, bool] = {}
            self.external = tuple(external)
            self.rings = tuple(Ring.filled(delay, self._plan.signals) for delay in self._plan.delays)
            self._loops = Loops(self._plan, self.instances, solver or LoopSolver())
            make = Engine if stepping == "compiled" else PythonLoop
            self.loop: Engine | PythonLoop = make(
                self._plan,
                self.instances,
                rings=self.rings,
                record_every=record_every,
                solve=self._loops.solve,
                where=where,
            )
            self._guard, self._where = guard, where or Where()
            self.source: Source | None = None
            self.k = 0
            self._closed = False
            self._stack = stack.pop_all()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *error: Any) -> None:
        self._closed = True
        self._stack.__exit__(*error)

    def _open(self) -> None:
        """Refuse what components would be asked for that are gone."""
        if self._closed:
            raise AdcsError("the session is closed, and its components with it: use it within its `with`")

    def __iter__(self) -> Iterator[tuple[float, dict[str, Floats]]]:
        """Yield (t_k, values by name) at every communication point, before stepping on from it."""
        while True:
            self.propagate()
            yield self.time, self.values
            if self.k >= self.last or self.ended is not None:
                return
            try:
                self.move_on()
            except EndRequested as end:
                self.k += 1  # the point itself was taken
                if end.time is not None and end.time > self._propagated_at and self.end_row() is not None:
                    yield end.time, self.values
                return

    @property
    def time(self) -> float:
        """The time of the present point [s]."""
        return self.grid.time(self.k)

    @property
    def values(self) -> dict[str, Floats]:
        """The recorded variables as they were last propagated, by name."""
        ports = self.recording.ports
        if not ports:
            return {}
        parts = np.split(self.row, np.cumsum([port.size for port in ports.values()])[:-1])
        return {name: part.reshape(port.shape) for (name, port), part in zip(ports.items(), parts, strict=True)}

    @property
    def ports(self) -> dict[str, Port]:
        """The recorded variables by name, in the order of a row."""
        return self.recording.ports

    @property
    def row(self) -> Floats:
        """The recorded variables at the point that was taken last, side by side."""
        return self._propagated

    @property
    def _propagated(self) -> Floats:
        """The recorded variables as they were last propagated."""
        row: Floats = self.signals[self._plan.row]
        return row

    @property
    def signals(self) -> Floats:
        """All values on their way between components; a buffer that is written on."""
        return self._plan.signals

    @property
    def warnings(self) -> list[str]:
        """What the FMUs warned of, what they changed that was not theirs, and what else there is to be told."""
        told = [f"{i.name}: {text}" for i in self.instances.values() for text in i.warnings]
        return told + overstepped(self.instances, self._guard, [self.loop]) + self.notes

    def check(self) -> None:
        """Look at what components may have changed of the process, if one was not built here."""
        if self._guard is not None and not all(i.ours for i in self.instances.values()):
            self._guard.check()

    @property
    def n_external(self) -> int:
        """Number of values that come from outside at each point."""
        return self._plan.n_external

    def propagate(self) -> None:
        """Fetch all outputs and hand them on, at the present point; see whether a component ends the simulation."""
        self._open()
        if self.k > self.grid.full:
            self._propagate_off_grid()
        else:
            self.loop.propagate(self.k, self.time)
        self.see_end()

    def move_on(self) -> None:
        """Step all components to the next point. EndRequested if a component ends the simulation on the way."""
        self._open()
        if self.k >= self.last:
            raise AdcsError(f"the session is at its last point, t = {self.time:g} s: there is no step from there")
        if self.k == self.grid.full and self.grid.shorter:
            self.shorter_step()
            return
        try:
            with failing_at(self.time):
                self.loop.move_on(self.k, self.grid.full, self.time, self.step)
        except EndRequested as end:
            self.ended = end
            raise
        self.k += 1

    def advance(self, count: int, rows: Floats, *, stay: bool = False) -> tuple[int, int, CallFailed | None]:
        """Take `count` points from the present one on, recorded in `rows`.

        Returns the point that comes next, the number of rows, and what failed. With `stay` no component is stepped on
        from the last of them; `leave` does that. The last point, if the step to it is shorter, is for a call of its
        own, after `shorter_step`.
        """
        external = self._outside(count)
        if self.k <= self.grid.full:
            last = self.k + count - 1 if stay else self.grid.full
            k, written, failed = self.loop.steps(self.start, self.step, self.k, count, last, external, rows)
            if isinstance(failed, EndRequested):
                self.ended, k = failed, k + 1  # the point itself was taken
            return k, written, failed
        if external is not None:
            self.signals[: self.n_external] = external[0]
        try:
            with failing_at(self.time):
                self._propagate_off_grid()
        except CallFailed as failed:
            return self.k, 0, failed
        rows[0] = self.row
        self.see_end()
        return self.k + 1, 1, self.ended

    def _outside(self, count: int) -> Floats | None:
        """The values from outside at the next points, (count, number of values)."""
        if self.source is None:
            return None
        return self.source.at(self.grid.at(np.arange(self.k, self.k + count)))

    def end_row(self) -> Floats | None:
        """Return the row of the time at which a component ended the simulation, where it can still be asked.

        Between two points the component that ended it has values of its own time; those of the others are of the point
        before, which `ended.others_at` tells. Where its values cannot be had there is no row, and a warning.
        """
        end, at = self.ended, self._propagated_at
        assert end is not None
        if end.time is None or abs(end.time - at) <= SNAP * self.step:
            return self._propagated
        before = self.signals.copy()
        try:
            for call in self._gets:
                if call.component == end.component:
                    execute(call, self.signals, self.instances)
        except CallFailed as failed:
            self.signals[:] = before
            self.instances[end.component].warn(f"its values at its end, t = {end.time:.9g} s, are lost: {failed.text}")
            return None
        end.others_at = at
        return self._propagated

    @property
    def _propagated_at(self) -> float:
        """The time of the last point that was taken [s]."""
        return self.grid.time(self.k - 1)

    def report(self) -> dict[str, Any]:
        """Return what the manifest is to have of it."""
        return {"algebraic_loops": self._loops.reports} if self._loops.reports else {}

    def leave(self) -> None:
        """After `advance` with `stay`: go on to the next point, by a step if it is not a shorter one."""
        if self.k < self.grid.full:
            self.move_on()
        else:
            self.k += 1

    def shorter_step(self) -> None:
        """From the last point of the grid, step to the end those components that communicate at every point."""
        full, held = self.grid.full, [self.signals[ring.delay.target].copy() for ring in self.rings]
        try:
            with failing_at(self.grid.time(full)):
                self.loop.move_on(full, full + 1, self.grid.time(full), self.grid.shorter)
        except EndRequested as end:
            self.ended = end
            raise
        # what is delayed arrives at points of the grid only, and until then what arrived last holds
        for ring, values in zip(self.rings, held, strict=True):
            ring.values[:] = values
        self.k, self._shortened = self.last, True

    def stop(self, at_once: bool = False) -> None:
        """Let `advance` return before its next point, or before its next call; to be called from another thread."""
        self.loop.stop(at_once)

    @property
    def shorter_due(self) -> bool:
        """Whether the point that comes next is the last one, and the shorter step to it has not been taken."""
        return self.k > self.grid.full and self.k == self.last and not self._shortened

    def _propagate_off_grid(self) -> None:
        """Propagate at the end of a shorter step, where components that communicate at some points only do not."""
        self.loop.propagate(1, self.time)

    def see_end(self) -> None:
        """See whether a component ends the simulation at the present point, which was propagated."""
        end = self.loop.ending(self.k)
        if end is not None and self.ended is None:
            end.time = self.time
            self.ended = end

    def set(self, name: str, value: Value) -> None:
        """Set an input that nothing feeds, or a tunable parameter, at the present point."""
        self._open()
        component, port, values = self.check_change(name, value)
        with failing_at(self.time):
            instance = self.instances[component]
            instance.change(self.k, instance.fmu.ports[port.name], values)  # whose FMI version may be another

    def shows(self, name: str) -> bool:
        """Whether what is set in a variable may show in what is fetched at the same point.

        That is said of inputs only: of those on which, by the FMU's ModelStructure, nothing depends that is fetched. In
        event mode of FMI 3.0 values are set first.
        """
        if name not in self._shown:
            component, port = self.system.port(name)
            fmu, gets = self.instances[component].fmu, [call for call in self._gets if call.component == component]
            late = port.causality == "input" and self.instances[component].in_step_mode
            self._shown[name] = not late or any(
                depends_on(fmu, get, fmu.nodes.of(fmu.ports[port.name])) for get in gets
            )
        return self._shown[name]

    def check_change(self, name: str, value: Value) -> tuple[str, Port, tuple[Any, ...]]:
        """Return component, port and flat value of a variable that may be set during a run; refuse any other."""
        return checked_change(self.system, self.external, name, value)

    def save(self) -> Snapshot:
        """Return a copy of all that is remembered at the present point; to be freed."""
        self._open()
        for instance in self.instances.values():
            if not instance.can_save:
                raise AdcsError(f"{instance.name} ({instance.fmu.path.name}) cannot save its state")
        states = {name: instance.save() for name, instance in self.instances.items()}
        return Snapshot(self.k, self._plan.signals.copy(), tuple(r.values.copy() for r in self.rings), states)

    def memory(self) -> dict[str, NDArray[Any]]:
        """Return what has to be kept to go on from here, besides the components' states."""
        return {"signals": self.signals, **{f"ring_{i}": ring.values for i, ring in enumerate(self.rings)}}

    def remember(self, k: int, memory: Mapping[str, NDArray[Any]]) -> None:
        """Go on at point k with what `memory` gave; the components are there already."""
        self.k = k
        for name, values in self.memory().items():
            values[:] = memory[name]

    def restore(self, snapshot: Snapshot) -> None:
        """Go back to a snapshot."""
        self._open()
        if not isinstance(snapshot, Snapshot):
            raise expected.refused("snapshot", snapshot, "what `save` returned")
        self.k, self.ended, self._shortened = snapshot.k, None, False
        for instance in self.instances.values():
            instance.wants_end = False
        self.loop.forget_end()
        self._plan.signals[:] = snapshot.signals
        for ring, values in zip(self.rings, snapshot.rings, strict=True):
            ring.values[:] = values
        for name, state in snapshot.states.items():
            self.instances[name].restore(state)

    def free(self, snapshot: Snapshot) -> None:
        """Give back the memory of a snapshot."""
        for name, state in snapshot.states.items():
            self.instances[name].free(state)


def _in_steps(connection: Connection, step: float) -> Connection:
    """The connection with its delay in steps."""
    if not connection.delay:
        return connection
    steps = whole_steps(connection.delay, step, f"the delay of {connection.target}", none=True)
    return replace(connection, delay_steps=steps, delay=0.0)


def rigid(system: System, version: FmiVersion) -> str | None:
    """Say why the last step of a co-simulation may not be shorter than the others; None if it may."""
    for component in system.components.values():
        fmu = component.open(version)
        if component.every == 1 and not fmu.interface("co-simulation").canHandleVariableCommunicationStepSize:
            return (
                f", and {component.name} ({fmu.path.name}) takes no shorter last one "
                "(canHandleVariableCommunicationStepSize is not true)"
            )
    return None


def steps(
    system: System | str | Path,
    *,
    stop_time: Seconds | None = None,
    step: Seconds | None = None,
    start_time: Seconds | None = None,
    fmi_version: FmiVersion = "2.0",
    record: Sequence[str] | None = None,
) -> Iterator[tuple[float, Mapping[str, Floats]]]:
    """Co-simulate step by step: yield (t_k, values by name) at every communication point, before stepping on from it.

    The values are those that `run` records, to the last bit. Time goes on only while the caller asks for more. If a
    component ends the simulation, nothing is yielded after that. Times that are not given are the system's own.
    """
    system = as_system(system, step)
    arguments.check(steps, locals())
    choice("fmi_version", fmi_version, FmiVersion)
    grid = Grid.make(*system.run_times(start_time, stop_time, step), partial(rigid, system, fmi_version))
    times: dict[str, Any] = {"step": grid.step, "start_time": grid.start, "steps": grid.steps, "stop_time": grid.stop}
    with Session(system, **times, fmi_version=fmi_version, record=record) as simulation:
        yield from simulation
