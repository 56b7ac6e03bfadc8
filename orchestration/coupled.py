"""Coupled Model Exchange: all components as one ordinary differential equation, with time events."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from ctypes import POINTER, c_double, c_void_p
from functools import cache
from math import inf
from typing import Any, Literal, Protocol

import numpy as np
from scipy.integrate import DOP853

from fmus.errors import AdcsError
from orchestration.cosim import Progress
from orchestration.engine import Engine
from orchestration.fmu import FmiVersion
from orchestration.grid import Grid
from orchestration.instance import CallFailed, Instance, failing_at, initialised
from orchestration.plan import Floats, make_plan
from orchestration.results import Recording
from orchestration.system import System

SolverName = Literal["DOP853", "CVode"]

_MAX_EVENT_ITERATIONS = 100


class CoupledModel:
    """The system as x' = f(t, x), initialised, in continuous-time mode. A context manager.

        with CoupledModel(system) as model:
            model.rhs(0.0, model.x0)

    `state_names` names the elements of x, `x0` is the state after initialisation, `next_event` the time of the next
    time event (inf: none). Between two events `rhs` and `outputs` are functions of (t, x) alone.
    """

    def __init__(
        self,
        system: System,
        start_time: float = 0.0,
        stop_time: float = inf,
        fmi_version: FmiVersion = "2.0",
        record: Sequence[str] | None = None,
    ) -> None:
        recording = Recording(system, record, 1)
        self.ports = recording.ports
        with ExitStack() as stack:
            opened = initialised(system, "model-exchange", start_time, stop_time, fmi_version)
            self._instances = stack.enter_context(opened)
            fmus = {name: instance.fmu for name, instance in self._instances.items()}
            for name, fmu in fmus.items():
                if fmu.model.numberOfEventIndicators > 0:
                    raise AdcsError(
                        f"{name} ({fmu.path.name}) has state events, which coupled Model Exchange does not support: "
                        "use the method 'co-simulation'"
                    )
            # in continuous-time mode only inputs of continuous variability may be set
            continuous = [c for c in system.connections if system.port(c.target)[1].variability == "continuous"]
            self._at_events = make_plan(fmus, system.connections)
            self._propagate = Engine(self._at_events, self._instances).propagate
            self._derivatives = Engine(make_plan(fmus, continuous), self._instances)
            self._outputs = Engine(make_plan(fmus, continuous, recording.names), self._instances)
            self.state_names = [f"{name}.{state}" for name, fmu in fmus.items() for state in fmu.states]
            self._row_size = sum(port.size for port in self.ports.values())
            self._watchers = [i for i in self._instances.values() if _needs_completed_step(i)]
            self.next_event = inf
            self.x0 = self._settle()
            self._stack = stack.pop_all()

    def __enter__(self) -> CoupledModel:
        return self

    def __exit__(self, *error: Any) -> None:
        self._stack.__exit__(*error)

    @property
    def warnings(self) -> list[str]:
        """What the FMUs warned of."""
        return [f"{i.name}: {text}" for i in self._instances.values() for text in i.warnings]

    def rhs(self, t: float, x: Floats) -> Floats:
        """Return x' (n,) at time t and state x (n,)."""
        derivatives = np.empty(len(self.state_names))
        self._derivatives.evaluate(t, np.ascontiguousarray(x, np.float64), derivatives)
        return derivatives

    def row(self, t: float, x: Floats, row: Floats) -> None:
        """Write the recorded variables at (t, x) into a contiguous row."""
        self._outputs.evaluate(t, np.ascontiguousarray(x, np.float64), None, row)

    def outputs(self, t: float, x: Floats) -> dict[str, Floats]:
        """Return the recorded variables at (t, x) by name."""
        row = np.empty(self._row_size)
        self.row(t, x, row)
        cuts = np.cumsum([port.size for port in self.ports.values()])[:-1]
        parts = np.split(row, cuts)
        return {n: part.reshape(p.shape) for (n, p), part in zip(self.ports.items(), parts, strict=True)}

    def completed_step(self, t: float, x: Floats) -> bool:
        """Tell the components that want to know that the integrator accepted a step; True asks for an event."""
        if not self._watchers:
            return False
        self._derivatives.evaluate(t, np.ascontiguousarray(x, np.float64), None)
        wanted = False
        with failing_at(t):
            for instance in self._watchers:
                event, terminate = instance.call("completedIntegratorStep", "completedIntegratorStep")
                if terminate:
                    raise instance.ended()
                wanted = wanted or event
        return wanted

    def event(self, t: float, x: Floats) -> Floats:
        """Handle an event at (t, x) in all components; return the state after it."""
        self._derivatives.evaluate(t, np.ascontiguousarray(x, np.float64), None)
        for instance in self._instances.values():
            instance.call("entering event mode", "enterEventMode")
        after = self._settle()
        if self.next_event <= t:
            name = min(self._next, key=self._next.__getitem__)
            raise CallFailed(name, f"its next event, at t = {self.next_event!r} s, does not lie ahead of this one")
        return after

    def _settle(self) -> Floats:
        """In event mode: propagate and update discrete states until nothing changes; return the continuous states."""
        self._next: dict[str, float] = {}
        self._propagate()
        for _ in range(_MAX_EVENT_ITERATIONS):
            before = self._at_events.signals.copy()
            unsettled = [i for i in self._instances.values() if _update_discrete_states(i, self._next)]
            self._propagate()
            if not unsettled and np.array_equal(before, self._at_events.signals):
                break
        else:
            names = ", ".join(i.name for i in unsettled) or "values that components exchange"
            raise AdcsError(f"the event does not settle in {_MAX_EVENT_ITERATIONS} iterations: {names} keep changing")
        self.next_event = min(self._next.values(), default=inf)
        parts = []
        for instance in self._instances.values():
            instance.call("entering continuous-time mode", "enterContinuousTimeMode")
            part = np.empty(len(instance.fmu.states))
            if len(part):
                pointer = part.ctypes.data_as(POINTER(c_double))
                instance.call("getContinuousStates", "getContinuousStates", pointer, len(part))
            parts.append(part)
        return np.concatenate(parts)


