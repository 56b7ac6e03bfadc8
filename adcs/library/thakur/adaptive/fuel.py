"""Sec. 3.4.2, Figs. 3.8 to 3.11: fuel loss, under both readings of the reference."""

from __future__ import annotations

from math import hypot

import numpy as np

from adcs.library.outcome import Outcome, Row, Runner, claims_table, verdict
from adcs.library.thakur.adaptive import settings as settings
from adcs.library.thakur.adaptive.appendage import FULL, Runs, convergence_table, estimates, label
from adcs.library.thakur.adaptive.baseline import COMPARISON, OUTPUT_STEP, PROPOSED
from adcs.library.thakur.adaptive.settings import FREQUENCIES, Reading
from adcs.library.thakur.adaptive.signals import (
    ATTITUDE,
    RATE,
    TORQUE,
    Track,
    moments_panel,
    norm_panel,
    row,
    sigma_panel,
    theta_panel,
    track,
)
from adcs.library.thakur.adaptive.systems import RECORD_VARIABLE, comparison_fuel, fuel, fuel_full
from adcs.library.thakur.choices import Choices
from orchestration.results.plots import Guide, Panel, Series
from orchestration.results.report import KeyNumber, Table
from orchestration.running.method import ModelExchange
from orchestration.running.save import Save

GROUP = "3.4.2  Fuel loss"
RUNS = 2 * len(FREQUENCIES) + 1
RECORD_FUEL = (*RECORD_VARIABLE, "plant.fuel_left", "plant.torque_impulse")
RECORD_LAW = (*RECORD_FUEL, "controller.implementability")
EARLY = 60.0  # s, the transient
DECAY_FROM = 100.0  # s, from where the torque's peaks are compared
SIGMA_RADIUS = hypot(settings.FUEL_PROJECTION["sigma_bound"], settings.FUEL_PROJECTION["sigma_margin"])
_MARGIN = "controller.implementability"


def losing_fuel(run: Runner, choices: Choices) -> Outcome:
    """The statements of Sec. 3.4.2 for each reading, and the figures for the printed one."""
    times = {"stop_time": settings.STOP_TIME, "step": OUTPUT_STEP, "method": ModelExchange()}
    rows: list[Row] = []
    read: dict[Reading, Runs] = {}
    record = [*RECORD_LAW, "controller.sigma_est"]
    for reading in FREQUENCIES:
        proposed = run(f"fuel, proposed, {label(reading)}", fuel(reading), save=Save(record), **times)
        other = run(
            f"fuel, comparison, {label(reading)}",
            comparison_fuel(reading),
            save=Save(RECORD_FUEL),
            **times,
        )
        read[reading] = {PROPOSED: track(proposed), COMPARISON: track(other)}
        rows += _errors(read[reading], reading) + _law(read[reading], reading)
    record = [*RECORD_LAW, "controller.J_1_est"]
    full = track(run("fuel, full parametrisation", fuel_full(), save=Save(record), **times))
    for reading, runs in read.items():
        rows += [_bounded(runs[PROPOSED], reading), *_inertia(runs, reading)]
    printed = read["printed"]
    rows += estimates("Sec. 3.4.2", {PROPOSED: printed[PROPOSED], FULL: full}, choices)
    compared = {f"{PROPOSED}, {label(reading)}": runs[PROPOSED] for reading, runs in read.items()}
    tables = [
        claims_table(rows, "The statements of Sec. 3.4.2", GROUP),
        _ends(read),
        convergence_table({**compared, FULL: full}, GROUP),
    ]
    least = float(printed[PROPOSED].extra[_MARGIN].min())
    numbers = [KeyNumber("Fuel loss: least 1 - ‖Ĵ₁Ω‖", least, "", "positive: the law is defined, Eq. (3.39)")]
    return Outcome(rows, _panels(printed, full), tables, numbers)


def _row(cell: str, which: str, printed: float | str, ours: float | str, holds: bool, note: str = "") -> Row:
    return row("Sec. 3.4.2", cell, which, printed, ours, verdict(holds), note)


def _last(run: Track, name: str) -> float:
    return float(run.between(name, settings.STOP_TIME - 60.0, settings.STOP_TIME).max())


def _errors(runs: Runs, reading: Reading) -> list[Row]:
    rows = []
    for name, unit in ((ATTITUDE, ""), (RATE, " [deg/s]")):
        proposed, comparison = (_last(runs[control], name) for control in (PROPOSED, COMPARISON))
        part = proposed / runs[PROPOSED].peak(name)
        cell = f"{name}, largest over the last 60 s / peak"
        note = f"{proposed:.2g}{unit}; judged at 1e-4 of the peak"
        rows.append(_row(cell, f"{PROPOSED}, {label(reading)}", "driven to the origin", part, part < 1e-4, note))
        ratio = comparison / proposed
        cell = f"{name} in the end: ratio of the largest over the last 60 s"
        note = f"{comparison:.2g} and {proposed:.2g}{unit}; judged at 10"
        text = f"{COMPARISON} / {PROPOSED}, {label(reading)}"
        rows.append(_row(cell, text, "appreciable loss of accuracy", ratio, ratio > 10, note))
    return rows


