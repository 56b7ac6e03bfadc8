"""Sec. 4.3.2: measured vectors that err within a cone of 0.05 deg; Figs. 4.3 and 4.4."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import log10, radians
from typing import Any

import numpy as np

from adcs.library.outcome import Claim, Shown
from adcs.library.sections import Section, Simulation
from adcs.library.thakur.choices import ALMOST_AN_ORDER, NO_WORSE, Choices
from adcs.library.thakur.gyro_free.claims import FULL_STATE, GYRO_FREE
from adcs.library.thakur.gyro_free.settings import HALF_ANGLE
from adcs.library.thakur.gyro_free.signals import ANGLE, MEASURES, RATE, TORQUE, motion
from adcs.library.thakur.gyro_free.systems import gyro_free, gyro_free_full_state
from adcs.library.thakur.sequences import Steady, spread_of, steady
from adcs.library.trajectory import Runs, Trajectory, norm_panel
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber, Table
from orchestration.running.method import ModelExchange
from orchestration.system import System

WHERE = "Sec. 4.3.2"
LARGER = 10 * HALF_ANGLE  # deg
OTHER_PERIODS = (0.02, 0.5)  # s, to see what our choice of the redraw period does
OTHER_SPREAD = 10.0  # nearly uniform on the cone's cap
# At rest the exchange costs little, and 2 ms are short beside the filter's 0.1 s; the table says how little.
EXCHANGE = 0.002  # s
OUTPUT_STEP = 0.1  # s
UNAFFECTED = 0.02  # of the peak
LEFT_OVER = 100.0  # times what is left without noise: then it is the noise's
CONTROLS = {GYRO_FREE: gyro_free, FULL_STATE: gyro_free_full_state}
CLEAN, COUPLED = "no noise", "coupled"

Key = tuple[str, float]  # control, half-angle in deg
Draws = Mapping[Key, list[Trajectory]]
"""A run for each noise sequence; the same sequences for both controls."""


def exchanged(label: str, system: System, choices: Choices) -> Simulation:
    """A run of this chapter with noise."""
    every = round(OUTPUT_STEP / EXCHANGE)
    return Simulation(label, system, motion, choices.rest_stop_time, EXCHANGE, every=every)


def noisy(choices: Choices) -> Section:
    """Both laws in both cones: transient, steady state, comparison."""
    period, spread, seeds = choices.redraw_period, choices.vector_spread, _seeds(choices)
    noises: dict[object, tuple[float, float, float]] = {
        HALF_ANGLE: (HALF_ANGLE, period, spread),
        LARGER: (LARGER, period, spread),
        **{f"redrawn every {p:g} s": (HALF_ANGLE, p, spread) for p in OTHER_PERIODS},
        f"spread {OTHER_SPREAD:g}: uniform in the cone": (HALF_ANGLE, period, OTHER_SPREAD),
    }
    runs: dict[tuple[str, object, int], Simulation] = {}
    for control, build in CONTROLS.items():
        for name, (angle, redrawn, wide) in noises.items():
            for seed in seeds:
                label = f"{control}, {angle:g} deg, redrawn every {redrawn:g} s, spread {wide:.3g}, seed {seed}"
                system = build(half_angle=radians(angle), spread=wide, redraw_period=redrawn, seed=seed)
                runs[control, name, seed] = exchanged(label, system, choices)
        runs[control, CLEAN, 0] = exchanged(f"{control}, no noise", build(), choices)
        first = runs[control, HALF_ANGLE, seeds[0]].system
        runs[control, COUPLED, 0] = Simulation(
            f"{control}, coupled",
            first,
            motion,
            choices.rest_stop_time,
            OUTPUT_STEP,
            ModelExchange(rtol=1e-7, atol=1e-9),
        )
    others = [name for name in noises if isinstance(name, str)]
    title = "The statements of Sec. 4.3.2"
    return Section("4.3.2  Vectors with noise", title, lambda found: _show(found, others, choices), runs)


def _seeds(choices: Choices) -> list[int]:
    return list(range(choices.seed, choices.seed + choices.draws))


def _show(found: Mapping[Any, Trajectory], others: list[str], choices: Choices) -> Iterator[Shown]:
    def drawn(control: str, name: object) -> list[Trajectory]:
        return [found[control, name, seed] for seed in _seeds(choices)]

    runs = {(control, angle): drawn(control, angle) for angle in (HALF_ANGLE, LARGER) for control in CONTROLS}
    level = {key: _steady(value, choices) for key, value in runs.items()}
    exact = {control: found[control, CLEAN, 0] for control in CONTROLS}
    coupled = {control: found[control, COUPLED, 0] for control in CONTROLS}
    own = f"redrawn every {choices.redraw_period:g} s, spread {choices.vector_spread:.3g}"
    compared = {own: {control: level[control, HALF_ANGLE] for control in CONTROLS}}
    compared |= {name: {c: _steady(drawn(c, name), choices) for c in CONTROLS} for name in others}
    ratio = level[GYRO_FREE, HALF_ANGLE][RATE] / level[FULL_STATE, HALF_ANGLE][RATE]
    note = "angular velocity in steady state; printed: not any worse"
    yield from _transient(runs, exact)
    yield from _residual(level, exact, choices)
    yield from _growth(level)
    yield from _no_worse(runs, level, choices)
    yield from _panels(runs)
    yield _steady_table(level, choices)
    yield _comparison_table(compared)
    yield _coupled_table(runs, coupled, choices)
    yield KeyNumber("Gyro-free / full state, 0.05 deg", ratio, "", note)


def _steady(runs: list[Trajectory], choices: Choices) -> Steady:
    return steady(runs, choices.rest_from)


def _transient(runs: Draws, exact: Runs) -> Iterator[Claim]:
    for what in (ANGLE, RATE):
        for control, clean in exact.items():
            off = max(np.abs(run.norm(what) - clean.norm(what)).max() for run in runs[control, HALF_ANGLE])
            part = float(off / clean.peak(what))
            yield Claim(WHERE, f"transient of the {what}: largest change by noise / peak", control,
                        "relatively unaffected", part, part <= UNAFFECTED,
                        f"judged at {UNAFFECTED:g}")  # fmt: skip


def _residual(level: Mapping[Key, Steady], exact: Runs, choices: Choices) -> Iterator[Claim]:
    for what in (ANGLE, RATE):
        for control in CONTROLS:
            ours, clean = level[control, HALF_ANGLE][what], exact[control].after(choices.rest_from).rms(what)
            yield Claim(WHERE, f"{what} in steady state{what.in_unit}", control,
                        "nonzero steady-state value", ours, ours > LEFT_OVER * clean,
                        f"root mean square from {choices.rest_from:g} to {choices.rest_stop_time:g} s; "
                        f"without noise {clean:.1g}")  # fmt: skip


def _growth(level: Mapping[Key, Steady]) -> Iterator[Claim]:
    low, high = ALMOST_AN_ORDER
    for what in (ANGLE, RATE):
        for control in CONTROLS:
            ratio = level[control, LARGER][what] / level[control, HALF_ANGLE][what]
            yield Claim(WHERE, f"{what} in steady state, {LARGER:g} deg / {HALF_ANGLE:g} deg", control,
                        "grows with the cone", ratio, low <= log10(ratio) <= high,
                        f"in proportion, if judged at {10**low:.2g} to {10**high:.2g}")  # fmt: skip


def _no_worse(runs: Draws, level: Mapping[Key, Steady], choices: Choices) -> Iterator[Claim]:
    for what in (ANGLE, RATE):
        ratio = level[GYRO_FREE, HALF_ANGLE][what] / level[FULL_STATE, HALF_ANGLE][what]
        own, full = (runs[control, HALF_ANGLE] for control in (GYRO_FREE, FULL_STATE))
        ratios = spread_of(what, own, full, choices.rest_from)
        worse = "; full state knows the true rate, while the filter's derivative takes noise for motion"
        yield Claim(WHERE, f"{what} in steady state, gyro-free / full state", f"{HALF_ANGLE:g} deg",
                    "noise affects it not any worse than full state", ratio, ratio <= NO_WORSE,
                    f"{ratios}; judged at {NO_WORSE:g}{worse if ratio > NO_WORSE else ''}")  # fmt: skip


def _steady_table(level: Mapping[Key, Steady], choices: Choices) -> Table:
    rows = [[control, angle, *(values[what] for what in MEASURES)] for (control, angle), values in level.items()]
    note = (
        f"Root mean square from {choices.rest_from:g} to {choices.rest_stop_time:g} s over {choices.draws} noise "
        f"sequences (seeds from {choices.seed}, the same for both), each draw held for {choices.redraw_period:g} s; "
        f"normal within the cone, whose half-angle is {1 / choices.vector_spread:.3g} standard deviations. Angle and "
        "rate are the true ones."
    )
    columns = ["control", "cone half-angle [deg]", *(f"{what}{what.in_unit}" for what in MEASURES)]
    return Table("Steady state with noise", columns, rows, note)


def _comparison_table(cases: Mapping[str, Mapping[str, Steady]]) -> Table:
    rows = []
    for label, values in cases.items():
        ratios = [values[GYRO_FREE][what] / values[FULL_STATE][what] for what in MEASURES]
        rows.append([label, *(values[control][what] for what in (ANGLE, RATE) for control in CONTROLS), *ratios])
    columns = ["noise", *(f"{what}, {control}{what.in_unit}" for what in (ANGLE, RATE) for control in CONTROLS)]
    columns += [f"{what}, gyro-free / full state" for what in MEASURES]
    note = "The text gives neither the redraw period nor the standard deviation. What they do to the comparison:"
    return Table(f"Other noise, {HALF_ANGLE:g} deg", columns, rows, note)


def _coupled_table(runs: Draws, coupled: Runs, choices: Choices) -> Table:
    rows = []
    for control, exact in coupled.items():
        both = [run.after(choices.rest_from) for run in (runs[control, HALF_ANGLE][0], exact)]
        rows.append([control, *(run.rms(what) for what in (ANGLE, RATE) for run in both)])
    pairs = (f"{what}, {method}{what.in_unit}" for what in (ANGLE, RATE) for method in ("2 ms", "coupled"))
    note = "Steady state of the first noise sequence: in co-simulation, as in all runs with noise, and without an "
    note += "exchange step."
    return Table("Co-simulation against the coupled solution, with noise", ["control", *pairs], rows, note)


def _panels(runs: Draws) -> list[Panel]:
    """The first noise sequence."""
    small = {control: runs[control, HALF_ANGLE][0] for control in CONTROLS}
    cones = {f"{angle:g} deg": runs[GYRO_FREE, angle][0] for angle in (HALF_ANGLE, LARGER)}
    return [
        norm_panel(RATE, small, f"Fig. 4.3a  Angular velocity, {HALF_ANGLE:g} deg"),
        norm_panel(ANGLE, small, f"Fig. 4.3b  Rotation angle, {HALF_ANGLE:g} deg"),
        norm_panel(TORQUE, small, f"Fig. 4.4  Control torque, {HALF_ANGLE:g} deg"),
        norm_panel(ANGLE, cones, "Rotation angle, gyro-free, both cones"),
    ]
