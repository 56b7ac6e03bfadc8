"""What the exchange step of a co-simulation costs: distance to the coupled solution, its order, and the floor."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from adcs.library.exchange import COUPLED, at_steps, distance
from adcs.library.outcome import Shown
from adcs.library.sections import Section
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.observer.noise_free import FULL_STATE, OBSERVER
from adcs.library.thakur.observer.signals import ATTITUDE, ERRORS, signals
from adcs.library.thakur.observer.systems import full_state_pd, observer_pd
from adcs.library.trajectory import Trajectory, norm_panel
from orchestration.results.plots import Panel, Series
from orchestration.results.report import KeyNumber, Table
from orchestration.results.result import Result
from orchestration.system import System

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
SYSTEMS: dict[str, Callable[[], System]] = {OBSERVER: observer_pd, FULL_STATE: full_state_pd}

Ladder = Mapping[tuple[str, float], Result]


def exchange_step(choices: Choices) -> Section:
    """Both noise-free systems at several exchange steps: the largest difference of the states, and its order."""
    runs = at_steps(SYSTEMS, STEPS, GRID, choices.stop_time)

    def show(found: Ladder) -> Iterator[Shown]:
        for label in SYSTEMS:
            yield from _shown(label, found)
        yield _floors(found, choices)

    return Section("Co-simulation against the coupled solution", "", show, runs)


def fitted_order(steps: Sequence[float], errors: Sequence[float]) -> float:
    """Slope of log(error) over log(step), by least squares over the steps up to `FITTED_UP_TO`."""
    used = np.asarray(steps) <= FITTED_UP_TO * (1 + 1e-9)
    return float(np.polyfit(np.log(np.asarray(steps)[used]), np.log(np.asarray(errors)[used]), 1)[0])


def _floors(found: Ladder, choices: Choices) -> Table:
    def levels(run: Trajectory) -> list[float | None]:
        end = run.after(choices.steady_from)
        return [end.rms(error) if error in end else None for error in ERRORS]

    rows = [
        [label, 1e3 * step if step else "coupled", *levels(signals(found[label, step]))]
        for label in SYSTEMS
        for step in (*STEPS, COUPLED)
    ]
    columns = ["control", "exchange step [ms]", *(error.name for error in ERRORS)]
    note = (
        f"Root mean square of the norms from {choices.steady_from:g} s to {choices.stop_time:g} s. The coupled "
        "solution goes on falling; a co-simulation stays at the level that its exchange step sets, because between two "
        "exchanges the torque is held."
    )
    return Table("Floor of the errors at the end", columns, rows, note)


def _shown(label: str, found: Ladder) -> Iterator[Shown]:
    exact, milliseconds = found[label, COUPLED], [1e3 * step for step in STEPS]
    off = {
        name: [distance(found[label, step], exact, name) for step in STEPS] for name in STATES if name in exact.names
    }
    orders = {name: fitted_order(STEPS, values) for name, values in off.items()}
    series = [
        Series(f"{STATES[name]}: order {orders[name]:.3f}", milliseconds, values, markers=True)
        for name, values in off.items()
    ]
    line = [0.4 * off["plant.q_BN"][0] * h / milliseconds[0] for h in milliseconds]
    yield Panel(
        f"Distance from the coupled solution, {label}",
        "largest difference over the run",
        [*series, Series("first order", milliseconds, line, "dot", color=7)],
        log=True,
        log_x=True,
        x_label="exchange step [ms]",
        note=f"Orders fitted over the steps up to {1e3 * FITTED_UP_TO:g} ms.",
    )
    drawn = {f"{1e3 * step:g} ms" if step else "coupled": signals(found[label, step]) for step in (*DRAWN, COUPLED)}
    floor = norm_panel(ATTITUDE, drawn, f"Attitude tracking error and exchange step, {label}")
    rows = [[STATES[name], *values, f"{orders[name]:.3f}"] for name, values in off.items()]
    columns = ["state", *(f"{h:g} ms" for h in milliseconds), "order"]
    yield Table(f"Largest difference from the coupled solution, {label}", columns, rows)
    farthest, note = max(orders.values(), key=lambda order: abs(order - 1)), "co-simulation against coupled; "
    yield KeyNumber(f"Order in the exchange step, {label}", f"{farthest:.3f}", "", f"{note}farthest from 1")
    yield floor
