"""How one run of a system is shown: `adcs run` and its report."""

from __future__ import annotations

from adcs.library.deruiter.signals import (
    ATTITUDE,
    ATTITUDE_ESTIMATE,
    DISTANCES,
    FILTERED,
    RATE,
    RATE_ESTIMATE,
    TORQUE,
    distance_panel,
    signals,
)
from adcs.library.trajectory import norm_panel
from orchestration.results.plots import Guide, Panel
from orchestration.results.report import KeyNumber
from orchestration.results.result import Result

GROUPS = {
    ATTITUDE: "Tracking",
    RATE: "Tracking",
    FILTERED: "Adaptation",
    ATTITUDE_ESTIMATE: "Estimation",
    RATE_ESTIMATE: "Estimation",
    TORQUE: "Control",
}


def figures(result: Result) -> list[Panel]:
    """Norms of all errors, the filtered one with the dead zone, and the estimates in their balls."""
    run = signals(result)
    controller = result.system.components["controller"].start
    zone = controller["dead_zone"][0]
    panels = []
    for what, group in GROUPS.items():
        if what in run:
            guides = [Guide(zone, "dead zone")] if what is FILTERED and zone > 0 else []
            panels.append(norm_panel(what, {"": run}, group=group, guides=guides))
    return [*panels, distance_panel({"": run}, controller["epsilon"][0], "Adaptation")]


def key_numbers(result: Result) -> list[KeyNumber]:
    """Largest errors in the last third of the run, how far the estimates went, and the largest torque."""
    run = signals(result)
    start = run.time[0] + 2 / 3 * (run.time[-1] - run.time[0])
    tail, note = run.after(start), f"largest from {start:.4g} s on"
    numbers = [
        KeyNumber(f"{what.title}, last third", tail.peak(what), what.unit, note)
        for what in (ATTITUDE, RATE, ATTITUDE_ESTIMATE, RATE_ESTIMATE)
        if what in run
    ]
    edge = (1 + result.system.components["controller"].start["epsilon"][0]) ** 0.5
    farthest = max(run.peak(distance) for distance in DISTANCES)
    numbers.append(KeyNumber("Farthest estimate", farthest, "η", f"held within {edge:.3g}"))
    return [*numbers, KeyNumber("Largest torque", run.peak(TORQUE), "N·m")]
