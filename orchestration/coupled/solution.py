"""The solution of coupled Model Exchange, from event to event."""

from __future__ import annotations

from collections import deque
from math import inf
from typing import Any

import numpy as np

from orchestration.coupled.crossing import first_crossing
from orchestration.coupled.cvode import CVode
from orchestration.coupled.dop853 import Dop853
from orchestration.coupled.integrators import Integrator, SolverName, Terms
from orchestration.coupled.model import CoupledModel
from orchestration.engine.walk import Rows, no_rows
from orchestration.instances.instance import CallFailed, failing_at
from orchestration.plan.lowering import Floats
from orchestration.system import Value

LOOKS = 5  # into each step, for indicators that leave their domain and come back
_CHATTER = 100  # events in what counts as one instant
_MOST_EVENTS = 100_000  # between two rows
_ASKED = "events asked for after integrator steps"


class Solution:
    """The solution from the start on, as far as it has been reached: `time` and `x`.

    The integrator takes steps of its own length, mostly beyond what is asked for, and goes back where something is
    changed. Events are handled when something later is asked for, so that it never has to go back behind one. No step
    leads beyond `end`, or is longer than `longest`; state events are looked for at times at most `apart` from each
    other. Times that differ by at most `instant` are the same for events and for what is asked for. All in s.
    """

    def __init__(
        self,
        model: CoupledModel,
        start: float,
        instant: float,
        solver: SolverName,
        rtol: float,
        atol: float,
        *,
        end: float = inf,
        longest: float = inf,
        apart: float = inf,
    ) -> None:
        self._model = model
        self._events: deque[float] = deque(maxlen=_CHATTER)
        self._z: Floats = np.zeros(model.n_indicators)  # event indicators at the last event or accepted step
        self._terms = Terms(rtol, atol, longest, instant, end, LOOKS, apart, self._z)
        # without states there is nothing that CVODE could do
        kind = CVode if solver == "CVode" and model.state_names else Dop853
        self._integrator: Integrator = kind(model, self._terms)
        self._counted, self._last = 0, ""  # events, and whose the last was
        self._due: tuple[str, str] | None = None  # whose event is to be handled at the end of the last step, and why
        self._restart(start, model.x0)

    @property
    def time(self) -> float:
        """Where it has come to (s)."""
        return self._integrator.time

    @property
    def x(self) -> Floats:
        """The state there, (n,)."""
        return self._integrator.x

    @property
    def report(self) -> dict[str, Any]:
        """What it has taken, for the manifest."""
        return self._integrator.report

    def stop(self) -> None:
        """Let what goes on raise KeyboardInterrupt; to be called from another thread."""
        self._integrator.stop()

    def record(self, rows: Rows) -> None:
        """Write rows, each after all events of its instant; not beyond the end that a component asks for."""
        written, start, events = rows.written, self.time, 0
        while rows.next < inf and self._model.ended is None:
            if rows.next < self._integrator.covered:  # it lies in the last step
                self._integrator.go(self.time, self.time, rows)
                continue
            counted = self._counted
            if not self._go_on(rows):
                rows.take(self._take)
            events += self._counted - counted
            if rows.written > written:
                written, start, events = rows.written, rows.times[rows.written - 1], 0
            self._bound_events(events, start, rows.next)

    def reach(self, point: float) -> None:
        """Go on to a time, and through all events of its instant; not beyond the end that a component asks for."""
        none = no_rows(len(self.x))
        start, counted = self.time, self._counted
        while self._model.ended is None and not point < self._integrator.covered:
            if not self._go_on(none, point + 2 * self._terms.instant):
                break
            self._bound_events(self._counted - counted, start, point)
        if self._model.ended is None and point < self._integrator.covered:
            self._integrator.back(max(point, self._integrator.began))
            self._due, self._told = None, not self._model.watched
            self._look_anew()

    def change(self, name: str, value: Value) -> None:
        """Set an unconnected input or a tunable parameter where it has come to, as an event."""
        self._restart(self.time, self._model.event(self.time, self.x, [(name, value)]))

    def _go_on(self, rows: Rows, until: float = inf) -> bool:
        """Handle the event at the end of the last step, or make more steps; return False at the end.

        Rows are taken on the way. From the last step none is taken any more.
        """
        model, time = self._model, self.time
        if not self._told:
            self._told = True
            asking = model.completed_step(time, self.x)
            self._integrator.settle()
            if model.ended is not None:
                return True
            if asking is not None and self._due is None:
                self._due = asking, _ASKED
        if self._due is None and time >= model.next_event:
            self._due = model.next_event_of, "time events"
        if self._due is not None:
            due, self._due = self._due, None
            self._event(*due)
            return True
        bound = min(model.next_event, self._terms.end)
        if time >= bound:
            if not self._imminent():
                return False
            bound = min(time + self._terms.instant, model.next_event)
        if self._integrator.go(min(until, bound), bound, rows):
            self._due = self._crossing() if model.n_indicators else None
            self._told = not model.watched
        return True

    def _take(self, _: float, row: Floats) -> Floats:
        """Take a row where it has come to."""
        self._model.row(self.time, self.x, row)
        return self.x

    def _bound_events(self, events: int, start: float, target: float) -> None:
        """Refuse to go on for ever."""
        if events < _MOST_EVENTS:
            return
        needed = events * (target - start) / max(self.time - start, np.spacing(abs(target)))
        failed = CallFailed(
            self._last,
            f"{events} events lead from t = {start:.9g} only to {self.time:.9g} s, {needed:.2g} would be needed up to "
            f"{target:.9g} s: choose a shorter time between rows",
        )
        failed.time = self.time
        raise failed

    def _crossing(self) -> tuple[str, str] | None:
        """Find the first crossing of an event indicator in the last step, and go back to it."""
        walk = self._integrator
        positive = self._z > 0

        def crossed(z: Floats) -> bool:
            return bool(np.any((z > 0) != positive))

        def accurate(t: float) -> Floats:
            return self._model.indicators(t, walk.at(t))

        before, end = walk.began, self.time
        for t in np.linspace(before, end, self._terms.looks_into(end - before) + 1)[1:].tolist():
            z = self._model.indicators(t, walk.sketch(t))
            if not crossed(z):
                continue
            if t != end:  # the sketch may be on the wrong side of zero
                z = accurate(t)
            if crossed(z):
                found = first_crossing(accurate, before, self._z, t, z)
                z = self._model.indicators(found, walk.at(found))
                which = int(np.flatnonzero((z > 0) != positive)[0])
                walk.back(found)
                return self._model.indicator(which)
        self._z[:] = z
        return None

    def _imminent(self) -> bool:
        """Whether a state event happens within the next instant."""
        if not self._model.n_indicators or self.time + self._terms.instant <= self.time:
            return False
        ahead = self.x + self._terms.instant * self._model.rhs(self.time, self.x)
        z = self._model.indicators(self.time + self._terms.instant, ahead)
        return bool(np.any((z > 0) != (self._z > 0)))

    def _event(self, component: str, kind: str) -> None:
        """Handle an event.

        One that was asked for after an integrator step, as some FMUs do after each, and changes neither states nor
        derivatives does not count: the integration goes on as without it, which a restart each time would hold up.
        """
        time, x, model = self.time, self.x.copy(), self._model
        before = model.rhs(time, x).copy() if kind == _ASKED else None
        if model.n_indicators:  # some FMUs go by what they were asked for last, which may have been a row
            model.indicators(time, x)
        after = model.event(time, x)
        stays = before is not None and model.ended is None and np.array_equal(after, x)
        if before is not None and stays and np.array_equal(model.rhs(time, after), before):
            self._look_anew()
            return
        self._restart(time, after)
        span = time - self._events[0] if len(self._events) == _CHATTER else np.inf
        if span <= max(self._terms.instant, 1e3 * float(np.spacing(abs(time)))):
            with failing_at(time):
                raise CallFailed(
                    component,
                    f"it chatters: {_CHATTER} events within {span:.1e} s, the last by {kind}; give the model a "
                    "hysteresis or a state of rest, or use the method 'co-simulation'",
                )
        self._events.append(time)
        self._counted, self._last = self._counted + 1, component

    @property
    def origin(self) -> tuple[float, Floats, float]:
        """Time, state and length [s] with which `resume` makes the last steps again, and goes on as a longer run."""
        return self._integrator.origin

    def resume(self, time: float, x: Floats, length: float) -> None:
        """Go on from what `origin` gave."""
        self._restart(time, x, length)

    def _restart(self, time: float, x: Floats, length: float = 0.0) -> None:
        self._integrator.restart(time, x, length)
        self._told = True
        self._look_anew()

    def _look_anew(self) -> None:
        if self._model.n_indicators:
            self._z[:] = self._model.indicators(self.time, self.x)
