"""Communication steps of FMUs that do not simply take them: asynchronous, discarding, returning early, with events."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from contextlib import suppress
from ctypes import byref, c_bool, c_double, c_void_p
from math import inf, nextafter
from typing import TYPE_CHECKING

from fmpy.fmi1 import FMICallException

from orchestration.grid import SNAP
from orchestration.instances.events import Events

if TYPE_CHECKING:
    from orchestration.instances.instance import Instance

DISCARD, FATAL, PENDING = 2, 4, 5
_DO_STEP_STATUS = 0  # fmi2DoStepStatus
_MAX_HALVINGS = 12
_MAX_STANDING = 100  # returns in a row that do not get on
_MAX_PIECES = 1_000_000  # of one communication step
_PATIENCE = 2e-4  # s, between two looks at an asynchronous step


class _Discarded(Exception):
    """The FMU did not take the step."""


class Stepper:
    """Takes the communication steps of one instance."""

    def __init__(self, instance: Instance, events: Events | None) -> None:
        self._instance = instance
        self._handle = instance.handle
        self._events = events
        self._saves = instance.saves_for_retries
        self._retries = self._saves or instance.may_discard
        self._discarded, self._warning = 0, ""
        self._before = c_void_p()  # the state that a discarded step returns to; its memory is used again
        self._bind()

    def _bind(self) -> None:
        """Bind the two calls that every step makes: through fmpy's methods they would take several times as long."""
        functions = getattr(self._handle, "_functions")  # noqa: B009 - what fmpy loaded
        component, final = self._handle.component, int(self._instance.never_returns)
        if self._instance.major == 2:
            do_step, get_state = functions["fmi2DoStep"], functions["fmi2GetFMUstate"]
            self._call: Callable[[float, float], int] = lambda t, h: do_step(component, t, h, final)
        else:
            do_step, get_state = functions["fmi3DoStep"], functions["fmi3GetFMUState"]
            self._event, self._terminate, self._early, self._last = c_bool(), c_bool(), c_bool(), c_double()
            results = [byref(r) for r in (self._event, self._terminate, self._early, self._last)]

            def call(t: float, h: float) -> int:
                self._last.value = t + h  # which not all FMUs set
                return int(do_step(component, t, h, final, *results))

            self._call = call
        before = byref(self._before)
        self._get_state: Callable[[], int] = lambda: get_state(component, before)

    def step(self, time: float, step: float, *, discarded: bool = False) -> None:
        """Step from a communication point to the next, through whatever happens in between.

        `discarded` says that the whole step was tried before, and discarded.
        """
        end, resolution = time + step, SNAP * step
        if self._events is not None:
            self._events.depart(time, resolution)
            end = self._event_at(end, resolution)
        now, standing, pieces = time, 0, 0
        while True:
            target = self._target(now, end, resolution)
            length = step if (now, target) == (time, time + step) else _step(now, target)
            event, early, last = self._halves(now, length) if discarded else self._take(now, length)
            discarded = False
            reached = self._reached(now, target, resolution, last) if early else target
            standing, pieces = standing + 1 if reached <= now else 0, pieces + 1
            if standing == _MAX_STANDING:
                raise self._instance.wrong(
                    f"doStep does not get beyond t = {now:.9g} s: it returned early {standing} times"
                )
            now = reached
            if end - now <= resolution:
                break
            if self._instance.wants_end:
                raise self._instance.ended(now)
            if pieces == _MAX_PIECES:
                raise self._instance.wrong(
                    f"{pieces} events, ticks or early returns bring it from t = {time:.9g} only to {now:.9g} s, and "
                    f"{pieces * step / max(now - time, 1e-300):.3g} would be needed for a communication step: take "
                    "smaller ones"
                )
            if self._events is not None:
                self._events.inside(now, resolution, needed=event)
        if self._events is not None and not self._instance.wants_end:
            self._events.arrive(end, resolution, needed=event)

    def _event_at(self, end: float, resolution: float) -> float:
        """Return the end of a step, moved by roundings to a time event there, which the FMU would not find due else."""
        assert self._events is not None
        at_end = end < self._events.next_event <= end + resolution and self._instance.can_vary_step
        return self._events.next_event if at_end else end

    def _reached(self, now: float, target: float, resolution: float, last: float) -> float:
        """Return the time at which a step has returned early; refuse one outside of the step."""
        if not now - resolution <= last <= target + resolution:
            raise self._instance.returned_outside(last, now, target)
        return min(max(last, now), target)

    def _target(self, now: float, end: float, resolution: float) -> float:
        """Return where the next step ends: at the first tick or time event, if it comes before the end."""
        if self._events is None:
            return end
        due = self._events.next_time()
        if due >= end - resolution:
            return end
        if not self._instance.can_vary_step:
            raise self._instance.wrong(
                f"{self._events.next_name()} is due at t = {due:.9g} s, inside a communication step, and the FMU "
                "cannot take steps of different sizes: choose a step that ends there"
            )
        return max(due, now + resolution)  # beyond a time event that is closer than that

    def _take(self, time: float, step: float, halvings: int = 0) -> tuple[bool, bool, float]:
        """Return whether there was an event, whether the FMU returned early, and the time it reached."""
        if self._saves:
            self._save(time)
        try:
            return self._do_step(time, step)
        except _Discarded:
            return self._halves(time, step, halvings)

    def _halves(self, time: float, step: float, halvings: int = 0) -> tuple[bool, bool, float]:
        """Take a step that was discarded in two.

        FMI 3.0 promises that it has left the FMU as it was before; with FMI 2.0 that is restored.
        """
        if halvings == _MAX_HALVINGS:
            raise self._instance.failure("doStep", DISCARD, f", even in steps of {step:.3g} s")
        if halvings == 0:
            self._warn(time)
        if self._saves:
            self._instance.call("restoring a state", "setFMUState", self._before)
        half = step / 2
        event, early, last = self._take(time, half, halvings + 1)
        if event or early or self._instance.wants_end:
            return event, True, last if early else time + half
        return self._take(time + half, step - half, halvings + 1)

    def _warn(self, time: float) -> None:
        """Keep one warning that says how often a step was discarded."""
        self._discarded += 1
        if self._discarded == 1:
            self._warning = f"doStep discarded the step from t = {time:.9g} s, it was taken in smaller ones"
            self._instance.warn(self._warning)
        else:
            last, self._warning = self._warning, self._warning.partition(", it was")[0]
            self._warning += f", it was taken in smaller ones; so were {self._discarded - 1} later ones"
            self._instance.warn(self._warning, instead_of=last)

    def _do_step(self, time: float, step: float) -> tuple[bool, bool, float]:
        instance = self._instance
        with instance.calling("doStep"):
            status = self._call(time, step)
        if status == PENDING and instance.asynchronous:
            status = self._wait()
        if status == DISCARD and instance.ends_with_discarded(time, step):
            return False, False, time + step
        if status == DISCARD and self._retries and not instance.terminated:  # else it wants to end before
            raise _Discarded
        if status not in (0, 1):
            raise instance.failure("doStep", status)
        if instance.major == 2:
            return False, False, time + step
        if self._terminate.value:
            instance.end_at(time, step, early=self._early.value, last=self._last.value)
        return self._event.value, self._early.value, self._last.value

    def _wait(self) -> int:
        """Wait for the end of an asynchronous step of FMI 2; return how it ended."""
        pause = _PATIENCE
        while (
            status := self._instance.call("asking for the status of doStep", "getStatus", _DO_STEP_STATUS)
        ) == PENDING:
            clock.sleep(pause)
            pause = min(1.5 * pause, 0.05)
        return int(status)

    def _save(self, time: float) -> None:
        """Save the state that a discarded step returns to; do without if the FMU cannot, though it says so."""
        with self._instance.calling("saving the state"):
            status = self._get_state()
        if status in (0, 1):
            return
        failed = self._instance.failure("saving the state", status)
        if status == FATAL:
            raise failed
        self._saves = self._retries = False
        self._instance.warn(
            f"{failed.text} (at t = {time:.9g} s); a step that it discards is not taken in smaller ones"
        )

    def close(self) -> None:
        """Give back the memory of the saved state."""
        if self._before:
            with self._instance.calling("freeing a state"), suppress(FMICallException):
                self._handle.freeFMUState(self._before)


def _step(now: float, target: float) -> float:
    """Return a step that does not end before the target: an FMU that adds it up has to see its time event come."""
    step = target - now
    return step if now + step >= target else nextafter(step, inf)
