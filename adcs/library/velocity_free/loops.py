"""Stabilisation and tracking, Figs. 3 and 4: ideal, and with all uncertainties in several random sequences."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from adcs.library.outcome import Outcome, Row, Runner, claims_table, verdict
from adcs.library.velocity_free import systems
from adcs.library.velocity_free.settings import ERROR_BOUND, TORQUE_BOUND, Choices, Uncertainty
from adcs.library.velocity_free.signals import (
    ATTITUDE,
    DISTURBANCE,
    LABELS,
    MEASUREMENT,
    RATE,
    TORQUE,
    Signals,
    panel,
    signals,
)
from orchestration.results.plots import Guide
from orchestration.results.report import KeyNumber, Table
from orchestration.running.method import ModelExchange
from orchestration.running.save import Save
from orchestration.system import System

OUTPUT_STEP = 0.05  # s
HOLDS = (0.001, 0.01, 0.1, 1.0)  # s
MASSES = (1.0, 7.0)  # kg; 7 kg is a homogeneous cube of 0.2 m side with the moments of (91)
WALK_GROUP, TORQUE_GROUP = "Measurement error", "Disturbance torque"


@dataclass(frozen=True)
class Problem:
    """One of the two problems."""

    name: str
    figure: str
    ideal: Callable[[], System]
    uncertain: Callable[[Uncertainty], System]

    @property
    def group(self) -> str:
        """Heading in the report."""
        return f"Fig. {self.figure}  {self.name.capitalize()}"


PROBLEMS = (
    Problem("stabilisation", "3", systems.stabilisation, systems.uncertain_stabilisation),
    Problem("tracking", "4", systems.tracking, systems.uncertain_tracking),
)


def run_count(choices: Choices) -> int:
    """How many runs the study makes."""
    return len(PROBLEMS) * (1 + choices.seeds) + len(HOLDS) + 2 * len(MASSES)


def uncertainty(choices: Choices, index: int) -> Uncertainty:
    """The `index`-th random sequence."""
    return Uncertainty(choices.hold_time, ERROR_BOUND, choices.seed + index, choices.mass)


def problem(run: Runner, choices: Choices, which: Problem) -> Outcome:
    """One problem: does the ideal loop converge, and do the uncertain ones stay bounded?"""
    result = run(
        f"{which.name}, ideal",
        which.ideal(),
        stop_time=choices.stop_time,
        step=OUTPUT_STEP,
        method=ModelExchange(),
        save=Save(systems.RECORD),
    )
    ideal = signals(result)
    every = max(1, round(OUTPUT_STEP / choices.step))
    uncertain = [
        signals(
            run(
                f"{which.name}, uncertain, seed {choices.seed + i}",
                which.uncertain(uncertainty(choices, i)),
                stop_time=choices.stop_time,
                step=choices.step,
                save=Save(systems.RECORD_UNCERTAIN),
            ),
            every,
        )
        for i in range(choices.seeds)
    ]
    rows = [*_ideal_rows(which, ideal), *_uncertain_rows(which, ideal, uncertain, choices)]
    runs = {"ideal": ideal, **{str(i + 1): run_ for i, run_ in enumerate(uncertain)}}
    note = f"Blue: ideal. Orange: {choices.seeds} random sequences with all uncertainties."
    panels = [
        panel(ATTITUDE, runs, f"Fig. {which.figure}a  Attitude tracking error", which.group, note=note),
        panel(RATE, runs, f"Fig. {which.figure}a  Rate tracking error", which.group, note=note),
        panel(
            MEASUREMENT,
            runs,
            f"Fig. {which.figure}b  Measurement error",
            which.group,
            (Guide(ERROR_BOUND, "μ_v"),),
            log=False,
        ),
        panel(TORQUE, runs, "Control torque", which.group, note=note),
    ]
    worst = max(float(run_.after(choices.steady_from, ATTITUDE).max()) for run_ in uncertain)
    number = KeyNumber(f"{which.name.capitalize()}: attitude error stays below", worst, "", "with all uncertainties")
    tables = [claims_table(rows, f"The statements on {which.name}", which.group), _table(which, uncertain, choices)]
    return Outcome(rows, panels, tables, [number])


def _row(table: str, cell: str, settings: str, printed: str, ours: float | str, holds: bool, note: str) -> Row:
    return Row("velocity-free", table, cell, settings, printed, ours, None, verdict(holds), note)


def _ideal_rows(which: Problem, ideal: Signals) -> list[Row]:
    rows = []
    for name in (ATTITUDE, RATE):
        end, peak = float(ideal.norms[name][-1]), float(ideal.norms[name].max())
        rows.append(
            _row(
                "Sec. IV",
                f"{name} converges to zero without uncertainties",
                which.name,
                "asymptotically",
                end,
                end < 1e-9 * peak,
                f"{LABELS[name]} at {ideal.time[-1]:g} s, peak {peak:.3g}; judged at 1e-9 of the peak",
            )
        )
    return rows


def _uncertain_rows(which: Problem, ideal: Signals, runs: list[Signals], choices: Choices) -> list[Row]:
    rows = []
    start = choices.steady_from
    settings = f"{which.name}, {len(runs)} random sequences"
    for name in (ATTITUDE, RATE):
        peaks = [float(run.after(start, name).max()) for run in runs]
        floors = [float(np.sqrt(np.mean(run.after(start, name) ** 2))) for run in runs]
        bounded = max(peaks) < float(ideal.norms[name].max())
        vanishing = min(floors) < 100 * float(ideal.after(start, name).max())
        rows.append(
            _row(
                f"Fig. {which.figure}",
                f"{name} does not converge to zero but is bounded: largest from {start:g} s on",
                settings,
                "bounded",
                max(peaks),
                bounded and not vanishing,
                f"root mean square {min(floors):.3g} to {max(floors):.3g}; bounded: below the peak of the ideal run, "
                f"{ideal.norms[name].max():.3g}; not zero: more than 100 times the ideal run",
            )
        )
    return rows


def _table(which: Problem, runs: list[Signals], choices: Choices) -> Table:
    cells = []
    for i, run in enumerate(runs):
        steady = [run.after(choices.steady_from, name) for name in (ATTITUDE, RATE)]
        rms = [float(np.sqrt(np.mean(x**2))) for x in steady]
        extremes = [float(run.norms[name].max()) for name in (MEASUREMENT, DISTURBANCE, TORQUE)]
        cells.append([choices.seed + i, rms[0], float(steady[0].max()), rms[1], float(steady[1].max()), *extremes])
    columns = [
        "seed",
        "‖δq_v‖ rms",
        "largest",
        "‖δω‖ rms [rad/s]",
        "largest [rad/s]",
        "largest ‖q̃_v‖",
        "largest ‖d‖ [N·m]",
        "largest ‖u‖ [N·m]",
    ]
    note = f"Errors from {choices.steady_from:g} s to {choices.stop_time:g} s; the last three over the whole run."
    return Table(f"Random sequences, {which.name}", columns, cells, note, which.group)


def measurement_error(run: Runner, choices: Choices) -> Outcome:
    """The error generator by the letter of the text, without the bound mu_v: what it gives depends on the hold."""
    cells: list[list[object]] = []
    largest = {}
    for hold in HOLDS:
        system = System("measurement-error", "The random walk of the measured attitude alone")
        start = Uncertainty(hold, 1.0, choices.seed).tracker | {"q_BN": (1.0, 0.0, 0.0, 0.0)}
        system.add("tracker", "RandomWalkStarTracker", start)
        stop = np.ceil(choices.stop_time)
        result = run(
            f"measurement error, hold {hold:g} s", system, stop_time=stop, step=hold, save=Save(["tracker.q_EB"])
        )
        size = np.linalg.norm(result["tracker.q_EB"][:, 1:], axis=1)
        out = np.flatnonzero(size > ERROR_BOUND)
        largest[hold] = float(size.max())
        expected = 2 * ERROR_BOUND / np.sqrt(12) * np.sqrt(stop * hold)
        cells.append([hold, largest[hold], float(expected), float(result.time[out[0]]) if out.size else None])
    below = [hold for hold, size in largest.items() if size < ERROR_BOUND]
    row = _row(
        "Fig. 3b",
        "measurement error stays below mu_v by itself: largest",
        f"no bound, rate held for {choices.hold_time:g} s",
        f"< {ERROR_BOUND:g}",
        largest.get(choices.hold_time, max(largest.values())),
        largest.get(choices.hold_time, np.inf) < ERROR_BOUND,
        "a random walk: it stays below only for holds of "
        + (", ".join(f"{h:g} s" for h in below) or "none of those tried")
        + "; the runs above keep the bound by reversing draws that would break it",
    )
    columns = ["hold [s]", "largest ‖q̃_v‖", "expected rms at the end", "leaves μ_v at [s]"]
    note = (
        "The random rate is drawn anew after each hold. As the hold goes to 0 so does the error, like its root: the "
        "text's 'at each simulation time' has no limit, and its figure depends on the integrator's step."
    )
    table = Table("The random walk without bound", columns, cells, note, WALK_GROUP)
    return Outcome([row], [], [claims_table([row], "The statement on the measurement error", WALK_GROUP), table])


def disturbance(run: Runner, choices: Choices) -> Outcome:
    """The size of (92) over the run and over one orbit, for the missing mass."""
    rows, cells = [], []
    for mass in MASSES:
        sizes = {}
        for stop, step in ((choices.stop_time, OUTPUT_STEP), (6000.0, 0.05)):
            system = systems.uncertain_stabilisation(Uncertainty(seed=choices.seed, mass=mass))
            result = run(
                f"disturbance, {mass:g} kg, {stop:g} s",
                system,
                stop_time=stop,
                step=step,
                save=Save(["environment.torque_B"]),
            )
            sizes[stop] = float(np.linalg.norm(result["environment.torque_B"], axis=1).max())
        cells.append([mass, *sizes.values()])
        rows.append(
            _row(
                "Sec. V",
                "disturbance torque does not exceed mu_d: largest [N.m]",
                f"stabilisation, {mass:g} kg, {choices.stop_time:g} s",
                f"<= {TORQUE_BOUND:g}",
                sizes[choices.stop_time],
                sizes[choices.stop_time] <= TORQUE_BOUND,
                f"{sizes[6000.0]:.2e} N.m over an orbit; nearly all is the oblateness force at its lever arm, "
                "proportional to the mass, which is missing in print",
            )
        )
    rows.append(
        Row(
            "velocity-free",
            "Eq. (92)",
            "rows of the oblateness bracket",
            "factors of r_i |r|²",
            "3, 3, 3",
            "1, 1, 3",
            None,
            "wrong in print",
            "the gradient of the oblateness potential, checked by complex step",
        )
    )
    rows.append(
        Row(
            "velocity-free",
            "Eqs. (31), (32), (38), (56)-(59)",
            "what the law feeds back",
            "",
            "sigma",
            "its rate",
            None,
            "wrong in print",
            "the dot is lost; with sigma itself the identity of the proof fails at once, see tests/laws",
        )
    )
    columns = ["mass [kg]", f"over {choices.stop_time:g} s [N·m]", "over an orbit [N·m]"]
    table = Table("Largest disturbance torque", columns, cells, group=TORQUE_GROUP)
    return Outcome(
        rows,
        [],
        [claims_table(rows, "The statements on the disturbance, and what is lost in print", TORQUE_GROUP), table],
    )
