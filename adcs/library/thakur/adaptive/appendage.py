"""Sec. 3.4.1, Figs. 3.4 to 3.7: moving appendages, under both readings of the reference."""

from __future__ import annotations

import numpy as np

from adcs.library.outcome import Outcome, Row, Runner, claims_table, verdict
from adcs.library.thakur.adaptive import settings as settings
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
from adcs.library.thakur.adaptive.systems import RECORD_VARIABLE, appendage, appendage_full, comparison_appendage
from adcs.library.thakur.choices import Choices
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber, Table
from orchestration.running.method import ModelExchange
from orchestration.running.save import Save

GROUP = "3.4.1  Deployable appendage"
FULL = "proposed, full parametrisation"
RUNS = 2 * len(FREQUENCIES) + 1
EARLY, LATE = 60.0, 200.0  # s: the transient is over, and the steady state is from here on
LAST = 60.0  # s at the end, three periods of the printed reference
SATURATED = {RATE: 0.5, ATTITUDE: 1e-3}  # deg/s and 1, near which the comparison law is said to stay
REACHED = {RATE: 1e-3, ATTITUDE: 1e-4}  # deg/s and 1, below which the proposed law is said to come within 400 s

Runs = dict[str, Track]


def moving_appendages(run: Runner, choices: Choices) -> Outcome:
    """The statements of Sec. 3.4.1 for each reading, and the figures for the printed one."""
    record = [*RECORD_VARIABLE, "controller.mass_est"]
    coupled = {"stop_time": settings.STOP_TIME, "step": OUTPUT_STEP, "method": ModelExchange()}
    rows: list[Row] = []
    read: dict[Reading, Runs] = {}
    for reading in FREQUENCIES:
        proposed = run(f"appendage, proposed, {label(reading)}", appendage(reading), save=Save(record), **coupled)
        other = run(
            f"appendage, comparison, {label(reading)}",
            comparison_appendage(reading),
            save=Save(RECORD_VARIABLE),
            **coupled,
        )
        read[reading] = {PROPOSED: track(proposed), COMPARISON: track(other)}
        rows += _errors(read[reading], reading, choices) + _effort(read[reading], reading)
    full = track(
        run(
            "appendage, full parametrisation",
            appendage_full(),
            save=Save([*RECORD_VARIABLE, "controller.J_1_est"]),
            **coupled,
        )
    )
    printed = read["printed"]
    rows += [*_inertia(printed[PROPOSED]), *estimates("Sec. 3.4.1", {PROPOSED: printed[PROPOSED], FULL: full}, choices)]
    tables = [
        claims_table(rows, "The statements of Sec. 3.4.1", GROUP),
        _levels(read),
        convergence_table(
            {**{f"{PROPOSED}, {label(reading)}": runs[PROPOSED] for reading, runs in read.items()}, FULL: full}, GROUP
        ),
    ]
    end = printed[PROPOSED].end(RATE)
    numbers = [KeyNumber("Appendage: rate error at 400 s", end, "deg/s", "printed: below 0.001 deg/s")]
    return Outcome(rows, _panels(printed, full), tables, numbers)


def label(reading: Reading) -> str:
    """How a reading is named in tables."""
    return f"ω₁ = {FREQUENCIES[reading]:g} rad/s"


def _errors(runs: Runs, reading: Reading, choices: Choices) -> list[Row]:
    proposed, comparison = runs[PROPOSED], runs[COMPARISON]
    rows = []
    for name, limit in REACHED.items():
        end, largest = proposed.end(name), float(proposed.between(name, *_last()).max())
        note = f"it oscillates: over the last {LAST:g} s it is between {_least(proposed, name):.2g} and {largest:.2g}"
        text = f"{PROPOSED}, {label(reading)}"
        printed = f"below {limit:g} within 400 s"
        rows.append(row("Sec. 3.4.1", f"{name} at 400 s{_unit(name)}", text, printed, end, verdict(end < limit), note))
        cell = f"{name}, largest over the last {LAST:g} s{_unit(name)}"
        note = "the stricter reading of the same sentence: that it stays below"
        rows.append(row("Sec. 3.4.1", cell, text, printed, largest, verdict(largest < limit), note))
    for name, level in SATURATED.items():
        mean = _rms(comparison, name)
        note = (
            f"root mean square over the last {LAST:g} s, where it is between {_least(comparison, name):.2g} and "
            f"{comparison.between(name, *_last()).max():.2g}; judged at a factor of {choices.marginal:g}"
        )
        near = level / choices.marginal <= mean <= level * choices.marginal
        text = f"{COMPARISON}, {label(reading)}"
        cell = f"{name} saturates{_unit(name)}"
        rows.append(row("Sec. 3.4.1", cell, text, f"around {level:g}", mean, verdict(near), note))
        ratio = mean / _rms(proposed, name)
        cell = f"{name} in the end: ratio"
        note = "of the root mean squares; judged at 10"
        text = f"{COMPARISON} / {PROPOSED}, {label(reading)}"
        printed = "significantly diminished convergence"
        rows.append(row("Sec. 3.4.1", cell, text, printed, ratio, verdict(ratio > 10), note))
    return rows


