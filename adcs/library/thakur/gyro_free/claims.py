"""Sec. 4.3.1: the gyro-free law against full-state control with exact measurements, in coupled Model Exchange."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from adcs.library.attitude import direction_cosines
from adcs.library.outcome import Outcome, Row, Runner, Verdict, claims_table, verdict
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.gyro_free.settings import AT_REST_BY, PRINTED_C_R, PRINTED_P, Q_RN
from adcs.library.thakur.gyro_free.signals import ANGLE, RATE, SYMBOLS, TORQUE, Motion, motion, panel, vector_panel
from adcs.library.thakur.gyro_free.systems import RECORD, RECORD_GYRO_FREE, gyro_free, gyro_free_full_state
from orchestration.results.plots import Guide, Panel
from orchestration.results.report import KeyNumber, Table
from orchestration.running.method import ModelExchange
from orchestration.running.save import Save

GROUP = "4.3.1  Vectors without noise"
GYRO_FREE, FULL_STATE = "gyro-free", "full state"
STEP = 0.1  # s, of the coupled solution
LARGEST_TORQUE, MORE_TORQUE = 1.5e-2, 0.002  # N.m, as printed
COMPARABLE = 1.25  # the efforts are comparable within this factor
RUNS = 3

Pair = Mapping[str, Motion]


def noise_free(run: Runner, choices: Choices) -> Outcome:
    """Check the statements of the section one by one, and draw Figs. 4.1 and 4.2."""
    settings = {"stop_time": choices.stop_time, "step": STEP, "method": ModelExchange()}
    own = run("gyro-free, coupled", gyro_free(), save=Save([*RECORD_GYRO_FREE, "controller.P"]), **settings)
    full = run("full state on unit vectors, coupled", gyro_free_full_state(), save=Save(RECORD), **settings)
    at_zero = gyro_free(controller={"filter_at_rest": False})
    zero = run("gyro-free, z(0) = 0, coupled", at_zero, save=Save(RECORD_GYRO_FREE), **settings)
    pair = {GYRO_FREE: motion(own), FULL_STATE: motion(full)}
    rows = [
        _reference(),
        _lyapunov_matrix(own["controller.P"][0]),
        *_torques(pair),
        *_convergence(pair, choices),
        _effort(pair),
    ]
    tables = [claims_table(rows, "The statements of Sec. 4.3.1", GROUP), _table(pair, motion(zero), choices)]
    last = max(run_.settling_time(name, choices.settled) for run_ in pair.values() for name in (ANGLE, RATE))
    number = KeyNumber("Gyro-free and full state at rest", last, "s", f"printed: within {AT_REST_BY:g} s")
    return Outcome(rows, _panels(pair, motion(zero), choices), tables, [number])


def _row(
    cell: str,
    settings: str,
    printed: float | str,
    ours: float | str,
    result: Verdict,
    note: str,
    off: float | None = None,
) -> Row:
    return Row("thakur", "Sec. 4.3", cell, settings, printed, ours, off, result, note)


def _reference() -> Row:
    off = float(np.abs(direction_cosines(Q_RN) - np.array(PRINTED_C_R)).max())
    orthogonal = float(np.abs(np.array(PRINTED_C_R) @ np.transpose(PRINTED_C_R) - np.eye(3)).max())
    return _row(
        "C_r against 87.7° about [1, 1, 1]: largest difference of an element",
        "",
        "equal",
        off,
        verdict(off <= 1e-4),
        f"printed to four digits, with which it is orthogonal to {orthogonal:.1g} only; the rotation itself is used",
    )


def _lyapunov_matrix(P: np.ndarray) -> Row:
    off = float(np.abs(P - np.diag(PRINTED_P)).max() / max(PRINTED_P))
    text = "diag(" + ", ".join(f"{p:g}" for p in PRINTED_P) + ")"
    ours = "diag(" + ", ".join(f"{p:.6g}" for p in np.diag(P)) + ")"
    return _row("P", "A_m, Q as printed", text, ours, verdict(off <= 1e-12), "solved for by the component", off)


def _torques(pair: Pair) -> list[Row]:
    rows = []
    for control, run in pair.items():
        peak = run.peak(TORQUE)
        note = f"at {run.time[int(run.values[TORQUE].argmax())]:g} s"
        printed = f"less than {LARGEST_TORQUE:g}"
        rows.append(_row("largest control torque [N·m]", control, printed, peak, verdict(peak < LARGEST_TORQUE), note))
    more = float(pair[GYRO_FREE].values[TORQUE][0] - pair[FULL_STATE].values[TORQUE][0])
    off = more / MORE_TORQUE - 1
    note = "judged to the one digit given; it is the rate term of full state, k_ω ‖ω(0)‖ = 0.0021 N·m, against Ω(0)"
    rows.append(
        _row(
            "initial torque norm, gyro-free - full state [N·m]",
            "",
            MORE_TORQUE,
            more,
            verdict(round(more, 3) == MORE_TORQUE),
            note,
            off,
        )
    )
    return rows


def _convergence(pair: Pair, choices: Choices) -> list[Row]:
    rows = []
    for name in (RATE, ANGLE):
        for control, run in pair.items():
            settled, peak = run.settling_time(name, choices.settled), run.peak(name)
            left = run.since(AT_REST_BY).values[name][0]
            unit = SYMBOLS[name].partition("[")[2].rstrip("]")
            note = f"below {choices.settled:g} of its peak ({peak:.3g} {unit}); at {AT_REST_BY:g} s {left:.2g} {unit}, "
            note += f"{left / peak:.2g} of it"
            rows.append(
                _row(
                    f"{name} driven to the origin [s]",
                    control,
                    "within two minutes",
                    settled,
                    verdict(settled <= AT_REST_BY),
                    note,
                )
            )
    return rows


def _effort(pair: Pair) -> Row:
    efforts = [pair[control].area(TORQUE) for control in (GYRO_FREE, FULL_STATE)]
    ratio = efforts[0] / efforts[1]
    return _row(
        "torque requirement: ratio of the integrals of the torque",
        "gyro-free / full state",
        "comparable",
        ratio,
        verdict(1 / COMPARABLE <= ratio <= COMPARABLE),
        f"{efforts[0]:.3g} and {efforts[1]:.3g} N·m·s; judged at a factor of {COMPARABLE:g}",
    )


def _table(pair: Pair, zero: Motion, choices: Choices) -> Table:
    rows = []
    for label, run in {**pair, "gyro-free, z(0) = 0": zero}.items():
        times = [run.settling_time(name, choices.settled) for name in (ANGLE, RATE)]
        rows.append([label, *times, run.area(TORQUE), run.peak(TORQUE), float(run.values[TORQUE][0])])
    columns = ["control", "angle converged [s]", "rate converged [s]", "effort [N·m·s]"]
    columns += ["largest torque [N·m]", "initial torque [N·m]"]
    note = (
        "Last line: the filter started at zero instead of at rest. Its derivative then stands for a motion that is not "
        "there, and the torque answers to it."
    )
    return Table("The two laws, and the filter's start", columns, rows, note, GROUP)


def _panels(pair: Pair, zero: Motion, choices: Choices) -> list[Panel]:
    shown = {control: run.until(AT_REST_BY) for control, run in pair.items()}
    by = [Guide(AT_REST_BY, f"{AT_REST_BY:g} s", "x")]
    starts = {"z(0) = -A_m⁻¹ B Ω(0)": pair[GYRO_FREE].until(10.0), "z(0) = 0": zero.until(10.0)}
    return [
        vector_panel(RATE, "ω [rad/s]", shown, "Fig. 4.1a  Angular velocity", GROUP),
        panel(ANGLE, shown, "Fig. 4.1b  Rotation angle of the error", GROUP),
        panel(
            TORQUE,
            shown,
            "Fig. 4.2a  Norm of the control torque",
            GROUP,
            guides=[Guide(LARGEST_TORQUE, "printed limit")],
        ),
        vector_panel("z", "z", {"": shown[GYRO_FREE]}, "Fig. 4.2b  Filter state z", GROUP),
        panel(ANGLE, pair, "Rotation angle, logarithmic", GROUP, log=True, guides=by),
        panel(TORQUE, starts, "Torque, filter started at rest and at zero", GROUP, log=True),
    ]
