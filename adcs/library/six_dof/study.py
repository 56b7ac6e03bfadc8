"""The study: the paper's theorem on a scenario of ours."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from adcs.library.outcome import Outcome, Progress, Row, Runner, claims_table, verdict
from adcs.library.six_dof.settings import LENGTH_UNIT, MASS, MASS_UNIT, TIME_UNIT, Choices, Scaling
from adcs.library.six_dof.signals import (
    ATTITUDE,
    DELTA_V,
    ERRORS,
    FORCE,
    LABELS,
    POSITION,
    RATE,
    TORQUE,
    VELOCITY,
    Signals,
    panel,
    signals,
)
from adcs.library.six_dof.systems import RECORD, saturated, six_dof
from orchestration.results.plots import Guide
from orchestration.results.report import KeyNumber, Table
from orchestration.results.result import Result
from orchestration.running.method import ModelExchange
from orchestration.running.run import run as run_system
from orchestration.running.save import Save

TITLE = "Orbit and attitude at once, without any velocity measurement: Pan, Wong, Kapila"
SUMMARY = (
    "A spacecraft of 100 kg starts 27 m away from its place on an orbit, and 45 degrees from its attitude. Both are "
    "to follow a reference: the orbit an ellipse, the attitude a swinging motion. Position and attitude are measured, "
    "no velocity is. The paper proves convergence and simulates nothing, so the scenario is ours, and its claims are "
    "set beside what the components compute; with unlimited actuators, with limited ones, and in SI units, as printed."
)
FREE, LIMITED, PRINTED = "scaled units, no limits", "scaled units, limited", "SI units, as printed"
COUPLED: dict[str, Any] = {"method": ModelExchange(rtol=1e-10, atol=1e-9), "save": Save(RECORD)}
"""An absolute tolerance below 1e-9 m asks for more than positions of 7e6 m can hold in double precision."""
OUTPUT_STEP, SHORT_STEP, SHORT_STOP = 0.5, 0.05, 60.0  # s
STEPS = (1.0, 0.5, 0.2, 0.1)  # s, of the exchange
GROUP, CONTROL_GROUP, STEP_GROUP = "Convergence", "Force and torque", "Exchange step"
NEGLIGIBLE = {POSITION: 1e-6, VELOCITY: 1e-8, ATTITUDE: 1e-9, RATE: 1e-10}  # m, m/s, 1, rad/s: converged to zero


def run(
    choices: Choices, progress: Progress, simulate: Callable[..., Result] = run_system
) -> tuple[Outcome, list[tuple[str, Mapping[str, Any]]]]:
    """Run everything; returns the outcome, and label and manifest of each run."""
    runner = Runner(progress, 3 + len(STEPS), simulate)
    grid = {"stop_time": choices.stop_time, "step": OUTPUT_STEP}
    free = runner(FREE, six_dof(), **grid, **COUPLED)
    limited = runner(LIMITED, saturated(choices.max_force, choices.max_torque), **grid, **COUPLED)
    short = {"stop_time": SHORT_STOP, "step": SHORT_STEP}
    printed = runner(PRINTED, six_dof(scaling=Scaling(1.0, 1.0, 1.0)), **short, **COUPLED)
    runs = {label: signals(result, MASS) for label, result in ((FREE, free), (LIMITED, limited), (PRINTED, printed))}
    rows = [*_convergence(runs), *_blind(free), *_errata()]
    both = {label: runs[label] for label in (FREE, LIMITED)}
    panels = [panel(name, both, GROUP) for name in ERRORS]
    limits = {FORCE: choices.max_force * np.sqrt(3), TORQUE: choices.max_torque * np.sqrt(3)}
    panels += [panel(name, both, CONTROL_GROUP, guides=(Guide(limit, "all axes at their limit"),))
               for name, limit in limits.items()]  # fmt: skip
    panels.append(panel(DELTA_V, both, CONTROL_GROUP, log=False))
    tables = [
        claims_table(rows, "The claims of the paper", GROUP),
        _settling_table(runs, choices),
        _effort_table(runs, free),
    ]
    outcome = Outcome(rows, panels, tables, _key_numbers(runs, choices))
    return outcome + _exchange_step(runner, choices, runs[FREE]), runner.runs


def _row(cell: str, settings: str, printed: str, ours: float | str, holds: bool, note: str, table: str = "") -> Row:
    return Row("six-dof", table or "Theorem 4.1", cell, settings, printed, ours, None, verdict(holds), note)


def _convergence(runs: Mapping[str, Signals]) -> list[Row]:
    rows = []
    for label, run_ in runs.items():
        for name in ERRORS:
            note = (
                f"{LABELS[name]} at {run_.time[-1]:g} s, {run_.start(name):.3g} at the start; judged at "
                f"{NEGLIGIBLE[name]:g}"
            )
            if label == LIMITED:
                note += "; the theorem knows no limits, that it converges all the same is an observation"
            end = run_.end(name)
            rows.append(_row(f"{name} converges to zero", label, "asymptotically", end, end < NEGLIGIBLE[name], note))
    return rows


def _blind(free: Result) -> list[Row]:
    """That no velocity reaches filter or controller can be read off the wiring."""
    manifest = free.manifest["system"]["connections"]
    fed = [source for source, target in manifest if target.split(".")[0] in ("filter", "controller")]
    velocities = [source for source in fed if source in ("plant.v_BN_N", "plant.omega_BN_B")]
    return [
        _row(
            "velocity measurements used",
            "connections from the plant to filter and controller",
            "none",
            ", ".join(velocities) or "none",
            not velocities,
            "they receive " + ", ".join(sorted({source for source in fed if source.startswith("plant.")}))
            + "; the rate of the reference is known, not measured",
        )
    ]  # fmt: skip


def _errata() -> list[Row]:
    wrong = (
        ("after (59)", "det T", "e_ζ", "e_ζ / 8", "T = ½(e_ζ I + S(e_ε)), three factors ½; invertible all the same"),
        ("(47)", "k_max", "max{k_eR, k_y}", "min{k_eR, k_y}", "both terms of the bound after (56) must be covered"),
        ("Sec. II", "skew matrix of the vectrices", "misprinted", "[0 -a3 a2; a3 0 -a1; -a2 a1 0]", "as (29) uses it"),
    )
    return [
        Row("six-dof", table, cell, "", printed, ours, None, "wrong in print", f"{note}; see tests/laws")
        for table, cell, printed, ours, note in wrong
    ]


def _settling_table(runs: Mapping[str, Signals], choices: Choices) -> Table:
    parts = (0.1, choices.settled, 1e-4)
    cells = [
        [name, label, run_.start(name), *(run_.settled(name, part) for part in parts)]
        for name in ERRORS
        for label, run_ in runs.items()
    ]
    columns = ["error", "run", "at the start", *(f"below {part:g} of it [s]" for part in parts)]
    return Table("When the errors have converged", columns, cells, "Time from which on the norm stays below.", GROUP)


def _effort_table(runs: Mapping[str, Signals], free: Result) -> Table:
    cells = []
    for label, run_ in runs.items():
        angular = float(np.trapezoid(run_.norms[TORQUE], run_.time))
        cells.append([label, run_.time[-1], run_.peak(FORCE), run_.end(DELTA_V), run_.peak(TORQUE), angular])
    gradient = [float(np.linalg.norm(free[f"plant.gravity_gradient_{x}_B"], axis=1).max()) for x in ("force", "torque")]
    note = (
        "‖F‖ and ‖τ‖ are Euclidean; the velocity increment is the integral of ‖F‖ over the mass, by the actuator "
        "itself. The torque lasts, as the reference attitude swings. The law is applied in units of "
        f"{LENGTH_UNIT:g} m, {TIME_UNIT:g} s and {MASS_UNIT:g} kg; in SI units its built-in time constant is 1 s, and "
        f"27 m take kilonewtons. Gravity on the extent of the body: at most {gradient[0]:.1e} N, {gradient[1]:.1e} N·m."
    )
    columns = ["run", "until [s]", "largest ‖F‖ [N]", "velocity increment [m/s]", "largest ‖τ‖ [N·m]", "∫‖τ‖dt [N·m·s]"]
    return Table("Force, torque and velocity increment", columns, cells, note, CONTROL_GROUP)


def _key_numbers(runs: Mapping[str, Signals], choices: Choices) -> list[KeyNumber]:
    free = runs[FREE]
    part = f"stays below {choices.settled:.0%} of its start"
    return [
        KeyNumber("Position error converged", free.settled(POSITION, choices.settled), "s", part),
        KeyNumber("Attitude error converged", free.settled(ATTITUDE, choices.settled), "s", part),
        KeyNumber("Velocity increment", free.end(DELTA_V), "m/s", f"{runs[LIMITED].end(DELTA_V):.3g} m/s with limits"),
        KeyNumber("Largest force", free.peak(FORCE), "N", f"{runs[PRINTED].peak(FORCE):.4g} N in SI units"),
        KeyNumber("Largest torque", free.peak(TORQUE), "N·m", f"{runs[PRINTED].peak(TORQUE):.3g} N·m in SI units"),
    ]


def _exchange_step(runner: Runner, choices: Choices, coupled: Signals) -> Outcome:
    cells: list[list[object]] = []
    for step in STEPS:
        result = runner(
            f"co-simulation at {step:g} s", six_dof(), stop_time=choices.stop_time, step=step, save=Save(RECORD)
        )
        run_ = signals(result, MASS)
        same = np.isin(run_.time.round(6), coupled.time.round(6))
        there = np.isin(coupled.time.round(6), run_.time.round(6))
        away = [float(np.abs(run_.norms[n][same] - coupled.norms[n][there]).max()) for n in (POSITION, ATTITUDE)]
        cells.append([step, *away, run_.end(DELTA_V)])
    cells.append(["coupled", None, None, coupled.end(DELTA_V)])
    note = (
        "Largest difference of the norms of the errors from the coupled solution. Force and torque are held for a step."
    )
    columns = ["exchange step [s]", "‖e_R‖ [m]", "‖e_ε‖", "velocity increment [m/s]"]
    return Outcome(tables=[Table("Co-simulation", columns, cells, note, STEP_GROUP)])
