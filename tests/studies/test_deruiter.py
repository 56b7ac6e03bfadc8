"""The study on short runs of the real components, and its verdicts on made-up signals."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from adcs import AdcsError, ModelExchange, Save, System
from adcs import run as run_system
from adcs.catalogue import STUDIES, SYSTEMS
from adcs.library.deruiter import bounded, exact, study, systems, views
from adcs.library.deruiter.bounded import ERRORS, EXACT, OBSERVER
from adcs.library.deruiter.design import EstimationBounds
from adcs.library.deruiter.settings import Choices
from adcs.library.deruiter.signals import (
    ATTITUDE,
    ATTITUDE_ESTIMATE,
    DISTANCE,
    DISTANCE_P,
    FILTERED,
    RATE,
    RATE_ESTIMATE,
    TORQUE,
    signals,
)
from adcs.library.outcome import Outcome
from adcs.library.trajectory import Trajectory


def made_up(size: float, error: float = 0.0, distance: float = 0.2, distance_p: float = 1.04) -> Trajectory:
    """Errors of constant size over 1500 s; the rate estimate is off by a constant."""
    time = np.linspace(0, 1500, 151)
    sizes = {ATTITUDE: size, RATE: size, FILTERED: size, TORQUE: size, DISTANCE: distance, DISTANCE_P: distance_p}
    values = {what: np.full(151, value) for what, value in sizes.items()}
    return Trajectory(time, {**values, RATE_ESTIMATE: np.tile([0.0, error, 0.0], (151, 1))})


# --- choices and what they presuppose ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"margin": 1.0},
            "choice margin = 1: expected a factor above 1: the dead zone must exceed its limit, Eq. (47)",
        ),
        ({"gamma": -1.0}, "choice gamma = -1: expected a positive gain"),
        ({"seeds": 0}, "choice seeds = 0: expected 1 or more"),
        ({"stop_time": 900.0}, "choice stop_time = 900: expected later than steady_from, 900 s"),
        (
            {"disturbance": 0.0},
            "choice disturbance = 0: expected a positive torque: with none and exact states all bounds are 0",
        ),
    ],
)
def test_choices_that_cannot_be_judged_are_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(AdcsError) as error:
        Choices(**changes)
    assert str(error.value) == message


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        (
            {"rate_error": 0.2},
            "for bounded estimation errors: gain (Theorem 1): a + c + e < k [1/s], but 0.4217 is not below",
        ),
        ({"k": 2e-4}, "for exact states: bound below 1 (Theorem 1): q_1 < 1"),
        ({"lam": 5e-4}, "bound below 1 (Theorem 1): q_1 < 1, else the bound on the attitude error says nothing, but "),
        ({"disturbance": 1.0}, "bound below 1 (Theorem 1)"),
        ({"eta_p": 0.036}, "invertibility (after Eq. (22)): eta_p < lambda_min(P*) / sqrt(5/3 (1 + epsilon_p))"),
        ({"eta": 0.2}, "theta within F (after Eq. (19)): |theta - theta*| < eta, but 0.2928 is not below 0.2"),
        ({"eta_p": 0.007}, "theta_p within F_p (after Eq. (19))"),
        ({"attitude_error": 1.0}, "attitude = 1: the vector part of the attitude's estimation error must stay below 1"),
        ({"rate_error": -1e-4}, "rate = -0.0001: expected a bound, 0 or more"),
        ({"k": -0.3}, "k = -0.3: expected a positive number"),
    ],
)
def test_the_study_names_the_condition_that_fails_before_it_runs_anything(
    changes: dict[str, float], named: str
) -> None:
    def simulate(*_: Any, **__: Any) -> Any:
        pytest.fail("a run was started")

    with pytest.raises(AdcsError) as error:
        study.run(Choices(**changes), lambda done, text: None, simulate)  # type: ignore[arg-type]
    assert named in str(error.value)
    assert "\n" not in str(error.value)


def test_what_is_guaranteed_with_the_choices_as_they_are() -> None:
    """Values of a separate computation by hand."""
    found = bounded.guarantees(Choices())
    assert found[EXACT].dead_zone_limit == pytest.approx(1e-3 / 13 / 0.3)
    assert found[EXACT].q_limit == pytest.approx(1.05 * 1e-3 / 13 / 0.3 / 0.05)
    assert found[ERRORS].dead_zone_limit == pytest.approx(4.51605e-4, rel=1e-5)
    assert found[ERRORS].q_limit == pytest.approx(0.0130494, rel=1e-5)
    assert found[ERRORS].rate_limit == pytest.approx(2 * 0.05 * 0.0130494, rel=1e-5)
    assert found[OBSERVER].q_limit == pytest.approx(0.0348865, rel=1e-5)
    assert all(not guarantee.failing for guarantee in found.values())


def test_design_tables() -> None:
    outcome = Outcome.of(study.design(Choices()))
    values, conditions = outcome.tables
    assert values.rows[0] == ["v_q, attitude estimation error", 0.0, 1e-3, 0.0]
    assert len(conditions.rows) == 7
    assert conditions.rows[0][3:] == ["0 < 0.3", "0.0003674 < 0.3", "0.001686 < 0.3"]
    assert "fails" not in str(conditions.rows)
    without = Outcome.of(study.design(Choices(lam=1e-4))).tables[1].rows
    assert [row[0] for row in without if "fails" in row[3]] == ["bound below 1"]


def test_errata() -> None:
    rows = study.errata(Choices())
    assert {row.verdict for row in rows} == {"wrong in print"}
    assert ("v", "y") in {(row.printed, row.measure) for row in rows}


def test_phases_of_the_errors_follow_the_seed() -> None:
    first, again, other = Choices().generator(), Choices().generator(), Choices().generator(1)
    assert first == again
    assert first["attitude_phase"] != other["attitude_phase"]
    assert Choices(seed=2).generator() == other
    assert Choices(error_speed=2.0).errors().attitude_rate == 2 * Choices().errors().attitude_rate


# --- systems and signals ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", systems.BUILDERS)
def test_every_system_builds_runs_and_is_shown(name: str) -> None:
    entry = SYSTEMS[name]
    system = entry.build()
    assert (system.name, system.description) == (name, entry.description)
    result = run_system(system, stop_time=1.0, step=entry.step)
    panels = entry.figures(result)
    assert all(np.isfinite(np.asarray(series.y)).all() for panel in panels for series in panel.series)
    assert {panel.group for panel in panels} >= {"Tracking", "Control", "Adaptation"}
    numbers = {number.label: number.value for number in entry.key_numbers(result)}
    assert 0.1 < float(numbers["Largest torque"]) < 1.5
    assert float(numbers["Farthest estimate"]) < 1.05


def test_signals_are_those_of_the_definitions() -> None:
    """Errors at the start: 120 degrees off, and the rate less that of the reference."""
    result = run_system(systems.bounded_errors(), stop_time=1.0, step=0.25, method=ModelExchange())
    run = signals(result)
    assert run.start(ATTITUDE) == pytest.approx(np.sin(np.radians(60)))
    assert run.peak(ATTITUDE_ESTIMATE) <= 1e-3
    assert run.peak(RATE_ESTIMATE) <= 1e-4
    offset = np.linalg.norm(result["controller.theta_p_offset"], axis=1) / 0.015
    np.testing.assert_allclose(run[DISTANCE_P], offset, rtol=1e-9, atol=1e-7)
    assert offset[-1] > 0.01
    assert run.after(0.5).time.tolist() == [0.5, 0.75, 1.0]
    assert run.speed(RATE_ESTIMATE) <= Choices().errors().rate_rate


def test_the_disturbance_stays_within_its_bound() -> None:
    system = systems.bounded_errors()
    result = run_system(system, stop_time=600.0, step=2.0, save=Save(["disturbance.torque_B"]))
    torque = np.linalg.norm(result["disturbance.torque_B"], axis=1)
    assert 0.9e-3 < torque.max() <= 1e-3 * (1 + 1e-12)


def test_views_show_the_dead_zone() -> None:
    result = run_system(systems.observer(), stop_time=1.0, step=0.25)
    panel = next(p for p in views.figures(result) if p.title == "Filtered rate error")
    guarantee = Choices().guarantee(Choices().observer_errors())
    assert [guide.value for guide in panel.guides] == [guarantee.dead_zone]


# --- verdicts ---------------------------------------------------------------------------------------------------------


class TestVerdicts:
    choices = Choices()

    def case(self, label: str) -> bounded.Case:
        return next(c for c in bounded.cases(self.choices) if c.label == label)

    @pytest.mark.parametrize(
        ("size", "error", "verdicts"),
        [
            (1e-4, 7e-4, ["reproduced", "reproduced"]),
            (1e-2, 7e-4, ["reproduced", "not reproduced"]),  # above the bound on the rate error, 0.0035 rad/s
            (1e-1, 7e-4, ["not reproduced", "not reproduced"]),
            (1e-4, 9e-4, ["not reproduced", "not reproduced"]),  # nothing is shown if the observer breaks its bound
        ],
    )
    def test_bounds(self, size: float, error: float, verdicts: list[str]) -> None:
        rows = list(bounded._claims(self.case("observer knows the inertia"), made_up(size, error), self.choices))
        assert [row.verdict for row in rows[:2]] == verdicts
        assert ("beyond its bound" in rows[0].note) == (error > 8e-4)
        assert rows[2].verdict == "reproduced"
        assert rows[2].measure == pytest.approx(1.04)

    def test_an_estimate_outside_its_ball(self) -> None:
        run = made_up(1e-4, distance=1.05, distance_p=0.0)
        rows = list(bounded._claims(self.case("exact states"), run, self.choices))
        assert [row.verdict for row in rows] == ["reproduced", "reproduced", "not reproduced"]
        assert exact._edge("made up", run, self.choices).verdict == "not reproduced"

    def test_sequence(self) -> None:
        row = bounded._sequence(ERRORS, self.choices.guarantee(self.choices.errors()))
        assert (row.verdict, row.measure) == ("reproduced", "0.0130499, 0.0130494, limit 0.0130494")


# --- the study, shortened ---------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    """Judged far too early: the attitude error is still large, and the verdicts must say so."""
    stretch = exact.STRETCH
    exact.STRETCH = 10.0
    try:
        return study.run(Choices(stop_time=30.0, steady_from=20.0, seeds=1, fast=50.0), lambda done, text: None)[0]
    finally:
        exact.STRETCH = stretch


def test_rows_of_a_run_that_is_too_short(outcome: Outcome) -> None:
    bounds = [row for row in outcome.claims if row.where == "Theorem 1"]
    assert len(bounds) == 8
    assert {row.verdict for row in bounds} == {"not reproduced"}
    kept = [row for row in outcome.claims if row.statement == "estimates stay in G and G_p"]
    assert [row.verdict for row in kept] == ["reproduced"] * 6


def test_panels_draw_the_bounds_beside_the_trajectories(outcome: Outcome) -> None:
    guarantees = bounded.guarantees(Choices())
    for group, guarantee in guarantees.items():
        panels = {p.title: p for p in outcome.panels if p.group == group}
        assert panels["Attitude tracking error"].guides[0].value == guarantee.q_limit
        assert panels["Rate tracking error"].guides[0].value == guarantee.rate_limit
        assert panels["Filtered rate error"].guides[0].value == guarantee.dead_zone
        assert panels["Parameter estimates"].guides[0].value == pytest.approx(np.sqrt(1.1))
    assert {"Attitude estimation error", "Rate estimation error"} <= {p.title for p in outcome.panels}


def test_lyapunov_panel(outcome: Outcome) -> None:
    """V and V(0) - k times the integral of |filtered rate error|^2 are one curve where the projection rests."""
    panel = next(p for p in outcome.panels if p.title == "Lyapunov function (49)")
    values, expected, *fast = (np.asarray(series.y) for series in panel.series)
    np.testing.assert_allclose(values, expected, rtol=2e-5)
    assert (fast[0] <= fast[1] * (1 + 1e-4)).all()


def test_the_bounds_hold_without_adaptation_too(outcome: Outcome) -> None:
    table = next(t for t in outcome.tables if t.title == "With and without adaptation")
    assert len(table.rows) == 4
    assert "proves nothing" in table.note


def test_registered() -> None:
    assert STUDIES["deruiter"].run is study.run
    assert STUDIES["deruiter"].choices is Choices


@pytest.mark.parametrize("build", [systems.exact_states, systems.bounded_errors, systems.observer])
def test_an_own_dead_zone(build: Callable[..., System]) -> None:
    assert build(dead_zone=0.5).components["controller"].start["dead_zone"] == (0.5,)


def test_exact_states_have_a_dead_zone_only_under_disturbance() -> None:
    zone = Choices().guarantee(EstimationBounds()).dead_zone
    assert systems.exact_states().components["controller"].start["dead_zone"] == (0.0,)
    assert systems.exact_states(disturbed=True).components["controller"].start["dead_zone"] == (zone,)
