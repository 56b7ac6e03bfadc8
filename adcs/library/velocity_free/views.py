"""How one run of a system of Sec. V is shown: `adcs run` and its report."""

from __future__ import annotations

from adcs.library.trajectory import component_panel, norm_panel
from adcs.library.velocity_free.settings import ERROR_BOUND, TORQUE_BOUND
from adcs.library.velocity_free.signals import ATTITUDE, DISTURBANCE, MEASUREMENT, RATE, TORQUE, signals
from orchestration.results.plots import Guide, Panel
from orchestration.results.report import KeyNumber
from orchestration.results.result import Result


def figures(result: Result) -> list[Panel]:
    """Errors and torque; what disturbs them, where something does."""
    run = {"": signals(result)}
    panels = [norm_panel(what, run, group="Tracking") for what in (ATTITUDE, RATE)]
    panels.append(component_panel(TORQUE, run, group="Control"))
    if MEASUREMENT in run[""]:
        for what, bound in ((MEASUREMENT, Guide(ERROR_BOUND, "μ_v")), (DISTURBANCE, Guide(TORQUE_BOUND, "μ_d"))):
            panels.append(norm_panel(what, run, group="Uncertainty", guides=(bound,), log=False))
    return panels


def key_numbers(result: Result) -> list[KeyNumber]:
    """Largest errors over the second half, and the largest torque."""
    run = signals(result)
    half = float(run.time[-1]) / 2
    note, tail = f"largest from {half:g} s to {run.time[-1]:g} s", run.after(half)
    return [
        KeyNumber("Attitude error", tail.peak(ATTITUDE), "", note),
        KeyNumber("Rate error", tail.peak(RATE), "rad/s", note),
        KeyNumber("Largest torque", run.peak(TORQUE), "N·m"),
    ]
