"""Disturbance and estimation errors: the tracking errors beside the bounds that were known before the run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from adcs.library.deruiter.design import EstimationBounds, Guarantee
from adcs.library.deruiter.settings import NOMINAL_INERTIA, Choices
from adcs.library.deruiter.signals import (
    ATTITUDE,
    ATTITUDE_ESTIMATE,
    FILTERED,
    RATE,
    RATE_ESTIMATE,
    Signals,
    distance_panel,
    norm_panel,
    signals,
)
from adcs.library.deruiter.systems import RECORD, RECORD_ERRORS, RECORD_OBSERVER, bounded_errors, exact_states, observer
from adcs.library.outcome import Outcome, Row, Runner, claims_table, verdict
from orchestration.results.plots import Guide, Panel
from orchestration.results.report import KeyNumber, Table
from orchestration.running.method import ModelExchange
from orchestration.running.save import Save
from orchestration.system import System

OUTPUT_STEP = 0.25  # s
NO_ADAPTATION = 10.0  # rad/s: a dead zone that is never left
EXACT, ERRORS, OBSERVER = "Exact states", "Bounded estimation errors", "Observer in the loop"
STEPS = 30  # of Algorithm 1
ROUNDING = 1e-9


@dataclass(frozen=True)
class Case:
    """A system, the guarantee for it, and what is recorded."""

    label: str
    group: str
    system: System
    guarantee: Guarantee
    record: tuple[str, ...]


def cases(choices: Choices) -> list[Case]:
    """Every run under disturbance; refuses choices for which the theorem gives no bound."""
    found = []
    exact, errors = choices.guarantee(EstimationBounds()), choices.guarantee(choices.errors())
    seen = choices.guarantee(choices.observer_errors())
    for group, guarantee in ((EXACT, exact), (ERRORS, errors), (OBSERVER, seen)):
        guarantee.require(group.lower())
    found.append(Case("exact states", EXACT, exact_states(choices, disturbed=True), exact, RECORD))
    for run in range(choices.seeds):
        label = f"phases {choices.seed + run}"
        found.append(Case(label, ERRORS, bounded_errors(choices, run=run), errors, RECORD_ERRORS))
    found.append(Case("observer knows the inertia", OBSERVER, observer(choices), seen, RECORD_OBSERVER))
    nominal = observer(choices, inertia=NOMINAL_INERTIA)
    found.append(Case("observer assumes the nominal inertia", OBSERVER, nominal, seen, RECORD_OBSERVER))
    return found


def run_count(choices: Choices) -> int:
    """How many runs `bounded` makes."""
    return len(cases(choices)) + 2


def bounded(run: Runner, choices: Choices) -> Outcome:
    """Run every case, and two without adaptation for comparison."""
    settings = {"stop_time": choices.stop_time, "step": OUTPUT_STEP, "method": ModelExchange()}
    found = cases(choices)
    runs = {c.label: signals(run(c.label, c.system, save=Save(c.record), **settings)) for c in found}
    outcome = Outcome()
    for group in (EXACT, ERRORS, OBSERVER):
        members = [c for c in found if c.group == group]
        outcome = outcome + _group(group, members, runs, choices)
    resting = {
        EXACT: exact_states(choices, disturbed=True, dead_zone=NO_ADAPTATION),
        ERRORS: bounded_errors(choices, dead_zone=NO_ADAPTATION),
    }
    still = {
        group: signals(run(f"{group.lower()}, without adaptation", system, save=Save(RECORD), **settings))
        for group, system in resting.items()
    }
    return outcome + _without_adaptation(found, runs, still, choices)


def _group(group: str, members: list[Case], runs: Mapping[str, Signals], choices: Choices) -> Outcome:
    rows = [row for case in members for row in _rows(case, runs[case.label], choices)]
    rows.append(_sequence_row(group, members[0].guarantee))
    shown = {case.label: runs[case.label] for case in members}
    guarantee = members[0].guarantee
    tail = Guide(choices.steady_from, "judged from here", "x")
    panels = [
        norm_panel(ATTITUDE, shown, "Attitude tracking error", group, [Guide(guarantee.q_limit, "bound q̄"), tail]),
        norm_panel(RATE, shown, "Rate tracking error", group, [Guide(guarantee.rate_limit, "bound 2 r̄"), tail]),
        norm_panel(FILTERED, shown, "Filtered rate error", group, [Guide(guarantee.dead_zone, "dead zone Ω")]),
        distance_panel(shown, choices.epsilon, "Parameter estimates", group),
        *_estimation_panels(shown, guarantee, group),
    ]
    tables = [claims_table(rows, "The statements of Theorem 1", group)]
    premises = [row for case in members for row in _premises(case, runs[case.label], choices)]
    if premises:
        columns = ["run", "error", "bound taken", f"largest from {choices.steady_from:g} s on", "holds"]
        tables.append(Table("What the theorem presupposes of the estimates", columns, premises, group=group))
    worst = max(runs[case.label].after(choices.steady_from).peak(ATTITUDE) for case in members)
    number = KeyNumber(f"{group}: attitude error", worst, "", f"guaranteed: {guarantee.q_limit:.3g}")
    return Outcome(rows, panels, tables, [number])


def _rows(case: Case, run: Signals, choices: Choices) -> list[Row]:
    tail = run.after(choices.steady_from)
    broken = [f"{premise[1]} beyond its bound" for premise in _premises(case, run, choices) if not premise[4]]
    rows = []
    for name, limit, unit in (
        (ATTITUDE, case.guarantee.q_limit, ""),
        (RATE, case.guarantee.rate_limit, " [rad/s]"),
    ):
        peak = tail.peak(name)
        note = (
            f"{peak / limit:.0%} of the bound; largest norm from {choices.steady_from:g} s to {choices.stop_time:g} s"
        )
        rows.append(
            Row(
                "deruiter",
                "Theorem 1",
                f"limit superior of the {name}{unit}",
                f"{case.group.lower()}, {case.label}" if case.group != EXACT else "exact states, disturbance",
                f"at most {limit:.4g}",
                peak,
                None,
                verdict(peak <= limit and not broken),
                "; ".join([note, *broken]),
            )
        )
    edge = float(np.sqrt(1 + choices.epsilon))
    farthest = max(float(d.max()) for d in run.distance.values())
    rows.append(
        Row(
            "deruiter",
            "Projection, 2)",
            "estimates stay in G and G_p",
            rows[0].settings,
            f"at most {edge:.5g} times η, η_p",
            farthest,
            None,
            verdict(farthest <= edge),
            "over the whole run; the projection never acts" if farthest <= 1 else "the projection acts",
        )
    )
    return rows


def _sequence_row(group: str, guarantee: Guarantee) -> Row:
    q, _ = guarantee.sequence(STEPS)
    steps = np.diff(q)
    holds = bool((steps <= 0).all()) and abs(q[-1] - guarantee.q_limit) <= 1e-12 * guarantee.q_limit
    return Row(
        "deruiter",
        "Proposition 1",
        "q_1, q_2, ... of Algorithm 1 decrease and converge",
        group.lower(),
        "yes",
        f"{q[0]:.6g}, {q[1]:.6g}, limit {guarantee.q_limit:.6g}",
        None,
        verdict(holds),
        "the limit in closed form: r̄ = (Ω + v_ω + (2 w_d + λ) v_q) / √(1 - v_q²), q̄ = r̄ / λ",
    )


def _premises(case: Case, run: Signals, choices: Choices) -> list[list[object]]:
    tail, bounds = run.after(choices.steady_from), case.guarantee.estimation
    rows: list[list[object]] = []
    for name, symbol, unit, size, speed in (
        (ATTITUDE_ESTIMATE, "v_q", "1", bounds.attitude, bounds.attitude_rate),
        (RATE_ESTIMATE, "v_ω", "rad/s", bounds.rate, bounds.rate_rate),
    ):
        if name not in tail.estimation:
            continue
        found = ((f"{symbol} [{unit}]", size, tail.peak(name)), (f"d{symbol}/dt [{unit}/s]", speed, tail.speed(name)))
        rows += [[case.label, what, bound, value, value <= bound * (1 + ROUNDING)] for what, bound, value in found]
    return rows


def _estimation_panels(runs: Mapping[str, Signals], guarantee: Guarantee, group: str) -> list[Panel]:
    panels = []
    limits = {ATTITUDE_ESTIMATE: guarantee.estimation.attitude, RATE_ESTIMATE: guarantee.estimation.rate}
    for name, limit in limits.items():
        if any(name in run.norms for run in runs.values()):
            guides = [Guide(limit, "bound taken")]
            panels.append(norm_panel(name, runs, name.capitalize(), group, guides, log=group == OBSERVER))
    return panels


def _without_adaptation(
    found: list[Case], runs: Mapping[str, Signals], still: Mapping[str, Signals], choices: Choices
) -> Outcome:
    """The bounds hold without adaptation too: they do not show that it is right."""
    rows = []
    for group, resting in still.items():
        case = next(c for c in found if c.group == group)
        for name, limit in ((ATTITUDE, case.guarantee.q_limit), (RATE, case.guarantee.rate_limit)):
            peaks = [s.after(choices.steady_from).peak(name) for s in (runs[case.label], resting)]
            rows.append([group.lower(), name, limit, *peaks])
    note = (
        "Largest norms in steady state. That a run stays within the bounds proves nothing about the adaptation: it "
        "does so without any. The tests compare the 24 estimates themselves, and the Lyapunov function."
    )
    columns = ["case", "error", "bound", "with adaptation", "without adaptation"]
    return Outcome(tables=[Table("With and without adaptation", columns, rows, note, "What the bounds do not show")])
