"""The integrators of coupled Model Exchange, one accepted step at a time."""

from __future__ import annotations

import os
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_void_p
from functools import cache
from typing import Any, Literal, Protocol

import numpy as np

from fmus.errors import AdcsError
from orchestration.coupled.model import CoupledModel
from orchestration.instances.instance import CallFailed
from orchestration.plan.lowering import Floats

SolverName = Literal["DOP853", "CVode"]

_MAX_RETRIES = 12
_MAX_STEPS = 100_000  # on the way to one target


class Integrator(Protocol):
    """Walks along the solution. `time` and `x` are where it has come to."""

    time: float
    x: Floats

    def restart(self, t: float, x: Floats) -> None:
        """Go on from (t, x), with what was learned before forgotten."""

    def step(self, target: float) -> None:
        """Make one step toward the target, and none beyond."""

    def sketch(self, t: float) -> Floats:
        """Return the state at a time within the last step, cheaply."""

    def at(self, t: float) -> Floats:
        """Return the state at a time within the last step as accurately as at the end of a step."""


def integrator(model: CoupledModel, solver: SolverName, rtol: float, atol: float) -> Integrator:
    """`rtol` is relative to a state's value, `atol` to its nominal value."""
    if not model.state_names:
        return _Nothing()
    return _Dop853(model, rtol, atol) if solver == "DOP853" else _CVode(model, rtol, atol)


class _Budget:
    """Counts the steps on the way to a target, which could go on for ever."""

    _target = np.nan

    def count(self, time: float, target: float, name: str) -> None:
        """Count one more; AdcsError that says how many would be needed, if they are too many."""
        if target != self._target:
            self._target, self._from, self._steps = target, time, 0
        self._steps += 1
        if self._steps > _MAX_STEPS:
            needed = _MAX_STEPS * (target - self._from) / max(time - self._from, np.spacing(abs(target)))
            raise AdcsError(
                f"{name} cannot go on from t = {time:.9g} s: {_MAX_STEPS} steps do not reach t = {target:.9g} s, "
                f"{needed:.2g} would be needed: choose a shorter time between rows, or loosen the tolerances"
            )


class _Nothing:
    """Integrates a system without continuous states."""

    time: float
    x: Floats

    def restart(self, t: float, x: Floats) -> None:
        self.time, self.x = t, x

    def step(self, target: float) -> None:
        self.time = target

    def sketch(self, t: float) -> Floats:
        return self.x

    at = sketch


class _Dop853:
    """SciPy's DOP853. Its dense output is less accurate than its steps, which therefore end on targets and events."""

    def __init__(self, model: CoupledModel, rtol: float, atol: float) -> None:
        self._model = model
        self._rtol, self._atol = rtol, atol
        self._budget = _Budget()

    def restart(self, t: float, x: Floats) -> None:
        self.time, self.x = t, x
        self._solver: Any = None

    def step(self, target: float) -> None:
        self._budget.count(self.time, target, "DOP853")
        if self._solver is None:
            self._solver = self._start(self.time, self.x, target)
        solver = self._solver
        solver.t_bound, solver.status = target, "running"
        self._before: tuple[float, Floats] = solver.t, solver.y
        self._dense: Any = None
        for attempt in range(_MAX_RETRIES + 1):
            try:
                with np.errstate(over="ignore", invalid="ignore"):  # a state that diverges is reported below
                    message = solver.step()
                break
            except CallFailed as failure:
                # the step may have led out of the states that a component can take: a smaller one need not
                if not _of_the_state(failure) or attempt == _MAX_RETRIES:
                    raise
                solver.h_abs = 0.1 * min(solver.h_abs, target - solver.t)
        if solver.status == "failed":
            raise AdcsError(
                f"DOP853 cannot go on from t = {solver.t:.9g} s: {' '.join(str(message).split())}; "
                "loosen the tolerances, or look for a state that diverges or jumps"
            )
        self.time, self.x = float(solver.t), solver.y

    def sketch(self, t: float) -> Floats:
        if t == self.time:
            return self.x
        if self._dense is None:
            self._dense = self._solver.dense_output()
        dense: Floats = self._dense(t)
        return dense

    def at(self, t: float) -> Floats:
        if t == self.time:
            return self.x
        time, x = self._before
        if t <= time:
            return x
        solver = self._start(time, x, t, first_step=t - time)  # a shorter step than one that was accepted
        while solver.status == "running":
            solver.step()
        if solver.status == "failed":
            raise AdcsError(f"DOP853 cannot locate an event near t = {solver.t:.9g} s: loosen the tolerances")
        return np.asarray(solver.y, np.float64)

    def _start(self, time: float, x: Floats, target: float, **options: Any) -> Any:
        from scipy.integrate import DOP853  # here, since it takes half a second that co-simulation does without

        atol = self._atol * self._model.nominals
        return DOP853(self._model.rhs, time, x, target, rtol=self._rtol, atol=atol, **options)


