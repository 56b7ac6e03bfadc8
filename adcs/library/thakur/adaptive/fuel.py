"""Sec. 3.4.2, Figs. 3.8 to 3.11: fuel loss, under both readings of the reference."""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot

import numpy as np

from adcs.library.outcome import Claim, Shown
from adcs.library.sections import Section
from adcs.library.thakur.adaptive import settings as settings
from adcs.library.thakur.adaptive.baseline import ALIKE, COMPARISON, PROPOSED, alike
from adcs.library.thakur.adaptive.readings import (
    FULL,
    LAST,
    Read,
    convergence_table,
    estimates,
    in_both_readings,
    label,
    last,
)
from adcs.library.thakur.adaptive.settings import FREQUENCIES, Reading
from adcs.library.thakur.adaptive.signals import (
    ATTITUDE,
    FUEL_LEFT,
    IMPULSE,
    MARGIN,
    MOMENTS,
    RATE,
    SIGMA_EST,
    TORQUE,
    TRIANGLE,
    moments_panel,
    sigma_panel,
    theta_panel,
)
from adcs.library.thakur.adaptive.systems import comparison_fuel, fuel, fuel_full
from adcs.library.thakur.choices import Choices
from adcs.library.trajectory import Runs, Trajectory, norm_panel
from orchestration.results.plots import Guide, Panel, Series
from orchestration.results.report import KeyNumber, Table

WHERE = "Sec. 3.4.2"
EARLY = 60.0  # s, the transient
DECAY_FROM = 100.0  # s, from where the torque's peaks are compared
SIGMA_RADIUS = hypot(settings.FUEL_PROJECTION["sigma_bound"], settings.FUEL_PROJECTION["sigma_margin"])


def losing_fuel(choices: Choices) -> Section:
    """The statements of Sec. 3.4.2 for each reading, and the figures for the printed one."""
    builds = {PROPOSED: fuel, COMPARISON: comparison_fuel, FULL: fuel_full}

    def show(read: Read, full: Trajectory) -> Iterator[Shown]:
        proposed = read["printed"][PROPOSED]
        for reading, runs in read.items():
            yield from _errors(runs, reading)
            yield from _law(runs, reading)
        for reading, runs in read.items():
            yield _bounded(runs[PROPOSED], reading)
            yield from _inertia(runs, reading)
        yield from estimates(WHERE, proposed, full, choices)
        note = "positive: the law is defined, Eq. (3.39)"
        yield KeyNumber("Fuel loss: least 1 - ‖Ĵ₁Ω‖", proposed.least(MARGIN), "", note)
        yield from _panels(read["printed"], full)
        yield _ends(read)
        yield convergence_table(read, full)

    return in_both_readings("3.4.2  Fuel loss", "fuel", builds, show)


def _errors(runs: Runs, reading: Reading) -> Iterator[Claim]:
    for error in (ATTITUDE, RATE):
        ours, theirs = (last(runs[law]).peak(error) for law in (PROPOSED, COMPARISON))
        part = ours / runs[PROPOSED].peak(error)
        yield Claim(WHERE, f"{error}, largest over the last {LAST:g} s / peak", f"{PROPOSED}, {label(reading)}",
                    "driven to the origin", part, part < 1e-4,
                    f"{ours:.2g}{error.in_unit}; judged at 1e-4 of the peak")  # fmt: skip
        yield Claim(WHERE, f"{error} in the end: ratio of the largest over the last {LAST:g} s",
                    f"{COMPARISON} / {PROPOSED}, {label(reading)}",
                    "appreciable loss of accuracy", theirs / ours, theirs / ours > 10,
                    f"{theirs:.2g} and {ours:.2g}{error.in_unit}; judged at 10")  # fmt: skip


def _law(runs: Runs, reading: Reading) -> Iterator[Claim]:
    least = runs[PROPOSED].least(MARGIN)
    yield Claim(WHERE, "least implementability of the law", f"{PROPOSED}, {label(reading)}",
                "well-defined throughout", least, least > 0,
                "1 - ‖Ĵ₁Ω‖ must be positive, (3.39)")  # fmt: skip
    ours, theirs = (runs[law].until(EARLY).peak(TORQUE) for law in (PROPOSED, COMPARISON))
    yield Claim(WHERE, "control torque in the transient: ratio of the peaks",
                f"{PROPOSED} / {COMPARISON}, {label(reading)}",
                "comparable", ours / theirs, alike(ours / theirs),
                f"{ours:.3g} and {theirs:.3g} N.m; judged at a factor of {ALIKE:g}")  # fmt: skip
    for control, run in runs.items():
        tops = torque_peaks(run, np.pi / FREQUENCIES[reading])
        falling = bool(np.all(np.diff(tops) < 0))
        text = "each below the one before" if falling else "not all falling"
        yield Claim(WHERE, f"peaks of the control torque from {DECAY_FROM:g} s on [N.m]",
                    f"{control}, {label(reading)}",
                    "monotonic decay", f"{tops[0]:.4g} to {tops[-1]:.4g}, {text}", falling,
                    f"{len(tops)} peaks, one in each half period of the reference")  # fmt: skip


