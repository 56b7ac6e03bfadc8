"""How one run of a system is shown: `adcs run` and its report."""

from __future__ import annotations

from adcs.library.deruiter.signals import (
    ATTITUDE,
    ATTITUDE_ESTIMATE,
    FILTERED,
    RATE,
    RATE_ESTIMATE,
    SYMBOLS,
    TORQUE,
    distance_panel,
    norm_panel,
    signals,
)
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
    panels = [
        norm_panel(
            name,
            {"": run},
            name.capitalize(),
            group,
            [Guide(zone, "dead zone")] if name == FILTERED and zone > 0 else (),
        )
        for name, group in GROUPS.items()
        if name in run.norms
    ]
    return [*panels, distance_panel({"": run}, controller["epsilon"][0], "Parameter estimates", "Adaptation")]


def key_numbers(result: Result) -> list[KeyNumber]:
    """Largest errors in the last third of the run, how far the estimates went, and the largest torque."""
    run = signals(result)
    start = run.time[0] + 2 / 3 * (run.time[-1] - run.time[0])
    tail = run.after(start)
    numbers = [
        KeyNumber(f"{name.capitalize()}, last third", tail.peak(name), _unit(name), f"largest from {start:.4g} s on")
        for name in (ATTITUDE, RATE, ATTITUDE_ESTIMATE, RATE_ESTIMATE)
        if name in run.norms
    ]
    largest = max(float(distance.max()) for distance in run.distance.values())
    edge = (1 + result.system.components["controller"].start["epsilon"][0]) ** 0.5
    numbers.append(KeyNumber("Farthest estimate", largest, "η", f"held within {edge:.3g}"))
    numbers.append(KeyNumber("Largest torque", run.peak(TORQUE), "N·m"))
    return numbers


def _unit(name: str) -> str:
    _, _, unit = SYMBOLS[name].partition("[")
    return unit.rstrip("]")
