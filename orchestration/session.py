"""A co-simulation that is under way: where it is, what goes on in it, how to change it, save it and go back."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Any, Literal

import numpy as np

from fmus.errors import AdcsError
from orchestration.engine import Engine
from orchestration.fmu import FmiVersion, Port
from orchestration.instance import Instance, failing_at
from orchestration.isolation.guard import Guard
from orchestration.isolation.overstepping import overstepped
from orchestration.isolation.where import Where
from orchestration.loops import Loops, LoopSolver
from orchestration.opening import initialised
from orchestration.plan import Floats, make_plan
from orchestration.propagation import Ring
from orchestration.python_loop import PythonLoop
from orchestration.results import Recording
from orchestration.system import Connection, System, Value, checked_value

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


class CoSimulation:
    """A system in co-simulation, at communication point `k` of `last`; a context manager.

        with CoSimulation(system, step=0.01) as simulation:
            for time, values in simulation:
                simulation.set("controller.k_p", 2.0)

    What is set after a point acts from there on: an input over the following step, and all that depends on it in other
    components from the next point.

    The components live in this process: one that crashes takes it along. `run(..., isolated=True)` has them in one of
    their own.
    """

    def __init__(
        self,
        system: System,
        *,
        step: float,
        start_time: float = 0.0,
        steps: int = ENDLESS,
        fmi_version: FmiVersion = "2.0",
        stepping: Stepping = "compiled",
        record: Sequence[str] | None = None,
        record_every: int = 1,
        external: Sequence[str] = (),
        may_go_on: bool = False,
        solver: LoopSolver | None = None,
        where: Where | None = None,
        guard: Guard | None = None,
    ) -> None:
        """`record` names the variables of a row (None: all outputs); `external` inputs whose values come with steps.

        The FMUs are told the stop time, unless it `may_go_on` after it.
        """
        if not (isfinite(step) and step > 0 and isfinite(start_time)):
            raise AdcsError(f"step = {step} s, start_time = {start_time} s: expected finite times, the step positive")
        self.system, self.start, self.step, self.last = system, start_time, step, steps
        self.recording = Recording(system, record)
        stop_time = inf if may_go_on or steps == ENDLESS else start_time + steps * step
        with ExitStack() as stack:
            opened = initialised(
                system,
                "co-simulation",
                start_time,
                stop_time,
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
            self._guard = guard
            self.k = 0
            self._stack = stack.pop_all()

    def __enter__(self) -> CoSimulation:
        return self

    def __exit__(self, *error: Any) -> None:
        self._stack.__exit__(*error)

    def __iter__(self) -> Iterator[tuple[float, dict[str, Floats]]]:
        """Yield (t_k, values by name) at every communication point, before stepping on from it."""
        while True:
            self.propagate()
            yield self.time, self.values
            if self.k >= self.last:
                return
            self.move_on()

    @property
    def time(self) -> float:
        """The time of the present point [s]."""
        return self.start + self.k * self.step

    @property
    def values(self) -> dict[str, Floats]:
        """The recorded variables as they were last propagated, by name."""
        ports = self.recording.ports
        if not ports:
            return {}
        parts = np.split(self.row, np.cumsum([port.size for port in ports.values()])[:-1])
        return {name: part.reshape(port.shape) for (name, port), part in zip(ports.items(), parts, strict=True)}

    @property
    def row(self) -> Floats:
        """The recorded variables as they were last propagated, side by side."""
        row: Floats = self.signals[self._plan.row]
        return row

    @property
    def signals(self) -> Floats:
        """All values on their way between components; a buffer that is written on."""
        return self._plan.signals

    @property
    def warnings(self) -> list[str]:
        """What the FMUs warned of, and what they changed that was not theirs."""
        told = [f"{i.name}: {text}" for i in self.instances.values() for text in i.warnings]
        return told + overstepped(self.instances, self._guard, [self.loop])

    def check(self) -> None:
        """Look at what components may have changed of the process, if one was not built here."""
        if self._guard is not None and not all(i.ours for i in self.instances.values()):
            self._guard.check()

    @property
    def loop_reports(self) -> list[dict[str, Any]]:
        """What solving each algebraic loop took."""
        return self._loops.reports

    @property
    def n_external(self) -> int:
        """Number of values that come from outside at each point."""
        return self._plan.n_external

    def propagate(self) -> None:
        """Fetch all outputs and hand them on, at the present point."""
        self.loop.propagate(self.k, self.time)

    def move_on(self) -> None:
        """Step all components to the next point."""
        self.loop.move_on(self.k, self.last, self.time, self.step)
        self.k += 1

    def set(self, name: str, value: Value) -> None:
        """Set an input that nothing feeds, or a tunable parameter, at the present point."""
        component, port, values = self.check_change(name, value)
        with failing_at(self.time):
            instance = self.instances[component]
            instance.set_start(instance.fmu.ports[port.name], values)  # whose FMI version may be another

    def check_change(self, name: str, value: Value) -> tuple[str, Port, tuple[Any, ...]]:
        """Return component, port and flat value of a variable that may be set during a run; refuse any other."""
        component, port = self.system.port(name)
        if name.partition(".")[2] != port.name:
            raise AdcsError(f"{name} is one element: give all values of {component}.{port.name}")
        if port.causality == "input":
            outside = next((n for n in self.external if self.system.port(n) == (component, port)), None)
            if outside is not None:
                raise AdcsError(f"{name} gets its values from a table: it cannot be set during a run")
            fed = next((c for c in self.system.connections if self.system.port(c.target) == (component, port)), None)
            if fed is not None:
                raise AdcsError(f"{name} is connected to {fed.source}: it cannot be set during a run")
        elif not (port.causality == "parameter" and port.variability == "tunable"):
            raise AdcsError(
                f"{name} cannot be set during a run: it is a {port.variability} {port.causality}, only inputs and "
                "tunable parameters can"
            )
        return component, port, checked_value(name, port, value)

    def save(self) -> Snapshot:
        """Return a copy of all that is remembered at the present point; to be freed."""
        for instance in self.instances.values():
            if not instance.can_save:
                raise AdcsError(f"{instance.name} ({instance.fmu.path.name}) cannot save its state")
        states = {name: instance.save() for name, instance in self.instances.items()}
        return Snapshot(self.k, self._plan.signals.copy(), tuple(r.values.copy() for r in self.rings), states)

    def restore(self, snapshot: Snapshot) -> None:
        """Go back to a snapshot."""
        self.k = snapshot.k
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
    ratio = connection.delay / step
    steps = round(ratio)
    if not isfinite(ratio) or steps < 1 or abs(ratio - steps) > 1e-9 * ratio:
        raise AdcsError(
            f"the delay of {connection.target}, {connection.delay:g} s, is not a whole number of exchange steps of "
            f"{step:g} s: use {max(1, int(ratio)) * step:.12g} or {(int(ratio) + 1) * step:.12g} s, or another step"
        )
    return replace(connection, delay_steps=steps, delay=0.0)
