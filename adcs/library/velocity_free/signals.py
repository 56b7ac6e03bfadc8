"""The errors of Sec. V from a recorded run, and how they are drawn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adcs.library import attitude
from orchestration.results.plots import Guide, Panel, Series
from orchestration.results.result import Result

Array = NDArray[np.float64]

ATTITUDE, RATE, TORQUE = "attitude tracking error", "rate tracking error", "control torque"
MEASUREMENT, DISTURBANCE = "measurement error", "disturbance torque"
LABELS = {
    ATTITUDE: "‖δq_v‖",
    RATE: "‖δω‖ [rad/s]",
    TORQUE: "‖u‖ [N·m]",
    MEASUREMENT: "‖q̃_v‖",
    DISTURBANCE: "‖d‖ [N·m]",
}

FLOOR = 1e-7


@dataclass(frozen=True)
class Signals:
    """Norms over time, all (N,), of the true errors.

    Vector part of q_BR, omega_BN_B - C(q_BR) omega_RN_R [rad/s], control torque [N.m]; with uncertainties also the
    vector part of q_EB, and the disturbance torque [N.m].
    """

    time: Array
    norms: Mapping[str, Array]

    def after(self, start: float, name: str) -> Array:
        """The norm from `start` [s] on."""
        return self.norms[name][self.time >= start - 1e-9]


def signals(result: Result, every: int = 1) -> Signals:
    """The errors of a run of one of the four systems; every `every`-th row."""
    rows = slice(None, None, every)
    q_BR = attitude.relative_quaternion(result["plant.q_BN"][rows], result["guidance.q_RN"][rows])
    rate = attitude.rate_error(result["plant.omega_BN_B"][rows], q_BR, result["guidance.omega_RN_R"][rows])
    norms = {
        ATTITUDE: attitude.norm(q_BR[:, 1:]),
        RATE: attitude.norm(rate),
        TORQUE: attitude.norm(result["controller.torque_B"][rows]),
    }
    if "tracker.q_EB" in result.names:
        norms[MEASUREMENT] = attitude.norm(result["tracker.q_EB"][rows, 1:])
        norms[DISTURBANCE] = attitude.norm(result["environment.torque_B"][rows])
    return Signals(result.time[rows], norms)


def panel(
    name: str,
    runs: Mapping[str, Signals],
    title: str,
    group: str,
    guides: tuple[Guide, ...] = (),
    log: bool = True,
    note: str = "",
) -> Panel:
    """One norm over time; of several runs those labelled with an empty string or a number are drawn thin."""
    series = [
        Series(label, run.time, _shown(run.norms[name], log), faint=label.isdigit(), color=1 if label.isdigit() else 0)
        for label, run in runs.items()
        if name in run.norms
    ]
    return Panel(title, LABELS[name], series, log, note, guides=guides, group=group)


def _shown(values: Array, log: bool) -> Array:
    """On a logarithmic axis nothing below `FLOOR`: an ideal run goes down to rounding and would flatten the others."""
    return np.where(values < FLOOR, np.nan, values) if log else values
