"""The communication points of a run. Time is an index: t_k = start + k*step is computed, never accumulated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import floor, isfinite, ulp

import numpy as np
from numpy.typing import NDArray

from fmus.errors import AdcsError

_MOST_STEPS = 2**53  # beyond, not every index is a double

SNAP = 1e-9
"""Of a step: times that differ by less are the same."""


@dataclass(frozen=True)
class Grid:
    """The points t_k for k = 0 .. steps, in s; the last is `stop`, if that is given: its step is shorter."""

    start: float
    step: float
    steps: int
    stop: float | None = None

    @classmethod
    def make(cls, start: float, stop: float, step: float, rigid: Callable[[], str | None] = lambda: "") -> Grid:
        """Check the three times. Where stop is no whole number of steps after start, the last step is shorter.

        `rigid` is asked why that may not be, for the refusal; it returns None if it may.
        """
        for name, value in (("start_time", start), ("stop_time", stop), ("step", step)):
            if not isfinite(value):
                raise AdcsError(f"{name} = {value} s is not finite")
        if step <= 0:
            raise AdcsError(f"step = {step} s: expected a positive time")
        if stop < start:
            raise AdcsError(f"stop_time = {stop} s lies before start_time = {start} s")
        if start + step == start or stop - step == stop:
            raise AdcsError(f"step = {step} s is below the resolution of time at {max(abs(start), abs(stop))} s")
        ratio = (stop - start) / step
        if not ratio < _MOST_STEPS:
            raise AdcsError(
                f"{start} to {stop} s in steps of {step} s are {ratio:.3g} steps, more than 2^53 can be counted: use a "
                f"step of {(stop - start) / 1e9:.3g} s, which makes 1e9, or more"
            )
        grid = cls(float(start), float(step), round(ratio))
        if abs(ratio - grid.steps) <= grid._tolerance(ratio):
            return grid
        below = floor(ratio)
        obstacle = rigid()
        if obstacle is not None:
            raise AdcsError(
                f"stop_time = {stop} s is not a whole number of steps of {step} s after start_time = {start} s"
                f"{obstacle}: use {grid.time(below):.15g} or {grid.time(below + 1):.15g} s"
            )
        return cls(grid.start, grid.step, below + 1, float(stop))

    @property
    def full(self) -> int:
        """Number of steps of full length."""
        return self.steps if self.stop is None else self.steps - 1

    @property
    def shorter(self) -> float:
        """Length of a last step that is shorter than the others [s]; 0 if there is none."""
        return 0.0 if self.stop is None else self.stop - (self.start + self.full * self.step)

    def time(self, k: int) -> float:
        """t_k."""
        return self.stop if self.stop is not None and k == self.steps else self.start + k * self.step

    def index(self, time: float, what: str) -> int:
        """Return k of a communication point; refuse a time before, after or between them."""
        ratio, end = (time - self.start) / self.step, self.time(self.steps)
        tolerance = self._tolerance(ratio)
        if not -tolerance <= ratio <= (end - self.start) / self.step + tolerance:
            raise AdcsError(f"{what} at {time:g} s lies outside the run, {self.start:g} to {end:g} s")
        k = round(ratio)
        if k <= self.full and abs(ratio - k) <= tolerance:
            return k
        if self.stop is not None and abs(time - end) <= tolerance * self.step:
            return self.steps
        before = floor(ratio)
        raise AdcsError(
            f"{what} at {time:.12g} s lies between two communication points: use {self.time(before):.12g} or "
            f"{self.time(before + 1):.12g} s"
        )

    @property
    def bound(self) -> float:
        """A time that no component reaches: what a component is told as stop time.

        t_k + step is not always t_(k+1), and a component that adds up steps is off by a rounding for each of them: it
        must not find that the last one leads beyond the stop time. Smaller steps inside a step add up, too: for them a
        millionth of a step is left.
        """
        end = self.time(self.steps)
        return end + 1e-6 * self.step + (self.steps + 3) * ulp(max(abs(self.start), abs(end)))

    @property
    def times(self) -> NDArray[np.float64]:
        """All points, (steps+1,)."""
        return self.rows(0, 1)

    def count(self, first: int, every: int) -> int:
        """How many rows there are from point `first` on: of every `every`-th point, and of a shorter last step."""
        return self.full // every - -(-first // every) + 1 + (self.stop is not None)

    def capacity(self, first: int, every: int) -> int:
        """How many rows there may be at most: with one for an end between the last of these points and that of all."""
        return self.count(first, every) + (every > 1)

    def rows(self, first: int, every: int, most: int = _MOST_STEPS) -> NDArray[np.float64]:
        """The times of these rows, or of the first of them."""
        begin = -(-first // every) * every
        try:
            last = min(self.full + 1, begin + most * every)
            times: NDArray[np.float64] = np.arange(begin, last, every, dtype=np.float64)
        except (MemoryError, ValueError):  # of what can be addressed
            raise AdcsError(
                f"{(self.full - begin) // every + 1} rows do not fit into memory: record not every step, or take "
                "longer ones"
            ) from None
        self._make_times(times)
        return times if self.stop is None or len(times) == most else np.append(times, self.stop)

    def at(self, points: NDArray[np.int64]) -> NDArray[np.float64]:
        """The times of some points, as `time` gives them."""
        times = points.astype(np.float64)
        self._make_times(times)
        if self.stop is not None:
            times[points == self.steps] = self.stop
        return times

    def _make_times(self, points: NDArray[np.float64]) -> None:
        points *= self.step  # in place: of many rows, three arrays do not fit where one does
        points += self.start

    def places(self, first: int, every: int, most: int = _MOST_STEPS) -> NDArray[np.float64]:
        """The times of all rows that there may be, or of the first of them."""
        times = self.rows(first, every, most)
        return times if every == 1 or len(times) == most else np.append(times, self.time(self.steps))

    def _tolerance(self, ratio: float) -> float:
        """How far (in steps) a time may be off a point: what writing it in decimals costs, and resolution of time."""
        far = max(abs(self.start), abs(self.start + ratio * self.step))
        written = min(SNAP * max(abs(ratio), 1.0), 1e-3)
        return max(written, min(4 * ulp(far) / self.step, 0.25)) if isfinite(far) else SNAP


def whole_steps(time: float, step: float, what: str, *, none: bool = False) -> int:
    """Return how many steps a positive time is; AdcsError if it is no whole number of them.

    `what` names it there; `none` says whether it may as well be left out.
    """
    ratio = time / step
    steps = round(ratio) if isfinite(ratio) else 0
    if steps < 1 or abs(ratio - steps) > SNAP * ratio:
        below = floor(ratio) if isfinite(ratio) else 0
        less = f"{below * step:.12g} or " if below or none else ""
        raise AdcsError(
            f"{what}, {time:g} s, is not a whole number of exchange steps of {step:g} s: use {less}"
            f"{(below + 1) * step:.12g} s, or another step"
        )
    return steps