def couple(
    model: CoupledModel,
    grid: Grid,
    recording: Recording,
    states: Floats,
    solver: SolverName = "DOP853",
    rtol: float = 1e-10,
    atol: float = 1e-12,
    progress: Progress = lambda fraction: None,
) -> None:
    """Integrate over the grid, stopping exactly at time events; fill the recording and `states` (steps+1, n).

    A row at the time of an event holds the values after it.
    """
    integrator = _integrator(model, solver, rtol, atol)
    time = grid.start
    integrator.restart(time, model.x0)
    snap = 1e-9 * grid.step  # an event this close to a grid point is at it
    for k in range(grid.steps + 1):
        point = grid.time(k)
        while time < point or model.next_event <= point + snap:
            due = model.next_event
            target = min(due, point) if abs(due - point) > snap else max(due, point)
            if time < target:
                time, asked = integrator.advance(target)
            else:
                asked = False
            if asked or time >= due:
                with failing_at(time):
                    integrator.restart(time, model.event(time, integrator.x))
        model.row(time, integrator.x, recording.data[k])
        states[k] = integrator.x
        recording.filled = k + 1
        progress((k + 1) / (grid.steps + 1))


class _Integrator(Protocol):
    x: Floats

    def restart(self, t: float, x: Floats) -> None: ...

    def advance(self, target: float) -> tuple[float, bool]:
        """Integrate to the target, or to where a component asks for an event: (time reached, event asked for)."""


def _integrator(model: CoupledModel, solver: SolverName, rtol: float, atol: float) -> _Integrator:
    if not model.state_names:
        return _Nothing()
    return _Dop853(model, rtol, atol) if solver == "DOP853" else _CVode(model, rtol, atol)


class _Nothing:
    """Integrates a system without continuous states."""

    def restart(self, t: float, x: Floats) -> None:
        self.x = x

    def advance(self, target: float) -> tuple[float, bool]:
        return target, False


