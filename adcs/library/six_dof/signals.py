"""The errors of the loop from a recorded run, and how they are drawn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adcs.library import attitude
from orchestration.results.plots import Guide, Panel, Series
from orchestration.results.result import Result

Array = NDArray[np.float64]

POSITION, VELOCITY, ATTITUDE, RATE = "position error", "velocity error", "attitude error", "rate error"
FORCE, TORQUE, DELTA_V = "control force", "control torque", "velocity increment"
ERRORS = (POSITION, VELOCITY, ATTITUDE, RATE)
LABELS = {
    POSITION: "‖e_R‖ [m]",
    VELOCITY: "‖e_V‖ [m/s]",
    ATTITUDE: "‖e_ε‖",
    RATE: "‖ω - C ω_d‖ [rad/s]",
    FORCE: "‖F‖ [N]",
    TORQUE: "‖τ‖ [N·m]",
    DELTA_V: "∫‖F‖dt / m [m/s]",
}
ROUNDING = {POSITION: 1e-7, VELOCITY: 1e-9, ATTITUDE: 1e-12, RATE: 1e-13, FORCE: 1e-7, TORQUE: 0.0, DELTA_V: 0.0}
"""Below, a curve shows how double precision resolves positions of 7e6 m, and nothing else: not drawn."""


@dataclass(frozen=True)
class Signals:
    """Norms over time, all (N,) in SI units, by the names above."""

    time: Array
    norms: Mapping[str, Array]

    def start(self, name: str) -> float:
        """Value at the start."""
        return float(self.norms[name][0])

    def settled(self, name: str, part: float) -> float:
        """Time from which on the norm stays below `part` of its value at the start [s]; NaN if it does not."""
        return attitude.settling_time(self.time, self.norms[name], part * self.start(name))

    def end(self, name: str) -> float:
        """Value at the end."""
        return float(self.norms[name][-1])

    def peak(self, name: str) -> float:
        """Largest value."""
        return float(self.norms[name].max())


def signals(result: Result, mass: float) -> Signals:
    """The errors of a run of one of the systems; `mass` [kg] turns the impulse into a velocity increment."""
    q_BR = result["controller.q_BR"]
    norms = {
        POSITION: attitude.norm(result["controller.r_RB_B"]),
        VELOCITY: attitude.norm(result["orbit.v_ON_N"] - result["plant.v_BN_N"]),
        ATTITUDE: attitude.norm(q_BR[:, 1:]),
        RATE: attitude.norm(attitude.rate_error(result["plant.omega_BN_B"], q_BR, result["guidance.omega_RN_R"])),
        FORCE: attitude.norm(result["actuator.force_B"]),
        TORQUE: attitude.norm(result["actuator.torque_B"]),
        DELTA_V: result["actuator.impulse"] / mass,
    }
    return Signals(result.time, norms)


def panel(
    name: str, runs: Mapping[str, Signals], group: str, log: bool = True, guides: tuple[Guide, ...] = (), note: str = ""
) -> Panel:
    """One norm over time, one curve for each run."""
    series = []
    for label, run in runs.items():
        values = run.norms[name]
        shown = np.where(values < ROUNDING[name], np.nan, values) if log else values
        series.append(Series(label, run.time, shown))
    return Panel(name.capitalize(), LABELS[name], series, log, note, guides=guides, group=group)
