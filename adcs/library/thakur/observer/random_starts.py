"""Sec. 5.4.2, Figs. 5.5 and 5.6: random initial conditions with the noise of the small cone."""

from __future__ import annotations

from collections.abc import Iterator
from math import radians

import numpy as np

from adcs.library.outcome import Shown
from adcs.library.sections import Section, Simulation
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.observer.noise import COUPLED, OUTPUT_STEP, SMALL, WHERE
from adcs.library.thakur.observer.settings import Start
from adcs.library.thakur.observer.signals import ATTITUDE, ERRORS, ESTIMATION, TORQUE, TRACKING, signals
from adcs.library.thakur.observer.systems import observer_pd
from adcs.library.thakur.sequences import residual_set, stays_small, steady
from adcs.library.trajectory import Runs, norm_panel
from orchestration.results.report import KeyNumber, Table

FIGURES = {**dict.fromkeys(TRACKING, "5.5"), **dict.fromkeys((*ESTIMATION, TORQUE), "5.6")}


def random_starts(choices: Choices) -> Section:
    """The observer-based loop from random attitudes, rates and rate estimates: bounded, and how large in the end."""
    starts = {f"run {i + 1}": start for i, start in enumerate(draw_starts(choices))}
    runs = {}
    for i, (name, start) in enumerate(starts.items()):
        label, system = f"random start {i + 1} of {len(starts)}", observer_pd(start, **_noise(choices, i))  # type: ignore[arg-type]
        runs[name] = Simulation(label, system, signals, choices.stop_time, OUTPUT_STEP, COUPLED)

    def show(found: Runs) -> Iterator[Shown]:
        late, part, every = choices.steady_from, choices.settled, list(found.values())
        for error in ERRORS:
            yield residual_set(WHERE, f"{error} converges to a bounded residual set", SMALL, error, every, late, part)
        bounded = sum(all(stays_small(run, error, late, part) for error in ERRORS) for run in every)
        note = f"noise of {SMALL:g} deg"
        yield KeyNumber("Random starts bounded", f"{bounded} of {len(every)}", "", note)
        for what, figure in FIGURES.items():
            yield norm_panel(what, found, f"Fig. {figure}  {what.title}", log=what is not TORQUE, faint=True)
        yield _statistics(found, choices)
        yield _starts(starts, found, choices)

    return Section("5.4.2  Random initial conditions", "The statement on random initial conditions", show, runs)


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


def _statistics(runs: Runs, choices: Choices) -> Table:
    rows = []
    for error in ERRORS:
        values = np.array([steady([run], choices.steady_from)[error] for run in runs.values()])
        largest = max(run.after(choices.steady_from).peak(error) for run in runs.values())
        numbers = [float(f(values)) for f in (np.min, np.median, np.mean, np.max)]
        rows.append([error.name + error.in_unit, *numbers, largest])
    note = (
        f"Over the root mean squares of each run from {choices.steady_from:g} to {choices.stop_time:g} s; "
        "last, the largest single value."
    )
    columns = ["error", "min", "median", "mean", "max", "largest value"]
    return Table("Steady-state errors over the random starts", columns, rows, note)


def _starts(starts: dict[str, Start], runs: Runs, choices: Choices) -> Table:
    rows = []
    for i, (name, start) in enumerate(starts.items()):
        run, vectors = runs[name], (start.q_BN, start.omega_BN_B, start.omega_EN_E)
        texts = [", ".join(f"{x:.3f}" for x in vector) for vector in vectors]
        rows.append([i + 1, *texts, run.peak(ATTITUDE), run.settled(ATTITUDE, choices.settled)])
    note = (
        f"Our choice: q(0) uniform over all rotations, ω(0) and ω̂(0) uniform within ±{choices.start_rate:g} rad/s per "
        f"axis, seed {choices.start_seed}; q̂(0) = q(0). The noise of run i has seed "
        f"{choices.seed + choices.draws - 1} + i."
    )
    columns = ["run", "q(0)", "ω(0) [rad/s]", "ω̂(0) [rad/s]", "peak attitude error", "converged after [s]"]
    return Table("The random starts", columns, rows, note)