def _law(runs: Runs, reading: Reading) -> list[Row]:
    proposed, comparison = runs[PROPOSED], runs[COMPARISON]
    least = float(proposed.extra[_MARGIN].min())
    text = f"{PROPOSED}, {label(reading)}"
    note = "1 - ‖Ĵ₁Ω‖ must be positive, (3.39)"
    rows = [_row("least implementability of the law", text, "well-defined throughout", least, least > 0, note)]
    peaks = [float(run.between(TORQUE, 0.0, EARLY).max()) for run in (proposed, comparison)]
    ratio = peaks[0] / peaks[1]
    cell = "control torque in the transient: ratio of the peaks"
    note = f"{peaks[0]:.3g} and {peaks[1]:.3g} N.m; judged at a factor of 1.5"
    text = f"{PROPOSED} / {COMPARISON}, {label(reading)}"
    rows.append(_row(cell, text, "comparable", ratio, 1 / 1.5 < ratio < 1.5, note))
    for control, run in runs.items():
        tops = torque_peaks(run, np.pi / FREQUENCIES[reading])
        falling = bool(np.all(np.diff(tops) < 0))
        cell = f"peaks of the control torque from {DECAY_FROM:g} s on [N.m]"
        note = f"{len(tops)} peaks, one in each half period of the reference"
        ours = f"{tops[0]:.4g} to {tops[-1]:.4g}, {'each below the one before' if falling else 'not all falling'}"
        rows.append(_row(cell, f"{control}, {label(reading)}", "monotonic decay", ours, falling, note))
    return rows


def torque_peaks(run: Track, half_period: float) -> np.ndarray:
    """Largest torque in each half period of the reference from `DECAY_FROM` to the end [N.m]."""
    starts = np.arange(DECAY_FROM, settings.STOP_TIME - half_period, half_period)
    return np.array([run.between(TORQUE, start, start + half_period).max() for start in starts])


def _bounded(run: Track, reading: Reading) -> Row:
    largest = float(np.linalg.norm(run.sigma, axis=1).max())
    cell = "‖Ĵ₁‖ by its elements, largest [kg.m2/(N.m.s)]"
    note = f"sqrt(ε2 + δ2) = {SIGMA_RADIUS:.6f} is reached and not passed"
    holds = largest <= SIGMA_RADIUS * (1 + 1e-6)
    return _row(cell, f"{PROPOSED}, {label(reading)}", "bounded by 0.0113", largest, holds, note)


def _inertia(runs: Runs, reading: Reading) -> list[Row]:
    rows = []
    for control, run in runs.items():
        least, margin = float(run.moments.min()), run.triangle_margin()
        cell = "inertia positive definite and within (3.5), Fig. 3.11"
        spent = float(run.extra["plant.torque_impulse"][-1])
        note = (
            f"least principal moment {least:.3g}, least margin {margin:.2g} kg.m2, at an impulse of {spent:.0f} N.m.s"
        )
        holds = least > 0 and margin > 0
        text = f"{control}, {label(reading)}"
        rows.append(_row(cell, text, "throughout", "throughout" if holds else "not to the end", holds, note))
    return rows


def _ends(read: dict[Reading, Runs]) -> Table:
    cells = []
    for reading, runs in read.items():
        for control, run in runs.items():
            moments = ", ".join(f"{m:.4g}" for m in run.moments[-1])
            spent = float(run.extra["plant.torque_impulse"][-1])
            left = float(run.extra["plant.fuel_left"][-1])
            errors = [_last(run, ATTITUDE), _last(run, RATE)]
            cells.append([label(reading), control, *errors, spent, left, moments, run.triangle_margin()])
    columns = [
        "reference",
        "control",
        "attitude error",
        "rate error [deg/s]",
        "impulse [N.m.s]",
        "fuel left [N.m.s]",
        "principal moments [kg.m2]",
        "margin of (3.5) [kg.m2]",
    ]
    note = "Errors: largest over the last 60 s. Everything else at 400 s, the margin the least of the run."
    return Table("At the end", columns, cells, note, GROUP)


def _panels(runs: Runs, full: Track) -> list[Panel]:
    proposed = runs[PROPOSED]
    size = Series("‖Ĵ₁‖", proposed.time, np.linalg.norm(proposed.sigma, axis=1))
    guide = Guide(SIGMA_RADIUS, "sqrt(ε2 + δ2)")
    labels = ("J₁ 11", "J₁ 22", "J₁ 33")
    return [
        norm_panel(RATE, runs, "Fig. 3.8  Rate tracking error", GROUP),
        norm_panel(ATTITUDE, runs, "Fig. 3.8  Attitude tracking error", GROUP),
        norm_panel(TORQUE, runs, "Fig. 3.9a  Control torque", GROUP, log=False),
        norm_panel(TORQUE, runs, "Fig. 3.9b  Control torque, transient", GROUP, log=False, until=30.0),
        theta_panel(proposed, "Fig. 3.10a  Estimate of J_0", GROUP),
        sigma_panel(proposed, labels, "s", "Fig. 3.10b  Estimate of J_1: its diagonal", GROUP),
        moments_panel(runs, "Fig. 3.11  Principal moments of inertia", GROUP),
        Panel("Norm of the estimate of J_1", "‖Ĵ₁‖ [s]", [size], guides=[guide], group=GROUP),
        sigma_panel(full, (), "s", "Estimate of J_1, full parametrisation: 9 elements", GROUP),
        Panel(
            "Implementability of the law: ‖Ĵ₁Ω‖ must be below 1",
            "‖Ĵ₁Ω‖",
            [Series("", proposed.time, 1 - proposed.extra[_MARGIN])],
            group=GROUP,
        ),
    ]
