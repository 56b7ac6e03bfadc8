"""How one run of a system of Sec. 3.4 is shown: `adcs run` and its report."""

from __future__ import annotations

from adcs.library.thakur.adaptive.signals import (
    ATTITUDE,
    FUEL_LEFT,
    MARGIN,
    MOMENTS,
    RATE,
    SIGMA_ERROR,
    SIGMA_EST,
    TORQUE,
    TRIANGLE,
    moments_panel,
    sigma_panel,
    theta_panel,
    track,
)
from adcs.library.thakur.observer.views import error_numbers
from adcs.library.trajectory import Trajectory, norm_panel
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber
from orchestration.results.result import Result


def figures(result: Result) -> list[Panel]:
    """Errors and torque, the estimates, and the inertia where it changes."""
    run = track(result)
    panels = [
        norm_panel(error, {"": run}, f"{error.name.split()[0].capitalize()} tracking error", "Tracking")
        for error in (ATTITUDE, RATE)
    ]
    panels.append(norm_panel(TORQUE, {"": run}, group="Control", log=False))
    if MARGIN in run:
        panels.append(norm_panel(MARGIN, {"": run}, group="Control", log=False))
    panels.append(theta_panel(run, "Estimate of J_0", "Adaptation"))
    if SIGMA_EST in run:
        labels = [f"Ĵ₁ {i + 1}" for i in range(min(3, run[SIGMA_EST].shape[1]))]
        panels.append(sigma_panel(run, labels, "kg or s", "Estimate of J_1", "Adaptation"))
    if MOMENTS in run:
        panels.append(moments_panel({"": run}, "Principal moments of inertia", "Inertia"))
    return panels


def key_numbers(result: Result) -> list[KeyNumber]:
    """Convergence, the largest torque, how good the estimates are, and how far the limits of law and plant are."""
    run = track(result)
    errors = [number for error in (ATTITUDE, RATE) for number in error_numbers(error, run)]
    return [*errors, KeyNumber("Largest torque", run.peak(TORQUE), "N·m"), *_limits(run)]


def _limits(run: Trajectory) -> list[KeyNumber]:
    numbers = []
    if SIGMA_ERROR in run:
        error = f"{run.end(SIGMA_ERROR):.1%}"
        numbers.append(KeyNumber("Error of the estimate of J_1", error, "", "of the true value, at the end"))
    if MARGIN in run:
        note = "the law is valid while this is positive, Eq. (3.39)"
        numbers.append(KeyNumber("Least 1 - ‖Ĵ₁Ω‖", run.least(MARGIN), "", note))
    if FUEL_LEFT in run:
        numbers.append(KeyNumber("Fuel left", run.end(FUEL_LEFT), "N·m·s", "at 0 the thrusters give no torque"))
    if TRIANGLE in run:
        note = "of J, Eq. (3.5)"
        numbers.append(KeyNumber("Least margin of the triangle inequality", run.least(TRIANGLE), "kg·m²", note))
    return numbers
