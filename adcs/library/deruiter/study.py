"""The study as a whole: what is guaranteed, what is simulated, and what is wrong in print."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from adcs.library.deruiter.bounded import bounded, guarantees
from adcs.library.deruiter.design import Condition, Guarantee
from adcs.library.deruiter.exact import exact
from adcs.library.deruiter.settings import Choices
from adcs.library.outcome import Claim, Shown
from adcs.library.sections import Section, study_of
from orchestration.results.report import Table

TITLE = "Adaptive tracking with guaranteed bounds: de Ruiter"
SUMMARY = (
    "A spacecraft of unknown inertia tracks a moving attitude under a disturbance torque, fed with estimates of "
    "attitude and rate. From bounds on disturbance and estimation errors the paper derives bounds on the tracking "
    "errors before any run. It has no simulation: here it is run with exact states, with smooth errors of guaranteed "
    "size, and with an angular velocity observer, the bounds drawn beside the trajectories."
)


def sections(choices: Choices) -> list[Section]:
    """What is known before any run, the runs under disturbance, those without, and misprints."""
    before = Section("Design", "", lambda _: design(choices))
    misprints = Section("Misprints", "Misprints", lambda _: errata(choices))
    return [before, *bounded(choices), exact(choices), misprints]


run = study_of(sections)


def design(choices: Choices) -> Iterator[Shown]:
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
    yield Table("What is guaranteed", ["quantity", *(name.lower() for name in found)], rows)
    conditions = [
        [same[0].name, same[0].source, same[0].statement, *(_numbers(c) for c in same)]
        for same in zip(*(g.conditions for g in found.values()), strict=True)
    ]
    columns = ["condition", "source", "statement", *(name.lower() for name in found)]
    yield Table("The conditions of the theorem", columns, conditions)


def _numbers(condition: Condition) -> str:
    return f"{condition.left:.4g} < {condition.right:.4g}" + ("" if condition.holds else ": fails")


_UNITS = {"a": "[1/s]", "b": "[rad/s²]", "c": "[1/s]", "d": "[rad/s²]", "e": "[1/s]", "f": "[rad/s²]"}


def _term(name: str) -> Callable[[Guarantee], float]:
    return lambda guarantee: float(guarantee.terms[name])


def errata(choices: Choices) -> list[Claim]:
    """Misprints, each shown by a test on its own."""
    radius, printed = choices.law.radii[0], (1 + choices.epsilon * choices.eta) ** 0.5
    return [
        Claim("Eq. (23)", "projection, otherwise", "", "v", "y", None,
              f"with v the estimate grows e-fold every {1 / choices.gamma:g} s"),
        Claim("Projection, 2)", "radius of G", "", f"√(1+ε η) = {printed:.4g}", f"√(1+ε) η = {radius:.4g}", None,
              "where d = 1 and the projection takes all outward motion away; likewise G_p"),
        Claim("Eqs. (36), (40)-(48)", "bound inside b, d, f and on the left of (40)", "", "of v_ω", "of v_ω̃", None,
              "the error of the filtered rate error, (34); read as that of v_ω, bound (39) fails by a multiple"),
        Claim("Eq. (10)", "left-hand side", "", "|v_q4|", "|dv_q4/dt|", None,
              "as the right-hand side, which is used in (46)"),
        Claim("Eq. (32)", "third term of the auxiliary acceleration's error", "", "δĈ dω_d/dt", "δC dω_d/dt", None,
              "its bound (34) is the same for both"),
    ]  # fmt: skip
