"""Tracking and estimation errors of a recorded run, and the distances of the estimates from where they started."""

from __future__ import annotations

import numpy as np

from adcs.library import attitude
from adcs.library.trajectory import Quantity, Runs, Trajectory
from orchestration.results.plots import Dash, Guide, Panel, Series
from orchestration.results.result import Result

ATTITUDE = Quantity("attitude tracking error", "q")
RATE = Quantity("rate tracking error", "δω", "rad/s")
FILTERED = Quantity("filtered rate error", "ω̃", "rad/s")  # as the law sees it
TORQUE = Quantity("torque", "τ", "N·m")
ATTITUDE_ESTIMATE = Quantity("attitude estimation error", "v_q")
RATE_ESTIMATE = Quantity("rate estimation error", "v_ω", "rad/s")
THETA, THETA_P = Quantity("estimate of theta", "θ̂"), Quantity("estimate of theta_p", "θ̂_p", "1/(kg·m²)")
# In units of eta, eta_p: the projection acts from 1, and sqrt(1 + eps) is the edge of G and G_p.
DISTANCE, DISTANCE_P = Quantity("distance from theta*", "θ"), Quantity("distance from theta_p*", "θ_p")
DISTANCES = (DISTANCE, DISTANCE_P)


def signals(result: Result) -> Trajectory:
    """A run of one of the three systems; the tracking errors are the true ones, whatever the law was fed with."""
    q_BN, omega = result["plant.q_BN"], result["plant.omega_BN_B"]
    q_BR = attitude.relative_quaternion(q_BN, result["guidance.q_RN"])
    values = {
        ATTITUDE: q_BR[:, 1:],
        RATE: attitude.rate_error(omega, q_BR, result["guidance.omega_RN_R"]),
        FILTERED: result["controller.filtered_rate_B"],
        TORQUE: result["controller.torque_B"],
        THETA: result["controller.theta_est"],
        THETA_P: result["controller.theta_p_est"],
    }
    if "estimate.q_EB" in result.names:
        values[ATTITUDE_ESTIMATE] = result["estimate.q_EB"][:, 1:]
        values[RATE_ESTIMATE] = result["estimate.rate_error_B"]
    elif "observer.omega_BN_B_est" in result.names:
        values[RATE_ESTIMATE] = result["observer.omega_BN_B_est"] - omega
    start = result.system.components["controller"].start
    for distance, level, epsilon in ((DISTANCE, "theta", "epsilon"), (DISTANCE_P, "theta_p", "epsilon_p")):
        # the level is (distance^2 - 1) / epsilon
        values[distance] = np.sqrt(np.maximum(0.0, 1 + start[epsilon][0] * result[f"controller.{level}_level"]))
    return Trajectory(result.time, values)


def distance_panel(runs: Runs, epsilon: float, group: str = "") -> Panel:
    """How far the estimates are from where they started, in units of eta and eta_p."""
    kinds: tuple[tuple[Quantity, Dash], ...] = ((DISTANCE, "solid"), (DISTANCE_P, "dash"))
    series = [
        Series(f"{label} {what.symbol}".strip(), run.time, run[what], dash, color=color)
        for color, (label, run) in enumerate(runs.items())
        for what, dash in kinds
    ]
    guides = [Guide(float(np.sqrt(1 + epsilon)), "edge of G and G_p: √(1+ε)"), Guide(1.0)]
    return Panel("Parameter estimates", "distance from the nominal value / η", series, guides=guides, group=group)
