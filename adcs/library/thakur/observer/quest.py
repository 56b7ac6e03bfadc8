"""Sec. 5.4.3, Fig. 5.7: the attitude for observer and control law comes from three vectors by QUEST."""

from __future__ import annotations

import numpy as np

from adcs.library import attitude
from adcs.library.outcome import Outcome, Row, Runner, claims_table, verdict
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.observer.signals import (
    ATTITUDE,
    ERRORS,
    RATE,
    RATE_ESTIMATE,
    SYMBOLS,
    TORQUE,
    component_panel,
    signals,
)
from adcs.library.thakur.observer.systems import RECORD_OBSERVER, observer_pd, quest_observer_pd
from orchestration.results.plots import Panel, Series
from orchestration.results.report import KeyNumber, Table
from orchestration.results.result import Result
from orchestration.running.method import ModelExchange
from orchestration.running.save import Save

GROUP = "5.4.3  Quaternion by QUEST"
QUEST, DIRECT = "QUEST", "quaternion"
STEP = 0.05  # s, of the coupled solution
STEPS = (0.001, 0.01)  # s, exchange steps of co-simulation
IDENTICAL = 1e-6  # of the peak; a printed curve shows about a thousandth
RUNS = 2 + len(STEPS)


def quest(run: Runner, choices: Choices) -> Outcome:
    """The loop of Fig. 5.1 with QUEST in place of the quaternion: what differs, and whether the sign ever jumps."""
    coupled = {"stop_time": choices.stop_time, "step": STEP, "method": ModelExchange()}
    record = [*RECORD_OBSERVER, "quest.q_BN_est", "quest.observability"]
    with_quest = run("QUEST, coupled", quest_observer_pd(), save=Save(record), **coupled)
    direct = run("quaternion, coupled", observer_pd(), save=Save(RECORD_OBSERVER), **coupled)
    pair = {QUEST: signals(with_quest), DIRECT: signals(direct)}
    rows = []
    for name in (*ERRORS, TORQUE):
        difference = attitude.norm(pair[QUEST].vectors[name] - pair[DIRECT].vectors[name]).max()
        peak = pair[DIRECT].peak(name)
        rows.append(
            _row(
                f"{name}: largest difference / peak",
                "QUEST against the quaternion itself",
                "virtually identical",
                float(difference / peak),
                difference <= IDENTICAL * peak,
                f"peak {peak:.3g}{SYMBOLS[name][1]}; judged at {IDENTICAL:g}",
            )
        )
    q_est, q = with_quest["quest.q_BN_est"], with_quest["plant.q_BN"]
    jump = float(attitude.norm(np.diff(q_est, axis=0)).max())
    turned = float(attitude.norm(np.diff(q, axis=0)).max())
    note = f"the true quaternion changes by {turned:.3g}; a jump of sign would be 2. Its scalar part goes from "
    note += f"{q[0, 0]:.3g} to {q[:, 0].min():.3g}, so a sign fixed once would jump"
    rows.append(
        _row(
            f"largest change of the estimate in {STEP:g} s",
            "over the whole run",
            "no sign jumps",
            jump,
            jump < 2 * turned,
            note,
        )
    )
    shown = {"": pair[QUEST].until(choices.shown)}
    names = (ATTITUDE, RATE, RATE_ESTIMATE, TORQUE)
    panels = [component_panel(name, shown, f"Fig. 5.7  {name.capitalize()}", GROUP) for name in names]
    scalars = [Series("QUEST", with_quest.time, q_est[:, 0]), Series("true", with_quest.time, q[:, 0], dash="dash")]
    panels.append(Panel("Scalar part of the estimated quaternion", "q₀", scalars, group=GROUP))
    tables = [claims_table(rows, "The statements of Sec. 5.4.3", GROUP), _steps(run, direct, choices)]
    return Outcome(
        rows, panels, tables, [KeyNumber("Torque, QUEST against quaternion", rows[4].ours or 0.0, "", "of the peak")]
    )


def _steps(run: Runner, exact: Result, choices: Choices) -> Table:
    """Co-simulation of the QUEST loop against the coupled solution without QUEST."""
    states = {"plant.q_BN": "q_BN", "plant.omega_BN_B": "ω_BN [rad/s]"}
    rows = []
    for step in STEPS:
        result = run(
            f"QUEST, co-simulation at {1e3 * step:g} ms",
            quest_observer_pd(),
            stop_time=choices.stop_time,
            step=step,
            save=Save(list(states)),
        )
        every = round(STEP / step)
        rows.append([1e3 * step, *(float(attitude.norm(result[n][::every] - exact[n]).max()) for n in states)])
    note = "Largest difference from the coupled solution. QUEST itself adds nothing to it: it has no state."
    return Table("Co-simulation of the QUEST loop", ["exchange step [ms]", *states.values()], rows, note, GROUP)


def _row(cell: str, settings: str, printed: str, ours: float, holds: bool, note: str) -> Row:
    return Row("thakur", "Sec. 5.4.3", cell, settings, printed, ours, None, verdict(holds), note)
