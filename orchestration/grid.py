"""The communication points of a run. Time is an index: t_k = start + k*step is computed, never accumulated."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, isfinite

import numpy as np
from numpy.typing import NDArray

from fmus.errors import AdcsError


@dataclass(frozen=True)
class Grid:
    """The points t_k for k = 0 .. steps, in s."""

    start: float
    step: float
    steps: int

    @classmethod
    def make(cls, start: float, stop: float, step: float) -> Grid:
        """Check the three times; stop must be a whole number of steps after start."""
        for name, value in (("start_time", start), ("stop_time", stop), ("step", step)):
            if not isfinite(value):
                raise AdcsError(f"{name} = {value} s is not finite")
        if step <= 0:
            raise AdcsError(f"step = {step} s: expected a positive time")
        if stop < start:
            raise AdcsError(f"stop_time = {stop} s lies before start_time = {start} s")
        ratio = (stop - start) / step
        steps = round(ratio)
        if abs(ratio - steps) > 1e-9 * max(ratio, 1.0):
            below = floor(ratio)
            raise AdcsError(
                f"stop_time = {stop} s is not a whole number of steps of {step} s after start_time = {start} s: "
                f"use {start + below * step:.12g} or {start + (below + 1) * step:.12g} s"
            )
        if start + step == start or stop - step == stop:
            raise AdcsError(f"step = {step} s is below the resolution of time at {max(abs(start), abs(stop))} s")
        return cls(float(start), float(step), steps)

    def time(self, k: int) -> float:
        """t_k."""
        return self.start + k * self.step

    def index(self, time: float, what: str) -> int:
        """Return k of a communication point; refuse a time before, after or between them."""
        ratio = (time - self.start) / self.step
        k = round(ratio) if isfinite(ratio) else -1
        if not 0 <= k <= self.steps:
            raise AdcsError(f"{what} at {time:g} s lies outside the run, {self.start:g} to {self.time(self.steps):g} s")
        if abs(ratio - k) > 1e-9 * max(ratio, 1.0):
            before = floor(ratio)
            raise AdcsError(
                f"{what} at {time:.12g} s lies between two communication points: use {self.time(before):.12g} or "
                f"{self.time(before + 1):.12g} s"
            )
        return k

    @property
    def times(self) -> NDArray[np.float64]:
        """All points, (steps+1,)."""
        return self.start + np.arange(self.steps + 1, dtype=np.float64) * self.step
