"""Disturbance and estimation errors: the tracking errors beside the bounds that were known before the run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from adcs.library.deruiter.design import EstimationBounds, Guarantee
from adcs.library.deruiter.settings import NOMINAL_INERTIA, Choices
from adcs.library.deruiter.signals import (
    ATTITUDE,
    ATTITUDE_ESTIMATE,
    DISTANCES,
    FILTERED,
    RATE,
    RATE_ESTIMATE,
    distance_panel,
    signals,
)
from adcs.library.deruiter.systems import bounded_errors, exact_states, observer
from adcs.library.outcome import Claim, Shown
from adcs.library.sections import Section, Simulation
from adcs.library.trajectory import Runs, Trajectory, norm_panel
from orchestration.results.plots import Guide, Panel
from orchestration.results.report import KeyNumber, Table
from orchestration.running.method import ModelExchange
from orchestration.system import System

OUTPUT_STEP = 0.25  # s
NO_ADAPTATION = 10.0  # rad/s: a dead zone that is never left
EXACT, ERRORS, OBSERVER = "Exact states", "Bounded estimation errors", "Observer in the loop"
STEPS = 30  # of Algorithm 1
ROUNDING = 1e-9


@dataclass(frozen=True)
class Case:
    """A system and the guarantee for it."""

    label: str
    group: str
    system: System
    guarantee: Guarantee

    def simulation(self, choices: Choices) -> Simulation:
        """Its run."""
        stop, method = choices.stop_time, ModelExchange()
        return Simulation(self.label, self.system, signals, stop, OUTPUT_STEP, method)


def guarantees(choices: Choices) -> dict[str, Guarantee]:
    """The theorem for each of the three cases."""
    return {
        EXACT: choices.guarantee(EstimationBounds()),
        ERRORS: choices.guarantee(choices.errors()),
        OBSERVER: choices.guarantee(choices.observer_errors()),
    }


def cases(choices: Choices) -> list[Case]:
    """Every run under disturbance; refuses choices for which the theorem gives no bound."""
    found = guarantees(choices)
    for group, guarantee in found.items():
        guarantee.require(group.lower())
    exact, errors, seen = found.values()
    drawn = [
        Case(f"phases {choices.seed + run}", ERRORS, bounded_errors(choices, run=run), errors)
        for run in range(choices.seeds)
    ]
    nominal = observer(choices, inertia=NOMINAL_INERTIA)
    return [
        Case("exact states", EXACT, exact_states(choices, disturbed=True), exact),
        *drawn,
        Case("observer knows the inertia", OBSERVER, observer(choices), seen),
        Case("observer assumes the nominal inertia", OBSERVER, nominal, seen),
    ]


def bounded(choices: Choices) -> list[Section]:
    """A section for each of the three groups of cases, and one of runs without adaptation, for comparison."""
    found = cases(choices)
    groups = [[case for case in found if case.group == group] for group in (EXACT, ERRORS, OBSERVER)]
    return [*(_section(members, choices) for members in groups), _without_adaptation(groups[:2], choices)]


def _section(members: list[Case], choices: Choices) -> Section:
    group, guarantee = members[0].group, members[0].guarantee

    def show(runs: Runs) -> Iterator[Shown]:
        for case in members:
            yield from _claims(case, runs[case.label], choices)
        yield _sequence(group, guarantee)
        premises = [row for case in members for row in _premises(case, runs[case.label], choices)]
        columns = ["run", "error", "bound taken", f"largest from {choices.steady_from:g} s on", "holds"]
        if premises:
            yield Table("What the theorem presupposes of the estimates", columns, premises)
        worst = max(run.after(choices.steady_from).peak(ATTITUDE) for run in runs.values())
        yield KeyNumber(f"{group}: attitude error", worst, "", f"guaranteed: {guarantee.q_limit:.3g}")
        yield from _panels(runs, guarantee, group, choices)

    simulations = {case.label: case.simulation(choices) for case in members}
    return Section(group, "The statements of Theorem 1", show, simulations)


def _panels(runs: Runs, guarantee: Guarantee, group: str, choices: Choices) -> list[Panel]:
    bounds, tail = guarantee.estimation, Guide(choices.steady_from, "judged from here", "x")
    panels = [
        norm_panel(ATTITUDE, runs, guides=[Guide(guarantee.q_limit, "bound q̄"), tail]),
        norm_panel(RATE, runs, guides=[Guide(guarantee.rate_limit, "bound 2 r̄"), tail]),
        norm_panel(FILTERED, runs, guides=[Guide(guarantee.dead_zone, "dead zone Ω")], note="as the law sees it"),
        distance_panel(runs, choices.epsilon),
    ]
    for what, limit in ((ATTITUDE_ESTIMATE, bounds.attitude), (RATE_ESTIMATE, bounds.rate)):
        if any(what in run for run in runs.values()):
            panels.append(norm_panel(what, runs, guides=[Guide(limit, "bound taken")], log=group == OBSERVER))
    return panels


def _claims(case: Case, run: Trajectory, choices: Choices) -> Iterator[Claim]:
    tail, guarantee = run.after(choices.steady_from), case.guarantee
    broken = [f"{premise[1]} beyond its bound" for premise in _premises(case, run, choices) if not premise[4]]
    settings = f"{case.group.lower()}, {case.label}" if case.group != EXACT else "exact states, disturbance"
    judged = f"largest norm from {choices.steady_from:g} s to {choices.stop_time:g} s"
    for error, limit in ((ATTITUDE, guarantee.q_limit), (RATE, guarantee.rate_limit)):
        peak = tail.peak(error)
        yield Claim("Theorem 1", f"limit superior of the {error}{error.in_unit}", settings,
                    f"at most {limit:.4g}", peak, peak <= limit and not broken,
                    "; ".join([f"{peak / limit:.0%} of the bound", judged, *broken]))  # fmt: skip
    edge, farthest = float(np.sqrt(1 + choices.epsilon)), max(run.peak(distance) for distance in DISTANCES)
    yield Claim("Projection, 2)", "estimates stay in G and G_p", settings,
                f"at most {edge:.5g} times η, η_p", farthest, farthest <= edge,
                "over the whole run; the projection never acts" if farthest <= 1 else "the projection acts",
    )  # fmt: skip


def _sequence(group: str, guarantee: Guarantee) -> Claim:
    q, _ = guarantee.sequence(STEPS)
    falling, converged = (np.diff(q) <= 0).all(), abs(q[-1] - guarantee.q_limit) <= 1e-12 * guarantee.q_limit
    return Claim("Proposition 1", "q_1, q_2, ... of Algorithm 1 decrease and converge", group.lower(),
                 "yes", f"{q[0]:.6g}, {q[1]:.6g}, limit {guarantee.q_limit:.6g}", bool(falling and converged),
                 "the limit in closed form: r̄ = (Ω + v_ω + (2 w_d + λ) v_q) / √(1 - v_q²), q̄ = r̄ / λ")  # fmt: skip


def _premises(case: Case, run: Trajectory, choices: Choices) -> list[list[object]]:
    """What the theorem presupposes of each estimate: label, error, bound, the largest found, whether that holds."""
    tail, bounds = run.after(choices.steady_from), case.guarantee.estimation
    rows: list[list[object]] = []
    for what, unit, size, speed in (
        (ATTITUDE_ESTIMATE, "1", bounds.attitude, bounds.attitude_rate),
        (RATE_ESTIMATE, "rad/s", bounds.rate, bounds.rate_rate),
    ):
        if what in tail:
            names = (f"{what.symbol} [{unit}]", f"d{what.symbol}/dt [{unit}/s]")
            for name, bound, value in zip(names, (size, speed), (tail.peak(what), tail.speed(what)), strict=True):
                rows.append([case.label, name, bound, value, value <= bound * (1 + ROUNDING)])
    return rows


def _without_adaptation(groups: list[list[Case]], choices: Choices) -> Section:
    """The bounds hold without adaptation too: they do not show that it is right."""
    resting = {
        EXACT: exact_states(choices, disturbed=True, dead_zone=NO_ADAPTATION),
        ERRORS: bounded_errors(choices, dead_zone=NO_ADAPTATION),
    }
    adapting = [members[0] for members in groups]
    still = [Case(f"{c.group.lower()}, without adaptation", "", resting[c.group], c.guarantee) for c in adapting]

    def show(runs: Runs) -> Iterator[Shown]:
        rows = []
        for one, other in zip(adapting, still, strict=True):
            tails = [runs[case.label].after(choices.steady_from) for case in (one, other)]
            for error, limit in ((ATTITUDE, one.guarantee.q_limit), (RATE, one.guarantee.rate_limit)):
                rows.append([one.group.lower(), error.name, limit, *(tail.peak(error) for tail in tails)])
        note = (
            "Largest norms in steady state. That a run stays within the bounds proves nothing about the adaptation: it "
            "does so without any. The tests compare the 24 estimates themselves, and the Lyapunov function."
        )
        columns = ["case", "error", "bound", "with adaptation", "without adaptation"]
        yield Table("With and without adaptation", columns, rows, note)

    simulations = {case.label: case.simulation(choices) for case in (*adapting, *still)}
    return Section("What the bounds do not show", "", show, simulations)
