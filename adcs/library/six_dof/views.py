"""How one run is shown: `adcs run` and its report."""

from __future__ import annotations

from adcs.library.six_dof.settings import MASS
from adcs.library.six_dof.signals import DELTA_V, ERRORS, FORCE, POSITION, TORQUE, panel, signals
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber
from orchestration.results.result import Result

TRACKING_GROUP, CONTROL_GROUP = "Tracking", "Control"


def figures(result: Result) -> list[Panel]:
    """The four errors, force and torque, and what they cost."""
    run = {"": signals(result, MASS)}
    tracking = [panel(name, run, TRACKING_GROUP) for name in ERRORS]
    control = [panel(FORCE, run, CONTROL_GROUP), panel(TORQUE, run, CONTROL_GROUP)]
    return [*tracking, *control, panel(DELTA_V, run, CONTROL_GROUP, log=False)]


def key_numbers(result: Result) -> list[KeyNumber]:
    """When the position has converged, the velocity increment, the largest force and torque."""
    run = signals(result, MASS)
    return [
        KeyNumber("Position error converged", run.settled(POSITION, 0.01), "s", "stays below 1 % of its start"),
        KeyNumber("Velocity increment", run.end(DELTA_V), "m/s", "integral of the force over the mass"),
        KeyNumber("Largest force", run.peak(FORCE), "N"),
        KeyNumber("Largest torque", run.peak(TORQUE), "N·m"),
    ]
