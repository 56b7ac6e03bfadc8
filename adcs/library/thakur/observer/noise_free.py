"""Sec. 5.4.1: observer-based against full-state control with an exact attitude, in coupled Model Exchange."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from adcs.library.attitude import norm, settling_time
from adcs.library.outcome import Outcome, Row, Runner, Verdict, claims_table, verdict
from adcs.library.thakur.choices import TRACKED_BY, Choices
from adcs.library.thakur.observer.settings import ESTIMATED_BY, GUIDANCE, Start
from adcs.library.thakur.observer.signals import (
    ATTITUDE,
    ATTITUDE_ESTIMATE,
    ERRORS,
    FEEDBACK,
    RATE,
    RATE_ESTIMATE,
    SYMBOLS,
    TORQUE,
    Signals,
    component_panel,
    norm_panel,
    signals,
)
from adcs.library.thakur.observer.systems import RECORD, RECORD_OBSERVER, full_state_pd, observer_pd
from orchestration.results.plots import Guide, Panel
from orchestration.results.report import KeyNumber, Table
from orchestration.running.method import ModelExchange
from orchestration.running.save import Save

GROUP = "5.4.1  Quaternion without noise"
OBSERVER, FULL_STATE = "observer", "full state"
LIMITS = {ATTITUDE: TRACKED_BY, RATE: TRACKED_BY, ATTITUDE_ESTIMATE: ESTIMATED_BY, RATE_ESTIMATE: ESTIMATED_BY}
OUTPUT_STEP = 0.05  # s, of the coupled solution
ESTIMATE_SCALES = (1.0, 2.0, 4.0)
RUNS = 1 + len(ESTIMATE_SCALES)

Pair = Mapping[str, Signals]


def noise_free(run: Runner, choices: Choices) -> Outcome:
    """Check the statements of the section one by one, and draw Figs. 5.1 and 5.2."""
    coupled = {"stop_time": choices.stop_time, "step": OUTPUT_STEP, "method": ModelExchange()}
    full = signals(run("full state, coupled", full_state_pd(), save=Save(RECORD), **coupled))
    scaled = {
        scale: signals(
            run(
                f"observer, coupled, rate estimate {scale:g} x off",
                observer_pd(_start(scale)),
                save=Save(RECORD_OBSERVER),
                **coupled,
            )
        )
        for scale in ESTIMATE_SCALES
    }
    pair = {OBSERVER: scaled[1.0], FULL_STATE: full}
    rows = [
        *_convergence(pair, choices),
        *_steady_state(pair, choices),
        *_transient(pair, choices),
        *_effort(pair),
        *_larger_errors(scaled),
        _reference_sign(choices),
    ]
    tables = [claims_table(rows, "The statements of Sec. 5.4.1", GROUP), _settling_table(pair), _scale_table(scaled)]
    return Outcome(rows, _panels(pair, choices), tables, _key_numbers(pair, choices))


def _start(scale: float) -> Start:
    """The start of the text with the initial error of the rate estimate multiplied."""
    start = Start()
    true, estimate = np.array(start.omega_BN_B), np.array(start.omega_EN_E)  # E and B coincide at the start
    return Start(omega_EN_E=tuple((true + scale * (estimate - true)).tolist()))


def _row(cell: str, settings: str, printed: str, ours: float | str | None, result: Verdict, note: str = "") -> Row:
    return Row("thakur", "Sec. 5.4.1", cell, settings, printed, ours, None, result, note)


def _convergence(pair: Pair, choices: Choices) -> list[Row]:
    part = choices.settled
    rows = []
    for name, limit in LIMITS.items():
        for control, run in _having(pair, name):
            settled, peak, left = run.settling_time(name, part), run.peak(name), run.since(limit).norm(name)[0]
            rows.append(
                _row(
                    f"{name} converges [s]",
                    control,
                    f"within {limit:g} s",
                    settled,
                    verdict(settled <= limit),
                    f"stays below {part:g} of its peak ({peak:.3g}{SYMBOLS[name][1]}), and below {part / 2:g} from "
                    f"{run.settling_time(name, part / 2):.4g} s on; at {limit:g} s it is {left:.2g}, {left / peak:.2g} "
                    "of the peak",
                )
            )
    return rows


def _steady_state(pair: Pair, choices: Choices) -> list[Row]:
    observer, full = pair[OBSERVER], pair[FULL_STATE]
    rows = []
    for name in (ATTITUDE, RATE, TORQUE):
        difference = norm(observer.vectors[name] - full.vectors[name])[full.time >= TRACKED_BY] / full.peak(name)
        rows.append(
            _row(
                f"steady state of the {name}: largest difference from {TRACKED_BY:g} s on / peak",
                "observer against full state",
                "identical",
                float(difference.max()),
                verdict(difference.max() <= choices.settled),
                f"{difference[-1]:.1g} at {full.time[-1]:g} s; judged at {choices.settled:g}",
            )
        )
    return rows


def _transient(pair: Pair, choices: Choices) -> list[Row]:
    observer, full = pair[OBSERVER], pair[FULL_STATE]
    rows = []
    for name in (ATTITUDE, RATE):
        ratio = observer.area(name) / full.area(name)
        rows.append(
            _row(
                f"transient of the {name}: ratio of the integrals of its norm",
                "observer / full state",
                "full state slightly faster (> 1)",
                ratio,
                verdict(ratio > 1),
                f"{observer.area(name):.4g} and {full.area(name):.4g}",
            )
        )
        times = [run.settling_time(name, choices.settled) for run in (observer, full)]
        rows.append(
            _row(
                f"transient of the {name}: difference of the times of convergence [s]",
                "observer - full state",
                "full state slightly faster (> 0)",
                times[0] - times[1],
                verdict(times[0] > times[1]),
                f"{times[0]:.4g} s and {times[1]:.4g} s; which is first depends on the level, see the settling times",
            )
        )
    for name in (RATE, ATTITUDE):
        ratio = observer.oscillation(name) / full.oscillation(name)
        rows.append(
            _row(
                f"oscillation of the {name} (total variation)",
                "observer / full state",
                "larger (> 1)",
                ratio,
                verdict(ratio > 1),
                f"ratio of the peaks {observer.peak(name) / full.peak(name):.3g}",
            )
        )
    return rows


def _effort(pair: Pair) -> list[Row]:
    observer, full = (pair[control].until(TRACKED_BY) for control in (OBSERVER, FULL_STATE))
    share = full.area(FEEDBACK) / full.area(TORQUE)
    notes = {
        TORQUE: f"peaks {observer.peak(TORQUE):.4g} and {full.peak(TORQUE):.4g} N.m; nearly all is feedforward that "
        f"turns the craft with the reference, the feedback torque is {share:.0%} of it",
        FEEDBACK: "-k_p q_v - k_v omega_e alone",
    }
    rows = []
    for name, note in notes.items():
        efforts = [run.area(name) for run in (observer, full)]
        rows.append(
            _row(
                f"control effort over {TRACKED_BY:g} s: ratio of the integrals of the {name}",
                "observer / full state",
                "slightly higher (> 1)",
                efforts[0] / efforts[1],
                verdict(efforts[0] > efforts[1]),
                f"{efforts[0]:.4g} and {efforts[1]:.4g} N.m.s; {note}",
            )
        )
    return rows


def _larger_errors(scaled: Mapping[float, Signals]) -> list[Row]:
    settings = "initial rate estimation error x " + ", ".join(f"{scale:g}" for scale in scaled)
    transients = [run.until(TRACKED_BY) for run in scaled.values()]
    measures = {
        "oscillation of the rate tracking error (total variation) [rad/s]": ("larger", Signals.oscillation, RATE),
        "control effort over 60 s: integral of the control torque [N.m.s]": ("increased", Signals.area, TORQUE),
        "control effort over 60 s: integral of the feedback torque [N.m.s]": ("increased", Signals.area, FEEDBACK),
    }
    rows = []
    for cell, (printed, measure, name) in measures.items():
        values = [measure(run, name) for run in transients]
        grows = all(a < b for a, b in pairwise(values))
        note = "the feedforward outweighs the feedback terms, see the row below" if name == TORQUE and not grows else ""
        rows.append(_row(cell, settings, printed, ", ".join(f"{v:.4g}" for v in values), verdict(grows), note))
    return rows


def _reference_sign(choices: Choices) -> Row:
    end = choices.shown
    reached = GUIDANCE["amplitude"] * np.exp(GUIDANCE["decay"] * end**2)
    return _row(
        "r(t), first exponent",
        f"t = {end:g} s",
        "1 - exp(+0.01 t²)",
        "1 - exp(-0.01 t²)",
        "wrong in print",
        f"a minus sign is missing: as printed r would reach {reached:.1g} rad/s at {end:g} s",
    )


def _settling_table(pair: Pair) -> Table:
    parts, levels = (0.1, 0.05, 0.02, 0.01), (1e-2, 1e-3, 1e-4)
    rows = []
    for name in ERRORS:
        for control, run in _having(pair, name):
            relative = [run.settling_time(name, part) for part in parts]
            absolute = [settling_time(run.time, run.norm(name), level) for level in levels]
            rows.append([name + SYMBOLS[name][1], control, run.peak(name), *relative, *absolute])
    columns = ["error", "control", "peak", *(f"{part:.0%}" for part in parts), *(f"{level:g}" for level in levels)]
    note = (
        "Time [s] from which on the norm stays below a part of its peak, or below an absolute level. The text does not "
        "say when an error has converged, and the answer depends on it."
    )
    return Table("Settling times", columns, rows, note, GROUP)


def _scale_table(scaled: Mapping[float, Signals]) -> Table:
    rows = []
    for scale, run in scaled.items():
        part = run.until(TRACKED_BY)
        efforts = [part.area(TORQUE), part.area(FEEDBACK)]
        rows.append([f"x {scale:g}", part.peak(RATE), part.oscillation(RATE), part.peak(TORQUE), *efforts])
    columns = [
        "initial rate estimation error",
        "peak rate error [rad/s]",
        "its total variation [rad/s]",
        "peak torque [N.m]",
        "effort [N.m.s]",
        "of the feedback terms",
    ]
    return Table(f"Larger initial estimation errors, over {TRACKED_BY:g} s", columns, rows, group=GROUP)


def _key_numbers(pair: Pair, choices: Choices) -> list[KeyNumber]:
    numbers = []
    for title, limit in (("Tracking errors converged", TRACKED_BY), ("Estimation errors converged", ESTIMATED_BY)):
        names = [name for name in ERRORS if LIMITS[name] == limit]
        last = max(run.settling_time(name, choices.settled) for name in names for _, run in _having(pair, name))
        numbers.append(KeyNumber(title, last, "s", f"printed: within {limit:g} s"))
    return numbers


def _panels(pair: Pair, choices: Choices) -> list[Panel]:
    shown = {control: run.until(choices.shown) for control, run in pair.items()}
    panels = [
        component_panel(ATTITUDE, shown, "Fig. 5.1a  Attitude tracking error", GROUP),
        component_panel(RATE, shown, "Fig. 5.1b  Rate tracking error", GROUP),
        component_panel(RATE_ESTIMATE, shown, "Fig. 5.2  Rate estimation error", GROUP),
        component_panel(TORQUE, shown, "Fig. 5.2  Control torque", GROUP),
    ]
    for name, limit in LIMITS.items():
        level = choices.settled * max(run.peak(name) for _, run in _having(pair, name))
        guides = [Guide(limit, f"{limit:g} s", "x"), Guide(level, f"{choices.settled:.0%} of the peak")]
        panels.append(norm_panel(name, shown, f"Norm of the {name}", GROUP, guides=guides))
    return panels


def _having(pair: Pair, name: str) -> list[tuple[str, Signals]]:
    """The controls whose run has the error: those of estimation are the observer's alone."""
    return [(control, run) for control, run in pair.items() if name in run.vectors]
