"""What the exchange step of a co-simulation costs: distance to the coupled solution, its order, and the floor."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from adcs.library import attitude
from adcs.library.outcome import Outcome, Runner
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.observer.noise_free import FULL_STATE, OBSERVER
from adcs.library.thakur.observer.signals import ERRORS, Signals, norm_panel, signals
from adcs.library.thakur.observer.systems import RECORD, RECORD_OBSERVER, full_state_pd, observer_pd
from orchestration.results.plots import Panel, Series
from orchestration.results.report import KeyNumber, Table
from orchestration.results.result import Result
from orchestration.running.method import ModelExchange
from orchestration.running.save import Save
from orchestration.system import System

GROUP = "Co-simulation against the coupled solution"
STEPS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05)  # s
DRAWN = (STEPS[0], 0.01, STEPS[-1])
GRID = 0.1  # s, common multiple of the steps, on which the solutions are compared
FITTED_UP_TO = 0.01  # s
STATES = {
    "plant.q_BN": "q_BN",
    "plant.omega_BN_B": "ω_BN [rad/s]",
    "observer.q_EN": "q_EN",
    "observer.omega_EN_E": "ω_EN [rad/s]",
}
SYSTEMS: dict[str, tuple[Callable[[], System], tuple[str, ...]]] = {
    OBSERVER: (observer_pd, RECORD_OBSERVER),
    FULL_STATE: (full_state_pd, RECORD),
}
RUNS = len(SYSTEMS) * (len(STEPS) + 1)


def exchange_step(run: Runner, choices: Choices) -> Outcome:
    """Both noise-free systems at several exchange steps: the largest difference of the states, and its order."""
    outcome = Outcome()
    floors: list[list[object]] = []
    for label, (build, record) in SYSTEMS.items():
        exact = run(
            f"{label}, coupled",
            build(),
            stop_time=choices.stop_time,
            step=GRID,
            method=ModelExchange(),
            save=Save(record),
        )
        states = [name for name in STATES if name in exact.names]
        distance: dict[str, list[float]] = {name: [] for name in states}
        curves = {"coupled": signals(exact)}
        for step in STEPS:
            result = run(
                f"{label}, co-simulation at {1e3 * step:g} ms",
                build(),
                stop_time=choices.stop_time,
                step=step,
                save=Save(record),
            )
            every = round(GRID / step)
            for name in states:
                distance[name].append(_distance(result, exact, name, every))
            errors = signals(result)
            curves[f"{1e3 * step:g} ms"] = errors.every(every)
            floors.append([label, 1e3 * step, *_floors(errors, choices)])
        floors.append([label, "coupled", *_floors(curves["coupled"], choices)])
        orders = {name: fitted_order(STEPS, values) for name, values in distance.items()}
        outcome += _shown(label, distance, orders, curves)
    columns = ["control", "exchange step [ms]", *ERRORS]
    note = (
        f"Root mean square of the norms from {choices.steady_from:g} s to {choices.stop_time:g} s. The coupled "
        "solution goes on falling; a co-simulation stays at the level that its exchange step sets, because between two "
        "exchanges the torque is held."
    )
    outcome.tables.append(Table("Floor of the errors at the end", columns, floors, note, GROUP))
    return outcome


def fitted_order(steps: tuple[float, ...], errors: list[float]) -> float:
    """Slope of log(error) over log(step), by least squares over the steps up to `FITTED_UP_TO`."""
    used = np.asarray(steps) <= FITTED_UP_TO * (1 + 1e-9)
    return float(np.polyfit(np.log(np.asarray(steps)[used]), np.log(np.asarray(errors)[used]), 1)[0])


def _distance(result: Result, exact: Result, name: str, every: int) -> float:
    difference: NDArray[np.float64] = result[name][::every] - exact[name]
    return float(attitude.norm(difference).max())


def _floors(errors: Signals, choices: Choices) -> list[float | None]:
    end = errors.since(choices.steady_from)
    return [attitude.rms(end.norm(name)) if name in end.vectors else None for name in ERRORS]


def _shown(
    label: str, distance: dict[str, list[float]], orders: dict[str, float], curves: dict[str, Signals]
) -> Outcome:
    milliseconds = [1e3 * step for step in STEPS]
    series = [
        Series(f"{STATES[name]}: order {orders[name]:.3f}", milliseconds, values, markers=True)
        for name, values in distance.items()
    ]
    first = distance["plant.q_BN"][0]
    series.append(
        Series("first order", milliseconds, [0.4 * first * h / milliseconds[0] for h in milliseconds], "dot", color=7)
    )
    panel = Panel(
        f"Distance from the coupled solution, {label}",
        "largest difference over the run",
        series,
        log=True,
        log_x=True,
        x_label="exchange step [ms]",
        note=f"Orders fitted over the steps up to {1e3 * FITTED_UP_TO:g} ms.",
        group=GROUP,
    )
    shown = {key: curves[key] for key in (*(f"{1e3 * step:g} ms" for step in DRAWN), "coupled")}
    floor = norm_panel(ERRORS[0], shown, f"Attitude tracking error and exchange step, {label}", GROUP)
    table = Table(
        f"Largest difference from the coupled solution, {label}",
        ["state", *(f"{h:g} ms" for h in milliseconds), "order"],
        [[STATES[name], *values, f"{orders[name]:.3f}"] for name, values in distance.items()],
        group=GROUP,
    )
    farthest = max(orders.values(), key=lambda order: abs(order - 1))
    numbers = [
        KeyNumber(
            f"Order in the exchange step, {label}",
            f"{farthest:.3f}",
            "",
            "co-simulation against coupled; farthest from 1",
        )
    ]
    return Outcome([], [panel, floor], [table], numbers)
