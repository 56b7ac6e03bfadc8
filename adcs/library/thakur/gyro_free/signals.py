"""What Sec. 4.3 looks at, from a recorded run, and how it is drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adcs.library import attitude
from adcs.library.thakur.gyro_free.settings import Q_RN
from orchestration.results.error_angles import turned_by
from orchestration.results.plots import Guide, Panel, Series, components, told_apart
from orchestration.results.result import Result

Array = NDArray[np.float64]

_TINY = 1e-9  # s, against rounding of the time grid
ANGLE = "rotation angle"
RATE = "angular velocity"
TORQUE = "control torque"
MEASURES = (ANGLE, RATE, TORQUE)
SYMBOLS = {ANGLE: "φ [deg]", RATE: "‖ω‖ [rad/s]", TORQUE: "‖u‖ [N·m]"}


@dataclass(frozen=True)
class Motion:
    """Truth and command over time: `values` maps the names above to norms (N,), the angle in degrees.

    `vectors` has omega_BN_B [rad/s] and torque_B [N.m], and z of the filter where there is one, each (N, 3).
    """

    time: Array
    values: Mapping[str, Array]
    vectors: Mapping[str, Array]

    def since(self, start: float) -> Motion:
        """The part from `start` [s] on."""
        return self._part(self.time >= start - _TINY)

    def until(self, end: float) -> Motion:
        """The part up to `end` [s]."""
        return self._part(self.time <= end + _TINY)

    def every(self, stride: int) -> Motion:
        """Each `stride`-th sample."""
        return self._part(slice(None, None, stride))

    def peak(self, name: str) -> float:
        """Largest value."""
        return float(self.values[name].max())

    def rms(self, name: str) -> float:
        """Root mean square over time."""
        return attitude.rms(self.values[name])

    def area(self, name: str) -> float:
        """Integral over time."""
        return float(np.trapezoid(self.values[name], self.time))

    def settling_time(self, name: str, part: float) -> float:
        """Time from which on it stays below `part` of its peak [s]; NaN if it does not."""
        return attitude.settling_time(self.time, self.values[name], part * self.peak(name))

    def _part(self, kept: Any) -> Motion:
        values = {name: value[kept] for name, value in self.values.items()}
        vectors = {name: vector[kept] for name, vector in self.vectors.items()}
        return Motion(self.time[kept], values, vectors)


def motion(result: Result) -> Motion:
    """The run of `gyro-free` or `gyro-free-full-state`."""
    q_BR = attitude.relative_quaternion(result["plant.q_BN"], Q_RN)
    # cos(phi) = (tr E - 1)/2 of the text, without its loss of digits near zero
    angle = np.degrees(turned_by(q_BR))
    vectors = {RATE: result["plant.omega_BN_B"], TORQUE: result["controller.torque_B"]}
    values = {ANGLE: angle, **{name: attitude.norm(vector) for name, vector in vectors.items()}}
    if "controller.z" in result.names:
        vectors["z"] = result["controller.z"]
    return Motion(result.time, values, vectors)


def panel(
    name: str,
    runs: Mapping[str, Motion],
    title: str = "",
    group: str = "",
    *,
    log: bool = False,
    guides: Sequence[Guide] = (),
    note: str = "",
    faint: bool = False,
) -> Panel:
    """A measure over time, a curve for each run."""
    series = [Series(label, run.time, run.values[name], faint=faint) for label, run in runs.items()]
    return Panel(title or name.capitalize(), SYMBOLS[name], series, log, note, guides=guides, group=group)


def vector_panel(name: str, label: str, runs: Mapping[str, Motion], title: str, group: str = "") -> Panel:
    """The components of a vector, the runs told apart by the dashes."""
    series = [
        curve
        for run_label, run, dash in told_apart(runs)
        for curve in components(run_label, run.time, run.vectors[name], dash)
    ]
    return Panel(title, label, series, group=group)
