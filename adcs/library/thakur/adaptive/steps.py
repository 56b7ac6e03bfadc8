"""What sampling does to the loops of chapter 3: exchange steps, and the stiff law for fuel loss."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from adcs.library.exchange import COUPLED, at_steps, whole
from adcs.library.outcome import Shown
from adcs.library.sections import Section, Simulation, failed_at
from adcs.library.thakur.adaptive.systems import appendage, baseline, comparison_appendage, fuel
from adcs.library.thakur.choices import Choices
from orchestration.results.report import Table
from orchestration.results.result import Result
from orchestration.running.method import ModelExchange

GROUP = "Chapter 3: co-simulation against the coupled solution"
STEPS = (0.001, 0.01)  # s
FUEL_STEPS = (0.0001, 0.0005, 0.001, 0.002, 0.005, 0.01)  # s
INTERNAL_STEPS = (0.01, 0.001, 0.0001)  # s
GRID = 0.1  # s, a multiple of the steps
STOP_TIME, FUEL_STOP_TIME = 100.0, 40.0  # s
COMPARED = {
    "plant.q_BN": "q_BN",
    "plant.omega_BN_B": "ω_BN [rad/s]",
    "controller.torque_B": "torque [N·m]",
    "controller.theta_est": "θ̂ [kg·m²]",
}
SYSTEMS = {
    "baseline": baseline,
    "appendage": appendage,
    "appendage, comparison": comparison_appendage,
    "fuel": fuel,
}
FUEL_CASES = [
    (step, internal)
    for internal in INTERNAL_STEPS
    for step in FUEL_STEPS
    # the internal step is never longer than the exchange step
    if internal == INTERNAL_STEPS[0] or step > internal
]


def exchange_steps(_: Choices) -> Section:
    """Every loop at 1 ms and 10 ms: the largest difference of a component."""
    runs = at_steps(SYSTEMS, STEPS, GRID, STOP_TIME)

    def show(found: Mapping[tuple[str, float], Result]) -> Iterator[Shown]:
        rows = [
            [label, 1e3 * step, *_distances(found[label, step], found[label, COUPLED])]
            for label in SYSTEMS
            for step in STEPS
        ]
        note = (
            f"Largest difference of a component over {STOP_TIME:g} s. The controller for fuel loss integrates inside "
            "with 0.1 ms. Ten times the step, ten times the difference, but for its torque, which chatters at 10 ms: "
            "there the loop is no longer resolved."
        )
        columns = ["loop", "exchange step [ms]", *COMPARED.values()]
        yield Table("Distance from the coupled solution", columns, rows, note)

    return Section(GROUP, "", show, runs)


def fuel_limits(_: Choices) -> Section:
    """The limits of the sampled law for fuel loss, with the printed gains."""
    stop, exact = FUEL_STOP_TIME, (0.0, 0.0)
    runs = {exact: Simulation("fuel, coupled, 40 s", fuel(), whole, stop, GRID, ModelExchange())}
    for step, internal in FUEL_CASES:
        runs[step, internal] = Simulation(
            f"fuel, exchange {1e3 * step:g} ms, internal {1e3 * internal:g} ms",
            fuel(max_internal_step=internal),
            whole,
            stop,
            step,
            every=round(GRID / step),
            may_fail=True,
        )

    def show(found: Mapping[tuple[float, float], Result]) -> Iterator[Shown]:
        rows: list[list[object]] = []
        for step, internal in FUEL_CASES:
            run, steps = found[step, internal], [1e3 * step, 1e3 * min(internal, step)]
            if (end := failed_at(run)) is not None:
                rows.append([*steps, f"diverges at {end:.3g} s", *[None] * len(COMPARED)])
            else:
                rows.append([*steps, "runs", *_distances(run, found[exact])])
        note = (
            f"The adaptive law for fuel loss with the printed gains, {stop:g} s, at the printed frequency. Its "
            "projection pulls the estimate back at up to 4.5e3 1/s, and the adaptation oscillates with the loop at up "
            "to 100 rad/s. The internal step is that of the integrator in the controller; where both steps are "
            "equal it is nearest to a digital controller that updates its estimates once per sample."
        )
        columns = ["exchange step [ms]", "internal step used [ms]", "", *COMPARED.values()]
        yield Table("Sampled limits of the law for fuel loss", columns, rows, note)

    return Section(GROUP, "", show, runs)


def _distances(run: Result, exact: Result) -> list[float]:
    return [float(np.abs(run[name] - exact[name]).max()) for name in COMPARED]
