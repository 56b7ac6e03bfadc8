"""The errors of Sec. 5.4 from a recorded run, and how they are drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adcs.library import attitude
from adcs.library.thakur.observer.settings import PD_GAINS
from orchestration.results.plots import Guide, Panel, Series, components, told_apart
from orchestration.results.result import Result

Array = NDArray[np.float64]

_TINY = 1e-9  # s, against rounding of the time grid
ATTITUDE = "attitude tracking error"
RATE = "rate tracking error"
ATTITUDE_ESTIMATE = "attitude estimation error"
RATE_ESTIMATE = "rate estimation error"
TORQUE = "control torque"
FEEDBACK = "feedback torque"
ERRORS = (ATTITUDE, RATE, ATTITUDE_ESTIMATE, RATE_ESTIMATE)
SYMBOLS = {
    ATTITUDE: ("q_BR,v", ""),
    RATE: ("ω_BR", " [rad/s]"),
    ATTITUDE_ESTIMATE: ("q_BE,v", ""),
    RATE_ESTIMATE: ("ω - ω̂", " [rad/s]"),
    TORQUE: ("u", " [N·m]"),
    FEEDBACK: ("k_p q_v + k_v ω_e", " [N·m]"),
}


@dataclass(frozen=True)
class Signals:
    """Errors with respect to the truth, also where controller and observer see only a measurement.

    `vectors` maps the names above to arrays (N, 3): vector part of q_BR; omega_BR_B [rad/s]; vector part of q_BE;
    omega_BN_B - C(q_BE) omega_EN_E [rad/s]; torque_B, and its part -k_p q_BR,v - k_v omega_BR_B [N.m]. Those of the
    observer are there only if it is.
    """

    time: Array
    vectors: Mapping[str, Array]

    def norm(self, name: str) -> Array:
        """Euclidean norm over time, (N,)."""
        return attitude.norm(self.vectors[name])

    def peak(self, name: str) -> float:
        """Largest norm."""
        return float(self.norm(name).max())

    def settling_time(self, name: str, part: float) -> float:
        """Time from which on the norm stays below `part` of its peak [s]; NaN if it does not."""
        return attitude.settling_time(self.time, self.norm(name), part * self.peak(name))

    def area(self, name: str) -> float:
        """Integral of the norm over time."""
        return float(np.trapezoid(self.norm(name), self.time))

    def oscillation(self, name: str) -> float:
        """Total variation: how far the three components travel up and down, summed."""
        return float(np.abs(np.diff(self.vectors[name], axis=0)).sum())

    def until(self, end: float) -> Signals:
        """The part up to `end` [s]."""
        return self._part(self.time <= end + _TINY)

    def since(self, start: float) -> Signals:
        """The part from `start` [s] on."""
        return self._part(self.time >= start - _TINY)

    def every(self, stride: int) -> Signals:
        """Each `stride`-th sample."""
        return self._part(slice(None, None, stride))

    def _part(self, kept: Any) -> Signals:
        return Signals(self.time[kept], {name: vector[kept] for name, vector in self.vectors.items()})


def signals(result: Result) -> Signals:
    """The errors of a run of `observer-pd` or `full-state-pd`."""
    q_BN, omega_BN_B = result["plant.q_BN"], result["plant.omega_BN_B"]
    q_BR = attitude.relative_quaternion(q_BN, result["guidance.q_RN"])
    k_p, k_v = PD_GAINS["k_p"], PD_GAINS["k_v"]
    vectors = {
        ATTITUDE: q_BR[:, 1:],
        RATE: attitude.rate_error(omega_BN_B, q_BR, result["guidance.omega_RN_R"]),
        TORQUE: result["controller.torque_B"],
        FEEDBACK: -k_p * result["controller.q_BR"][:, 1:] - k_v * result["controller.omega_BR_B"],
    }
    if "observer.q_EN" in result.names:
        q_BE = attitude.relative_quaternion(q_BN, result["observer.q_EN"])
        vectors[ATTITUDE_ESTIMATE] = q_BE[:, 1:]
        vectors[RATE_ESTIMATE] = attitude.rate_error(omega_BN_B, q_BE, result["observer.omega_EN_E"])
    return Signals(result.time, vectors)


def component_panel(name: str, runs: Mapping[str, Signals], title: str = "", group: str = "") -> Panel:
    """The three components of an error, all runs that have it in one panel, told apart by the dashes."""
    symbol, unit = SYMBOLS[name]
    having = {label: run for label, run in runs.items() if name in run.vectors}
    series = [
        curve
        for label, run, dash in told_apart(having)
        for curve in components(label, run.time, run.vectors[name], dash)
    ]
    return Panel(title or name.capitalize(), symbol + unit, series, group=group)


def norm_panel(
    name: str,
    runs: Mapping[str, Signals],
    title: str = "",
    group: str = "",
    log: bool = True,
    guides: Sequence[Guide] = (),
    note: str = "",
) -> Panel:
    """The norm of an error over time, one curve for each run that has it."""
    symbol, unit = SYMBOLS[name]
    series = [
        Series(label, run.time, run.norm(name), color=color)
        for color, (label, run) in enumerate(runs.items())
        if name in run.vectors
    ]
    return Panel(title or name.capitalize(), f"‖{symbol}‖{unit}", series, log, note, guides=guides, group=group)
