"""How one run is shown: `adcs run` and its report."""

from __future__ import annotations

from adcs.library.six_dof.signals import DELTA_V, ERRORS, FORCE, POSITION, TORQUE, signals
from adcs.library.trajectory import norm_panel
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber
from orchestration.results.result import Result


def figures(result: Result) -> list[Panel]:
    """The four errors, force and torque, and what they cost."""
    run = {"": signals(result)}
    tracking = [norm_panel(what, run, group="Tracking") for what in ERRORS]
    control = [norm_panel(what, run, group="Control", log=what is not DELTA_V) for what in (FORCE, TORQUE, DELTA_V)]
    return [*tracking, *control]


def key_numbers(result: Result) -> list[KeyNumber]:
    """When the position has converged, the velocity increment, the largest force and torque."""
    run = signals(result)
    converged = run.settled(POSITION, 0.01, run.start(POSITION))
    return [
        KeyNumber("Position error converged", converged, "s", "stays below 1 % of its start"),
        KeyNumber("Velocity increment", run.end(DELTA_V), "m/s", "integral of the force over the mass"),
        KeyNumber("Largest force", run.peak(FORCE), "N"),
        KeyNumber("Largest torque", run.peak(TORQUE), "N·m"),
    ]
