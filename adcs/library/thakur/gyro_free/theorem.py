"""Theorem 4.2.3: attitudes below its level in which the gyro-free law rests, and the level that is enough."""

from __future__ import annotations

import numpy as np

from adcs.library.outcome import Outcome, Row, Runner, claims_table, verdict
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.gyro_free.level import printed_level, resting_attitudes, start_value, sufficient_level
from adcs.library.thakur.gyro_free.settings import Q_RN, Start
from adcs.library.thakur.gyro_free.signals import ANGLE, TORQUE, Motion, motion
from adcs.library.thakur.gyro_free.systems import RECORD, gyro_free
from orchestration.results.plots import Guide, Panel, Series
from orchestration.results.report import KeyNumber, Table
from orchestration.running.method import ModelExchange
from orchestration.running.save import Save

GROUP = "4.2.3  From where it converges"
STILL = (0.0, 0.0, 0.0)
REST_TIME = 30.0  # s; longer, and rounding errors set the body going from an unstable rest
STEP = 0.5  # s
BELOW = 0.99  # of the sufficient level, from where a run must converge
RUNS = 4


def theorem(run: Runner, choices: Choices) -> Outcome:
    """Three runs from rest, turned by 180 degrees, that stay; one from just below the corrected level that does not."""
    settings = {"step": STEP, "method": ModelExchange(), "save": Save(RECORD)}
    rests = {}
    for value, q in resting_attitudes():
        start = Start(q, STILL)
        result = run(
            f"gyro-free, at rest at 180 deg, eigenvalue {value:.3g}", gyro_free(start), stop_time=REST_TIME, **settings
        )
        rests[value] = (start, motion(result))
    below = _below()
    end = 2 * choices.stop_time
    away = motion(run("gyro-free, just below the level", gyro_free(below), stop_time=end, **settings))
    rows = [_counterexample(rests), _text()]
    series = [Series(f"at rest, eigenvalue {v:.3g}", m.time, m.values[ANGLE]) for v, (_, m) in rests.items()]
    shown = away.until(choices.shown)
    series.append(Series(f"V(0) = {BELOW:g} of the level", shown.time, shown.values[ANGLE]))
    panels = [
        Panel("Rotation angle from starts that (4.27) allows", "φ [deg]", series, group=GROUP, guides=[Guide(180.0)])
    ]
    tables = [claims_table(rows, "Theorem 4.2.3", GROUP), _table(rests, below, away)]
    number = KeyNumber(
        "Gyro-free law sure to converge",
        sufficient_level(),
        "N·m",
        f"if V(0) is below; printed: {printed_level():.4g}, which is not enough",
    )
    return Outcome(rows, panels, tables, [number])


def _below() -> Start:
    """Turned from rest about the axis of the largest eigenvalue, to `BELOW` of the sufficient level.

    V grows with sin^2 of half the angle, up to the level itself at 180 degrees.
    """
    _, q_180 = resting_attitudes()[-1]
    # q_BN = cos(phi/2) q_RN + sin(phi/2) q_180: the turn about the same axis by phi instead of 180 degrees
    sine = BELOW**0.5
    q = (1 - BELOW) ** 0.5 * np.array(Q_RN) + sine * np.array(q_180)
    return Start(tuple(q.tolist()), STILL)


def _counterexample(rests: dict[float, tuple[Start, Motion]]) -> Row:
    value, (start, stays) = max(rests.items())
    note = (
        f"V(0) = {start_value(start):.4g} N·m is below kp Σk = {printed_level():.4g} N·m, and after {REST_TIME:g} s "
        f"the angle is {stays.values[ANGLE][-1]:.6f}° with a torque of at most {stays.peak(TORQUE):.0e} N·m. So for "
        "all three eigenvectors e of M₀: turned by 180° about e, ME = (2eeᵀ - I)M₀ is symmetric, hence Ω = 0 and "
        "u = 0. The proof excludes only y_j = -y_rj for all j at once, which no rotation can do"
    )
    return Row(
        "thakur",
        "Theorem 4.2.3",
        "every start with V(0) < kp Σk converges",
        f"at rest, 180° about the eigenvector of {value:.4g}",
        "[E, ω] → [I, 0]",
        f"stays at {stays.values[ANGLE][-1]:.6g}°",
        None,
        "wrong in print",
        note,
    )


def _text() -> Row:
    value = start_value()
    return Row(
        "thakur",
        "Theorem 4.2.3",
        "V(0) of the start of Sec. 4.3 over the level",
        "",
        "convergence",
        value / sufficient_level(),
        None,
        verdict(value < sufficient_level()),
        f"V(0) = {value:.4g} N·m is below the corrected level {sufficient_level():.4g} N·m too",
    )


def _table(rests: dict[float, tuple[Start, Motion]], below: Start, away: Motion) -> Table:
    rows = []
    for label, start, run in (
        *((f"180° about the eigenvector of {value:.4g}", *pair) for value, pair in rests.items()),
        (f"V(0) = {BELOW:g} of the corrected level", below, away),
        ("start of Sec. 4.3", Start(), None),
    ):
        value = start_value(start)
        rows.append([label, value, value / printed_level(), value / sufficient_level()])
        rows[-1] += [None] * 3 if run is None else [float(run.time[-1]), float(run.values[ANGLE][-1]), run.peak(TORQUE)]
    columns = [
        "start",
        "V(0) [N·m]",
        "over kp Σk",
        "over kp (Σk - λ_max)",
        "after [s]",
        "angle [deg]",
        "largest torque [N·m]",
    ]
    note = (
        "Starts at rest with the filter at rest. The rests are unstable: rounding errors leave them after a minute or "
        "so, a disturbance at once. Yet Eq. (4.27) admits them, and near them a run takes as long as one likes."
    )
    return Table("Starts that (4.27) admits", columns, rows, note, GROUP)
