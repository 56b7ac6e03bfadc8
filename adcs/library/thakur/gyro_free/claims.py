"""Sec. 4.3.1: the gyro-free law against full-state control with exact measurements, in coupled Model Exchange."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from adcs.library.attitude import direction_cosines
from adcs.library.outcome import Claim, Shown
from adcs.library.sections import Section, Simulation
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.gyro_free.settings import AT_REST_BY, PRINTED_C_R, PRINTED_P, Q_RN
from adcs.library.thakur.gyro_free.signals import ANGLE, FILTER, LYAPUNOV, RATE, TORQUE, motion
from adcs.library.thakur.gyro_free.systems import gyro_free, gyro_free_full_state
from adcs.library.trajectory import Array, Runs, component_panel, norm_panel
from orchestration.results.plots import Guide, Panel
from orchestration.results.report import KeyNumber, Table
from orchestration.running.method import ModelExchange

WHERE = "Sec. 4.3"
GYRO_FREE, FULL_STATE, FROM_ZERO = "gyro-free", "full state", "gyro-free, z(0) = 0"
STEP = 0.1  # s, of the coupled solution
LARGEST_TORQUE, MORE_TORQUE = 1.5e-2, 0.002  # N.m, as printed
COMPARABLE = 1.25  # the efforts are comparable within this factor


def noise_free(choices: Choices) -> Section:
    """The statements of the section one by one, and Figs. 4.1 and 4.2."""
    stop, method = choices.stop_time, ModelExchange()
    from_zero = gyro_free(controller={"filter_at_rest": False})
    own = gyro_free()
    record = [*own.outputs(), "controller.P"]
    full, text = gyro_free_full_state(), "full state on unit vectors, coupled"
    runs = {
        GYRO_FREE: Simulation("gyro-free, coupled", own, motion, stop, STEP, method, record=record),
        FULL_STATE: Simulation(text, full, motion, stop, STEP, method),
        FROM_ZERO: Simulation(f"{FROM_ZERO}, coupled", from_zero, motion, stop, STEP, method),
    }
    return Section(
        "4.3.1  Vectors without noise", "The statements of Sec. 4.3.1", lambda found: _show(found, choices), runs
    )


def _show(found: Runs, choices: Choices) -> Iterator[Shown]:
    pair = {control: found[control] for control in (GYRO_FREE, FULL_STATE)}
    three = {**pair, FROM_ZERO: found[FROM_ZERO]}
    last = max(run.settled(what, choices.settled) for run in pair.values() for what in (ANGLE, RATE))
    yield KeyNumber("Gyro-free and full state at rest", last, "s", f"printed: within {AT_REST_BY:g} s")
    yield _reference()
    yield _lyapunov_matrix(found[GYRO_FREE][LYAPUNOV][0])
    yield from _torques(pair)
    yield from _convergence(pair, choices)
    yield _effort(pair)
    yield from _panels(three)
    yield _table(three, choices)


def _reference() -> Claim:
    off = float(np.abs(direction_cosines(Q_RN) - np.array(PRINTED_C_R)).max())
    orthogonal = float(np.abs(np.array(PRINTED_C_R) @ np.transpose(PRINTED_C_R) - np.eye(3)).max())
    return Claim(WHERE, "C_r against 87.7° about [1, 1, 1]: largest difference of an element", "",
                 "equal", off, off <= 1e-4,
                 f"printed to four digits, with which it is orthogonal to {orthogonal:.1g} only; "
                 "the rotation itself is used")  # fmt: skip


def _lyapunov_matrix(P: Array) -> Claim:
    off = float(np.abs(P - np.diag(PRINTED_P)).max() / max(PRINTED_P))
    return Claim(WHERE, "P", "A_m, Q as printed",
                 "diag(" + ", ".join(f"{p:g}" for p in PRINTED_P) + ")",
                 "diag(" + ", ".join(f"{p:.6g}" for p in np.diag(P)) + ")", off <= 1e-12,
                 "solved for by the component", off)  # fmt: skip


def _torques(pair: Runs) -> Iterator[Claim]:
    for control, run in pair.items():
        peak = run.peak(TORQUE)
        yield Claim(WHERE, "largest control torque [N·m]", control,
                    f"less than {LARGEST_TORQUE:g}", peak, peak < LARGEST_TORQUE,
                    f"at {run.time[int(run.norm(TORQUE).argmax())]:g} s")  # fmt: skip
    more = pair[GYRO_FREE].start(TORQUE) - pair[FULL_STATE].start(TORQUE)
    yield Claim(WHERE, "initial torque norm, gyro-free - full state [N·m]", "",
                MORE_TORQUE, more, round(more, 3) == MORE_TORQUE,
                "judged to the one digit given; it is the rate term of full state, k_ω ‖ω(0)‖ = 0.0021 N·m, "
                "against Ω(0)", more / MORE_TORQUE - 1)  # fmt: skip


def _convergence(pair: Runs, choices: Choices) -> Iterator[Claim]:
    for what in (RATE, ANGLE):
        for control, run in pair.items():
            settled, peak, left = run.settled(what, choices.settled), run.peak(what), run.after(AT_REST_BY).start(what)
            yield Claim(WHERE, f"{what} driven to the origin [s]", control,
                        "within two minutes", settled, settled <= AT_REST_BY,
                        f"below {choices.settled:g} of its peak ({peak:.3g} {what.unit}); at {AT_REST_BY:g} s "
                        f"{left:.2g} {what.unit}, {left / peak:.2g} of it")  # fmt: skip


def _effort(pair: Runs) -> Claim:
    own, full = (pair[control].area(TORQUE) for control in (GYRO_FREE, FULL_STATE))
    return Claim(WHERE, "torque requirement: ratio of the integrals of the torque", "gyro-free / full state",
                 "comparable", own / full, 1 / COMPARABLE <= own / full <= COMPARABLE,
                 f"{own:.3g} and {full:.3g} N·m·s; judged at a factor of {COMPARABLE:g}")  # fmt: skip


def _table(runs: Runs, choices: Choices) -> Table:
    rows = []
    for label, run in runs.items():
        times = [run.settled(what, choices.settled) for what in (ANGLE, RATE)]
        rows.append([label, *times, run.area(TORQUE), run.peak(TORQUE), run.start(TORQUE)])
    columns = ["control", "angle converged [s]", "rate converged [s]", "effort [N·m·s]"]
    columns += ["largest torque [N·m]", "initial torque [N·m]"]
    note = (
        "Last line: the filter started at zero instead of at rest. Its derivative then stands for a motion that is not "
        "there, and the torque answers to it."
    )
    return Table("The two laws, and the filter's start", columns, rows, note)


def _panels(runs: Runs) -> list[Panel]:
    pair = {control: runs[control] for control in (GYRO_FREE, FULL_STATE)}
    shown = {control: run.until(AT_REST_BY) for control, run in pair.items()}
    limit, by = Guide(LARGEST_TORQUE, "printed limit"), Guide(AT_REST_BY, f"{AT_REST_BY:g} s", "x")
    starts = {"z(0) = -A_m⁻¹ B Ω(0)": runs[GYRO_FREE].until(10.0), "z(0) = 0": runs[FROM_ZERO].until(10.0)}
    return [
        component_panel(RATE, shown, "Fig. 4.1a  Angular velocity"),
        norm_panel(ANGLE, shown, "Fig. 4.1b  Rotation angle of the error", log=False),
        norm_panel(TORQUE, shown, "Fig. 4.2a  Norm of the control torque", log=False, guides=[limit]),
        component_panel(FILTER, {"": shown[GYRO_FREE]}, "Fig. 4.2b  Filter state z"),
        norm_panel(ANGLE, pair, "Rotation angle, logarithmic", guides=[by]),
        norm_panel(TORQUE, starts, "Torque, filter started at rest and at zero"),
    ]
