"""What Sec. 3.4 shows of a run: tracking errors, torque, estimates, moments of inertia; and how estimates are drawn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from adcs.library import attitude
from adcs.library.thakur.adaptive.settings import FUEL_RATES, MASSES, THETA
from adcs.library.trajectory import Array, Quantity, Runs, Trajectory
from orchestration.results.plots import Panel, Series, told_apart
from orchestration.results.result import Result

ATTITUDE, RATE = Quantity("attitude error", "q_ev"), Quantity("rate error", "‖ω_e‖", "deg/s")
TORQUE = Quantity("control torque", "u", "N·m")
THETA_EST, THETA_ERROR = Quantity("estimate of J_0", "θ̂", "kg·m²"), Quantity("error of it", "θ̂ - θ", "kg·m²")
# Of J_1 each controller estimates something else: masses, the diagonal, or all elements.
SIGMA_EST, SIGMA_TRUE = Quantity("estimate of J_1", "Ĵ₁"), Quantity("true J_1", "J₁")
SIGMA_ERROR = Quantity("error of the estimate of J_1 as a part of the norm of the true value", "Ĵ₁ - J₁")
MOMENTS = Quantity("principal moments of inertia", "λ", "kg·m²")  # in ascending order
TRIANGLE = Quantity("sum of the smaller two principal moments less the largest, (3.5)", "λ₁ + λ₂ - λ₃", "kg·m²")
MARGIN = Quantity("implementability of the law", "1 - ‖Ĵ₁Ω‖")
FUEL_LEFT, IMPULSE = Quantity("fuel left", "ψ_max - ψ", "N·m·s"), Quantity("torque impulse", "ψ", "N·m·s")

THETA_LABELS = ("J11", "J12", "J13", "J22", "J23", "J33")
TRUE_J_1 = {
    ("mass_est", 2): np.array(MASSES),
    ("sigma_est", 3): np.array(FUEL_RATES),
    ("J_1_est", 18): -np.hstack([m * np.eye(3) for m in MASSES]).ravel(),
    ("J_1_est", 9): np.diag(FUEL_RATES).ravel(),
}
"""By the name of the estimate in the controllers, of which each has at most one, and its size."""
RECORDED = {
    "controller.implementability": MARGIN,
    "plant.fuel_left": FUEL_LEFT,
    "plant.torque_impulse": IMPULSE,
}


def track(result: Result) -> Trajectory:
    """The run of any system of Sec. 3.4; what it does not estimate, or does not change, is not there."""
    theta, rows = result["controller.theta_est"], len(result.time)
    values = {
        ATTITUDE: result["controller.q_BR"][:, 1:],
        RATE: np.degrees(attitude.norm(result["controller.omega_BR_B"])),
        TORQUE: result["controller.torque_B"],
        THETA_EST: theta,
        THETA_ERROR: theta - np.array(THETA),
    }
    for (name, size), true in TRUE_J_1.items():
        if f"controller.{name}" in result.names and result[f"controller.{name}"][0].size == size:
            sigma = result[f"controller.{name}"].reshape(rows, size)
            error = attitude.norm(sigma - true) / float(np.linalg.norm(true))
            values |= {SIGMA_EST: sigma, SIGMA_TRUE: np.tile(true, (rows, 1)), SIGMA_ERROR: error}
    if "plant.J_B" in result.names:
        moments = np.asarray(np.linalg.eigvalsh(result["plant.J_B"]), dtype=float)
        values |= {MOMENTS: moments, TRIANGLE: moments[:, 0] + moments[:, 1] - moments[:, 2]}
    values |= {what: result[name] for name, what in RECORDED.items() if name in result.names}
    return Trajectory(result.time, values)


def moments_panel(runs: Runs, title: str, group: str = "") -> Panel:
    """Principal moments of inertia, runs told apart by the dashes."""
    series = [
        Series(f"{label} λ{i + 1}".strip(), run.time, run[MOMENTS][:, i], dash, color=i)
        for label, run, dash in told_apart(runs)
        for i in range(3)
    ]
    return Panel(title, "principal moments [kg·m²]", series, group=group)


def theta_panel(run: Trajectory, title: str, group: str = "") -> Panel:
    """The estimate of J_0 as solid curves, the true values dashed."""
    return _estimate_panel(run.time, run[THETA_EST], np.array(THETA), THETA_LABELS, title, "θ̂ [kg·m²]", group)


def sigma_panel(run: Trajectory, labels: Sequence[str], unit: str, title: str, group: str = "") -> Panel:
    """The estimate of J_1 as solid curves, the true values dashed; many of them are drawn thin and without label."""
    return _estimate_panel(run.time, run[SIGMA_EST], run[SIGMA_TRUE][0], labels, title, f"Ĵ₁ [{unit}]", group)


def _estimate_panel(
    time: Array, values: Array, true: Array, labels: Sequence[str], title: str, y_label: str, group: str
) -> Panel:
    faint = values.shape[1] > len(labels)
    names = [f"{i + 1}" for i in range(values.shape[1])] if faint else list(labels)
    series = [Series(name, time, values[:, i], color=i % 8, faint=faint) for i, name in enumerate(names)]
    ends = [time[0], time[-1]]
    series += [
        Series("true values" if i == 0 else "", ends, [value, value], "dash", color=i % 8, faint=i > 0)
        for i, value in enumerate(true)
    ]
    return Panel(title, y_label, series, group=group)
