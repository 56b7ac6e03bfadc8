"""How one run of a system of Sec. 5.4 is shown: `adcs run` and its report."""

from __future__ import annotations

from adcs.library.thakur.choices import Choices
from adcs.library.thakur.observer.signals import ERRORS, TORQUE, TRACKING, signals
from adcs.library.trajectory import Quantity, Trajectory, component_panel, norm_panel
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber
from orchestration.results.result import Result


def figures(result: Result) -> list[Panel]:
    """Errors by component and by norm, and the torque."""
    run = signals(result)
    errors = [panel for what in ERRORS for panel in error_panels(what, run)]
    torque = norm_panel(TORQUE, {"": run}, "Norm of the control torque", "Control", log=False)
    return [*errors, component_panel(TORQUE, {"": run}, group="Control"), torque]


def key_numbers(result: Result) -> list[KeyNumber]:
    """When each error has converged, where it ends, and the largest torque."""
    run = signals(result)
    errors = [number for what in ERRORS for number in error_numbers(what, run)]
    return [*errors, KeyNumber("Largest torque", run.peak(TORQUE), "N·m")]


def error_panels(what: Quantity, run: Trajectory) -> list[Panel]:
    """An error by component and by norm, if the run has it."""
    group, runs = "Tracking" if what in TRACKING else "Estimation", {"": run}
    if what not in run:
        return []
    return [component_panel(what, runs, group=group), norm_panel(what, runs, f"Norm of the {what}", group)]


def error_numbers(what: Quantity, run: Trajectory) -> list[KeyNumber]:
    """When an error has converged and where it ends, if the run has it."""
    if what not in run:
        return []
    part, end = Choices().settled, f"at {run.time[-1]:g} s"
    return [
        KeyNumber(f"{what.title} converged", run.settled(what, part), "s", f"stays below {part:.0%} of its peak"),
        KeyNumber(f"{what.title} at the end", run.end(what), what.unit, end),
    ]
