"""Sec. 5.4.1: observer-based against full-state control with an exact attitude, in coupled Model Exchange."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np

from adcs.library.attitude import norm
from adcs.library.outcome import Claim, Shown
from adcs.library.sections import Section, Simulation
from adcs.library.thakur.choices import TRACKED_BY, Choices
from adcs.library.thakur.observer.settings import ESTIMATED_BY, GUIDANCE, Start
from adcs.library.thakur.observer.signals import (
    ATTITUDE,
    ERRORS,
    ESTIMATION,
    FEEDBACK,
    RATE,
    RATE_ESTIMATE,
    TORQUE,
    TRACKING,
    signals,
)
from adcs.library.thakur.observer.systems import full_state_pd, observer_pd
from adcs.library.trajectory import Runs, Trajectory, component_panel, having, norm_panel
from orchestration.results.plots import Guide, Panel
from orchestration.results.report import KeyNumber, Table
from orchestration.running.method import ModelExchange

WHERE = "Sec. 5.4.1"
OBSERVER, FULL_STATE = "observer", "full state"
BOTH = "observer / full state"
LIMITS = {**dict.fromkeys(TRACKING, TRACKED_BY), **dict.fromkeys(ESTIMATION, ESTIMATED_BY)}
OUTPUT_STEP = 0.05  # s, of the coupled solution
ESTIMATE_SCALES = (1.0, 2.0, 4.0)

Scaled = Mapping[float, Trajectory]
"""Runs by how much larger the initial error of the rate estimate is."""


def noise_free(choices: Choices) -> Section:
    """The statements of the section one by one, and Figs. 5.1 and 5.2."""
    stop, method = choices.stop_time, ModelExchange()
    label, system = f"{FULL_STATE}, coupled", full_state_pd()
    runs: dict[object, Simulation] = {FULL_STATE: Simulation(label, system, signals, stop, OUTPUT_STEP, method)}
    for scale in ESTIMATE_SCALES:
        label, system = f"observer, coupled, rate estimate {scale:g} x off", observer_pd(_start(scale))
        runs[scale] = Simulation(label, system, signals, stop, OUTPUT_STEP, method)

    def show(found: Mapping[object, Trajectory]) -> Iterator[Shown]:
        pair = {OBSERVER: found[1.0], FULL_STATE: found[FULL_STATE]}
        scaled = {scale: found[scale] for scale in ESTIMATE_SCALES}
        yield from _convergence(pair, choices)
        yield from _steady_state(pair, choices)
        yield from _transient(pair, choices)
        yield from _effort(pair)
        yield from _larger_errors(scaled)
        yield _reference_sign(choices)
        yield from _panels(pair, choices)
        yield _settling_table(pair)
        yield _scale_table(scaled)
        yield from _key_numbers(pair, choices)

    return Section("5.4.1  Quaternion without noise", "The statements of Sec. 5.4.1", show, runs)


def _start(scale: float) -> Start:
    """The start of the text with the initial error of the rate estimate multiplied."""
    start = Start()
    true, estimate = np.array(start.omega_BN_B), np.array(start.omega_EN_E)  # E and B coincide at the start
    return Start(omega_EN_E=tuple((true + scale * (estimate - true)).tolist()))


def _convergence(pair: Runs, choices: Choices) -> Iterator[Claim]:
    part = choices.settled
    for error, limit in LIMITS.items():
        for control, run in having(pair, error).items():
            settled, peak, left = run.settled(error, part), run.peak(error), run.after(limit).start(error)
            yield Claim(WHERE, f"{error} converges [s]", control,
                        f"within {limit:g} s", settled, settled <= limit,
                        f"stays below {part:g} of its peak ({peak:.3g}{error.in_unit}), "
                        f"and below {part / 2:g} from {run.settled(error, part / 2):.4g} s on; "
                        f"at {limit:g} s it is {left:.2g}, {left / peak:.2g} of the peak")  # fmt: skip


def _steady_state(pair: Runs, choices: Choices) -> Iterator[Claim]:
    observer, full = pair[OBSERVER], pair[FULL_STATE]
    for what in (ATTITUDE, RATE, TORQUE):
        difference = norm(observer[what] - full[what])[full.time >= TRACKED_BY] / full.peak(what)
        largest = float(difference.max())
        yield Claim(WHERE, f"steady state of the {what}: largest difference from {TRACKED_BY:g} s on / peak",
                    "observer against full state",
                    "identical", largest, largest <= choices.settled,
                    f"{difference[-1]:.1g} at {full.time[-1]:g} s; judged at {choices.settled:g}")  # fmt: skip


def _transient(pair: Runs, choices: Choices) -> Iterator[Claim]:
    observer, full = pair[OBSERVER], pair[FULL_STATE]
    for what in TRACKING:
        ours, theirs = observer.area(what), full.area(what)
        yield Claim(WHERE, f"transient of the {what}: ratio of the integrals of its norm", BOTH,
                    "full state slightly faster (> 1)", ours / theirs, ours / theirs > 1,
                    f"{ours:.4g} and {theirs:.4g}")  # fmt: skip
        ours, theirs = (run.settled(what, choices.settled) for run in (observer, full))
        yield Claim(WHERE, f"transient of the {what}: difference of the times of convergence [s]",
                    "observer - full state",
                    "full state slightly faster (> 0)", ours - theirs, ours > theirs,
                    f"{ours:.4g} s and {theirs:.4g} s; which is first depends on the level, see the settling times",
        )  # fmt: skip
    for what in (RATE, ATTITUDE):
        ratio = observer.oscillation(what) / full.oscillation(what)
        yield Claim(WHERE, f"oscillation of the {what} (total variation)", BOTH,
                    "larger (> 1)", ratio, ratio > 1,
                    f"ratio of the peaks {observer.peak(what) / full.peak(what):.3g}")  # fmt: skip


def _effort(pair: Runs) -> Iterator[Claim]:
    observer, full = (pair[control].until(TRACKED_BY) for control in (OBSERVER, FULL_STATE))
    share = full.area(FEEDBACK) / full.area(TORQUE)
    notes = {
        TORQUE: f"peaks {observer.peak(TORQUE):.4g} and {full.peak(TORQUE):.4g} N.m; nearly all is feedforward that "
        f"turns the craft with the reference, the feedback torque is {share:.0%} of it",
        FEEDBACK: "-k_p q_v - k_v omega_e alone",
    }
    for what, note in notes.items():
        ours, theirs = observer.area(what), full.area(what)
        yield Claim(WHERE, f"control effort over {TRACKED_BY:g} s: ratio of the integrals of the {what}", BOTH,
                    "slightly higher (> 1)", ours / theirs, ours > theirs,
                    f"{ours:.4g} and {theirs:.4g} N.m.s; {note}")  # fmt: skip


def _larger_errors(scaled: Scaled) -> Iterator[Claim]:
    runs = [run.until(TRACKED_BY) for run in scaled.values()]
    for what, printed, cell, values in (
        (RATE, "larger", "oscillation of the rate tracking error (total variation) [rad/s]",
         [run.oscillation(RATE) for run in runs]),
        (TORQUE, "increased", "control effort over 60 s: integral of the control torque [N.m.s]",
         [run.area(TORQUE) for run in runs]),
        (FEEDBACK, "increased", "control effort over 60 s: integral of the feedback torque [N.m.s]",
         [run.area(FEEDBACK) for run in runs]),
    ):  # fmt: skip
        grows = all(a < b for a, b in pairwise(values))
        note = "the feedforward outweighs the feedback terms, see the row below"
        yield Claim(WHERE, cell, "initial rate estimation error x " + ", ".join(f"{scale:g}" for scale in scaled),
                    printed, ", ".join(f"{v:.4g}" for v in values), grows,
                    note if what is TORQUE and not grows else "")  # fmt: skip


def _reference_sign(choices: Choices) -> Claim:
    end = choices.shown
    reached = GUIDANCE["amplitude"] * np.exp(GUIDANCE["decay"] * end**2)
    return Claim(WHERE, "r(t), first exponent", f"t = {end:g} s", "1 - exp(+0.01 t²)", "1 - exp(-0.01 t²)", None,
                 f"a minus sign is missing: as printed r would reach {reached:.1g} rad/s at {end:g} s")  # fmt: skip


def _settling_table(pair: Runs) -> Table:
    parts, levels = (0.1, 0.05, 0.02, 0.01), (1e-2, 1e-3, 1e-4)
    rows = []
    for error in ERRORS:
        for control, run in having(pair, error).items():
            times = [run.settled(error, part) for part in parts] + [run.settled(error, level, 1.0) for level in levels]
            rows.append([error.name + error.in_unit, control, run.peak(error), *times])
    columns = ["error", "control", "peak", *(f"{part:.0%}" for part in parts), *(f"{level:g}" for level in levels)]
    note = (
        "Time [s] from which on the norm stays below a part of its peak, or below an absolute level. The text does not "
        "say when an error has converged, and the answer depends on it."
    )
    return Table("Settling times", columns, rows, note)


def _scale_table(scaled: Scaled) -> Table:
    rows = []
    for scale, run in scaled.items():
        part = run.until(TRACKED_BY)
        efforts = [part.area(TORQUE), part.area(FEEDBACK)]
        rows.append([f"x {scale:g}", part.peak(RATE), part.oscillation(RATE), part.peak(TORQUE), *efforts])
    columns = ["initial rate estimation error", "peak rate error [rad/s]", "its total variation [rad/s]"]
    columns += ["peak torque [N.m]", "effort [N.m.s]", "of the feedback terms"]
    return Table(f"Larger initial estimation errors, over {TRACKED_BY:g} s", columns, rows)


def _key_numbers(pair: Runs, choices: Choices) -> list[KeyNumber]:
    numbers = []
    for what, errors, limit in (("Tracking", TRACKING, TRACKED_BY), ("Estimation", ESTIMATION, ESTIMATED_BY)):
        last = max(run.settled(error, choices.settled) for error in errors for run in having(pair, error).values())
        numbers.append(KeyNumber(f"{what} errors converged", last, "s", f"printed: within {limit:g} s"))
    return numbers


def _panels(pair: Runs, choices: Choices) -> list[Panel]:
    shown = {control: run.until(choices.shown) for control, run in pair.items()}
    panels = [
        component_panel(ATTITUDE, shown, "Fig. 5.1a  Attitude tracking error"),
        component_panel(RATE, shown, "Fig. 5.1b  Rate tracking error"),
        component_panel(RATE_ESTIMATE, shown, "Fig. 5.2  Rate estimation error"),
        component_panel(TORQUE, shown, "Fig. 5.2  Control torque"),
    ]
    for error, limit in LIMITS.items():
        level = choices.settled * max(run.peak(error) for run in having(pair, error).values())
        guides = [Guide(limit, f"{limit:g} s", "x"), Guide(level, f"{choices.settled:.0%} of the peak")]
        panels.append(norm_panel(error, shown, f"Norm of the {error}", guides=guides))
    return panels
