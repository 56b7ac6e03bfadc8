"""How one run of a system of Sec. 5.4 is shown: `adcs run` and its report."""

from __future__ import annotations

from adcs.library.thakur.choices import Choices
from adcs.library.thakur.observer.signals import (
    ATTITUDE,
    ERRORS,
    RATE,
    SYMBOLS,
    TORQUE,
    component_panel,
    norm_panel,
    signals,
)
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber
from orchestration.results.result import Result

TORQUE_GROUP, TRACKING_GROUP, ESTIMATION_GROUP = "Control", "Tracking", "Estimation"


def figures(result: Result) -> list[Panel]:
    """Errors by component and by norm, and the torque."""
    run = signals(result)
    panels = []
    for name in ERRORS:
        if name in run.vectors:
            group = TRACKING_GROUP if name in (ATTITUDE, RATE) else ESTIMATION_GROUP
            panels.append(component_panel(name, {"": run}, group=group))
            panels.append(norm_panel(name, {"": run}, f"Norm of the {name}", group))
    panels.append(component_panel(TORQUE, {"": run}, group=TORQUE_GROUP))
    panels.append(norm_panel(TORQUE, {"": run}, "Norm of the control torque", TORQUE_GROUP, log=False))
    return panels


def key_numbers(result: Result) -> list[KeyNumber]:
    """When each error has converged, where it ends, and the largest torque."""
    run = signals(result)
    part = Choices().settled
    numbers = []
    for name in ERRORS:
        if name in run.vectors:
            title, unit = name.capitalize(), SYMBOLS[name][1].strip(" []")
            time, end = run.settling_time(name, part), float(run.norm(name)[-1])
            numbers.append(KeyNumber(f"{title} converged", time, "s", f"stays below {part:.0%} of its peak"))
            numbers.append(KeyNumber(f"{title} at the end", end, unit, f"at {run.time[-1]:g} s"))
    numbers.append(KeyNumber("Largest torque", run.peak(TORQUE), "N·m"))
    return numbers
