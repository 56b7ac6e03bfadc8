"""Sec. 5.4.3, Fig. 5.7: the attitude for observer and control law comes from three vectors by QUEST."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from adcs.library.attitude import norm
from adcs.library.exchange import COUPLED, at_steps, distance
from adcs.library.outcome import Claim, Shown
from adcs.library.sections import Section
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.observer.noise_free import OUTPUT_STEP
from adcs.library.thakur.observer.signals import ATTITUDE, ERRORS, RATE, RATE_ESTIMATE, TORQUE, signals
from adcs.library.thakur.observer.systems import observer_pd, quest_observer_pd
from adcs.library.trajectory import component_panel
from orchestration.results.plots import Panel, Series
from orchestration.results.report import KeyNumber, Table
from orchestration.results.result import Result

WHERE = "Sec. 5.4.3"
QUEST, DIRECT = "QUEST", "quaternion"
STEPS = (0.001, 0.01)  # s, exchange steps of co-simulation
STATES = {"plant.q_BN": "q_BN", "plant.omega_BN_B": "ω_BN [rad/s]"}
IDENTICAL = 1e-6  # of the peak; a printed curve shows about a thousandth


def quest(choices: Choices) -> Section:
    """The loop of Fig. 5.1 with QUEST in place of the quaternion: what differs, and whether the sign ever jumps."""
    runs = at_steps({QUEST: quest_observer_pd}, STEPS, OUTPUT_STEP, choices.stop_time)
    runs |= at_steps({DIRECT: observer_pd}, (), OUTPUT_STEP, choices.stop_time)
    return Section(
        "5.4.3  Quaternion by QUEST", "The statements of Sec. 5.4.3", lambda found: _show(found, choices), runs
    )


def _show(found: Mapping[tuple[str, float], Result], choices: Choices) -> Iterator[Shown]:
    with_quest = found[QUEST, COUPLED]
    run, direct = signals(with_quest), signals(found[DIRECT, COUPLED])
    for what in (*ERRORS, TORQUE):
        peak = direct.peak(what)
        part = float(norm(run[what] - direct[what]).max() / peak)
        yield Claim(WHERE, f"{what}: largest difference / peak", "QUEST against the quaternion itself",
                    "virtually identical", part, part <= IDENTICAL,
                    f"peak {peak:.3g}{what.in_unit}; judged at {IDENTICAL:g}")  # fmt: skip
    yield KeyNumber("Torque, QUEST against quaternion", part, "", "of the peak")
    estimate, true = with_quest["quest.q_BN_est"], with_quest["plant.q_BN"]
    jump, turned = (float(norm(np.diff(q, axis=0)).max()) for q in (estimate, true))
    yield Claim(WHERE, f"largest change of the estimate in {OUTPUT_STEP:g} s", "over the whole run",
                "no sign jumps", jump, jump < 2 * turned,
                f"the true quaternion changes by {turned:.3g}; a jump of sign would be 2. Its scalar part goes from "
                f"{true[0, 0]:.3g} to {true[:, 0].min():.3g}, so a sign fixed once would jump")  # fmt: skip
    shown = {"": run.until(choices.shown)}
    for what in (ATTITUDE, RATE, RATE_ESTIMATE, TORQUE):
        yield component_panel(what, shown, f"Fig. 5.7  {what.title}")
    scalars = [Series("QUEST", run.time, estimate[:, 0]), Series("true", run.time, true[:, 0], dash="dash")]
    yield Panel("Scalar part of the estimated quaternion", "q₀", scalars)
    yield _steps(found)


def _steps(found: Mapping[tuple[str, float], Result]) -> Table:
    """Co-simulation of the QUEST loop against the coupled solution without QUEST."""
    exact = found[DIRECT, COUPLED]
    rows = [[1e3 * step, *(distance(found[QUEST, step], exact, name) for name in STATES)] for step in STEPS]
    note = "Largest difference from the coupled solution. QUEST itself adds nothing to it: it has no state."
    return Table("Co-simulation of the QUEST loop", ["exchange step [ms]", *STATES.values()], rows, note)
