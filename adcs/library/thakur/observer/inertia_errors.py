"""Sec. 5.4.4, Fig. 5.8: the observer with a wrong inertia, at zero torque."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from adcs.library.outcome import Claim, Shown
from adcs.library.sections import Section, Simulation
from adcs.library.thakur.choices import Choices, Matrix
from adcs.library.thakur.observer.settings import INERTIA, INERTIA_ERRORS
from adcs.library.thakur.observer.signals import ESTIMATION, RATE_ESTIMATE, estimation
from adcs.library.thakur.observer.systems import observer_inertia_error
from adcs.library.thakur.observer.views import error_numbers, error_panels
from adcs.library.trajectory import Runs, norm_panel
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber, Table
from orchestration.results.result import Result
from orchestration.running.method import ModelExchange

WHERE = "Sec. 5.4.4"
EXACT, FIRST, SECOND = "exact J", "J + ΔJ₁", "J + ΔJ₂"
NO_ERROR: Matrix = ((0.0,) * 3,) * 3
ERRORS = {EXACT: NO_ERROR, FIRST: INERTIA_ERRORS[0], SECOND: INERTIA_ERRORS[1]}
PRINTED_NORMS = {FIRST: 0.1, SECOND: 0.3}  # of the error over that of J
SIMILAR = 1.2  # times of convergence are similar within this factor
STEP = 0.1  # s


def figures(result: Result) -> list[Panel]:
    """Show one run."""
    run = estimation(result)
    return [panel for error in ESTIMATION for panel in error_panels(error, run)]


def key_numbers(result: Result) -> list[KeyNumber]:
    """Say when each error has converged, and where it ends."""
    run = estimation(result)
    return [number for error in ESTIMATION for number in error_numbers(error, run)]


def inertia_errors(choices: Choices) -> Section:
    """The observer with J, J + delta J_1 and J + delta J_2: norms, transients, residual sets."""
    runs = {}
    for name, error in ERRORS.items():
        label, system = f"observer at zero torque, {name}", observer_inertia_error(error)
        runs[name] = Simulation(label, system, estimation, choices.stop_time, STEP, ModelExchange())

    def show(found: Runs) -> Iterator[Shown]:
        for what in ESTIMATION:
            yield norm_panel(what, found, f"Fig. 5.8  {what.title}", note="at zero torque")
        worst = max(found[name].after(choices.steady_from).peak(RATE_ESTIMATE) for name in (FIRST, SECOND))
        note = "largest error in steady state"
        yield KeyNumber("Rate estimate with a wrong inertia", worst, "rad/s", note)
        yield from _norms()
        yield _magnitude()
        yield from _moments()
        yield from _transients(found, choices)
        yield from _residuals(found, choices)
        yield _table(found, choices)

    return Section("5.4.4  Inertia errors", "The statements of Sec. 5.4.4", show, runs)


def _ratio(error: Matrix, order: int | str | None) -> float:
    return float(np.linalg.norm(error, order) / np.linalg.norm(INERTIA, order))  # type: ignore[arg-type]


def _moments_of(label: str) -> list[float]:
    return [float(x) for x in np.linalg.eigvalsh(np.asarray(INERTIA) + np.asarray(ERRORS[label]))]


def _norms() -> Iterator[Claim]:
    for label, printed in PRINTED_NORMS.items():
        ours, frobenius, columns = (_ratio(ERRORS[label], order) for order in (2, "fro", 1))
        yield Claim("Eq. (5.63)", f"norm of {label[4:]} over that of J", "",
                    f"≈ {printed}", ours, round(ours, 1) == printed,
                    f"spectral norm; Frobenius {frobenius:.3g}, largest column sum {columns:.3g}; "
                    "judged by the one digit given", ours / printed - 1)  # fmt: skip


def _magnitude() -> Claim:
    first, second = (_ratio(ERRORS[label], 2) for label in (FIRST, SECOND))
    return Claim(WHERE, "which error is larger and makes the principal moments smaller", "", "ΔJ₁", "ΔJ₂", None,
                 f"‖ΔJ₁‖/‖J‖ = {first:.3g}, ‖ΔJ₂‖/‖J‖ = {second:.3g}, in the order that Eq. (5.63) itself gives (0.1 "
                 "and 0.3), and the moments are in the rows below: the prose swaps the two labels, and is judged here "
                 "with them put right")  # fmt: skip


def _moments() -> Iterator[Claim]:
    true = _moments_of(EXACT)
    for label, printed, sign in ((SECOND, "smaller", -1), (FIRST, "slightly larger", 1)):
        ours = _moments_of(label)
        holding = sum(sign * (a - b) > 0 for a, b in zip(ours, true, strict=True))
        trace = sum(ours) / sum(true)
        yield Claim(WHERE, "principal moments against the true ones, sum", label,
                    printed, trace, sign * (trace - 1) > 0,
                    f"{_list(ours)} against {_list(true)} kg·m²; {holding} of 3 are {printed.split()[-1]}, their sum "
                    f"{trace:.3g} times as large{'' if holding == 3 else ': holds for the sum'}")  # fmt: skip


def _transients(runs: Runs, choices: Choices) -> Iterator[Claim]:
    for error in ESTIMATION:
        exact = runs[EXACT].settled(error, choices.settled)
        for label, printed in ((SECOND, "appears to converge faster at first"), (FIRST, "similar transient")):
            time = runs[label].settled(error, choices.settled)
            areas = runs[label].area(error) / runs[EXACT].area(error)
            similar = "" if label == SECOND else f"; similar: within a factor of {SIMILAR:g}"
            yield Claim(WHERE, f"{error} converges [s]", label,
                        printed, time, time < exact if label == SECOND else 1 / SIMILAR <= time / exact <= SIMILAR,
                        f"{exact:.4g} s with the exact inertia; "
                        f"ratio of the integrals of the norm {areas:.3g}{similar}")  # fmt: skip


def _residuals(runs: Runs, choices: Choices) -> Iterator[Claim]:
    for error in ESTIMATION:
        ends = {label: run.after(choices.steady_from).peak(error) for label, run in runs.items()}
        for label in (FIRST, SECOND):
            ours, small = ends[label], choices.settled * runs[label].peak(error)
            yield Claim(WHERE, f"{error} in steady state{error.in_unit}", label,
                        "bounded, not zero", ours, 1e3 * ends[EXACT] < ours <= small,
                        f"largest after {choices.steady_from:g} s; "
                        f"{ends[EXACT]:.1g} with the exact inertia, still falling")  # fmt: skip


def _table(runs: Runs, choices: Choices) -> Table:
    rows = []
    for label, run in runs.items():
        end = run.after(choices.steady_from)
        times = [run.settled(error, choices.settled) for error in ESTIMATION]
        values = [value for error in ESTIMATION for value in (run.peak(error), end.peak(error))]
        rows.append([label, _list(_moments_of(label)), *times, *values])
    columns = ["assumed inertia", "principal moments [kg·m²]", *(f"{error} converged [s]" for error in ESTIMATION)]
    columns += [f"{error}, {what}" for error in ESTIMATION for what in ("peak", "steady state")]
    note = (
        f"Converged: below {choices.settled:.0%} of the peak. Steady state: largest value from "
        f"{choices.steady_from:g} to {choices.stop_time:g} s. The body turns freely at about 0.01 rad/s, which is why "
        "the errors that a wrong inertia leaves are small."
    )
    return Table("The observer with wrong inertias", columns, rows, note)


def _list(values: Sequence[float]) -> str:
    return ", ".join(f"{value:.4g}" for value in values)
