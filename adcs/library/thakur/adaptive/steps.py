"""What sampling does to the loops of chapter 3: exchange steps, and the stiff law for fuel loss."""

from __future__ import annotations

from typing import Any

import numpy as np

from adcs.library.outcome import Outcome, Runner
from adcs.library.thakur.adaptive.systems import RECORD, appendage, baseline, comparison_appendage, fuel
from adcs.library.thakur.choices import Choices
from orchestration.results.report import Table
from orchestration.results.result import Result, RunFailed
from orchestration.running.method import ModelExchange
from orchestration.running.save import Save
from orchestration.system import System

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
RUNS = len(SYSTEMS) * (1 + len(STEPS)) + 1 + len(FUEL_CASES)


def exchange_steps(run: Runner, _: Choices) -> Outcome:
    """Every loop at 1 ms and 10 ms, and the limits of the sampled law for fuel loss."""
    rows = []
    for label, build in SYSTEMS.items():
        times = {"stop_time": STOP_TIME, "save": Save(RECORD)}
        exact = run(f"{label}, coupled, 100 s", build(), step=GRID, **times, method=ModelExchange())
        for step in STEPS:
            result = run(f"{label}, co-simulation at {1e3 * step:g} ms", build(), step=step, **times)
            rows.append([label, 1e3 * step, *_distances(result, exact, step)])
    note = (
        f"Largest difference of a component over {STOP_TIME:g} s. The controller for fuel loss integrates inside with "
        "0.1 ms. Ten times the step, ten times the difference, but for its torque, which chatters at 10 ms: there the "
        "loop is no longer resolved."
    )
    columns = ["loop", "exchange step [ms]", *COMPARED.values()]
    distance = Table("Distance from the coupled solution", columns, rows, note, GROUP)
    return Outcome(tables=[distance, _fuel_limits(run)])


def _fuel_limits(run: Runner) -> Table:
    times: dict[str, Any] = {"stop_time": FUEL_STOP_TIME, "save": Save(RECORD)}
    exact = run("fuel, coupled, 40 s", fuel(), step=GRID, **times, method=ModelExchange())
    rows: list[list[object]] = []
    for step, internal in FUEL_CASES:
        label = f"fuel, exchange {1e3 * step:g} ms, internal {1e3 * internal:g} ms"
        outcome = _attempt(run, label, fuel(max_internal_step=internal), step, times)
        used = 1e3 * min(internal, step)
        if isinstance(outcome, str):
            rows.append([1e3 * step, used, outcome, *[None] * len(COMPARED)])
        else:
            rows.append([1e3 * step, used, "runs", *_distances(outcome, exact, step)])
    note = (
        f"The adaptive law for fuel loss with the printed gains, {FUEL_STOP_TIME:g} s, at the printed frequency. Its "
        "projection pulls the estimate back at up to 4.5e3 1/s, and the adaptation oscillates with the loop at up to "
        "100 rad/s. The internal step is that of the integrator in the controller; where both steps are "
        "equal it is nearest to a digital controller that updates its estimates once per sample."
    )
    columns = ["exchange step [ms]", "internal step used [ms]", "", *COMPARED.values()]
    return Table("Sampled limits of the law for fuel loss", columns, rows, note, GROUP)


def _attempt(run: Runner, label: str, system: System, step: float, times: dict[str, Any]) -> Result | str:
    """The result, or when the run ended because a value was no longer finite."""
    try:
        return run(label, system, step=step, **times)
    except RunFailed as failure:
        return f"diverges at {failure.result.time[-1]:.3g} s"


def _distances(result: Result, exact: Result, step: float) -> list[float]:
    every = round(GRID / step)
    return [float(np.abs(result[name][::every] - exact[name]).max()) for name in COMPARED]
