"""How one run of a system of Sec. 3.4 is shown: `adcs run` and its report."""

from __future__ import annotations

from adcs.library.thakur.adaptive.signals import (
    ATTITUDE,
    RATE,
    TORQUE,
    Track,
    moments_panel,
    norm_panel,
    sigma_panel,
    theta_panel,
    track,
)
from adcs.library.thakur.choices import Choices
from orchestration.results.plots import Panel, Series
from orchestration.results.report import KeyNumber
from orchestration.results.result import Result

_MARGIN = "controller.implementability"


def figures(result: Result) -> list[Panel]:
    """Errors and torque, the estimates, and the inertia where it changes."""
    run = track(result)
    panels = [
        norm_panel(ATTITUDE, {"": run}, "Attitude tracking error", "Tracking"),
        norm_panel(RATE, {"": run}, "Rate tracking error", "Tracking"),
        norm_panel(TORQUE, {"": run}, "Control torque", "Control", log=False),
    ]
    if _MARGIN in run.extra:
        margin = Series("", run.time, run.extra[_MARGIN])
        panels.append(Panel("Implementability of the law", "1 - ‖Ĵ₁Ω‖", [margin], group="Control"))
    panels.append(theta_panel(run, "Estimate of J_0", "Adaptation"))
    if run.sigma.shape[1]:
        labels = [f"Ĵ₁ {i + 1}" for i in range(run.sigma.shape[1])]
        panels.append(sigma_panel(run, labels[:3], "kg or s", "Estimate of J_1", "Adaptation"))
    if len(run.moments):
        panels.append(moments_panel({"": run}, "Principal moments of inertia", "Inertia"))
    return panels


def key_numbers(result: Result) -> list[KeyNumber]:
    """Convergence, the largest torque, how good the estimates are, and how far the limits of law and plant are."""
    run, part = track(result), Choices().settled
    numbers = []
    for name, unit in ((ATTITUDE, ""), (RATE, "deg/s")):
        note = f"stays below {part:.0%} of its peak"
        title = name.capitalize()
        numbers.append(KeyNumber(f"{title} converged", run.settling_time(name, part), "s", note))
        numbers.append(KeyNumber(f"{title} at the end", run.end(name), unit, f"at {run.time[-1]:g} s"))
    numbers.append(KeyNumber("Largest torque", run.peak(TORQUE), "N·m"))
    return numbers + _limits(run)


def _limits(run: Track) -> list[KeyNumber]:
    numbers = []
    if run.sigma.shape[1]:
        error = f"{run.sigma_error()[-1]:.1%}"
        numbers.append(KeyNumber("Error of the estimate of J_1", error, "", "of the true value, at the end"))
    if _MARGIN in run.extra:
        least = float(run.extra[_MARGIN].min())
        numbers.append(KeyNumber("Least 1 - ‖Ĵ₁Ω‖", least, "", "the law is valid while this is positive, Eq. (3.39)"))
    if "plant.fuel_left" in run.extra:
        left = float(run.extra["plant.fuel_left"][-1])
        numbers.append(KeyNumber("Fuel left", left, "N·m·s", "at 0 the thrusters give no torque"))
    if len(run.moments):
        margin = run.triangle_margin()
        numbers.append(KeyNumber("Least margin of the triangle inequality", margin, "kg·m²", "of J, Eq. (3.5)"))
    return numbers
