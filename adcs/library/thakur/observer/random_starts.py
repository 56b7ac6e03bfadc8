"""Sec. 5.4.2, Figs. 5.5 and 5.6: random initial conditions with the noise of the small cone."""

from __future__ import annotations

from math import radians

import numpy as np

from adcs.library.outcome import Outcome, Row, Runner, claims_table, verdict
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.observer.noise import COUPLED, OUTPUT_STEP, SMALL, steady_values
from adcs.library.thakur.observer.settings import Start
from adcs.library.thakur.observer.signals import ATTITUDE, ERRORS, RATE, SYMBOLS, TORQUE, Signals, signals
from adcs.library.thakur.observer.systems import RECORD_OBSERVER, observer_pd
from orchestration.results.plots import Panel, Series
from orchestration.results.report import KeyNumber, Table
from orchestration.running.save import Save

GROUP = "5.4.2  Random initial conditions"
FIGURES = dict(zip((ATTITUDE, RATE, *ERRORS[2:], TORQUE), ("5.5", "5.5", "5.6", "5.6", "5.6"), strict=True))


def random_starts(run: Runner, choices: Choices) -> Outcome:
    """The observer-based loop from random attitudes, rates and rate estimates: bounded, and how large in the end."""
    settings = {**COUPLED, "stop_time": choices.stop_time, "step": OUTPUT_STEP, "save": Save(RECORD_OBSERVER)}
    starts = draw_starts(choices)
    runs = [
        signals(run(f"random start {i + 1} of {len(starts)}", observer_pd(start, **_noise(choices, i)), **settings))  # type: ignore[arg-type]
        for i, start in enumerate(starts)
    ]
    rows = [_row(name, runs, choices) for name in ERRORS]
    bounded = sum(all(_is_bounded(run_, name, choices) for name in ERRORS) for run_ in runs)
    numbers = [KeyNumber("Random starts bounded", f"{bounded} of {len(runs)}", "", f"noise of {SMALL:g} deg")]
    tables = [
        claims_table(rows, "The statement on random initial conditions", GROUP),
        _statistics(runs, choices),
        _starts(starts, runs, choices),
    ]
    return Outcome(rows, [_panel(name, runs) for name in FIGURES], tables, numbers)


def draw_starts(choices: Choices) -> list[Start]:
    """Attitudes uniform over all rotations; rates and, independently, their estimates uniform within a cube."""
    random = np.random.default_rng(choices.start_seed)
    starts = []
    for _ in range(choices.starts):
        q = random.normal(size=4)
        q *= np.copysign(1 / np.linalg.norm(q), q[0])
        omega, estimate = random.uniform(-choices.start_rate, choices.start_rate, (2, 3))
        starts.append(Start(tuple(q.tolist()), tuple(omega.tolist()), tuple(estimate.tolist())))
    return starts


def _noise(choices: Choices, index: int) -> dict[str, float | int]:
    seed = choices.seed + choices.draws + index  # other noise than in the runs from the start of the text
    return {"half_angle": radians(SMALL), "redraw_period": choices.redraw_period, "seed": seed}


def _is_bounded(run: Signals, name: str, choices: Choices) -> bool:
    """In steady state the error stays below the part of its peak that counts as converged."""
    return run.since(choices.steady_from).peak(name) <= choices.settled * run.peak(name)


def _row(name: str, runs: list[Signals], choices: Choices) -> Row:
    bounded = sum(_is_bounded(run, name, choices) for run in runs)
    worst = max(run.since(choices.steady_from).peak(name) for run in runs)
    return Row(
        "thakur",
        "Sec. 5.4.2",
        f"{name} converges to a bounded residual set",
        f"{len(runs)} random starts, {SMALL:g} deg",
        "all",
        f"{bounded} of {len(runs)}",
        None,
        verdict(bounded == len(runs)),
        f"after {choices.steady_from:g} s below {choices.settled:g} of the run's own peak; never above {worst:.2g}",
    )


def _statistics(runs: list[Signals], choices: Choices) -> Table:
    rows = []
    for name in ERRORS:
        values = np.array([steady_values([run], choices)[name] for run in runs])
        largest = max(run.since(choices.steady_from).peak(name) for run in runs)
        rows.append(
            [name + SYMBOLS[name][1], *(float(f(values)) for f in (np.min, np.median, np.mean, np.max)), largest]
        )
    note = (
        f"Over the root mean squares of each run from {choices.steady_from:g} to {choices.stop_time:g} s; "
        "last, the largest single value."
    )
    return Table(
        "Steady-state errors over the random starts",
        ["error", "min", "median", "mean", "max", "largest value"],
        rows,
        note,
        GROUP,
    )


def _starts(starts: list[Start], runs: list[Signals], choices: Choices) -> Table:
    rows = []
    for i, (start, run) in enumerate(zip(starts, runs, strict=True)):
        settled = run.settling_time(ATTITUDE, choices.settled)
        vectors = (start.q_BN, start.omega_BN_B, start.omega_EN_E)
        rows.append([i + 1, *(", ".join(f"{x:.3f}" for x in v) for v in vectors), run.peak(ATTITUDE), settled])
    note = (
        f"Our choice: q(0) uniform over all rotations, ω(0) and ω̂(0) uniform within ±{choices.start_rate:g} rad/s per "
        f"axis, seed {choices.start_seed}; q̂(0) = q(0). The noise of run i has seed "
        f"{choices.seed + choices.draws - 1} + i."
    )
    columns = ["run", "q(0)", "ω(0) [rad/s]", "ω̂(0) [rad/s]", "peak attitude error", "converged after [s]"]
    return Table("The random starts", columns, rows, note, GROUP)


def _panel(name: str, runs: list[Signals]) -> Panel:
    symbol, unit = SYMBOLS[name]
    series = [Series(f"run {i + 1}", run.time, run.norm(name), faint=True) for i, run in enumerate(runs)]
    return Panel(
        f"Fig. {FIGURES[name]}  {name.capitalize()}", f"‖{symbol}‖{unit}", series, log=name != TORQUE, group=GROUP
    )
