"""Sec. 5.4.2: the eigenaxis of the measured attitude errs within a cone of 0.05 and of 0.5 deg."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import log10, radians

import numpy as np

from adcs.library.attitude import rms
from adcs.library.outcome import Outcome, Row, Runner, claims_table, verdict
from adcs.library.thakur.choices import ALMOST_AN_ORDER, NO_WORSE, Choices
from adcs.library.thakur.observer.noise_free import FULL_STATE, OBSERVER
from adcs.library.thakur.observer.signals import (
    ATTITUDE,
    ATTITUDE_ESTIMATE,
    ERRORS,
    RATE,
    RATE_ESTIMATE,
    TORQUE,
    Signals,
    norm_panel,
    signals,
)
from adcs.library.thakur.observer.systems import RECORD, RECORD_OBSERVER, full_state_pd, observer_pd
from adcs.library.thakur.sequences import spread
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber, Table
from orchestration.running.method import ModelExchange
from orchestration.running.save import Save
from orchestration.system import System

GROUP = "5.4.2  Quaternion with noise"
SMALL, LARGE = 0.05, 0.5  # deg, half-angles of the cone
OTHER_PERIODS = (0.5, 2.0)  # s, to see what our choice of the redraw period does
# Coupled, with an event at each draw: exchanging the torque even every millisecond would leave an error not far below
# that of the small cone. Noise makes more digits than these meaningless.
COUPLED = {"method": ModelExchange(rtol=1e-7, atol=1e-9)}
OUTPUT_STEP = 0.1  # s
CONTROLS: dict[str, tuple[Callable[..., System], tuple[str, ...]]] = {
    OBSERVER: (observer_pd, RECORD_OBSERVER),
    FULL_STATE: (full_state_pd, RECORD),
}

Key = tuple[str, float]  # control, half-angle in deg
Steady = dict[str, float]  # error -> root mean square of its norm in steady state


def run_count(choices: Choices) -> int:
    """How many runs `noisy` makes."""
    return len(CONTROLS) * (2 + len(OTHER_PERIODS)) * choices.draws


def noisy(run: Runner, choices: Choices) -> Outcome:
    """Steady-state errors with noise, both controls, both cones; Figs. 5.3 and 5.4."""
    runs = {
        (control, angle): _draws(run, control, angle, choices.redraw_period, choices)
        for angle in (SMALL, LARGE)
        for control in CONTROLS
    }
    steady = {key: steady_values(value, choices) for key, value in runs.items()}
    periods = {choices.redraw_period: {control: steady[control, SMALL] for control in CONTROLS}}
    for period in OTHER_PERIODS:
        periods[period] = {c: steady_values(_draws(run, c, SMALL, period, choices), choices) for c in CONTROLS}
    rows = [*_bounded(runs, steady, choices), *_slightly_better(runs, steady, choices), *_angles(steady)]
    numbers = [
        KeyNumber(
            "Errors at 0.5 deg / 0.05 deg",
            steady[OBSERVER, LARGE][ATTITUDE] / steady[OBSERVER, SMALL][ATTITUDE],
            "",
            "observer, attitude; printed: almost an order of magnitude",
        ),
        KeyNumber(
            "Observer / full state, 0.05 deg",
            steady[OBSERVER, SMALL][ATTITUDE] / steady[FULL_STATE, SMALL][ATTITUDE],
            "",
            "attitude; printed: full state marginally smaller",
        ),
    ]
    tables = [
        claims_table(rows, "The statements of Sec. 5.4.2", GROUP),
        _steady_table(steady, choices),
        _period_table(dict(sorted(periods.items()))),
    ]
    return Outcome(rows, _panels(runs), tables, numbers)


def steady_values(runs: Sequence[Signals], choices: Choices) -> Steady:
    """Root mean square, over time in steady state and over the runs, of the norm of each error."""
    ends = [run.since(choices.steady_from) for run in runs]
    return {name: rms(np.concatenate([end.norm(name) for end in ends])) for name in ERRORS if name in ends[0].vectors}


def _draws(run: Runner, control: str, angle: float, period: float, choices: Choices) -> list[Signals]:
    """One run for each noise sequence; the same sequences for both controls."""
    build, record = CONTROLS[control]
    return [
        signals(
            run(
                f"{control}, {angle:g} deg, redrawn every {period:g} s, seed {seed}",
                build(half_angle=radians(angle), redraw_period=period, seed=seed),
                stop_time=choices.stop_time,
                step=OUTPUT_STEP,
                save=Save(record),
                **COUPLED,
            )
        )
        for seed in range(choices.seed, choices.seed + choices.draws)
    ]


def _row(cell: str, settings: str, printed: str, ours: float | str | None, holds: bool, note: str = "") -> Row:
    return Row("thakur", "Sec. 5.4.2", cell, settings, printed, ours, None, verdict(holds), note)


def _bounded(runs: dict[Key, list[Signals]], steady: dict[Key, Steady], choices: Choices) -> list[Row]:
    rows = []
    for (control, angle), draws in runs.items():
        for name in (ATTITUDE, ATTITUDE_ESTIMATE):
            if name in steady[control, angle]:
                largest = max(run.since(choices.steady_from).peak(name) for run in draws)
                whole = max(run.peak(name) for run in draws)
                rows.append(
                    _row(
                        f"steady-state {name}: bounded, not zero (rms)",
                        f"{control}, {angle:g} deg",
                        "non-zero steady-state value",
                        steady[control, angle][name],
                        0 < largest < whole,
                        f"never above {largest:.2g} after {choices.steady_from:g} s; peak of the run {whole:.2g}",
                    )
                )
    return rows


def _slightly_better(runs: dict[Key, list[Signals]], steady: dict[Key, Steady], choices: Choices) -> list[Row]:
    rows = []
    for angle in (SMALL, LARGE):
        for name in (ATTITUDE, RATE):
            ratio = steady[OBSERVER, angle][name] / steady[FULL_STATE, angle][name]
            pair = ([steady_values([r], choices)[name] for r in runs[c, angle]] for c in (OBSERVER, FULL_STATE))
            ratios = spread(*pair)
            judged = f"judged at a factor of {choices.marginal:g}"
            if ratio <= 1:
                note = f"full state is not better; {ratios}"
            elif ratio <= choices.marginal:
                note = f"{ratios}; {judged}"
            else:
                note = f"full state is better, by more than slightly: {ratios}; {judged}"
            rows.append(
                _row(
                    f"steady-state {name}, observer / full state",
                    f"{angle:g} deg",
                    "full state only slightly better (> 1)",
                    ratio,
                    1 < ratio <= choices.marginal,
                    note,
                )
            )
    return rows


def _angles(steady: dict[Key, Steady]) -> list[Row]:
    growth = {
        (control, name): steady[control, LARGE][name] / value
        for control in CONTROLS
        for name, value in steady[control, SMALL].items()
    }
    low, high = ALMOST_AN_ORDER
    rows = [
        _row(
            f"steady-state {name}, 0.5 deg / 0.05 deg",
            control,
            "almost a full order of magnitude",
            ratio,
            low <= log10(ratio) <= high,
            f"judged at {10**low:.2g} to {10**high:.2g}",
        )
        for (control, name), ratio in growth.items()
    ]
    for name in (ATTITUDE, RATE):
        ratio = growth[OBSERVER, name] / growth[FULL_STATE, name]
        rows.append(
            _row(
                f"growth of the {name} with the cone, observer / full state",
                "0.05 to 0.5 deg",
                "observer not affected worse",
                ratio,
                ratio <= NO_WORSE,
                f"judged at a factor of {NO_WORSE:g}",
            )
        )
    return rows


def _steady_table(steady: dict[Key, Steady], choices: Choices) -> Table:
    rows = [[control, angle, *(values.get(name) for name in ERRORS)] for (control, angle), values in steady.items()]
    note = (
        f"Root mean square of the norms from {choices.steady_from:g} to {choices.stop_time:g} s over {choices.draws} "
        f"noise sequences (seeds from {choices.seed}, the same for both controls), each draw held for "
        f"{choices.redraw_period:g} s. Errors are those of the true attitude and rate."
    )
    return Table("Steady-state errors", ["control", "cone half-angle [deg]", *ERRORS], rows, note, GROUP)


def _period_table(periods: dict[float, dict[str, Steady]]) -> Table:
    rows = []
    for period, values in periods.items():
        ratios = [values[OBSERVER][name] / values[FULL_STATE][name] for name in (ATTITUDE, RATE)]
        errors = [values[control][name] for control in CONTROLS for name in (ATTITUDE, RATE)]
        rows.append([period, *errors, *ratios])
    columns = [
        "redraw period [s]",
        *(f"{error}, {control}" for control in CONTROLS for error in ("attitude", "rate")),
        "attitude, observer / full state",
        "rate, observer / full state",
    ]
    note = (
        "The text does not say how long a draw is held. The period sets how large the errors are, since faster noise "
        "is averaged away; the last two columns show what it does to the comparison of the two controls."
    )
    return Table(f"Other redraw periods, {SMALL:g} deg", columns, rows, note, GROUP)


def _panels(runs: dict[Key, list[Signals]]) -> list[Panel]:
    """The first noise sequence."""
    small = {control: runs[control, SMALL][0] for control in CONTROLS}
    both = {f"{angle:g} deg": runs[OBSERVER, angle][0] for angle in (SMALL, LARGE)}
    return [
        norm_panel(ATTITUDE, small, "Fig. 5.3  Attitude tracking error, 0.05 deg", GROUP),
        norm_panel(RATE, small, "Fig. 5.3  Rate tracking error, 0.05 deg", GROUP),
        norm_panel(ATTITUDE_ESTIMATE, small, "Fig. 5.4  Attitude estimation error, 0.05 deg", GROUP),
        norm_panel(RATE_ESTIMATE, small, "Fig. 5.4  Rate estimation error, 0.05 deg", GROUP),
        norm_panel(TORQUE, small, "Fig. 5.4  Control torque, 0.05 deg", GROUP, log=False),
        norm_panel(ATTITUDE, both, "Attitude tracking error, observer, both cones", GROUP),
    ]
