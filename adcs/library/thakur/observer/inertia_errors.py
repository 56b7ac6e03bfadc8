"""Sec. 5.4.4, Fig. 5.8: the observer with a wrong inertia, at zero torque."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from adcs.library import attitude
from adcs.library.outcome import Outcome, Row, Runner, Verdict, claims_table, verdict
from adcs.library.thakur.choices import Choices, Matrix
from adcs.library.thakur.observer.settings import INERTIA, INERTIA_ERRORS
from adcs.library.thakur.observer.signals import (
    ATTITUDE_ESTIMATE,
    RATE_ESTIMATE,
    SYMBOLS,
    Signals,
    component_panel,
    norm_panel,
)
from adcs.library.thakur.observer.systems import observer_inertia_error
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber, Table
from orchestration.results.result import Result
from orchestration.running.method import ModelExchange
from orchestration.running.save import Save

GROUP = "5.4.4  Inertia errors"
EXACT, FIRST, SECOND = "exact J", "J + ΔJ₁", "J + ΔJ₂"
NO_ERROR: Matrix = ((0.0,) * 3,) * 3
ERRORS = {EXACT: NO_ERROR, FIRST: INERTIA_ERRORS[0], SECOND: INERTIA_ERRORS[1]}
PRINTED_NORMS = {FIRST: 0.1, SECOND: 0.3}  # of the error over that of J
SIMILAR = 1.2  # times of convergence are similar within this factor
RECORD = ("plant.q_BN", "plant.omega_BN_B", "observer.q_EN", "observer.omega_EN_E")
NAMES = (ATTITUDE_ESTIMATE, RATE_ESTIMATE)
STEP = 0.1  # s
RUNS = len(ERRORS)

Runs = Mapping[str, Signals]


def estimation(result: Result) -> Signals:
    """The estimation errors of a run of `observer-inertia-error`."""
    q_BE = attitude.relative_quaternion(result["plant.q_BN"], result["observer.q_EN"])
    rate = attitude.rate_error(result["plant.omega_BN_B"], q_BE, result["observer.omega_EN_E"])
    return Signals(result.time, {ATTITUDE_ESTIMATE: q_BE[:, 1:], RATE_ESTIMATE: rate})


def figures(result: Result) -> list[Panel]:
    """Show one run."""
    run = {"": estimation(result)}
    return [
        draw
        for name in NAMES
        for draw in (
            component_panel(name, run, group="Estimation"),
            norm_panel(name, run, f"Norm of the {name}", "Estimation"),
        )
    ]


def key_numbers(result: Result) -> list[KeyNumber]:
    """Say when each error has converged, and where it ends."""
    run, part = estimation(result), Choices().settled
    numbers = []
    for name in NAMES:
        title, unit = name.capitalize(), SYMBOLS[name][1].strip(" []")
        time = run.settling_time(name, part)
        numbers.append(KeyNumber(f"{title} converged", time, "s", f"stays below {part:.0%} of its peak"))
        numbers.append(KeyNumber(f"{title} at the end", float(run.norm(name)[-1]), unit, f"at {run.time[-1]:g} s"))
    return numbers


def inertia_errors(run: Runner, choices: Choices) -> Outcome:
    """The observer with J, J + delta J_1 and J + delta J_2: norms, transients, residual sets."""
    settings = {"stop_time": choices.stop_time, "step": STEP, "method": ModelExchange(), "save": Save(RECORD)}
    runs = {
        label: estimation(run(f"observer at zero torque, {label}", observer_inertia_error(error), **settings))
        for label, error in ERRORS.items()
    }
    rows = [*_norms(), _magnitude(), *_moments(), *_transients(runs, choices), *_residuals(runs, choices)]
    tables = [claims_table(rows, "The statements of Sec. 5.4.4", GROUP), _table(runs, choices)]
    panels = [norm_panel(name, runs, f"Fig. 5.8  {name.capitalize()}", GROUP, note="at zero torque") for name in NAMES]
    worst = max(runs[label].since(choices.steady_from).peak(RATE_ESTIMATE) for label in (FIRST, SECOND))
    number = KeyNumber("Rate estimate with a wrong inertia", worst, "rad/s", "largest error in steady state")
    return Outcome(rows, panels, tables, [number])


def _row(cell: str, settings: str, printed: str, ours: float | str, result: Verdict, note: str) -> Row:
    return Row("thakur", "Sec. 5.4.4", cell, settings, printed, ours, None, result, note)


def _ratio(error: Matrix, order: int | str | None) -> float:
    return float(np.linalg.norm(error, order) / np.linalg.norm(INERTIA, order))  # type: ignore[arg-type]


def _moments_of(label: str) -> list[float]:
    return [float(x) for x in np.linalg.eigvalsh(np.asarray(INERTIA) + np.asarray(ERRORS[label]))]


def _norms() -> list[Row]:
    rows = []
    for label, printed in PRINTED_NORMS.items():
        ours = _ratio(ERRORS[label], 2)
        others = f"Frobenius {_ratio(ERRORS[label], 'fro'):.3g}, largest column sum {_ratio(ERRORS[label], 1):.3g}"
        note = f"spectral norm; {others}; judged by the one digit given"
        cell = f"norm of {label[4:]} over that of J"
        result = verdict(round(ours, 1) == printed)
        rows.append(Row("thakur", "Eq. (5.63)", cell, "", f"≈ {printed}", ours, ours / printed - 1, result, note))
    return rows


def _magnitude() -> Row:
    first, second = (_ratio(ERRORS[label], 2) for label in (FIRST, SECOND))
    return _row(
        "which error is larger and makes the principal moments smaller",
        "",
        "ΔJ₁",
        "ΔJ₂",
        "wrong in print",
        f"‖ΔJ₁‖/‖J‖ = {first:.3g}, ‖ΔJ₂‖/‖J‖ = {second:.3g}, in the order that Eq. (5.63) itself gives (0.1 and 0.3), "
        "and the moments are in the rows below: the prose swaps the two labels, and is judged here with them put right",
    )


def _moments() -> list[Row]:
    true = _moments_of(EXACT)
    rows = []
    for label, printed, sign in ((SECOND, "smaller", -1), (FIRST, "slightly larger", 1)):
        ours = _moments_of(label)
        holding = sum(sign * (a - b) > 0 for a, b in zip(ours, true, strict=True))
        trace = sum(ours) / sum(true)
        note = f"{_list(ours)} against {_list(true)} kg·m²; {holding} of 3 are {printed.split()[-1]}, "
        note += f"their sum {trace:.3g} times as large" + ("" if holding == 3 else ": holds for the sum")
        rows.append(
            _row(
                "principal moments against the true ones, sum",
                label,
                printed,
                trace,
                verdict(sign * (trace - 1) > 0),
                note,
            )
        )
    return rows


def _transients(runs: Runs, choices: Choices) -> list[Row]:
    rows = []
    for name in NAMES:
        exact = runs[EXACT].settling_time(name, choices.settled)
        for label, printed in ((SECOND, "appears to converge faster at first"), (FIRST, "similar transient")):
            time = runs[label].settling_time(name, choices.settled)
            holds = time < exact if label == SECOND else 1 / SIMILAR <= time / exact <= SIMILAR
            areas = runs[label].area(name) / runs[EXACT].area(name)
            note = f"{exact:.4g} s with the exact inertia; ratio of the integrals of the norm {areas:.3g}"
            note += "" if label == SECOND else f"; similar: within a factor of {SIMILAR:g}"
            rows.append(_row(f"{name} converges [s]", label, printed, time, verdict(holds), note))
    return rows


def _residuals(runs: Runs, choices: Choices) -> list[Row]:
    rows = []
    for name in NAMES:
        exact = runs[EXACT].since(choices.steady_from).peak(name)
        for label in (FIRST, SECOND):
            ours = runs[label].since(choices.steady_from).peak(name)
            rows.append(
                _row(
                    f"{name} in steady state{SYMBOLS[name][1]}",
                    label,
                    "bounded, not zero",
                    ours,
                    verdict(1e3 * exact < ours <= choices.settled * runs[label].peak(name)),
                    f"largest after {choices.steady_from:g} s; {exact:.1g} with the exact inertia, still falling",
                )
            )
    return rows


def _table(runs: Runs, choices: Choices) -> Table:
    rows = []
    for label, run in runs.items():
        end = run.since(choices.steady_from)
        times = [run.settling_time(name, choices.settled) for name in NAMES]
        values = [value for name in NAMES for value in (run.peak(name), end.peak(name))]
        rows.append([label, _list(_moments_of(label)), *times, *values])
    columns = ["assumed inertia", "principal moments [kg·m²]", *(f"{name} converged [s]" for name in NAMES)]
    columns += [f"{name}, {what}" for name in NAMES for what in ("peak", "steady state")]
    note = (
        f"Converged: below {choices.settled:.0%} of the peak. Steady state: largest value from "
        f"{choices.steady_from:g} to {choices.stop_time:g} s. The body turns freely at about 0.01 rad/s, which is why "
        "the errors that a wrong inertia leaves are small."
    )
    return Table("The observer with wrong inertias", columns, rows, note, GROUP)


def _list(values: list[float]) -> str:
    return ", ".join(f"{value:.4g}" for value in values)
