"""Keeping a run to the clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from time import perf_counter, sleep
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from orchestration import expected
from orchestration.grid import Grid
from orchestration.running.hook import Hook, Watched
from orchestration.running.outline import Outline
from orchestration.running.simulation import Simulation

_NAP = 60.0  # s; longer ones are more than some systems sleep
_MOST_KEPT = 200_000  # of how late points were


class Clock:
    """Keeps a run to real time, or `speed` times as fast: point k is not taken before its time.

    Deadlines are absolute, so lateness does not add up; what is late is counted.
    """

    def __init__(self, grid: Grid, speed: float = 1.0) -> None:
        if not (isfinite(speed) and speed > 0):
            raise AdcsError(f"speed = {speed}: expected a positive number, 1 for real time")
        self.speed = speed
        self._step = grid.step / speed
        if not isfinite(self._step):
            raise AdcsError(f"speed = {speed}: a step of {grid.step:g} s would last for ever")
        self._late: list[float] = []
        self._points, self._most, self._every = 0, 0.0, 1

    def start(self, k: int) -> None:
        """Let point k be now."""
        self._origin = perf_counter() - k * self._step

    def wait(self, k: int) -> int:
        """Wait for point k; return how many points are due."""
        deadline = self._origin + k * self._step
        while (early := deadline - perf_counter()) > 0:
            sleep(min(early, _NAP) if early > 2e-3 else 0)  # sleeping longer than asked is what makes late
        self._points, self._most = self._points + 1, max(self._most, -early)
        if self._points % self._every == 0:
            self._late.append(-early)
            if len(self._late) == _MOST_KEPT:  # of a long run every second one is kept, then every fourth ...
                self._late, self._every = self._late[1::2], 2 * self._every
        return 1

    def report(self) -> dict[str, Any]:
        """Speed and how late points were taken [s]."""
        late = np.array(self._late or [0.0])
        p50, p99 = np.percentile(late, [50, 99])
        return {
            "speed": self.speed,
            "points": self._points,
            "late_median_s": float(p50),
            "late_99_percent_s": float(p99),
            "late_most_s": self._most,
        }


class Pace(Hook):
    """The run keeps to real time, or is `speed` times as fast."""

    _repeatable = True
    exchanges = "it keeps to the clock"

    def __init__(self, speed: float = 1.0) -> None:
        self._speed = expected.number("pace: speed", speed)

    def for_manifest(self) -> Mapping[str, Any]:
        """Return what the manifest is to have of it."""
        return {"real_time": self._speed}

    @classmethod
    def of_manifest(cls, settings: dict[str, Any]) -> list[Hook]:
        """Take what `for_manifest` gave out of the settings of a manifest: a run is not repeated at its pace."""
        settings.pop("real_time", None)
        return []

    def prepare(self, outline: Outline) -> None:
        """Refuse a speed that is none."""
        self._clock = Clock(outline.grid, self._speed)

    def begin(self, simulation: Simulation, hooks: Sequence[Hook], watched: Watched) -> None:
        """Let the present point be now."""
        if sum(isinstance(hook, Pace) for hook in hooks) > 1:
            raise AdcsError("pace: a run has one, leave the others out")
        self._clock.start(simulation.k)

    def ahead(self, k: int) -> int:
        """Wait for point k, and take no other with it."""
        return self._clock.wait(k)

    def report(self) -> Mapping[str, Any]:
        """Return how late points were taken."""
        return {"real_time": self._clock.report()}


pace = Pace
