"""The study as a whole: what is guaranteed, what is simulated, and what is wrong in print."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from adcs.library.deruiter.bounded import ERRORS, EXACT, OBSERVER, bounded, run_count
from adcs.library.deruiter.design import Condition, EstimationBounds, Guarantee
from adcs.library.deruiter.exact import RUNS, exact
from adcs.library.deruiter.settings import Choices
from adcs.library.outcome import Outcome, Progress, Row, Runner, claims_table
from orchestration.results.report import Table
from orchestration.results.result import Result
from orchestration.running.run import run as run_system

TITLE = "Adaptive tracking with guaranteed bounds: de Ruiter"
SUMMARY = (
    "A spacecraft of unknown inertia tracks a moving attitude under a disturbance torque, fed with estimates of "
    "attitude and rate. From bounds on disturbance and estimation errors the paper derives bounds on the tracking "
    "errors before any run. It has no simulation: here it is run with exact states, with smooth errors of guaranteed "
    "size, and with an angular velocity observer, the bounds drawn beside the trajectories."
)
GROUP = "Design"


def run(
    choices: Choices, progress: Progress, simulate: Callable[..., Result] = run_system
) -> tuple[Outcome, list[tuple[str, Mapping[str, Any]]]]:
    """Run everything; returns the outcome, and label and manifest of each run."""
    runner = Runner(progress, RUNS + run_count(choices), simulate)
    under_disturbance = bounded(runner, choices)
    undisturbed, _ = exact(runner, choices)
    return design(choices) + under_disturbance + undisturbed + errata(choices), runner.runs


def guarantees(choices: Choices) -> dict[str, Guarantee]:
    """The theorem for each of the three cases."""
    return {
        EXACT: choices.guarantee(EstimationBounds()),
        ERRORS: choices.guarantee(choices.errors()),
        OBSERVER: choices.guarantee(choices.observer_errors()),
    }


def design(choices: Choices) -> Outcome:
    """What is known before any run: the terms, the dead zone, Algorithm 1, and every condition."""
    found = guarantees(choices)
    quantities: list[tuple[str, Callable[[Guarantee], float]]] = [
        ("v_q, attitude estimation error", lambda g: g.estimation.attitude),
        ("v_ω, rate estimation error [rad/s]", lambda g: g.estimation.rate),
        ("dv_q/dt [1/s]", lambda g: g.estimation.attitude_rate),
        ("dv_ω/dt [rad/s²]", lambda g: g.estimation.rate_rate),
        *((f"{name}, Eq. ({41 + i}) {unit}", _term(name)) for i, (name, unit) in enumerate(_UNITS.items())),
        ("lower limit of the dead zone, Eq. (47) [rad/s]", lambda g: g.dead_zone_limit),
        ("dead zone Ω [rad/s]", lambda g: g.dead_zone),
        ("q_1 of Algorithm 1", lambda g: float(g.sequence(1)[0][0])),
        ("q̄, bound on |q|", lambda g: g.q_limit),
        ("2 r̄, bound on |δω| [rad/s]", lambda g: g.rate_limit),
    ]
    rows = [[name, *(value(g) for g in found.values())] for name, value in quantities]
    table = Table("What is guaranteed", ["quantity", *(name.lower() for name in found)], rows, group=GROUP)
    conditions = [
        [same[0].name, same[0].source, same[0].statement, *(_numbers(c) for c in same)]
        for same in zip(*(g.conditions for g in found.values()), strict=True)
    ]
    columns = ["condition", "source", "statement", *(name.lower() for name in found)]
    return Outcome(tables=[table, Table("The conditions of the theorem", columns, conditions, group=GROUP)])


def _numbers(condition: Condition) -> str:
    return f"{condition.left:.4g} < {condition.right:.4g}" + ("" if condition.holds else ": fails")


_UNITS = {"a": "[1/s]", "b": "[rad/s²]", "c": "[1/s]", "d": "[rad/s²]", "e": "[1/s]", "f": "[rad/s²]"}


def _term(name: str) -> Callable[[Guarantee], float]:
    return lambda guarantee: float(guarantee.terms[name])


def errata(choices: Choices) -> Outcome:
    """Misprints, each shown by a test on its own."""
    radius, printed = choices.law.radii[0], (1 + choices.epsilon * choices.eta) ** 0.5
    rows = [
        _erratum(
            "Eq. (23)",
            "projection, otherwise",
            "v",
            "y",
            f"with v the estimate grows e-fold every {1 / choices.gamma:g} s",
        ),
        _erratum(
            "Projection, 2)",
            "radius of G",
            f"√(1+ε η) = {printed:.4g}",
            f"√(1+ε) η = {radius:.4g}",
            "where d = 1 and the projection takes all outward motion away; likewise G_p",
        ),
        _erratum(
            "Eqs. (36), (40)-(48)",
            "bound inside b, d, f and on the left of (40)",
            "of v_ω",
            "of v_ω̃",
            "the error of the filtered rate error, (34); read as that of v_ω, bound (39) fails by a multiple",
        ),
        _erratum("Eq. (10)", "left-hand side", "|v_q4|", "|dv_q4/dt|", "as the right-hand side, which is used in (46)"),
        _erratum(
            "Eq. (32)",
            "third term of the auxiliary acceleration's error",
            "δĈ dω_d/dt",
            "δC dω_d/dt",
            "its bound (34) is the same for both",
        ),
    ]
    return Outcome(rows, tables=[claims_table(rows, "Misprints", "Misprints")])


def _erratum(where: str, what: str, printed: str, ours: str, note: str) -> Row:
    return Row("deruiter", where, what, "", printed, ours, None, "wrong in print", note)