class _CVode:
    """fmpy's CVODE (BDF), whose steps end on the targets too."""

    def __init__(self, model: CoupledModel, rtol: float, atol: float) -> None:
        self._make = _cvode()
        self._model = model
        self._rtol, self._atol = rtol, atol
        self._solver: Any = None
        self._budget = _Budget()

    def restart(self, t: float, x: Floats) -> None:
        self.time, self.x = t, x.copy()
        if self._solver is not None:
            self._solver.reset(t)

    def step(self, target: float) -> None:
        self._budget.count(self.time, target, "CVode")
        if target - self.time <= 1e3 * np.spacing(max(abs(target), abs(self.time))):  # CVODE finds that too close
            moved = (target - self.time) * self._model.rhs(self.time, self.x)
            if np.any(np.abs(moved) > np.sqrt(self._rtol) * (np.abs(self.x) + self._model.nominals)):
                raise AdcsError(
                    f"CVode cannot go on from t = {self.time:.9g} s: time has too few digits here for its steps, let "
                    "the run start nearer to 0"
                )
            self.restart(target, self.x + moved)
            self._short = True
            return
        self._short = False
        if self._solver is None:
            self._solver = self._make(self._model, self, self._rtol, self._atol)
        try:
            before = self.time
            self.time, self.x = self._solver.one_step(target)
            if self.time <= before:
                raise RuntimeError("its steps become too small for time to go on")
        except Exception as error:
            if self._solver.failure is not None:
                raise self._solver.failure from None
            reason = " ".join(str(error).split())
            raise AdcsError(f"CVode cannot go on from t = {self.time:.9g} s: {reason}") from error

    def sketch(self, t: float) -> Floats:
        if t == self.time or self._short:
            return self.x
        interpolated: Floats = self._solver.interpolate(t)
        return interpolated

    at = sketch


@cache
def _cvode() -> Any:
    """Return a solver on top of fmpy's, with what fmpy left out: single steps, interpolation, stop times, failures."""
    try:
        from fmpy.sundials import CVodeSolver, cvode
        from fmpy.sundials.libraries import sundials_core, sundials_cvode
        from fmpy.sundials.nvector_serial import NV_DATA_S, N_VNew_Serial
        from fmpy.sundials.sundials_nvector import N_Vector
        from fmpy.sundials.sundials_types import SUNContext
    except Exception as error:
        raise AdcsError("solver 'CVode': fmpy brings no CVODE for this platform, use 'DOP853'") from error

    one_step = 2  # CV_ONE_STEP
    set_stop_time = sundials_cvode.CVodeSetStopTime
    set_stop_time.argtypes = (c_void_p, c_double)
    interpolate = sundials_cvode.CVodeGetDky
    interpolate.argtypes = (c_void_p, c_double, c_int, N_Vector)
    get_logger = sundials_core.SUNContext_GetLogger
    get_logger.argtypes = (SUNContext, POINTER(c_void_p))
    log_files = (sundials_core.SUNLogger_SetErrorFilename, sundials_core.SUNLogger_SetWarningFilename)
    for function in log_files:
        function.argtypes = (c_void_p, c_char_p)

    class Solver(CVodeSolver):  # type: ignore[misc]
        def __init__(self, model: CoupledModel, at: Integrator, rtol: float, atol: float) -> None:
            self.failure: BaseException | None = None
            self._rhs = model.rhs
            n = len(at.x)

            def nominals(to: Any, _: int) -> None:  # times rtol they are the absolute tolerances
                np.ctypeslib.as_array(to, (n,))[:] = (atol / rtol) * model.nominals

            super().__init__(
                nx=n,
                nz=0,
                get_x=lambda to, _: _copy(at.x, to),
                set_x=None,
                get_dx=None,
                get_z=None,
                get_nominals=nominals,
                set_time=None,
                input=None,
                startTime=at.time,
                relativeTolerance=rtol,
            )
            logger = c_void_p()
            get_logger(self.sunctx, byref(logger))
            for function in log_files:  # failures are reported as errors; standard output is not CVODE's
                function(logger, os.devnull.encode())
            self._state = np.ctypeslib.as_array(self.px, (n,))
            self._between = N_VNew_Serial(n, self.sunctx)
            self._between_state = np.ctypeslib.as_array(NV_DATA_S(self._between), (n,))

        def f(self, t: float, y: Any, ydot: Any, user_data: Any) -> int:
            try:
                x = np.ctypeslib.as_array(NV_DATA_S(y), (self.nx,))
                np.ctypeslib.as_array(NV_DATA_S(ydot), (self.nx,))[:] = self._rhs(t, x)
            except BaseException as error:  # cannot pass through C, where a negative value ends the integration
                self.failure = error
                return 1 if isinstance(error, CallFailed) and _of_the_state(error) else -1
            return 0

        def reset(self, time: float) -> None:
            super().reset(time)
            cvode.CVodeSVtolerances(self.cvode_mem, self.reltol, self.abstol)  # which copies them

        def one_step(self, target: float) -> tuple[float, Floats]:
            reached = c_double()
            self.failure = None
            set_stop_time(self.cvode_mem, target)
            if cvode.CVode(self.cvode_mem, target, self.x, byref(reached), one_step) < 0:
                raise RuntimeError(self._trouble())
            return reached.value, self._state.copy()

        def interpolate(self, t: float) -> Floats:
            if interpolate(self.cvode_mem, t, 0, self._between) < 0:
                raise RuntimeError(self._trouble())
            return self._between_state.copy()

        def _trouble(self) -> str:
            code, function, _, message = self.error_info
            return f"{message} (code {code} of {function})"

    return Solver


def _copy(values: Floats, to: Any) -> None:
    np.ctypeslib.as_array(to, (len(values),))[:] = values


def _of_the_state(failure: CallFailed) -> bool:
    """Whether a call failed because the state that the integrator tried is out of bounds."""
    return " returned discard" in failure.text or failure.text.endswith("is not finite")
