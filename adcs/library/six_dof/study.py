"""The study: the paper's theorem on a scenario of ours."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from adcs.library.outcome import Claim, Shown
from adcs.library.sections import Section, Simulation, study_of
from adcs.library.six_dof.settings import LENGTH_UNIT, MASS_UNIT, TIME_UNIT, Choices, Scaling
from adcs.library.six_dof.signals import (
    ATTITUDE,
    DELTA_V,
    ERRORS,
    FORCE,
    GRADIENT_FORCE,
    GRADIENT_TORQUE,
    POSITION,
    RATE,
    TORQUE,
    VELOCITY,
    signals,
)
from adcs.library.six_dof.systems import saturated, six_dof
from adcs.library.trajectory import Runs, Trajectory, norm_panel
from orchestration.results.plots import Guide, Panel
from orchestration.results.report import KeyNumber, Table
from orchestration.running.method import ModelExchange

TITLE = "Orbit and attitude at once, without any velocity measurement: Pan, Wong, Kapila"
SUMMARY = (
    "A spacecraft of 100 kg starts 27 m away from its place on an orbit, and 45 degrees from its attitude. Both are "
    "to follow a reference: the orbit an ellipse, the attitude a swinging motion. Position and attitude are measured, "
    "no velocity is. The paper proves convergence and simulates nothing, so the scenario is ours, and its claims are "
    "set beside what the components compute; with unlimited actuators, with limited ones, and in SI units, as printed."
)
FREE, LIMITED, PRINTED = "scaled units, no limits", "scaled units, limited", "SI units, as printed"
COUPLED = ModelExchange(rtol=1e-10, atol=1e-9)
"""An absolute tolerance below 1e-9 m asks for more than positions of 7e6 m can hold in double precision."""
OUTPUT_STEP, SHORT_STEP, SHORT_STOP = 0.5, 0.05, 60.0  # s
STEPS, GRID = (1.0, 0.5, 0.2, 0.1), 1.0  # s, of the exchange, and where its solutions are compared
GROUP, CONTROL_GROUP, STEP_GROUP = "Convergence", "Force and torque", "Exchange step"
NEGLIGIBLE = {POSITION: 1e-6, VELOCITY: 1e-8, ATTITUDE: 1e-9, RATE: 1e-10}  # m, m/s, 1, rad/s: converged to zero


def sections(choices: Choices) -> list[Section]:
    """The theorem, and what the exchange step of a co-simulation costs."""
    stop, limits = choices.stop_time, (choices.max_force, choices.max_torque)
    free = Simulation(FREE, six_dof(), signals, stop, OUTPUT_STEP, COUPLED)
    limited = Simulation(LIMITED, saturated(*limits), signals, stop, OUTPUT_STEP, COUPLED)
    si_units = six_dof(scaling=Scaling(1.0, 1.0, 1.0))
    printed = Simulation(PRINTED, si_units, signals, SHORT_STOP, SHORT_STEP, COUPLED)
    exchanged = {
        step: Simulation(f"co-simulation at {step:g} s", six_dof(), signals, stop, step, every=round(GRID / step))
        for step in STEPS
    }
    return [
        Section(
            GROUP,
            "The claims of the paper",
            lambda runs: _theorem(runs, choices),
            {FREE: free, LIMITED: limited, PRINTED: printed},
        ),
        Section(STEP_GROUP, "", _exchange_step, {"coupled": free, **exchanged}),
    ]


run = study_of(sections)


def _theorem(runs: Runs, choices: Choices) -> Iterator[Shown]:
    yield from _convergence(runs)
    yield _blind()
    yield from ERRATA
    yield from _panels(runs, choices)
    yield _settling_table(runs, choices)
    yield _effort_table(runs)
    yield from _key_numbers(runs, choices)


def _convergence(runs: Runs) -> Iterator[Claim]:
    for label, run_ in runs.items():
        unproven = "; the theorem knows no limits, that it converges all the same is an observation"
        for error, limit in NEGLIGIBLE.items():
            end = run_.end(error)
            yield Claim("Theorem 4.1", f"{error} converges to zero", label,
                        "asymptotically", end, end < limit,
                        f"{error.size} at {run_.time[-1]:g} s, {run_.start(error):.3g} at the start; "
                        f"judged at {limit:g}{unproven if label == LIMITED else ''}")  # fmt: skip


def _blind() -> Claim:
    """That no velocity reaches filter or controller can be read off the wiring."""
    links = [(c.source, c.target.split(".")[0]) for c in six_dof().connections]
    fed = sorted({source for source, user in links if user in ("filter", "controller") and source.startswith("plant.")})
    velocities = ", ".join(source for source in fed if source in ("plant.v_BN_N", "plant.omega_BN_B")) or "none"
    return Claim("Theorem 4.1", "velocity measurements used", "connections from the plant to filter and controller",
                 "none", velocities, velocities == "none",
                 f"they receive {', '.join(fed)}; the rate of the reference is known, not measured")  # fmt: skip


ERRATA = (
    Claim("after (59)", "det T", "", "e_ζ", "e_ζ / 8", None,
          "T = ½(e_ζ I + S(e_ε)), three factors ½; invertible all the same; see tests/laws"),
    Claim("(47)", "k_max", "", "max{k_eR, k_y}", "min{k_eR, k_y}", None,
          "both terms of the bound after (56) must be covered; see tests/laws"),
    Claim("Sec. II", "skew matrix of the vectrices", "", "misprinted", "[0 -a3 a2; a3 0 -a1; -a2 a1 0]", None,
          "as (29) uses it; see tests/laws"),
)  # fmt: skip


def _panels(runs: Runs, choices: Choices) -> list[Panel]:
    both = {label: runs[label] for label in (FREE, LIMITED)}
    panels = [norm_panel(error, both) for error in ERRORS]
    for what, limit in ((FORCE, choices.max_force), (TORQUE, choices.max_torque)):
        guide = Guide(limit * np.sqrt(3), "all axes at their limit")
        panels.append(norm_panel(what, both, group=CONTROL_GROUP, guides=(guide,)))
    return [*panels, norm_panel(DELTA_V, both, group=CONTROL_GROUP, log=False)]


def _settling_table(runs: Runs, choices: Choices) -> Table:
    parts = (0.1, choices.settled, 1e-4)
    cells = []
    for error in ERRORS:
        for label, run_ in runs.items():
            start = run_.start(error)
            cells.append([error.name, label, start, *(run_.settled(error, part, start) for part in parts)])
    columns = ["error", "run", "at the start", *(f"below {part:g} of it [s]" for part in parts)]
    return Table("When the errors have converged", columns, cells, "Time from which on the norm stays below.")


def _effort_table(runs: Runs) -> Table:
    cells = [
        [label, r.time[-1], r.peak(FORCE), r.end(DELTA_V), r.peak(TORQUE), r.area(TORQUE)] for label, r in runs.items()
    ]
    gradient = [runs[FREE].peak(what) for what in (GRADIENT_FORCE, GRADIENT_TORQUE)]
    note = (
        "‖F‖ and ‖τ‖ are Euclidean; the velocity increment is the integral of ‖F‖ over the mass, by the actuator "
        "itself. The torque lasts, as the reference attitude swings. The law is applied in units of "
        f"{LENGTH_UNIT:g} m, {TIME_UNIT:g} s and {MASS_UNIT:g} kg; in SI units its built-in time constant is 1 s, and "
        f"27 m take kilonewtons. Gravity on the extent of the body: at most {gradient[0]:.1e} N, {gradient[1]:.1e} N·m."
    )
    columns = ["run", "until [s]", "largest ‖F‖ [N]", "velocity increment [m/s]", "largest ‖τ‖ [N·m]", "∫‖τ‖dt [N·m·s]"]
    return Table("Force, torque and velocity increment", columns, cells, note, CONTROL_GROUP)


def _key_numbers(runs: Runs, choices: Choices) -> list[KeyNumber]:
    free, limited, printed = (runs[label] for label in (FREE, LIMITED, PRINTED))
    part = f"stays below {choices.settled:.0%} of its start"
    times = [free.settled(error, choices.settled, free.start(error)) for error in (POSITION, ATTITUDE)]
    return [
        KeyNumber("Position error converged", times[0], "s", part),
        KeyNumber("Attitude error converged", times[1], "s", part),
        KeyNumber("Velocity increment", free.end(DELTA_V), "m/s", f"{limited.end(DELTA_V):.3g} m/s with limits"),
        KeyNumber("Largest force", free.peak(FORCE), "N", f"{printed.peak(FORCE):.4g} N in SI units"),
        KeyNumber("Largest torque", free.peak(TORQUE), "N·m", f"{printed.peak(TORQUE):.3g} N·m in SI units"),
    ]


def _exchange_step(runs: Mapping[object, Trajectory]) -> Iterator[Shown]:
    coupled = runs["coupled"].every(round(GRID / OUTPUT_STEP))
    cells: list[list[object]] = []
    for step in STEPS:
        run_ = runs[step]
        away = [float(np.abs(run_.norm(what) - coupled.norm(what)).max()) for what in (POSITION, ATTITUDE)]
        cells.append([step, *away, run_.end(DELTA_V)])
    cells.append(["coupled", None, None, coupled.end(DELTA_V)])
    note = "Largest difference of the norms of the errors from the coupled solution, each second. "
    note += "Force and torque are held for a step."
    columns = ["exchange step [s]", "‖e_R‖ [m]", "‖e_ε‖", "velocity increment [m/s]"]
    yield Table("Co-simulation", columns, cells, note)
