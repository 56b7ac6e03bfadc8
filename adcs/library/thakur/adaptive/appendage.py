"""Sec. 3.4.1, Figs. 3.4 to 3.7: moving appendages, under both readings of the reference."""

from __future__ import annotations

from collections.abc import Iterator

from adcs.library.outcome import Claim, Shown
from adcs.library.sections import Section
from adcs.library.thakur.adaptive import settings as settings
from adcs.library.thakur.adaptive.baseline import COMPARISON, PROPOSED
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
from adcs.library.thakur.adaptive.settings import Reading
from adcs.library.thakur.adaptive.signals import (
    ATTITUDE,
    MOMENTS,
    RATE,
    TORQUE,
    TRIANGLE,
    moments_panel,
    sigma_panel,
    theta_panel,
)
from adcs.library.thakur.adaptive.systems import appendage, appendage_full, comparison_appendage
from adcs.library.thakur.choices import Choices
from adcs.library.trajectory import Runs, Trajectory, norm_panel
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber, Table

WHERE = "Sec. 3.4.1"
EARLY, LATE = 60.0, 200.0  # s: the transient is over, and the steady state is from here on
SATURATED = {RATE: 0.5, ATTITUDE: 1e-3}  # deg/s and 1, near which the comparison law is said to stay
REACHED = {RATE: 1e-3, ATTITUDE: 1e-4}  # deg/s and 1, below which the proposed law is said to come within 400 s


def moving_appendages(choices: Choices) -> Section:
    """The statements of Sec. 3.4.1 for each reading, and the figures for the printed one."""
    builds = {PROPOSED: appendage, COMPARISON: comparison_appendage, FULL: appendage_full}

    def show(read: Read, full: Trajectory) -> Iterator[Shown]:
        proposed = read["printed"][PROPOSED]
        for reading, runs in read.items():
            yield from _errors(runs, reading, choices)
            yield from _effort(runs, reading)
        yield _inertia(proposed)
        yield from estimates(WHERE, proposed, full, choices)
        yield KeyNumber("Appendage: rate error at 400 s", proposed.end(RATE), "deg/s", "printed: below 0.001 deg/s")
        yield from _panels(read["printed"], full)
        yield _levels(read)
        yield convergence_table(read, full)

    return in_both_readings("3.4.1  Deployable appendage", "appendage", builds, show)


def _errors(runs: Runs, reading: Reading, choices: Choices) -> Iterator[Claim]:
    run, factor = runs[PROPOSED], choices.marginal
    ours, theirs = last(run), last(runs[COMPARISON])
    for error, limit in REACHED.items():
        end, largest = run.end(error), ours.peak(error)
        yield Claim(WHERE, f"{error} at 400 s{error.in_unit}", f"{PROPOSED}, {label(reading)}",
                    f"below {limit:g} within 400 s", end, end < limit,
                    f"it oscillates: over the last {LAST:g} s it is between {ours.least(error):.2g} and {largest:.2g}",
        )  # fmt: skip
        yield Claim(WHERE, f"{error}, largest over the last {LAST:g} s{error.in_unit}", f"{PROPOSED}, {label(reading)}",
                    f"below {limit:g} within 400 s", largest, largest < limit,
                    "the stricter reading of the same sentence: that it stays below")  # fmt: skip
    for error, level in SATURATED.items():
        mean = theirs.rms(error)
        yield Claim(WHERE, f"{error} saturates{error.in_unit}", f"{COMPARISON}, {label(reading)}",
                    f"around {level:g}", mean, level / factor <= mean <= level * factor,
                    f"root mean square over the last {LAST:g} s, where it is between {theirs.least(error):.2g} and "
                    f"{theirs.peak(error):.2g}; judged at a factor of {factor:g}")  # fmt: skip
        ratio = mean / ours.rms(error)
        yield Claim(WHERE, f"{error} in the end: ratio", f"{COMPARISON} / {PROPOSED}, {label(reading)}",
                    "significantly diminished convergence", ratio, ratio > 10,
                    "of the root mean squares; judged at 10")  # fmt: skip


def _effort(runs: Runs, reading: Reading) -> Iterator[Claim]:
    laws = (PROPOSED, COMPARISON)
    ours, theirs = (runs[law].until(EARLY).peak(TORQUE) for law in laws)
    yield Claim(WHERE, "overshoot of the control torque: ratio of the peaks",
                f"{PROPOSED} / {COMPARISON}, {label(reading)}",
                "slightly higher (> 1)", ours / theirs, ours / theirs > 1,
                f"{ours:.4g} and {theirs:.4g} N.m in the first {EARLY:g} s")  # fmt: skip
    ours, theirs = (runs[law].between(LATE, settings.STOP_TIME).area(TORQUE) for law in laws)
    yield Claim(WHERE, "control torque in steady state: ratio of the integrals",
                f"{COMPARISON} / {PROPOSED}, {label(reading)}",
                "higher (> 1)", theirs / ours, theirs / ours > 1,
                f"{theirs:.5g} and {ours:.5g} N.m.s from {LATE:g} to 400 s")  # fmt: skip


def _inertia(run: Trajectory) -> Claim:
    least, margin = float(run[MOMENTS].min()), run.least(TRIANGLE)
    return Claim(WHERE, "inertia positive definite and within (3.5), Fig. 3.4", "0 to 400 s",
                 "throughout", "throughout" if margin > 0 else "no", least > 0 and margin > 0,
                 f"least principal moment {least:.3g}, least margin of (3.5) {margin:.3g} kg.m2")  # fmt: skip


def _levels(read: Read) -> Table:
    cells = []
    for reading, runs in read.items():
        for control, run in runs.items():
            for error in (ATTITUDE, RATE):
                end = last(run)
                levels = [run.peak(error), end.least(error), end.rms(error), end.peak(error), run.end(error)]
                cells.append([label(reading), control, error.name + error.in_unit, *levels])
    columns = ["reference", "control", "error", "peak", "least", "root mean square", "largest", "at 400 s"]
    note = f"Least, root mean square and largest over the last {LAST:g} s."
    return Table("Errors at the end", columns, cells, note)


def _panels(runs: Runs, full: Trajectory) -> list[Panel]:
    proposed, transient = runs[PROPOSED], {law: run.until(30.0) for law, run in runs.items()}
    return [
        moments_panel({"": proposed}, "Fig. 3.4  Principal moments of inertia"),
        norm_panel(RATE, runs, "Fig. 3.5a  Rate tracking error"),
        norm_panel(ATTITUDE, runs, "Fig. 3.5b  Attitude tracking error"),
        norm_panel(TORQUE, runs, "Fig. 3.6a  Control torque", log=False),
        norm_panel(TORQUE, transient, "Fig. 3.6b  Control torque, transient", log=False),
        theta_panel(proposed, "Fig. 3.7a  Estimate of J_0"),
        sigma_panel(proposed, ("m₁", "m₂"), "kg", "Fig. 3.7b  Estimate of J_1: the masses"),
        sigma_panel(full, (), "kg", "Estimate of J_1, full parametrisation: 18 elements"),
        norm_panel(ATTITUDE, {**runs, FULL: full}, "Attitude tracking error, both parametrisations"),
    ]
