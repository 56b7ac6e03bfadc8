"""What Secs. 3.4.1 and 3.4.2 have in common: both laws in both readings of the reference, and what is estimated."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from adcs.library.outcome import Claim, Shown
from adcs.library.sections import Section, Simulation
from adcs.library.thakur.adaptive import settings as settings
from adcs.library.thakur.adaptive.baseline import COMPARISON, OUTPUT_STEP, PROPOSED
from adcs.library.thakur.adaptive.settings import FREQUENCIES, Reading
from adcs.library.thakur.adaptive.signals import SIGMA_ERROR, SIGMA_EST, THETA_ERROR, track
from adcs.library.thakur.choices import Choices
from adcs.library.trajectory import Runs, Trajectory
from orchestration.results.report import Table
from orchestration.running.method import ModelExchange
from orchestration.system import System

FULL = "proposed, full parametrisation"
LAST = 60.0  # s at the end, three periods of the printed reference

Read = Mapping[Reading, Runs]
"""The runs of both laws by reading."""


def label(reading: Reading) -> str:
    """How a reading is named in tables."""
    return f"ω₁ = {FREQUENCIES[reading]:g} rad/s"


def last(run: Trajectory) -> Trajectory:
    """The end of a run."""
    return run.between(settings.STOP_TIME - LAST, settings.STOP_TIME)


def in_both_readings(
    number: str,
    name: str,
    builds: Mapping[str, Callable[..., System]],
    show: Callable[[Read, Trajectory], Iterable[Shown]],
) -> Section:
    """A section with both laws in each reading, and the full parametrisation in the printed one.

    `builds` has what makes the systems by the name of the law.
    """
    runs: dict[tuple[str, Reading], Simulation] = {}
    for law, build in builds.items():
        for reading in [reading for reading in FREQUENCIES if law != FULL or reading == "printed"]:
            text = "full parametrisation" if law == FULL else f"{law}, {label(reading)}"
            stop, method = settings.STOP_TIME, ModelExchange()
            system = build(reading)
            runs[law, reading] = Simulation(f"{name}, {text}", system, track, stop, OUTPUT_STEP, method)

    def shown(found: Mapping[Any, Trajectory]) -> Iterable[Shown]:
        read = {reading: {law: found[law, reading] for law in (PROPOSED, COMPARISON)} for reading in FREQUENCIES}
        return show(read, found[FULL, "printed"])

    section = number.split()[0]
    return Section(number, f"The statements of Sec. {section}", shown, runs)


def estimates(section: str, proposed: Trajectory, full: Trajectory, choices: Choices) -> Iterator[Claim]:
    """That sigma converges to the true values and theta does not."""
    near = choices.estimated
    for name, run in ((PROPOSED, proposed), (FULL, full)):
        middle, end = run.at(SIGMA_ERROR, run.time[-1] / 2), run.end(SIGMA_ERROR)
        yield Claim(section, "J_1 estimate converges to the true value", name,
                    "to their true values", f"{end:.1%} off", end < near and end < middle,
                    f"{run[SIGMA_EST].shape[1]} parameters: {middle:.1%} of the true norm at half time; "
                    f"judged at {near:.0%} and falling")  # fmt: skip
    start, end = proposed.start(THETA_ERROR), proposed.end(THETA_ERROR)
    yield Claim(section, "J_0 estimate: error at the end / at the start", PROPOSED,
                "does not converge", end / start, end / start > near,
                f"‖θ̂ - θ‖ from {start:.3g} to {end:.3g} kg.m2; judged at {near:.0%} of the start")  # fmt: skip


def convergence_table(read: Read, full: Trajectory) -> Table:
    """Errors of both estimates over time."""
    times = (0.0, 50.0, 100.0, 200.0, 300.0, 400.0)
    runs = {f"{PROPOSED}, {label(reading)}": runs[PROPOSED] for reading, runs in read.items()} | {FULL: full}
    cells: list[list[object]] = []
    for name, run in runs.items():
        shown = [t for t in times if t <= run.time[-1] + 1e-9]
        cells.append([name, "Ĵ₁ [%]", *(100 * run.at(SIGMA_ERROR, t) for t in shown)])
        cells.append([name, "θ̂ [kg·m²]", *(run.at(THETA_ERROR, t) for t in shown)])
    note = (
        "Norm of the estimation error: of J_1 as a part of the true norm, of J_0 in kg m². The few parameters of the "
        "minimal parametrisation approach the true ones; those of the full one come to rest elsewhere, since many J_1 "
        "give the same torque along one trajectory."
    )
    return Table("Estimates", ["law", "error", *(f"{t:g} s" for t in times)], cells, note)
