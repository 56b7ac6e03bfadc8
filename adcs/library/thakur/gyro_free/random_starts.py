"""Sec. 4.3.2, Figs. 4.5 and 4.6: random attitudes and rates, with the noise of the small cone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import radians

import numpy as np

from adcs.library.outcome import Shown
from adcs.library.sections import Section
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.gyro_free.level import start_value, sufficient_level
from adcs.library.thakur.gyro_free.noise import WHERE, exchanged
from adcs.library.thakur.gyro_free.settings import HALF_ANGLE, Start
from adcs.library.thakur.gyro_free.signals import ANGLE, RATE, TORQUE
from adcs.library.thakur.gyro_free.systems import gyro_free
from adcs.library.thakur.sequences import residual_set
from adcs.library.trajectory import Runs, norm_panel
from orchestration.results.report import Table

FIGURES = {ANGLE: "4.5", RATE: "4.5", TORQUE: "4.6"}


def random_starts(choices: Choices) -> Section:
    """Bounded, and how large in the end."""
    starts = {f"run {i + 1}": start for i, start in enumerate(draw_starts(choices))}
    runs = {}
    for i, (name, start) in enumerate(starts.items()):
        seed = choices.seed + choices.draws + i  # other noise than in the runs from the start of the text
        noise = {"half_angle": radians(HALF_ANGLE), "spread": choices.vector_spread, "seed": seed}
        system = gyro_free(start, redraw_period=choices.redraw_period, **noise)  # type: ignore[arg-type]
        runs[name] = exchanged(f"gyro-free, random start {i + 1} of {len(starts)}", system, choices)

    def show(found: Runs) -> Iterator[Shown]:
        for what in (ANGLE, RATE):
            cell, late = f"{what} remains bounded within a residual set", choices.rest_from
            claim = residual_set(WHERE, cell, HALF_ANGLE, what, list(found.values()), late, choices.settled)
            yield replace(claim, note=f"{claim.note} {what.unit}")
        for what, number in FIGURES.items():
            yield norm_panel(what, found, f"Fig. {number}  {what.title}", faint=True)
        yield _table(starts, found, choices)

    return Section("4.3.2  Random initial conditions", "The statement on random initial conditions", show, runs)


def draw_starts(choices: Choices) -> list[Start]:
    """Attitudes uniform over all rotations, rates uniform within a cube."""
    random = np.random.default_rng(choices.start_seed)
    starts = []
    for _ in range(choices.starts):
        q = random.normal(size=4)
        omega = random.uniform(-choices.rest_rate, choices.rest_rate, 3)
        starts.append(Start(tuple((q / np.linalg.norm(q)).tolist()), tuple(omega.tolist())))
    return starts


def _table(starts: dict[str, Start], runs: Runs, choices: Choices) -> Table:
    levels = [start_value(start) / sufficient_level() for start in starts.values()]
    rows = []
    for i, ((name, start), level) in enumerate(zip(starts.items(), levels, strict=True)):
        run, vectors = runs[name], (start.q_BN, start.omega_BN_B)
        texts = (", ".join(f"{x:.3f}" for x in vector) for vector in vectors)
        rows.append([i + 1, *texts, run.start(ANGLE), level, run.settled(ANGLE, choices.settled)])
    beyond = sum(level >= 1 for level in levels)
    note = (
        f"Our choice: q(0) uniform over all rotations, ω(0) uniform within ±{choices.rest_rate:g} rad/s per axis, seed "
        f"{choices.start_seed}. {beyond} of {len(rows)} start above the level below which convergence is proven "
        "(corrected, see 4.2.3): that condition is sufficient, not necessary."
    )
    columns = ["run", "q(0)", "ω(0) [rad/s]", "initial angle [deg]", "V(0) / sufficient level"]
    return Table("The random starts", [*columns, "angle converged after [s]"], rows, note)
