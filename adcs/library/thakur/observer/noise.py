"""Sec. 5.4.2: the eigenaxis of the measured attitude errs within a cone of 0.05 and of 0.5 deg; Figs. 5.3 and 5.4."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from math import log10, radians

from adcs.library.outcome import Claim, Shown
from adcs.library.sections import Section, Simulation
from adcs.library.thakur.choices import ALMOST_AN_ORDER, NO_WORSE, Choices
from adcs.library.thakur.observer.noise_free import BOTH, FULL_STATE, OBSERVER
from adcs.library.thakur.observer.signals import (
    ATTITUDE,
    ATTITUDE_ESTIMATE,
    ERRORS,
    RATE_ESTIMATE,
    TORQUE,
    TRACKING,
    signals,
)
from adcs.library.thakur.observer.systems import full_state_pd, observer_pd
from adcs.library.thakur.sequences import Steady, spread_of, steady
from adcs.library.trajectory import Trajectory, norm_panel
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber, Table
from orchestration.running.method import ModelExchange
from orchestration.system import System

WHERE = "Sec. 5.4.2"
SMALL, LARGE = 0.05, 0.5  # deg, half-angles of the cone
OTHER_PERIODS = (0.5, 2.0)  # s, to see what our choice of the redraw period does
# Coupled, with an event at each draw: exchanging the torque even every millisecond would leave an error not far below
# that of the small cone. Noise makes more digits than these meaningless.
COUPLED = ModelExchange(rtol=1e-7, atol=1e-9)
OUTPUT_STEP = 0.1  # s
CONTROLS: dict[str, Callable[..., System]] = {OBSERVER: observer_pd, FULL_STATE: full_state_pd}

Key = tuple[str, float]  # control, half-angle in deg
Draws = Mapping[Key, list[Trajectory]]
"""A run for each noise sequence; the same sequences for both controls."""


def drawn(control: str, angle: float, period: float, seed: int, choices: Choices) -> Simulation:
    """The run with one noise sequence."""
    label = f"{control}, {angle:g} deg, redrawn every {period:g} s, seed {seed}"
    system = CONTROLS[control](half_angle=radians(angle), redraw_period=period, seed=seed)
    return Simulation(label, system, signals, choices.stop_time, OUTPUT_STEP, COUPLED)


def noisy(choices: Choices) -> Section:
    """Steady-state errors with noise, both controls, both cones."""
    period, seeds = choices.redraw_period, range(choices.seed, choices.seed + choices.draws)
    noises = [(angle, period) for angle in (SMALL, LARGE)] + [(SMALL, other) for other in OTHER_PERIODS]
    runs = {
        (control, angle, redrawn, seed): drawn(control, angle, redrawn, seed, choices)
        for angle, redrawn in noises
        for control in CONTROLS
        for seed in seeds
    }

    def show(found: Mapping[tuple[str, float, float, int], Trajectory]) -> Iterable[Shown]:
        def sequences(control: str, angle: float, redrawn: float) -> list[Trajectory]:
            return [found[control, angle, redrawn, seed] for seed in seeds]

        draws = {(c, angle): sequences(c, angle, period) for angle in (SMALL, LARGE) for c in CONTROLS}
        periods = {
            redrawn: {c: steady(sequences(c, SMALL, redrawn), choices.steady_from) for c in CONTROLS}
            for redrawn in sorted({period, *OTHER_PERIODS})
        }
        return _show(draws, periods, choices)

    return Section("5.4.2  Quaternion with noise", "The statements of Sec. 5.4.2", show, runs)


def _show(runs: Draws, periods: Mapping[float, Mapping[str, Steady]], choices: Choices) -> Iterator[Shown]:
    level = {key: steady(value, choices.steady_from) for key, value in runs.items()}
    observer, full = level[OBSERVER, SMALL][ATTITUDE], level[FULL_STATE, SMALL][ATTITUDE]
    growth, note = (
        level[OBSERVER, LARGE][ATTITUDE] / observer,
        "observer, attitude; printed: almost an order of magnitude",
    )
    yield from _bounded(runs, level, choices)
    yield from _slightly_better(runs, level, choices)
    yield from _angles(level)
    yield from _panels(runs)
    yield _steady_table(level, choices)
    yield _period_table(periods)
    yield KeyNumber("Errors at 0.5 deg / 0.05 deg", growth, "", note)
    yield KeyNumber(
        "Observer / full state, 0.05 deg", observer / full, "", "attitude; printed: full state marginally smaller"
    )


def _bounded(runs: Draws, level: Mapping[Key, Steady], choices: Choices) -> Iterator[Claim]:
    for (control, angle), draws in runs.items():
        for error in (ATTITUDE, ATTITUDE_ESTIMATE):
            if error in level[control, angle]:
                largest = max(run.after(choices.steady_from).peak(error) for run in draws)
                whole = max(run.peak(error) for run in draws)
                yield Claim(WHERE, f"steady-state {error}: bounded, not zero (rms)", f"{control}, {angle:g} deg",
                            "non-zero steady-state value", level[control, angle][error], 0 < largest < whole,
                            f"never above {largest:.2g} after {choices.steady_from:g} s; "
                            f"peak of the run {whole:.2g}")  # fmt: skip


def _slightly_better(runs: Draws, level: Mapping[Key, Steady], choices: Choices) -> Iterator[Claim]:
    for angle in (SMALL, LARGE):
        for error in TRACKING:
            ratio = level[OBSERVER, angle][error] / level[FULL_STATE, angle][error]
            ratios = spread_of(error, runs[OBSERVER, angle], runs[FULL_STATE, angle], choices.steady_from)
            judged = f"judged at a factor of {choices.marginal:g}"
            if ratio <= 1:
                note = f"full state is not better; {ratios}"
            elif ratio <= choices.marginal:
                note = f"{ratios}; {judged}"
            else:
                note = f"full state is better, by more than slightly: {ratios}; {judged}"
            yield Claim(WHERE, f"steady-state {error}, {BOTH}", f"{angle:g} deg",
                        "full state only slightly better (> 1)", ratio, 1 < ratio <= choices.marginal,
                        note)  # fmt: skip


def _angles(level: Mapping[Key, Steady]) -> Iterator[Claim]:
    growth = {
        (control, error): level[control, LARGE][error] / level[control, SMALL][error]
        for control in CONTROLS
        for error in ERRORS
        if error in level[control, SMALL]
    }
    low, high = ALMOST_AN_ORDER
    for (control, error), ratio in growth.items():
        yield Claim(WHERE, f"steady-state {error}, 0.5 deg / 0.05 deg", control,
                    "almost a full order of magnitude", ratio, low <= log10(ratio) <= high,
                    f"judged at {10**low:.2g} to {10**high:.2g}")  # fmt: skip
    for error in TRACKING:
        ratio = growth[OBSERVER, error] / growth[FULL_STATE, error]
        yield Claim(WHERE, f"growth of the {error} with the cone, {BOTH}", "0.05 to 0.5 deg",
                    "observer not affected worse", ratio, ratio <= NO_WORSE,
                    f"judged at a factor of {NO_WORSE:g}")  # fmt: skip


def _steady_table(level: Mapping[Key, Steady], choices: Choices) -> Table:
    rows = [[control, angle, *(values.get(error) for error in ERRORS)] for (control, angle), values in level.items()]
    note = (
        f"Root mean square of the norms from {choices.steady_from:g} to {choices.stop_time:g} s over {choices.draws} "
        f"noise sequences (seeds from {choices.seed}, the same for both controls), each draw held for "
        f"{choices.redraw_period:g} s. Errors are those of the true attitude and rate."
    )
    columns = ["control", "cone half-angle [deg]", *(error.name for error in ERRORS)]
    return Table("Steady-state errors", columns, rows, note)


def _period_table(periods: Mapping[float, Mapping[str, Steady]]) -> Table:
    rows = []
    for period, values in periods.items():
        ratios = [values[OBSERVER][error] / values[FULL_STATE][error] for error in TRACKING]
        rows.append([period, *(values[control][error] for control in CONTROLS for error in TRACKING), *ratios])
    columns = ["redraw period [s]", *(f"{error}, {c}" for c in CONTROLS for error in ("attitude", "rate"))]
    columns += [f"attitude, {BOTH}", f"rate, {BOTH}"]
    note = (
        "The text does not say how long a draw is held. The period sets how large the errors are, since faster noise "
        "is averaged away; the last two columns show what it does to the comparison of the two controls."
    )
    return Table(f"Other redraw periods, {SMALL:g} deg", columns, rows, note)


def _panels(runs: Draws) -> list[Panel]:
    """The first noise sequence."""
    small = {control: runs[control, SMALL][0] for control in CONTROLS}
    both = {f"{angle:g} deg": runs[OBSERVER, angle][0] for angle in (SMALL, LARGE)}
    figures = {**dict.fromkeys(TRACKING, "5.3"), **dict.fromkeys((ATTITUDE_ESTIMATE, RATE_ESTIMATE, TORQUE), "5.4")}
    panels = [
        norm_panel(what, small, f"Fig. {figure}  {what.title}, 0.05 deg", log=what is not TORQUE)
        for what, figure in figures.items()
    ]
    return [*panels, norm_panel(ATTITUDE, both, "Attitude tracking error, observer, both cones")]