def _effort(runs: Runs, reading: Reading) -> list[Row]:
    proposed, comparison = runs[PROPOSED], runs[COMPARISON]
    peaks = [run.between(TORQUE, 0.0, EARLY).max() for run in (proposed, comparison)]
    ratio = float(peaks[0] / peaks[1])
    text = f"{PROPOSED} / {COMPARISON}, {label(reading)}"
    note = f"{peaks[0]:.4g} and {peaks[1]:.4g} N.m in the first {EARLY:g} s"
    cell = "overshoot of the control torque: ratio of the peaks"
    rows = [row("Sec. 3.4.1", cell, text, "slightly higher (> 1)", ratio, verdict(ratio > 1), note)]
    efforts = [run.area(TORQUE, LATE, settings.STOP_TIME) for run in (comparison, proposed)]
    share = efforts[0] / efforts[1]
    cell = "control torque in steady state: ratio of the integrals"
    text = f"{COMPARISON} / {PROPOSED}, {label(reading)}"
    note = f"{efforts[0]:.5g} and {efforts[1]:.5g} N.m.s from {LATE:g} to 400 s"
    return [*rows, row("Sec. 3.4.1", cell, text, "higher (> 1)", share, verdict(share > 1), note)]


def _inertia(run: Track) -> list[Row]:
    least, margin = float(run.moments.min()), run.triangle_margin()
    note = f"least principal moment {least:.3g}, least margin of (3.5) {margin:.3g} kg.m2"
    result = verdict(least > 0 and margin > 0)
    cell = "inertia positive definite and within (3.5), Fig. 3.4"
    return [row("Sec. 3.4.1", cell, "0 to 400 s", "throughout", "throughout" if margin > 0 else "no", result, note)]


def estimates(section: str, runs: Runs, choices: Choices) -> list[Row]:
    """That sigma converges to the true values and theta does not."""
    rows = []
    for name, run in runs.items():
        error = run.sigma_error()
        middle = error[run.at(run.time[-1] / 2)]
        holds = bool(error[-1] < choices.estimated and error[-1] < middle)
        note = (
            f"{run.sigma.shape[1]} parameters: {middle:.1%} of the true norm at half time; judged at "
            f"{choices.estimated:.0%} and falling"
        )
        ours = f"{error[-1]:.1%} off"
        cell = "J_1 estimate converges to the true value"
        rows.append(row(section, cell, name, "to their true values", ours, verdict(holds), note))
    run = runs[PROPOSED]
    off = run.theta_error()
    share = float(off[-1] / off[0])
    note = f"‖θ̂ - θ‖ from {off[0]:.3g} to {off[-1]:.3g} kg.m2; judged at {choices.estimated:.0%} of the start"
    cell = "J_0 estimate: error at the end / at the start"
    rows.append(row(section, cell, PROPOSED, "does not converge", share, verdict(share > choices.estimated), note))
    return rows


def convergence_table(runs: Runs, group: str) -> Table:
    """Errors of both estimates over time."""
    times = (0.0, 50.0, 100.0, 200.0, 300.0, 400.0)
    cells: list[list[object]] = []
    for name, run in runs.items():
        shown = [t for t in times if t <= run.time[-1] + 1e-9]
        cells.append([name, "Ĵ₁ [%]", *(100 * run.sigma_error()[run.at(t)] for t in shown)])
        cells.append([name, "θ̂ [kg·m²]", *(run.theta_error()[run.at(t)] for t in shown)])
    note = (
        "Norm of the estimation error: of J_1 as a part of the true norm, of J_0 in kg m². The few parameters of the "
        "minimal parametrisation approach the true ones; those of the full one come to rest elsewhere, since many J_1 "
        "give the same torque along one trajectory."
    )
    return Table("Estimates", ["law", "error", *(f"{t:g} s" for t in times)], cells, note, group)


def _levels(read: dict[Reading, Runs]) -> Table:
    cells = []
    for reading, runs in read.items():
        for control, run in runs.items():
            for name in (ATTITUDE, RATE):
                levels = [_least(run, name), _rms(run, name), float(run.between(name, *_last()).max())]
                cells.append([label(reading), control, name + _unit(name), run.peak(name), *levels, run.end(name)])
    columns = ["reference", "control", "error", "peak", "least", "root mean square", "largest", "at 400 s"]
    note = f"Least, root mean square and largest over the last {LAST:g} s."
    return Table("Errors at the end", columns, cells, note, GROUP)


def _panels(runs: Runs, full: Track) -> list[Panel]:
    three = {**runs, FULL: full}
    labels = ("m₁", "m₂")
    return [
        moments_panel({"": runs[PROPOSED]}, "Fig. 3.4  Principal moments of inertia", GROUP),
        norm_panel(RATE, runs, "Fig. 3.5a  Rate tracking error", GROUP),
        norm_panel(ATTITUDE, runs, "Fig. 3.5b  Attitude tracking error", GROUP),
        norm_panel(TORQUE, runs, "Fig. 3.6a  Control torque", GROUP, log=False),
        norm_panel(TORQUE, runs, "Fig. 3.6b  Control torque, transient", GROUP, log=False, until=30.0),
        theta_panel(runs[PROPOSED], "Fig. 3.7a  Estimate of J_0", GROUP),
        sigma_panel(runs[PROPOSED], labels, "kg", "Fig. 3.7b  Estimate of J_1: the masses", GROUP),
        sigma_panel(full, (), "kg", "Estimate of J_1, full parametrisation: 18 elements", GROUP),
        norm_panel(ATTITUDE, three, "Attitude tracking error, both parametrisations", GROUP),
    ]


def _last() -> tuple[float, float]:
    return settings.STOP_TIME - LAST, settings.STOP_TIME


def _least(run: Track, name: str) -> float:
    return float(run.between(name, *_last()).min())


def _rms(run: Track, name: str) -> float:
    return float(np.sqrt(np.mean(run.between(name, *_last()) ** 2)))


def _unit(name: str) -> str:
    return " [deg/s]" if name == RATE else ""
