"""Tracking and estimation errors of a recorded run, and how they are drawn with their bounds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adcs.library import attitude
from orchestration.results.plots import Dash, Guide, Panel, Series
from orchestration.results.result import Result

Array = NDArray[np.float64]

ATTITUDE, RATE, FILTERED, TORQUE = "attitude tracking error", "rate tracking error", "filtered rate error", "torque"
ATTITUDE_ESTIMATE, RATE_ESTIMATE = "attitude estimation error", "rate estimation error"
SYMBOLS = {
    ATTITUDE: "‖q‖",
    RATE: "‖δω‖ [rad/s]",
    FILTERED: "‖ω̃‖ as the law sees it [rad/s]",
    TORQUE: "‖τ‖ [N·m]",
    ATTITUDE_ESTIMATE: "‖v_q‖",
    RATE_ESTIMATE: "‖v_ω‖ [rad/s]",
}


@dataclass(frozen=True)
class Signals:
    """Norms over time, each (N,): the tracking errors are the true ones, whatever the law was fed with.

    `distance` maps theta and theta_p to the distance of the estimate from its nominal value in units of eta, eta_p:
    the projection acts from 1, and sqrt(1 + eps) is the edge of G and G_p.
    """

    time: Array
    norms: Mapping[str, Array]
    estimation: Mapping[str, Array]  # v_q and v_omega [rad/s], as far as there are any, (N, 3)
    distance: Mapping[str, Array]

    def after(self, start: float, end: float = np.inf) -> Signals:
        """The part from `start` to `end` [s]."""
        kept = (self.time >= start - 1e-9) & (self.time <= end + 1e-9)
        norms = {name: values[kept] for name, values in self.norms.items()}
        distance = {name: values[kept] for name, values in self.distance.items()}
        estimation = {name: values[kept] for name, values in self.estimation.items()}
        return Signals(self.time[kept], norms, estimation, distance)

    def peak(self, name: str) -> float:
        """Largest norm; of the tail of a run, what its limit superior is judged by."""
        return float(self.norms[name].max())

    def speed(self, name: str) -> float:
        """Largest time derivative of an estimation error, by differences over the output step [1/s, rad/s2]."""
        return float(attitude.norm(np.diff(self.estimation[name], axis=0) / np.diff(self.time)[:, None]).max())


def signals(result: Result) -> Signals:
    """The errors of a run of one of the three systems."""
    q_BN, omega = result["plant.q_BN"], result["plant.omega_BN_B"]
    q_BR = attitude.relative_quaternion(q_BN, result["guidance.q_RN"])
    norms = {
        ATTITUDE: attitude.norm(q_BR[:, 1:]),
        RATE: attitude.norm(attitude.rate_error(omega, q_BR, result["guidance.omega_RN_R"])),
        FILTERED: attitude.norm(result["controller.filtered_rate_B"]),
        TORQUE: attitude.norm(result["controller.torque_B"]),
    }
    estimation = {}
    if "estimate.q_EB" in result.names:
        estimation[ATTITUDE_ESTIMATE] = result["estimate.q_EB"][:, 1:]
        estimation[RATE_ESTIMATE] = result["estimate.rate_error_B"]
    elif "observer.omega_BN_B_est" in result.names:
        estimation[RATE_ESTIMATE] = result["observer.omega_BN_B_est"] - omega
    norms |= {name: attitude.norm(error) for name, error in estimation.items()}
    start = result.system.components["controller"].start
    distance = {}
    for name, epsilon in (("theta", "epsilon"), ("theta_p", "epsilon_p")):
        level = result[f"controller.{name}_level"]  # (distance^2 - 1) / epsilon
        distance[name] = np.sqrt(np.maximum(0.0, 1 + start[epsilon][0] * level))
    return Signals(result.time, norms, estimation, distance)


def norm_panel(
    name: str, runs: Mapping[str, Signals], title: str, group: str, guides: Sequence[Guide] = (), log: bool = True
) -> Panel:
    """The norm of an error over time, one curve per run that has it, with its bounds as lines."""
    series = [
        Series(label, run.time, run.norms[name], color=color)
        for color, (label, run) in enumerate(runs.items())
        if name in run.norms
    ]
    return Panel(title, SYMBOLS[name], series, log=log, guides=guides, group=group)


def distance_panel(runs: Mapping[str, Signals], epsilon: float, title: str, group: str) -> Panel:
    """How far the estimates are from where they started, in units of eta and eta_p."""
    kinds: tuple[tuple[str, str, Dash], ...] = (("theta", "θ", "solid"), ("theta_p", "θ_p", "dash"))
    series = [
        Series(f"{label} {symbol}".strip(), run.time, run.distance[name], dash, color=color)
        for color, (label, run) in enumerate(runs.items())
        for name, symbol, dash in kinds
    ]
    edge = float(np.sqrt(1 + epsilon))
    guides = [Guide(edge, "edge of G and G_p: √(1+ε)"), Guide(1.0)]
    return Panel(title, "distance from the nominal value / η", series, guides=guides, group=group)
