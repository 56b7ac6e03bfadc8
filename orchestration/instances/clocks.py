"""When the clocks of an FMI 3.0 component tick: times are kept as index and interval, so that nothing adds up."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import c_double, c_int, c_uint, c_uint64
from dataclasses import dataclass
from fractions import Fraction
from math import inf
from typing import Any

from orchestration.fmu.description import PERIODIC, Clock

_NOT_YET_KNOWN, _UNCHANGED, _CHANGED = range(3)  # fmi3IntervalQualifier

Interval = Fraction | float


@dataclass
class Timer:
    """The ticks of one time-based clock.

    A periodic one ticks at origin + shift + count * interval, another one at origin + interval, once; `interval` is
    None while it is not known when that is. `waiting` says that the tick is still to come.
    """

    clock: Clock
    origin: float
    shift: Interval = 0.0
    interval: Interval | None = None
    count: int = 0
    waiting: bool = True

    @property
    def next(self) -> float:
        """Time of the next tick, infinity while it is not known."""
        if self.interval is None or not self.waiting:
            return inf
        if self.clock.kind not in PERIODIC:
            return self.origin + float(self.interval)
        if isinstance(self.interval, Fraction) and isinstance(self.shift, Fraction):
            return self.origin + float(self.shift + self.count * self.interval)
        return self.origin + (float(self.shift) + self.count * float(self.interval))

    def tick(self, time: float) -> None:
        """Note that the clock has ticked."""
        if self.clock.kind in PERIODIC:
            self.count += 1
        else:
            self.origin, self.waiting = time, False


class Intervals:
    """Asks an FMU for the intervals of its clocks.

    `call(action, method, *arguments)` calls a method of fmpy's object; `failed(text)` puts a failure into words.
    """

    def __init__(self, call: Callable[..., Any], failed: Callable[[str], Exception]) -> None:
        self._call, self._failed = call, failed

    def begin(self, clock: Clock, start: float) -> Timer:
        """Return the timer of a clock in initialisation mode; tell the FMU the interval, if that is the importer's."""
        timer = Timer(clock, start, clock.shift, clock.interval)
        if clock.kind in PERIODIC and clock.interval is not None:
            self._check(timer)
            if clock.kind != "constant":
                self._set(clock)
            return timer
        timer.interval, _ = self._get(clock)
        if clock.kind in PERIODIC:
            timer.shift = self._shift(clock)
        self._check(timer)
        return timer

    def update(self, timer: Timer, time: float, *, ticked: bool) -> None:
        """Ask for a new interval in event mode, where the clock is of a kind that may have one."""
        clock = timer.clock
        if clock.kind in ("constant", "fixed") or (clock.kind == "tunable" and clock.interval is not None):
            return
        if clock.kind == "changing" and not ticked:
            return
        interval, changed = self._get(clock)
        if clock.kind == "tunable":
            if changed:  # from now on
                timer.origin, timer.shift, timer.interval, timer.count = time, 0.0, interval, 1
                self._check(timer)
        elif changed or (clock.kind == "changing" and interval is not None):
            timer.origin, timer.interval, timer.waiting = time, interval, True
            self._check(timer)

    def _check(self, timer: Timer) -> None:
        """Refuse an interval or shift with which a clock would never tick, tick without end, or ticked in the past."""
        clock, interval, shift = timer.clock, timer.interval, timer.shift
        if interval is None and clock.kind in PERIODIC:
            raise self._failed(f"clock {clock.name} has no interval, and a {clock.kind} clock needs one from the start")
        now = clock.kind not in PERIODIC  # may the first tick be, and another one in the same instant
        if interval is not None and not (0 < interval < inf or (now and interval == 0)):
            raise self._failed(f"the interval of clock {clock.name} is {_seconds(interval)}: expected a positive time")
        if not 0 <= shift < inf:
            raise self._failed(f"the shift of clock {clock.name} is {_seconds(shift)}: expected a time from 0")

    def _get(self, clock: Clock) -> tuple[Interval | None, bool]:
        """Return the interval, None where it is not yet known, and whether it is a new one."""
        qualifier = (c_int * 1)()
        action = f"asking for the interval of clock {clock.name}"
        interval: Interval
        if clock.fractional:
            counter, resolution = (c_uint64 * 1)(), (c_uint64 * 1)(1)
            self._call(action, "getIntervalFraction", _one(clock), counter, resolution, qualifier)
            interval = 0 if qualifier[0] == _NOT_YET_KNOWN else self._fraction(clock, "interval", counter, resolution)
        else:
            value = (c_double * 1)()
            self._call(action, "getIntervalDecimal", _one(clock), value, qualifier)
            interval = value[0]
        if qualifier[0] == _NOT_YET_KNOWN:
            return None, False
        return interval, qualifier[0] == _CHANGED

    def _shift(self, clock: Clock) -> Interval:
        action = f"asking for the shift of clock {clock.name}"
        if clock.fractional:
            counter, resolution = (c_uint64 * 1)(), (c_uint64 * 1)(1)
            self._call(action, "getShiftFraction", _one(clock), counter, resolution)
            return self._fraction(clock, "shift", counter, resolution)
        value = (c_double * 1)()
        self._call(action, "getShiftDecimal", _one(clock), value)
        return value[0]

    def _fraction(self, clock: Clock, what: str, counter: Any, resolution: Any) -> Fraction:
        if resolution[0] == 0:
            raise self._failed(f"the {what} of clock {clock.name} is {counter[0]}/0 s: expected a resolution from 1")
        return Fraction(counter[0], resolution[0])

    def _set(self, clock: Clock) -> None:
        action = f"setting the interval of clock {clock.name} to {float(clock.interval or 0.0):.9g} s"
        if clock.fractional and isinstance(clock.interval, Fraction):
            numerator, denominator = clock.interval.as_integer_ratio()
            self._call(
                action, "setIntervalFraction", _one(clock), (c_uint64 * 1)(numerator), (c_uint64 * 1)(denominator)
            )
        else:
            self._call(action, "setIntervalDecimal", _one(clock), (c_double * 1)(float(clock.interval or 0.0)))


def _seconds(time: Interval) -> str:
    return f"{time} s" if isinstance(time, float) else f"{float(time):.9g} s"


def _one(clock: Clock) -> Any:
    return (c_uint * 1)(clock.reference)
