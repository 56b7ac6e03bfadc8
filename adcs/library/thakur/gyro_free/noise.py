"""Sec. 4.3.2: measured vectors that err within a cone of 0.05 deg, from one start and from ten random ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import log10, radians

import numpy as np

from adcs.library.attitude import rms
from adcs.library.outcome import Outcome, Row, Runner, Verdict, claims_table, verdict
from adcs.library.thakur.choices import ALMOST_AN_ORDER, NO_WORSE, Choices
from adcs.library.thakur.gyro_free.claims import FULL_STATE, GYRO_FREE
from adcs.library.thakur.gyro_free.level import start_value, sufficient_level
from adcs.library.thakur.gyro_free.settings import HALF_ANGLE, Start
from adcs.library.thakur.gyro_free.signals import ANGLE, MEASURES, RATE, SYMBOLS, TORQUE, Motion, motion, panel
from adcs.library.thakur.gyro_free.systems import RECORD, gyro_free, gyro_free_full_state
from adcs.library.thakur.sequences import spread
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber, Table
from orchestration.running.method import ModelExchange
from orchestration.running.save import Save
from orchestration.system import System

GROUP = "4.3.2  Vectors with noise"
GROUP_STARTS = "4.3.2  Random initial conditions"
LARGER = 10 * HALF_ANGLE  # deg
OTHER_PERIODS = (0.02, 0.5)  # s, to see what our choice of the redraw period does
OTHER_SPREAD = 10.0  # nearly uniform on the cone's cap
# At rest the exchange costs little, and 2 ms are short beside the filter's 0.1 s; the table says how little.
EXCHANGE = 0.002  # s
OUTPUT_STEP = 0.1  # s
UNAFFECTED = 0.02  # of the peak
LEFT_OVER = 100.0  # times what is left without noise: then it is the noise's
CONTROLS: dict[str, Callable[..., System]] = {GYRO_FREE: gyro_free, FULL_STATE: gyro_free_full_state}

Key = tuple[str, float]  # control, half-angle in deg
Steady = dict[str, float]


def run_count(choices: Choices) -> int:
    """How many runs `noisy` makes."""
    return len(CONTROLS) * ((3 + len(OTHER_PERIODS)) * choices.draws + 2)


def noisy(run: Runner, choices: Choices) -> Outcome:
    """Both laws in both cones: transient, steady state, comparison; Figs. 4.3 and 4.4."""
    period, spread = choices.redraw_period, choices.vector_spread
    runs = {
        (control, angle): _draws(run, control, angle, period, spread, choices)
        for angle in (HALF_ANGLE, LARGER)
        for control in CONTROLS
    }
    steady = {key: _steady(value, choices) for key, value in runs.items()}
    exact = {
        control: _motion(run, f"{control}, no noise", CONTROLS[control](), choices.rest_stop_time)
        for control in CONTROLS
    }
    others = {
        f"redrawn every {p:g} s": {
            c: _steady(_draws(run, c, HALF_ANGLE, p, spread, choices), choices) for c in CONTROLS
        }
        for p in OTHER_PERIODS
    }
    others[f"spread {OTHER_SPREAD:g}: uniform in the cone"] = {
        c: _steady(_draws(run, c, HALF_ANGLE, period, OTHER_SPREAD, choices), choices) for c in CONTROLS
    }
    own = {f"redrawn every {period:g} s, spread {spread:.3g}": {c: steady[c, HALF_ANGLE] for c in CONTROLS}}
    coupled = {control: _coupled(run, control, choices) for control in CONTROLS}
    rows = [
        *_transient(runs, exact),
        *_residual(steady, exact, choices),
        *_growth(steady),
        *_no_worse(runs, steady, choices),
    ]
    tables = [
        claims_table(rows, "The statements of Sec. 4.3.2", GROUP),
        _steady_table(steady, choices),
        _comparison_table({**own, **others}),
        _coupled_table(runs, coupled, choices),
    ]
    number = KeyNumber(
        "Gyro-free / full state, 0.05 deg",
        steady[GYRO_FREE, HALF_ANGLE][RATE] / steady[FULL_STATE, HALF_ANGLE][RATE],
        "",
        "angular velocity in steady state; printed: not any worse",
    )
    return Outcome(rows, _panels(runs), tables, [number])


def _motion(run: Runner, label: str, system: System, stop_time: float) -> Motion:
    result = run(label, system, stop_time=stop_time, step=EXCHANGE, save=Save(RECORD))
    return motion(result).every(round(OUTPUT_STEP / EXCHANGE))


def _draws(run: Runner, control: str, angle: float, period: float, spread: float, choices: Choices) -> list[Motion]:
    """One run for each noise sequence; the same sequences for both controls."""
    return [
        _motion(
            run,
            f"{control}, {angle:g} deg, redrawn every {period:g} s, spread {spread:.3g}, seed {seed}",
            CONTROLS[control](half_angle=radians(angle), spread=spread, redraw_period=period, seed=seed),
            choices.rest_stop_time,
        )
        for seed in range(choices.seed, choices.seed + choices.draws)
    ]


def _coupled(run: Runner, control: str, choices: Choices) -> Motion:
    """The first noise sequence once more, without an exchange step."""
    system = CONTROLS[control](
        half_angle=radians(HALF_ANGLE),
        spread=choices.vector_spread,
        redraw_period=choices.redraw_period,
        seed=choices.seed,
    )
    settings = {"method": ModelExchange(rtol=1e-7, atol=1e-9)}
    return motion(
        run(
            f"{control}, coupled",
            system,
            stop_time=choices.rest_stop_time,
            step=OUTPUT_STEP,
            save=Save(RECORD),
            **settings,
        )
    )


def _steady(runs: Sequence[Motion], choices: Choices) -> Steady:
    """Root mean square over time in steady state and over the runs."""
    ends = [run.since(choices.rest_from) for run in runs]
    return {name: rms(np.concatenate([end.values[name] for end in ends])) for name in MEASURES}


def _row(cell: str, settings: str, printed: str, ours: float | str, result: Verdict, note: str) -> Row:
    return Row("thakur", "Sec. 4.3.2", cell, settings, printed, ours, None, result, note)


def _transient(runs: dict[Key, list[Motion]], exact: dict[str, Motion]) -> list[Row]:
    rows = []
    for name in (ANGLE, RATE):
        for control, clean in exact.items():
            off = max(np.abs(r.values[name] - clean.values[name]).max() for r in runs[control, HALF_ANGLE])
            part = float(off / clean.peak(name))
            rows.append(
                _row(
                    f"transient of the {name}: largest change by noise / peak",
                    control,
                    "relatively unaffected",
                    part,
                    verdict(part <= UNAFFECTED),
                    f"judged at {UNAFFECTED:g}",
                )
            )
    return rows


def _residual(steady: dict[Key, Steady], exact: dict[str, Motion], choices: Choices) -> list[Row]:
    rows = []
    for name in (ANGLE, RATE):
        for control in CONTROLS:
            ours, clean = steady[control, HALF_ANGLE][name], exact[control].since(choices.rest_from).rms(name)
            note = f"root mean square from {choices.rest_from:g} to {choices.rest_stop_time:g} s; "
            note += f"without noise {clean:.1g}"
            cell = f"{name} in steady state {SYMBOLS[name].partition(' ')[2]}"
            printed = "nonzero steady-state value"
            rows.append(_row(cell, control, printed, ours, verdict(ours > LEFT_OVER * clean), note))
    return rows


def _growth(steady: dict[Key, Steady]) -> list[Row]:
    low, high = ALMOST_AN_ORDER
    rows = []
    for name in (ANGLE, RATE):
        for control in CONTROLS:
            ratio = steady[control, LARGER][name] / steady[control, HALF_ANGLE][name]
            rows.append(
                _row(
                    f"{name} in steady state, {LARGER:g} deg / {HALF_ANGLE:g} deg",
                    control,
                    "grows with the cone",
                    ratio,
                    verdict(low <= log10(ratio) <= high),
                    f"in proportion, if judged at {10**low:.2g} to {10**high:.2g}",
                )
            )
    return rows


def _no_worse(runs: dict[Key, list[Motion]], steady: dict[Key, Steady], choices: Choices) -> list[Row]:
    rows = []
    for name in (ANGLE, RATE):
        ratio = steady[GYRO_FREE, HALF_ANGLE][name] / steady[FULL_STATE, HALF_ANGLE][name]
        pair = ([_steady([r], choices)[name] for r in runs[c, HALF_ANGLE]] for c in (GYRO_FREE, FULL_STATE))
        note = f"{spread(*pair)}; judged at {NO_WORSE:g}"
        if ratio > NO_WORSE:
            note += "; full state knows the true rate, while the filter's derivative takes noise for motion"
        rows.append(
            _row(
                f"{name} in steady state, gyro-free / full state",
                f"{HALF_ANGLE:g} deg",
                "noise affects it not any worse than full state",
                ratio,
                verdict(ratio <= NO_WORSE),
                note,
            )
        )
    return rows


def _steady_table(steady: dict[Key, Steady], choices: Choices) -> Table:
    rows = [[control, angle, *(values[name] for name in MEASURES)] for (control, angle), values in steady.items()]
    note = (
        f"Root mean square from {choices.rest_from:g} to {choices.rest_stop_time:g} s over {choices.draws} noise "
        f"sequences (seeds from {choices.seed}, the same for both), each draw held for {choices.redraw_period:g} s; "
        f"normal within the cone, whose half-angle is {1 / choices.vector_spread:.3g} standard deviations. Angle and "
        "rate are the true ones."
    )
    columns = ["control", "cone half-angle [deg]", *(f"{name} {SYMBOLS[name].partition(' ')[2]}" for name in MEASURES)]
    return Table("Steady state with noise", columns, rows, note, GROUP)


def _comparison_table(cases: dict[str, dict[str, Steady]]) -> Table:
    rows = []
    for label, values in cases.items():
        ratios = [values[GYRO_FREE][name] / values[FULL_STATE][name] for name in MEASURES]
        rows.append([label, *(values[c][n] for n in (ANGLE, RATE) for c in CONTROLS), *ratios])
    columns = ["noise", *(f"{n}, {c} {SYMBOLS[n].partition(' ')[2]}" for n in (ANGLE, RATE) for c in CONTROLS)]
    columns += [f"{name}, gyro-free / full state" for name in MEASURES]
    note = "The text gives neither the redraw period nor the standard deviation. What they do to the comparison:"
    return Table(f"Other noise, {HALF_ANGLE:g} deg", columns, rows, note, GROUP)


def _coupled_table(runs: dict[Key, list[Motion]], coupled: dict[str, Motion], choices: Choices) -> Table:
    rows = []
    for control, exact in coupled.items():
        both = [run.since(choices.rest_from) for run in (runs[control, HALF_ANGLE][0], exact)]
        rows.append([control, *(run.rms(name) for name in (ANGLE, RATE) for run in both)])
    columns = [
        "control",
        *(f"{n}, {m} {SYMBOLS[n].partition(' ')[2]}" for n in (ANGLE, RATE) for m in ("2 ms", "coupled")),
    ]
    note = (
        "Steady state of the first noise sequence: in co-simulation, as in all runs with noise, and without an "
        "exchange step."
    )
    return Table("Co-simulation against the coupled solution, with noise", columns, rows, note, GROUP)


def _panels(runs: dict[Key, list[Motion]]) -> list[Panel]:
    """The first noise sequence."""
    small = {control: runs[control, HALF_ANGLE][0] for control in CONTROLS}
    cones = {f"{angle:g} deg": runs[GYRO_FREE, angle][0] for angle in (HALF_ANGLE, LARGER)}
    return [
        panel(RATE, small, f"Fig. 4.3a  Angular velocity, {HALF_ANGLE:g} deg", GROUP, log=True),
        panel(ANGLE, small, f"Fig. 4.3b  Rotation angle, {HALF_ANGLE:g} deg", GROUP, log=True),
        panel(TORQUE, small, f"Fig. 4.4  Control torque, {HALF_ANGLE:g} deg", GROUP, log=True),
        panel(ANGLE, cones, "Rotation angle, gyro-free, both cones", GROUP, log=True),
    ]


def random_starts(run: Runner, choices: Choices) -> Outcome:
    """The gyro-free law from random attitudes and rates: bounded, and how large in the end; Figs. 4.5 and 4.6."""
    starts = draw_starts(choices)
    runs = []
    for i, start in enumerate(starts):
        seed = choices.seed + choices.draws + i  # other noise than in the runs from the start of the text
        noise = {"half_angle": radians(HALF_ANGLE), "spread": choices.vector_spread, "seed": seed}
        system = gyro_free(start, redraw_period=choices.redraw_period, **noise)  # type: ignore[arg-type]
        runs.append(_motion(run, f"gyro-free, random start {i + 1} of {len(starts)}", system, choices.rest_stop_time))
    rows = []
    for name in (ANGLE, RATE):
        ends = [r.since(choices.rest_from).peak(name) for r in runs]
        bounded = sum(end <= choices.settled * r.peak(name) for r, end in zip(runs, ends, strict=True))
        note = f"after {choices.rest_from:g} s below {choices.settled:g} of the run's own peak; "
        note += f"never above {max(ends):.2g} "
        rows.append(
            _row(
                f"{name} remains bounded within a residual set",
                f"{len(runs)} random starts, {HALF_ANGLE:g} deg",
                "all",
                f"{bounded} of {len(runs)}",
                verdict(bounded == len(runs)),
                note + SYMBOLS[name].partition("[")[2].rstrip("]"),
            )
        )
    labelled = {f"run {i + 1}": r for i, r in enumerate(runs)}
    figures = {ANGLE: "4.5", RATE: "4.5", TORQUE: "4.6"}
    panels = [
        panel(name, labelled, f"Fig. {figures[name]}  {name.capitalize()}", GROUP_STARTS, log=True, faint=True)
        for name in MEASURES
    ]
    tables = [
        claims_table(rows, "The statement on random initial conditions", GROUP_STARTS),
        _starts(starts, runs, choices),
    ]
    return Outcome(rows, panels, tables)


def draw_starts(choices: Choices) -> list[Start]:
    """Attitudes uniform over all rotations, rates uniform within a cube."""
    random = np.random.default_rng(choices.start_seed)
    starts = []
    for _ in range(choices.starts):
        q = random.normal(size=4)
        omega = random.uniform(-choices.rest_rate, choices.rest_rate, 3)
        starts.append(Start(tuple((q / np.linalg.norm(q)).tolist()), tuple(omega.tolist())))
    return starts


def _starts(starts: list[Start], runs: list[Motion], choices: Choices) -> Table:
    rows = []
    for i, (start, run) in enumerate(zip(starts, runs, strict=True)):
        vectors = (start.q_BN, start.omega_BN_B)
        settled = run.settling_time(ANGLE, choices.settled)
        level = start_value(start) / sufficient_level()
        rows.append([i + 1, *(", ".join(f"{x:.3f}" for x in v) for v in vectors), run.values[ANGLE][0], level, settled])
    beyond = sum(row[4] >= 1 for row in rows)
    note = (
        f"Our choice: q(0) uniform over all rotations, ω(0) uniform within ±{choices.rest_rate:g} rad/s per axis, seed "
        f"{choices.start_seed}. {beyond} of {len(rows)} start above the level below which convergence is proven "
        "(corrected, see 4.2.3): that condition is sufficient, not necessary."
    )
    columns = [
        "run",
        "q(0)",
        "ω(0) [rad/s]",
        "initial angle [deg]",
        "V(0) / sufficient level",
        "angle converged after [s]",
    ]
    return Table("The random starts", columns, rows, note, GROUP_STARTS)