class _Dop853:
    """Steps of SciPy's DOP853 that end exactly on the targets: its dense output is less accurate than its steps."""

    def __init__(self, model: CoupledModel, rtol: float, atol: float) -> None:
        self._model = model
        self._rtol, self._atol = rtol, atol
        self._solver: Any = None

    def restart(self, t: float, x: Floats) -> None:
        self.x, self._time, self._solver = x, t, None

    def advance(self, target: float) -> tuple[float, bool]:
        if self._solver is None:
            self._solver = DOP853(self._model.rhs, self._time, self.x, target, rtol=self._rtol, atol=self._atol)
        solver = self._solver
        solver.t_bound, solver.status = target, "running"
        while solver.status == "running":
            with np.errstate(over="ignore", invalid="ignore"):  # a state that diverges is reported below
                message = solver.step()
            if solver.status == "failed":
                raise AdcsError(
                    f"DOP853 cannot go on from t = {solver.t:.9g} s: {' '.join(str(message).split())}; "
                    "loosen the tolerances, or look for a state that diverges or jumps"
                )
            self.x = solver.y
            if self._model.completed_step(solver.t, solver.y):
                return solver.t, True
        return target, False


class _CVode:
    """fmpy's CVODE (BDF), whose steps end on the targets too."""

    def __init__(self, model: CoupledModel, rtol: float, atol: float) -> None:
        self._make, self._set_stop_time = _cvode()
        self._model = model
        self._rtol, self._atol = rtol, atol
        self._solver: Any = None

    def restart(self, t: float, x: Floats) -> None:
        self.x, self._time = x.copy(), t
        if self._solver is not None:
            self._solver.reset(t)

    def advance(self, target: float) -> tuple[float, bool]:
        n = len(self.x)
        if self._solver is None:
            self._solver = self._make(
                nx=n,
                nz=0,
                get_x=lambda to, _: _copy(self.x, to),
                set_x=self._set,
                get_dx=lambda to, _: _copy(self._model.rhs(self._now, self.x), to),
                get_z=lambda to, _: None,
                get_nominals=lambda to, _: _copy(np.full(n, self._atol / self._rtol), to),
                set_time=self._set_time,
                input=None,
                startTime=self._time,
                relativeTolerance=self._rtol,
                maxNumSteps=100_000,
            )
        self._set_stop_time(self._solver.cvode_mem, target)
        try:
            self._solver.step(self._time, target)
        except Exception as error:
            if self._solver.failure is not None:
                raise self._solver.failure from None
            reason = " ".join(str(error).split())
            raise AdcsError(f"CVode cannot go on from t = {self._time:.9g} s: {reason}") from error
        self._time = target
        return target, self._model.completed_step(target, self.x)

    def _set_time(self, t: float) -> None:
        self._now = t

    def _set(self, source: Any, n: int) -> None:
        self.x = np.ctypeslib.as_array(source, (n,)).copy()


@cache
def _cvode() -> tuple[Any, Any]:
    """Return fmpy's solver, made to stop when the right-hand side fails, and CVodeSetStopTime, which fmpy left out."""
    try:
        from fmpy.sundials import CVodeSolver
        from fmpy.sundials.libraries import sundials_cvode
    except Exception as error:
        raise AdcsError("solver 'CVode': fmpy brings no CVODE for this platform, use 'DOP853'") from error

    class Solver(CVodeSolver):  # type: ignore[misc]
        failure: BaseException | None = None

        def f(self, t: float, y: Any, ydot: Any, user_data: Any) -> int:
            try:
                return int(super().f(t, y, ydot, user_data))
            except BaseException as error:  # cannot pass through C, where a negative value ends the integration
                self.failure = error
                return -1

    set_stop_time = sundials_cvode.CVodeSetStopTime
    set_stop_time.argtypes = (c_void_p, c_double)
    return Solver, set_stop_time


def _copy(values: Floats, to: Any) -> None:
    np.ctypeslib.as_array(to, (len(values),))[:] = values


def _needs_completed_step(instance: Instance) -> bool:
    return bool(instance.fmu.interface("model-exchange").needsCompletedIntegratorStep)


def _update_discrete_states(instance: Instance, next_events: dict[str, float]) -> bool:
    """Update once; note the next time event; return whether another update is needed."""
    method = "newDiscreteStates" if instance.major == 2 else "updateDiscreteStates"
    needed, terminate, _, _, defined, time = instance.call("updating discrete states", method)
    if terminate:
        raise instance.ended()
    next_events[instance.name] = time if defined else inf
    return bool(needed)
