"""The solution of coupled Model Exchange, from event to event."""

from __future__ import annotations

from collections import deque

import numpy as np

from orchestration.coupled.crossing import first_crossing
from orchestration.coupled.integrators import Integrator, SolverName, integrator
from orchestration.coupled.model import CoupledModel
from orchestration.instances.instance import CallFailed, failing_at
from orchestration.plan.lowering import Floats
from orchestration.system import Value

_LOOKS = 5  # into each step, for indicators that leave their domain and come back
_CHATTER = 100  # events in what counts as one instant
_MOST_EVENTS = 100_000  # between two rows
_ASKED = "events asked for after integrator steps"


class Solution:
    """The solution from the start on, as far as it has been reached: `time` and `x`.

    Times that differ by at most `instant` (s) are the same for events and for what is asked for.
    """

    def __init__(
        self,
        model: CoupledModel,
        start: float,
        instant: float,
        solver: SolverName = "DOP853",
        rtol: float = 1e-10,
        atol: float = 1e-12,
    ) -> None:
        self._model = model
        self._instant = instant
        self.stopped = False
        """Set from another thread: KeyboardInterrupt before the next step of the integrator."""
        self._events: deque[float] = deque(maxlen=_CHATTER)
        self._integrator: Integrator = integrator(model, solver, rtol, atol)
        self._z: Floats = np.empty(0)  # event indicators at the last event or accepted step
        self._restart(start, model.x0)

    @property
    def time(self) -> float:
        """Where it has come to (s)."""
        return self._integrator.time

    @property
    def x(self) -> Floats:
        """The state there, (n,)."""
        return self._integrator.x

    def reach(self, point: float) -> None:
        """Go on to a time, and through all events that happen there; not beyond the end that a component asks for."""
        looked, events, start = False, 0, self.time
        while self._model.ended is None:
            due = self._model.next_event
            if due <= point + self._instant:
                target = due
            elif self.time < point - self._instant:
                target = point
            elif not looked and self._imminent():
                target = min(self.time + self._instant, due)
            else:
                break
            looked = point - self._instant <= self.time
            cause = self._advance(target)
            if cause is None and self.time >= due:
                cause = self._model.next_event_of, "time events"
            if cause is not None and self._model.ended is None:
                changed = self._event(*cause)
                looked, events = looked and not changed, events + changed
                if changed and events == _MOST_EVENTS:
                    needed = events * (point - start) / max(self.time - start, np.spacing(abs(point)))
                    failed = CallFailed(
                        cause[0],
                        f"{events} events lead from t = {start:.9g} only to {self.time:.9g} s, {needed:.2g} would be "
                        f"needed up to {point:.9g} s: choose a shorter time between rows",
                    )
                    failed.time = self.time
                    raise failed
        if self._model.ended is None and self.time < point:  # by an instant, over which a straight line is exact
            self._restart(point, self.x + (point - self.time) * self._model.rhs(self.time, self.x))

    def change(self, name: str, value: Value) -> None:
        """Set an unconnected input or a tunable parameter where it has come to, as an event."""
        self._restart(self.time, self._model.event(self.time, self.x, [(name, value)]))

    def _advance(self, target: float) -> tuple[str, str] | None:
        """Integrate to the target, or to the first event; return whose it is and what it is."""
        while self.time < target:
            if self.stopped:
                raise KeyboardInterrupt
            before = self.time
            self._integrator.step(target)
            crossed = self._crossing(before) if self._model.has_state_events else None
            asking = self._model.completed_step(self.time, self.x)
            if self._model.ended is not None:
                return None
            if crossed is not None:
                return crossed
            if asking is not None:
                return asking, _ASKED
        return None

    def _crossing(self, before: float) -> tuple[str, str] | None:
        """Find the first crossing of an event indicator in the last step, and go back to it."""
        walk = self._integrator
        positive = self._z > 0

        def crossed(z: Floats) -> bool:
            return bool(np.any((z > 0) != positive))

        def accurate(t: float) -> Floats:
            return self._model.indicators(t, walk.at(t))

        end = self.time
        for t in np.linspace(before, end, _LOOKS + 1)[1:].tolist():
            z = self._model.indicators(t, walk.sketch(t))
            if not crossed(z):
                continue
            if t != end:  # the sketch may be on the wrong side of zero
                z = accurate(t)
            if crossed(z):
                found = first_crossing(accurate, before, self._z, t, z)
                x = walk.at(found)
                z = self._model.indicators(found, x)
                which = int(np.flatnonzero((z > 0) != positive)[0])
                if found < end:
                    walk.restart(found, x)
                return self._model.indicator(which)
        self._z = z
        return None

    def _imminent(self) -> bool:
        """Whether a state event happens within the next instant."""
        if not self._model.has_state_events or self.time + self._instant <= self.time:
            return False
        ahead = self.x + self._instant * self._model.rhs(self.time, self.x)
        z = self._model.indicators(self.time + self._instant, ahead)
        return bool(np.any((z > 0) != (self._z > 0)))

    def _event(self, component: str, kind: str) -> bool:
        """Handle an event; return whether it counts.

        One that was asked for after an integrator step, as some FMUs do after each, and changes neither states nor
        derivatives does not: the integration goes on as without it, which a restart each time would hold up.
        """
        time, x, model = self.time, self.x.copy(), self._model
        before = model.rhs(time, x).copy() if kind == _ASKED else None
        after = model.event(time, x)
        stays = before is not None and model.ended is None and np.array_equal(after, x)
        if before is not None and stays and np.array_equal(model.rhs(time, after), before):
            if model.has_state_events:
                self._z = model.indicators(time, after)
            return False
        self._restart(time, after)
        span = time - self._events[0] if len(self._events) == _CHATTER else np.inf
        if span <= max(self._instant, 1e3 * float(np.spacing(abs(time)))):
            with failing_at(time):
                raise CallFailed(
                    component,
                    f"it chatters: {_CHATTER} events within {span:.1e} s, the last by {kind}; give the model a "
                    "hysteresis or a state of rest, or use the method 'co-simulation'",
                )
        self._events.append(time)
        return True

    def _restart(self, time: float, x: Floats) -> None:
        self._integrator.restart(time, x)
        if self._model.has_state_events:
            self._z = self._model.indicators(time, x)
