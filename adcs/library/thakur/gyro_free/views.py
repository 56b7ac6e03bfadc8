"""How one run of a system of Sec. 4.3 is shown: `adcs run` and its report."""

from __future__ import annotations

from adcs.library.thakur.choices import Choices
from adcs.library.thakur.gyro_free.level import printed_level, sufficient_level
from adcs.library.thakur.gyro_free.signals import ANGLE, RATE, TORQUE, motion, panel, vector_panel
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber
from orchestration.results.result import Result


def figures(result: Result) -> list[Panel]:
    """Angle and rate, the torque, and the filter where there is one."""
    run = {"": motion(result)}
    panels = [
        panel(ANGLE, run, group="Attitude"),
        panel(ANGLE, run, "Rotation angle, logarithmic", "Attitude", log=True),
        vector_panel(RATE, "ω [rad/s]", run, "Angular velocity", "Attitude"),
        panel(RATE, run, "Norm of the angular velocity", "Attitude", log=True),
        vector_panel(TORQUE, "u [N·m]", run, "Control torque", "Control"),
        panel(TORQUE, run, "Norm of the control torque", "Control"),
    ]
    if "z" in run[""].vectors:
        panels.append(vector_panel("z", "z", run, "Filter state", "Control"))
    return panels


def key_numbers(result: Result) -> list[KeyNumber]:
    """When the body is at rest, where it ends, the largest torque, and from where convergence is sure."""
    run, part = motion(result), Choices().settled
    numbers = [
        KeyNumber("Angle converged", run.settling_time(ANGLE, part), "s", f"stays below {part:.0%} of its peak"),
        KeyNumber("Angle at the end", float(run.values[ANGLE][-1]), "deg", f"at {run.time[-1]:g} s"),
        KeyNumber("Rate converged", run.settling_time(RATE, part), "s", f"stays below {part:.0%} of its peak"),
        KeyNumber("Largest torque", run.peak(TORQUE), "N·m"),
    ]
    if "z" in run.vectors:
        note = f"for the parameters of the text; the {printed_level():.4g} N·m of Theorem 4.2.3 are not enough"
        numbers.append(KeyNumber("Sure to converge if V(0) is below", sufficient_level(), "N·m", note))
    return numbers
