"""How one run of a system of Sec. V is shown: `adcs run` and its report."""

from __future__ import annotations

from adcs.library.velocity_free.settings import ERROR_BOUND, TORQUE_BOUND
from adcs.library.velocity_free.signals import ATTITUDE, DISTURBANCE, MEASUREMENT, RATE, TORQUE, panel, signals
from orchestration.results.plots import Guide, Panel, components
from orchestration.results.report import KeyNumber
from orchestration.results.result import Result

TRACKING_GROUP, CONTROL_GROUP, UNCERTAINTY_GROUP = "Tracking", "Control", "Uncertainty"


def figures(result: Result) -> list[Panel]:
    """Errors and torque; what disturbs them, where something does."""
    run = signals(result)
    panels = [
        panel(ATTITUDE, {"": run}, "Attitude tracking error", TRACKING_GROUP),
        panel(RATE, {"": run}, "Rate tracking error", TRACKING_GROUP),
        Panel(
            "Control torque",
            "u [N·m]",
            components("axis", result.time, result["controller.torque_B"]),
            group=CONTROL_GROUP,
        ),
    ]
    if MEASUREMENT in run.norms:
        bound, limit = Guide(ERROR_BOUND, "μ_v"), Guide(TORQUE_BOUND, "μ_d")
        panels.append(panel(MEASUREMENT, {"": run}, "Measurement error", UNCERTAINTY_GROUP, (bound,), log=False))
        panels.append(panel(DISTURBANCE, {"": run}, "Disturbance torque", UNCERTAINTY_GROUP, (limit,), log=False))
    return panels


def key_numbers(result: Result) -> list[KeyNumber]:
    """Largest errors over the second half, and the largest torque."""
    run = signals(result)
    half = float(run.time[-1]) / 2
    note = f"largest from {half:g} s to {run.time[-1]:g} s"
    return [
        KeyNumber("Attitude error", float(run.after(half, ATTITUDE).max()), "", note),
        KeyNumber("Rate error", float(run.after(half, RATE).max()), "rad/s", note),
        KeyNumber("Largest torque", float(run.norms[TORQUE].max()), "N·m"),
    ]