def torque_peaks(run: Trajectory, half_period: float) -> np.ndarray:
    """Largest torque in each half period of the reference from `DECAY_FROM` to the end [N.m]."""
    starts = np.arange(DECAY_FROM, settings.STOP_TIME - half_period, half_period)
    return np.array([run.between(start, start + half_period).peak(TORQUE) for start in starts])


def _bounded(run: Trajectory, reading: Reading) -> Claim:
    largest = run.peak(SIGMA_EST)
    return Claim(WHERE, "‖Ĵ₁‖ by its elements, largest [kg.m2/(N.m.s)]", f"{PROPOSED}, {label(reading)}",
                 "bounded by 0.0113", largest, largest <= SIGMA_RADIUS * (1 + 1e-6),
                 f"sqrt(ε2 + δ2) = {SIGMA_RADIUS:.6f} is reached and not passed")  # fmt: skip


def _inertia(runs: Runs, reading: Reading) -> Iterator[Claim]:
    for control, run in runs.items():
        least, margin = float(run[MOMENTS].min()), run.least(TRIANGLE)
        holds = least > 0 and margin > 0
        yield Claim(WHERE, "inertia positive definite and within (3.5), Fig. 3.11", f"{control}, {label(reading)}",
                    "throughout", "throughout" if holds else "not to the end", holds,
                    f"least principal moment {least:.3g}, least margin {margin:.2g} kg.m2, "
                    f"at an impulse of {run.end(IMPULSE):.0f} N.m.s")  # fmt: skip


def _ends(read: Read) -> Table:
    cells = []
    for reading, runs in read.items():
        for control, run in runs.items():
            moments = ", ".join(f"{m:.4g}" for m in run[MOMENTS][-1])
            errors = [last(run).peak(error) for error in (ATTITUDE, RATE)]
            spent = [run.end(IMPULSE), run.end(FUEL_LEFT)]
            cells.append([label(reading), control, *errors, *spent, moments, run.least(TRIANGLE)])
    columns = ["reference", "control", "attitude error", "rate error [deg/s]", "impulse [N.m.s]"]
    columns += ["fuel left [N.m.s]", "principal moments [kg.m2]", "margin of (3.5) [kg.m2]"]
    note = f"Errors: largest over the last {LAST:g} s. Everything else at 400 s, the margin the least of the run."
    return Table("At the end", columns, cells, note)


def _panels(runs: Runs, full: Trajectory) -> list[Panel]:
    proposed, transient = runs[PROPOSED], {law: run.until(30.0) for law, run in runs.items()}
    size = Series("‖Ĵ₁‖", proposed.time, proposed.norm(SIGMA_EST))
    used, guide = Series("", proposed.time, 1 - proposed[MARGIN]), Guide(SIGMA_RADIUS, "sqrt(ε2 + δ2)")
    labels = ("J₁ 11", "J₁ 22", "J₁ 33")
    return [
        norm_panel(RATE, runs, "Fig. 3.8  Rate tracking error"),
        norm_panel(ATTITUDE, runs, "Fig. 3.8  Attitude tracking error"),
        norm_panel(TORQUE, runs, "Fig. 3.9a  Control torque", log=False),
        norm_panel(TORQUE, transient, "Fig. 3.9b  Control torque, transient", log=False),
        theta_panel(proposed, "Fig. 3.10a  Estimate of J_0"),
        sigma_panel(proposed, labels, "s", "Fig. 3.10b  Estimate of J_1: its diagonal"),
        moments_panel(runs, "Fig. 3.11  Principal moments of inertia"),
        Panel("Norm of the estimate of J_1", "‖Ĵ₁‖ [s]", [size], guides=[guide]),
        sigma_panel(full, (), "s", "Estimate of J_1, full parametrisation: 9 elements"),
        Panel("Implementability of the law: ‖Ĵ₁Ω‖ must be below 1", "‖Ĵ₁Ω‖", [used]),
    ]
