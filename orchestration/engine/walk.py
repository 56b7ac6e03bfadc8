"""The compiled DOP853, walk.c: the solution of coupled Model Exchange step by step, and rows between."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from enum import IntEnum
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchestration.engine import Engine, Failure, library
from orchestration.instances.instance import CallFailed
from orchestration.plan.lowering import Floats
from orchestration.process.where import Where

_EXTENDED, _DEGREE = 16, 7  # dop853.h

_OUTSIDE = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double)


class Outcome(IntEnum):
    """How a walk ends (walk.c)."""

    THERE = 0
    WRITTEN = 1
    LOOK = 2
    STOPPED = 3
    FAILED = 4
    ROWS_FAILED = 5
    TOO_SHORT = 6
    TOO_MANY = 7


class Taken(ctypes.Structure):
    """What a solution has taken: counts, the shortest and the longest step, steps since the last row, and its time."""

    _fields_ = (
        ("evaluations", ctypes.c_int64),
        ("steps", ctypes.c_int64),
        ("rejected", ctypes.c_int64),
        ("shortest", ctypes.c_double),
        ("longest", ctypes.c_double),
        ("since", ctypes.c_int64),
        ("row", ctypes.c_double),
    )

    def __init__(self) -> None:
        super().__init__(shortest=inf)

    @property
    def report(self) -> dict[str, Any]:
        """For the manifest."""
        lengths = {"shortest [s]": self.shortest, "longest [s]": self.longest} if self.steps else {}
        return {"steps": self.steps, "rejected": self.rejected, "evaluations": self.evaluations, **lengths}


class _Walk(ctypes.Structure):
    _fields_ = (
        ("flow", ctypes.c_void_p),
        ("rows", ctypes.c_void_p),
        ("outside", _OUTSIDE),
        ("n", ctypes.c_size_t),
        ("row_size", ctypes.c_size_t),
        ("tolerances", ctypes.c_void_p),
        ("relative", ctypes.c_double),
        ("longest", ctypes.c_double),
        ("instant", ctypes.c_double),
        ("looks", ctypes.c_double),
        ("apart", ctypes.c_double),
        ("n_indicators", ctypes.c_size_t),
        ("end", ctypes.c_double),
        ("watched", ctypes.c_bool),
        ("most_steps", ctypes.c_int64),
        ("started", ctypes.c_bool),
        ("extended", ctypes.c_bool),
        ("began", ctypes.c_double),
        ("time", ctypes.c_double),
        ("floor", ctypes.c_double),
        ("length", ctypes.c_double),
        ("origin", ctypes.c_double),
        ("tried", ctypes.c_double),
        ("at_origin", ctypes.c_void_p),
        ("cut", ctypes.c_bool),
        ("before", ctypes.c_void_p),
        ("x", ctypes.c_void_p),
        ("trial", ctypes.c_void_p),
        ("stages", ctypes.c_void_p),
        ("extension", ctypes.c_void_p),
        ("uncertain", ctypes.c_void_p),
        ("indicators", ctypes.c_void_p),
        ("look", ctypes.c_void_p),
        ("asked", ctypes.c_double),
        ("taken", ctypes.POINTER(Taken)),
    )


class RightHandSide(ctypes.Structure):
    """The right-hand side of a walk for CVODE; its last failure stays until it is forgotten."""

    _fields_ = (
        ("walk", ctypes.c_void_p),
        ("values", ctypes.c_void_p),
        ("failure", Failure),
        ("failed_at", ctypes.c_double),
    )

    def forget(self) -> None:
        """Note no failure."""
        self.failure.reason = 0


class _Output(ctypes.Structure):
    _fields_ = (
        ("times", ctypes.c_void_p),
        ("points", ctypes.c_void_p),
        ("count", ctypes.c_int64),
        ("written", ctypes.c_int64),
        ("rows", ctypes.c_void_p),
        ("states", ctypes.c_void_p),
        ("counted", ctypes.c_bool),
    )


class Rows:
    """Rows that are asked for: `times` and `points` (count,), into `values` (count or more, size).

    `states` (count, n) are those of the rows; the first `written` rows are there. `where` is told of them, if they are
    rows of the run.
    """

    def __init__(
        self, times: Floats, points: NDArray[np.int64], values: Floats, n_states: int, where: Where | None = None
    ) -> None:
        self.times, self.points, self.values, self.where = times, points, values, where
        self.states = np.empty((len(times), n_states))
        self.written = 0

    @property
    def next(self) -> float:
        """The time of the first that is not there; inf if all are."""
        return float(self.times[self.written]) if self.written < len(self.times) else inf

    def take(self, take: Callable[[float, Floats], Floats]) -> None:
        """Take the next one: `take` writes the row of a time, and returns the state."""
        if self.where is not None:
            self.where.place.k = int(self.points[self.written])
        self.states[self.written] = take(self.next, self.values[self.written])
        self.written += 1
        if self.where is not None:
            self.where.place.rows += 1


def no_rows(n_states: int) -> Rows:
    """Return none."""
    return Rows(np.empty(0), np.empty(0, np.int64), np.empty((0, 0)), n_states)


class Walk:
    """Where a solution has come to: the last step, from `began` to `time`, and the state `x` at its end.

    `flow` gives derivatives and event indicators, `rows` rows of `row_size` values. A step is to be looked at where one
    of `looks` times in it, or of more that are no more than `apart`, an event indicator has another sign than in
    `indicators`, those at its begin; if `watched`, always. `end` is that of the run. `outside` brings what comes from
    outside to a time; `taken` counts, no more than `most_steps` from row to row.
    """

    def __init__(
        self,
        flow: Engine,
        rows: Engine,
        n_states: int,
        row_size: int,
        *,
        relative: float,
        longest: float,
        instant: float,
        indicators: Floats,
        looks: int,
        apart: float,
        taken: Taken,
        end: float,
        most_steps: int,
        watched: bool = False,
        outside: Callable[[float], None] | None = None,
    ) -> None:
        self._flow, self._rows, self._outside = flow, rows, outside
        self._library = library()
        assert self._library.adcs_walk_size() == ctypes.sizeof(_Walk), "walk.c and its mirror in Python differ"
        self.tolerances = np.ones(n_states)
        self._at_origin = np.zeros(n_states)
        self.x, self._before, self._trial = np.zeros(n_states), np.zeros(n_states), np.zeros(n_states)
        self._stages, self._extension = np.zeros((_EXTENDED, n_states)), np.zeros((_DEGREE, n_states))
        self._uncertain = np.zeros(n_states)
        self._indicators, self._look = indicators, np.zeros_like(indicators)
        self._raw = _Walk(
            flow=ctypes.addressof(flow.raw),
            rows=ctypes.addressof(rows.raw),
            outside=_OUTSIDE() if outside is None else _OUTSIDE(self._bring),
            n=n_states,
            row_size=row_size,
            tolerances=self.tolerances.ctypes.data,
            relative=relative,
            longest=longest,
            instant=instant,
            looks=looks,
            apart=apart,
            n_indicators=len(indicators),
            watched=watched,
            most_steps=most_steps,
            at_origin=self._at_origin.ctypes.data,
            end=end,
            before=self._before.ctypes.data,
            x=self.x.ctypes.data,
            trial=self._trial.ctypes.data,
            stages=self._stages.ctypes.data,
            extension=self._extension.ctypes.data,
            uncertain=self._uncertain.ctypes.data,
            indicators=indicators.ctypes.data,
            look=self._look.ctypes.data,
            taken=ctypes.pointer(taken),
        )
        self._reference = ctypes.byref(self._raw)

    @property
    def began(self) -> float:
        """Where the last step began [s]."""
        return float(self._raw.began)

    @property
    def time(self) -> float:
        """Where it has come to [s]."""
        return float(self._raw.time)

    def settle(self) -> None:
        """Bring no component to a time before the present one any more."""
        self._raw.floor = self._raw.time

    @property
    def origin(self) -> tuple[float, Floats, float]:
        """Time, state and length [s] with which `restart` makes the last steps again, and goes on as a longer run."""
        return self._raw.origin, self._at_origin, self._raw.tried

    def restart(self, t: float, x: Floats, length: float = 0.0) -> None:
        """Go on from (t, x) with a step of this length (s); 0: one that is to be found."""
        self.x[:] = self._before[:] = x
        self._raw.began = self._raw.time = self._raw.floor = t
        self._raw.started = self._raw.extended = False
        self._raw.length = self._raw.tried = length
        self._raw.origin, self._raw.cut = t, False
        self._at_origin[:] = x

    def go(self, until: float, bound: float, rows: Rows) -> Outcome:
        """Go on to `until`, or until all rows are written, or there is something to be looked at in the last step.

        No step leads beyond `bound`.
        """
        first = rows.written
        output = _Output(
            times=rows.times[first:].ctypes.data,
            points=rows.points[first:].ctypes.data,
            count=len(rows.times) - first,
            rows=rows.values[first:].ctypes.data,
            states=rows.states[first:].ctypes.data,
            counted=rows.where is not None,
        )
        outcome = Outcome(self._library.adcs_walk(self._reference, until, bound, ctypes.byref(output)))
        rows.written += output.written
        if outcome in (Outcome.FAILED, Outcome.ROWS_FAILED):
            raise self._failed(self._rows if outcome == Outcome.ROWS_FAILED else self._flow)
        return outcome

    def between(self, t: float) -> Floats:
        """Return the state at a time within the last step, from the continuous extension."""
        x = np.empty(len(self.x))
        if not self._library.adcs_between(self._reference, t, x.ctypes.data):
            raise self._failed(self._flow)
        return x

    def shorter(self, t: float, other: Walk) -> Floats:
        """Let another walk be where this one would be, had its last step ended at t, and return its state."""
        if not self._library.adcs_shorter(self._reference, other._reference, t):
            raise other._failed(self._flow)
        return other.x

    def right_hand_side(self, values: Any) -> tuple[int, RightHandSide]:
        """Return the address of the right-hand side for CVODE, and its user data, which has to be kept.

        `values` is the function that returns the elements of one of its vectors.
        """
        address = ctypes.cast(self._library.adcs_right_hand_side, ctypes.c_void_p).value
        assert address is not None
        return address, RightHandSide(ctypes.addressof(self._raw), ctypes.cast(values, ctypes.c_void_p))

    def failed(self, given: RightHandSide) -> CallFailed | None:
        """Return the last failure of the right-hand side that is noted, or raise what a callback raised."""
        if not given.failure.reason:
            return None
        self._flow.raw.failure, self._raw.asked = given.failure, given.failed_at
        return self._failed(self._flow)

    def _bring(self, time: float) -> int:
        try:
            assert self._outside is not None
            self._outside(time)
        except BaseException as error:  # cannot pass through C
            self._flow.raised = self._rows.raised = error
            return 1
        return 0

    def _failed(self, engine: Engine) -> CallFailed:
        failed = engine.failed()
        if failed.time is None:
            failed.time = float(self._raw.asked)
        return failed
