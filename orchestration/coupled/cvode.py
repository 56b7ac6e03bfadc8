"""CVODE as fmpy brings it: backward differentiation, for what is stiff."""

from __future__ import annotations

import os
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_void_p
from functools import cache
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from orchestration.coupled import integrators
from orchestration.coupled.integrators import Terms, too_many
from orchestration.coupled.model import CoupledModel
from orchestration.engine.walk import Rows, Taken
from orchestration.plan.lowering import Floats


class CVode:
    """Its polynomial of several steps gives rows and events, as accurately as the ends of steps."""

    def __init__(self, model: CoupledModel, terms: Terms) -> None:
        self._make = _cvode()
        self._model, self._terms = model, terms
        self._looks = len(terms.indicators) > 0 or model.watched
        self._solver: Any = None
        self._stopped = False
        self.taken = Taken()
        self.began = self.time = 0.0
        self.x: Floats = np.empty(0)
        self._begin = self.x

    @property
    def covered(self) -> float:
        """Up to where the last step gives rows [s]."""
        return self._terms.covered(self.began, self.time)

    def settle(self) -> None:
        """Bring no component to a time before the present one any more."""
        self._floor = self.time

    @property
    def origin(self) -> tuple[float, Floats, float]:
        """Never asked for: what it knows of many steps cannot be made again."""
        raise NotImplementedError

    def restart(self, t: float, x: Floats, length: float = 0.0) -> None:
        """Go on from (t, x), with what was learned before forgotten."""
        if self.taken.since == 0:
            self.taken.row = t
        self.began = self.time = self._floor = t
        self.x = self._begin = x.copy()
        self._anew = True

    def go(self, until: float, bound: float, rows: Rows) -> bool:
        """Go on; see Integrator."""
        while True:
            while rows.next < self.covered:
                self.taken.row, self.taken.since = rows.next, 0
                rows.take(self._take)
            if (len(rows.times) and rows.next == np.inf) or self.time >= until:
                return False
            if self._stopped:
                raise KeyboardInterrupt
            self.taken.since += 1
            if self.taken.since > integrators.MOST_STEPS:
                raise too_many("CVode", self.taken.row, self.time, min(rows.next, bound))
            self._step(bound)
            if self._looks:
                return True

    def _take(self, asked: float, row: Floats) -> Floats:
        t = max(asked, self._floor)
        x = self.sketch(t)
        self._model.row(t, x, row)
        return x

    def _step(self, bound: float) -> None:
        """Make one step, not beyond the bound."""
        self._begin = self.x
        self.began = self.time
        if bound - self.time <= 1e3 * np.spacing(max(abs(bound), abs(self.time))):  # CVODE finds that too close
            self._straight(bound)
            return
        if self._solver is None:
            self._solver = self._make(self._model, self, self._terms)
        elif self._anew:
            self._solver.reset(self.time)
        self._anew = self._short = False
        try:
            before = self.time
            self.time, self.x = self._solver.one_step(bound)
            if self.time <= before:
                raise self._solver.failed("its steps become too small for time to go on")
            self.taken.steps += 1
        except RuntimeError as error:
            reason = " ".join(str(error).split())
            raise AdcsError(f"CVode cannot go on from t = {self.time:.9g} s: {reason}") from error

    def _straight(self, bound: float) -> None:
        moved = (bound - self.time) * self._model.rhs(self.time, self.x)
        if np.any(np.abs(moved) > np.sqrt(self._terms.rtol) * (np.abs(self.x) + self._model.nominals)):
            raise AdcsError(
                f"CVode cannot go on from t = {self.time:.9g} s: time has too few digits here for its steps, let "
                "the run start nearer to 0"
            )
        self.time, self.x = bound, self.x + moved
        self._short = self._anew = True

    def sketch(self, t: float) -> Floats:
        """Return the state at a time within the last step."""
        if t == self.time or self._short:
            return self.x
        if t <= self.began:  # by an instant, over which a straight line is exact
            return self._begin + (t - self.began) * self._model.rhs(self.began, self._begin)
        interpolated: Floats = self._solver.interpolate(t)
        return interpolated

    at = sketch

    def back(self, t: float) -> None:
        """Let the last step end at a time within it."""
        if t < self.time:
            self.x, self.time = self.sketch(t), t
            self._anew = True

    def stop(self) -> None:
        """Let `go` return; to be called from another thread."""
        self._stopped = True

    @property
    def report(self) -> dict[str, Any]:
        """What it has taken, for the manifest."""
        return {"steps": self.taken.steps, "evaluations": self.taken.evaluations}


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
    set_user_data = sundials_cvode.CVodeSetUserData
    set_user_data.argtypes = (c_void_p, c_void_p)
    interpolate = sundials_cvode.CVodeGetDky
    interpolate.argtypes = (c_void_p, c_double, c_int, N_Vector)
    get_logger = sundials_core.SUNContext_GetLogger
    get_logger.argtypes = (SUNContext, POINTER(c_void_p))
    log_files = (sundials_core.SUNLogger_SetErrorFilename, sundials_core.SUNLogger_SetWarningFilename)
    for function in log_files:
        function.argtypes = (c_void_p, c_char_p)

    class Solver(CVodeSolver):  # type: ignore[misc]
        def __init__(self, model: CoupledModel, at: CVode, terms: Terms) -> None:
            rtol, atol = terms.rtol, terms.atol
            n = len(at.x)
            self._walk = integrators.walk_of(model, terms, at.taken)
            # fmpy makes a function that CVODE calls of what `f` is: here that is one in C already
            self.f, self._given = self._walk.right_hand_side(sundials_core.N_VGetArrayPointer)

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
                maxStep=terms.longest,
            )
            logger = c_void_p()
            get_logger(self.sunctx, byref(logger))
            for function in log_files:  # failures are reported as errors; standard output is not CVODE's
                function(logger, os.devnull.encode())
            set_user_data(self.cvode_mem, byref(self._given))
            self._state = np.ctypeslib.as_array(self.px, (n,))
            self._between = N_VNew_Serial(n, self.sunctx)
            self._between_state = np.ctypeslib.as_array(NV_DATA_S(self._between), (n,))

        def reset(self, time: float) -> None:
            super().reset(time)
            cvode.CVodeSVtolerances(self.cvode_mem, self.reltol, self.abstol)  # which copies them

        def one_step(self, target: float) -> tuple[float, Floats]:
            reached = c_double()
            self._given.forget()
            set_stop_time(self.cvode_mem, target)
            if cvode.CVode(self.cvode_mem, target, self.x, byref(reached), one_step) < 0:
                raise self.failed(self._trouble())
            return reached.value, self._state.copy()

        def interpolate(self, t: float) -> Floats:
            if interpolate(self.cvode_mem, t, 0, self._between) < 0:
                raise RuntimeError(self._trouble())
            return self._between_state.copy()

        def failed(self, otherwise: str) -> Exception:
            return self._walk.failed(self._given) or RuntimeError(otherwise)

        def _trouble(self) -> str:
            code, function, _, message = self.error_info
            return f"{message} (code {code} of {function})"

    return Solver


def _copy(values: Floats, to: Any) -> None:
    np.ctypeslib.as_array(to, (len(values),))[:] = values
