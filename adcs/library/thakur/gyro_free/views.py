"""How one run of a system of Sec. 4.3 is shown: `adcs run` and its report."""

from __future__ import annotations

from adcs.library.thakur.choices import Choices
from adcs.library.thakur.gyro_free.level import printed_level, sufficient_level
from adcs.library.thakur.gyro_free.signals import ANGLE, FILTER, RATE, TORQUE, motion
from adcs.library.trajectory import component_panel, norm_panel
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber
from orchestration.results.result import Result


def figures(result: Result) -> list[Panel]:
    """Angle and rate, the torque, and the filter where there is one."""
    run = {"": motion(result)}
    panels = [
        norm_panel(ANGLE, run, group="Attitude", log=False),
        norm_panel(ANGLE, run, "Rotation angle, logarithmic", "Attitude"),
        component_panel(RATE, run, group="Attitude"),
        norm_panel(RATE, run, "Norm of the angular velocity", "Attitude"),
        component_panel(TORQUE, run, group="Control"),
        norm_panel(TORQUE, run, "Norm of the control torque", "Control", log=False),
    ]
    return [*panels, component_panel(FILTER, run, group="Control")] if FILTER in run[""] else panels


def key_numbers(result: Result) -> list[KeyNumber]:
    """When the body is at rest, where it ends, the largest torque, and from where convergence is sure."""
    run, part = motion(result), Choices().settled
    converged = f"stays below {part:.0%} of its peak"
    numbers = [
        KeyNumber("Angle converged", run.settled(ANGLE, part), "s", converged),
        KeyNumber("Angle at the end", run.end(ANGLE), "deg", f"at {run.time[-1]:g} s"),
        KeyNumber("Rate converged", run.settled(RATE, part), "s", converged),
        KeyNumber("Largest torque", run.peak(TORQUE), "N·m"),
    ]
    if FILTER in run:
        note = f"for the parameters of the text; the {printed_level():.4g} N·m of Theorem 4.2.3 are not enough"
        numbers.append(KeyNumber("Sure to converge if V(0) is below", sufficient_level(), "N·m", note))
    return numbers
