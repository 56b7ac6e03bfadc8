"""Theorem 4.2.3: attitudes below its level in which the gyro-free law rests, and the level that is enough."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from adcs.library.outcome import Claim, Shown
from adcs.library.sections import Section, Simulation
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.gyro_free.level import printed_level, resting_attitudes, start_value, sufficient_level
from adcs.library.thakur.gyro_free.settings import Q_RN, Start
from adcs.library.thakur.gyro_free.signals import ANGLE, TORQUE, motion
from adcs.library.thakur.gyro_free.systems import gyro_free
from adcs.library.trajectory import Trajectory
from orchestration.results.plots import Guide, Panel, Series
from orchestration.results.report import KeyNumber, Table
from orchestration.running.method import ModelExchange

WHERE = "Theorem 4.2.3"
STILL = (0.0, 0.0, 0.0)
REST_TIME = 30.0  # s; longer, and rounding errors set the body going from an unstable rest
STEP = 0.5  # s
BELOW = 0.99  # of the sufficient level, from where a run must converge

Starts = Mapping[float | None, Start]
"""By the eigenvalue of the rest; None: just below the sufficient level."""


def theorem(choices: Choices) -> Section:
    """Three runs from rest, turned by 180 degrees, that stay; one from just below the corrected level that does not."""
    starts: dict[float | None, Start] = {value: Start(q, STILL) for value, q in resting_attitudes()}
    starts[None] = _below()
    runs = {}
    for value, start in starts.items():
        label = "just below the level" if value is None else f"at rest at 180 deg, eigenvalue {value:.3g}"
        stop = 2 * choices.stop_time if value is None else REST_TIME
        runs[value] = Simulation(f"gyro-free, {label}", gyro_free(start), motion, stop, STEP, ModelExchange())

    def show(found: Mapping[float | None, Trajectory]) -> Iterator[Shown]:
        level, note = sufficient_level(), f"if V(0) is below; printed: {printed_level():.4g}, which is not enough"
        yield KeyNumber("Gyro-free law sure to converge", level, "N·m", note)
        value = max(value for value in starts if value is not None)
        yield _counterexample(value, starts[value], found[value])
        yield _text()
        yield _panel(found, choices)
        yield _table(starts, found)

    return Section("4.2.3  From where it converges", "Theorem 4.2.3", show, runs)


def _below() -> Start:
    """Turned from rest about the axis of the largest eigenvalue, to `BELOW` of the sufficient level.

    V grows with sin^2 of half the angle, up to the level itself at 180 degrees.
    """
    _, q_180 = resting_attitudes()[-1]
    # q_BN = cos(phi/2) q_RN + sin(phi/2) q_180: the turn about the same axis by phi instead of 180 degrees
    q = (1 - BELOW) ** 0.5 * np.array(Q_RN) + BELOW**0.5 * np.array(q_180)
    return Start(tuple(q.tolist()), STILL)


def _counterexample(value: float, start: Start, stays: Trajectory) -> Claim:
    angle = stays.end(ANGLE)
    return Claim(WHERE, "every start with V(0) < kp Σk converges",
                 f"at rest, 180° about the eigenvector of {value:.4g}",
                 "[E, ω] → [I, 0]", f"stays at {angle:.6g}°", None,
                 f"V(0) = {start_value(start):.4g} N·m is below kp Σk = {printed_level():.4g} N·m, and after "
                 f"{REST_TIME:g} s the angle is {angle:.6f}° with a torque of at most {stays.peak(TORQUE):.0e} N·m. So "
                 "for all three eigenvectors e of M₀: turned by 180° about e, ME = (2eeᵀ - I)M₀ is symmetric, hence "
                 "Ω = 0 and u = 0. The proof excludes only y_j = -y_rj for all j at once, which no rotation can do",
    )  # fmt: skip


def _text() -> Claim:
    value, level = start_value(), sufficient_level()
    return Claim(WHERE, "V(0) of the start of Sec. 4.3 over the level", "",
                 "convergence", value / level, value < level,
                 f"V(0) = {value:.4g} N·m is below the corrected level {level:.4g} N·m too")  # fmt: skip


def _panel(runs: Mapping[float | None, Trajectory], choices: Choices) -> Panel:
    series = []
    for value, run in runs.items():
        label = f"V(0) = {BELOW:g} of the level" if value is None else f"at rest, eigenvalue {value:.3g}"
        shown = run.until(choices.shown)
        series.append(Series(label, shown.time, shown[ANGLE]))
    return Panel("Rotation angle from starts that (4.27) allows", "φ [deg]", series, guides=[Guide(180.0)])


def _table(starts: Starts, runs: Mapping[float | None, Trajectory]) -> Table:
    rows: list[list[object]] = []
    for value, start in starts.items():
        label = f"180° about the eigenvector of {value:.4g}" if value else f"V(0) = {BELOW:g} of the corrected level"
        run = runs[value]
        rows.append([label, *_levels(start), float(run.time[-1]), run.end(ANGLE), run.peak(TORQUE)])
    rows.append(["start of Sec. 4.3", *_levels(Start()), None, None, None])
    columns = ["start", "V(0) [N·m]", "over kp Σk", "over kp (Σk - λ_max)"]
    columns += ["after [s]", "angle [deg]", "largest torque [N·m]"]
    note = (
        "Starts at rest with the filter at rest. The rests are unstable: rounding errors leave them after a minute or "
        "so, a disturbance at once. Yet Eq. (4.27) admits them, and near them a run takes as long as one likes."
    )
    return Table("Starts that (4.27) admits", columns, rows, note)


def _levels(start: Start) -> list[float]:
    value = start_value(start)
    return [value, value / printed_level(), value / sufficient_level()]
