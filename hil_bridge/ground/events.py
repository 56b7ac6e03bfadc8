"""What happens in a run, told in words: target acquired or lost, a wheel at its limit, values that are no numbers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from hil_bridge.ground.state import State


@dataclass(frozen=True)
class Event:
    """A text and how serious it is (MAV_SEVERITY)."""

    text: str
    severity: int = mavlink.MAV_SEVERITY_INFO


@dataclass(frozen=True)
class Limits:
    """When something is worth a word: angles in rad, rates in rad/s; `saturated` by the name of a value's role."""

    acquired: float = 0.0035  # 0.2 deg
    lost: float = 0.035
    saturated: float | None = None


class Watch:
    """Sees the states of a run one after the other, and says what is new."""

    def __init__(self, limits: Limits | None = None) -> None:
        self._limits = limits or Limits()
        self._acquired = False
        self._ill: set[str] = set()
        self._saturated: set[int] = set()

    def seen(self, state: State) -> Iterator[Event]:
        """Yield what is new in a state."""
        for key in state.scene.columns:
            if key not in self._ill and not np.isfinite(state.values[key]).all():
                self._ill.add(key)
                yield Event(f"{key} is not a number from t = {state.t:g} s", mavlink.MAV_SEVERITY_CRITICAL)
        error = state.attitude_error
        if error is not None:
            if not self._acquired and error < self._limits.acquired:
                self._acquired = True
                yield Event(f"Target acquired at t = {state.t:.6g} s, error {degrees(error):.3f} deg")
            elif self._acquired and error > self._limits.lost:
                self._acquired = False
                yield Event(
                    f"Target lost at t = {state.t:.6g} s, error {degrees(error):.2f} deg", mavlink.MAV_SEVERITY_WARNING
                )
        yield from self._wheels(state)

    def _wheels(self, state: State) -> Iterator[Event]:
        limit = self._limits.saturated
        speeds = state.vector("wheel_speed")
        if limit is None or speeds is None:
            return
        for i, speed in enumerate(speeds):
            if abs(speed) >= limit and i not in self._saturated:
                self._saturated.add(i)
                yield Event(f"Wheel {i + 1} saturated at t = {state.t:.6g} s", mavlink.MAV_SEVERITY_WARNING)
            elif abs(speed) < 0.95 * limit:
                self._saturated.discard(i)
