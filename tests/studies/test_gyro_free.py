"""Chapter 4 and Secs. 5.4.3, 5.4.4 of the study, on short runs of the real components and on made-up signals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from adcs import AdcsError
from adcs import run as run_system
from adcs.catalogue import SYSTEMS
from adcs.library.outcome import Claim, Outcome
from adcs.library.sections import Section, conduct
from adcs.library.thakur import study
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.gyro_free import claims as gyro_free
from adcs.library.thakur.gyro_free import noise as gyro_free_noise
from adcs.library.thakur.gyro_free import random_starts
from adcs.library.thakur.gyro_free import steps as gyro_free_steps
from adcs.library.thakur.gyro_free import theorem as gyro_free_theorem
from adcs.library.thakur.gyro_free.claims import FULL_STATE, GYRO_FREE
from adcs.library.thakur.gyro_free.level import printed_level, resting_attitudes, start_value, sufficient_level
from adcs.library.thakur.gyro_free.settings import HALF_ANGLE, Start
from adcs.library.thakur.gyro_free.signals import ANGLE, RATE, TORQUE
from adcs.library.thakur.observer import inertia_errors, quest
from adcs.library.trajectory import Trajectory

SHORT = Choices(stop_time=121.0, steady_from=120.0)


def shown(section: Section) -> Outcome:
    return conduct([section])[0]


def row(outcome: Outcome, cell: str, settings: str = "") -> Claim:
    (found,) = [r for r in outcome.claims if r.statement.startswith(cell) and r.settings.startswith(settings)]
    return found


def made_up(level: float) -> Trajectory:
    """All fall from 1 and stay at `level`."""
    time = np.linspace(0, 400, 801)
    values = np.maximum(np.exp(-time / 10), level)
    return Trajectory(time, {ANGLE: values, RATE: values, TORQUE: values})


@pytest.mark.parametrize("name", ["gyro-free", "gyro-free-full-state", "quest-observer-pd", "observer-inertia-error"])
def test_every_system_builds_runs_and_is_shown(name: str) -> None:
    entry = SYSTEMS[name]
    result = run_system(entry.build(), stop_time=1.0, step=entry.step)
    panels = entry.figures(result)
    assert all(np.isfinite(np.asarray(series.y)).all() for panel in panels for series in panel.series)
    assert all(panel.group for panel in panels)
    assert entry.key_numbers(result)
    assert (entry.build().name, entry.build().description) == (entry.name, entry.description)


def test_adcs_run_tells_the_corrected_level() -> None:
    result = run_system(SYSTEMS["gyro-free"].build(), stop_time=1.0, step=0.01)
    numbers = {number.label: number for number in SYSTEMS["gyro-free"].key_numbers(result)}
    level = numbers["Sure to converge if V(0) is below"]
    assert level.value == pytest.approx(0.03 * (2 - np.sqrt(0.5)), rel=1e-12)
    assert "0.09 N·m of Theorem 4.2.3 are not enough" in level.note


class TestLevel:
    def test_two_orthogonal_vectors(self) -> None:
        """M0 = diag(2, 1, 0): the level is 1 of the 3 that are printed."""
        directions = [[0.0, 0, 2], [0.0, 5, 0], [1.0, 1, 1]]
        assert sufficient_level(0.5, directions, [1, 2, 0]) == pytest.approx(0.5)
        assert printed_level(0.5, [1, 2, 0]) == pytest.approx(1.5)

    def test_no_attitude_with_zero_torque_lies_below(self) -> None:
        """V by brute force over all turns: Omega = 0 at the minimum and at three points not below the level."""
        values = [start_value(Start(q, (0, 0, 0))) for _, q in resting_attitudes()]
        assert min(values) == pytest.approx(sufficient_level(), rel=1e-12)
        rng = np.random.default_rng(3)
        q = rng.normal(size=(3000, 4))
        q /= np.linalg.norm(q, axis=1, keepdims=True)
        assert max(start_value(Start(tuple(row), (0, 0, 0))) for row in q) <= max(values)

    def test_the_rate_counts(self) -> None:
        still = start_value(Start(omega_BN_B=(0, 0, 0)))
        assert start_value() - still == pytest.approx(0.5 * 0.02**2 * (0.29 + 0.29 + 0.5), rel=1e-12)

    @pytest.mark.parametrize(
        ("directions", "weights", "message"),
        [
            (
                [[1, 0, 0], [-2, 0, 0]],
                [1, 1],
                "directions of positive weight are collinear: give at least two that are not",
            ),
            (
                [[1, 0, 0], [0, 1, 0]],
                [1, 0],
                "directions of positive weight are collinear: give at least two that are not",
            ),
            ([[1, 0, 0], [0, 0, 0]], [1, 1], "directions: expected rows of three numbers, none of them [0, 0, 0]"),
            ([[1, 0], [0, 1]], [1, 1], "directions: expected rows of three numbers, none of them [0, 0, 0]"),
            ([[1, 0, 0], [0, 1, 0]], [1, -1], "weights [1, -1]: expected a number >= 0 for each of the 2 directions"),
            ([[1, 0, 0], [0, 1, 0]], [1], "weights [1]: expected a number >= 0 for each of the 2 directions"),
        ],
    )
    def test_what_tells_no_attitude_is_refused(self, directions: Any, weights: Any, message: str) -> None:
        with pytest.raises(AdcsError) as error:
            sufficient_level(1.0, directions, weights)
        assert str(error.value) == message


@pytest.fixture(scope="module")
def exact() -> Outcome:
    return shown(gyro_free.noise_free(SHORT))


class TestNoiseFree:
    @pytest.mark.parametrize(
        ("cell", "settings", "expected"),
        [
            ("largest control torque", GYRO_FREE, 0.013926),
            ("largest control torque", FULL_STATE, 0.011947),
            ("initial torque norm", "", 0.0019794),
            ("rotation angle driven", GYRO_FREE, 51.1),
            ("angular velocity driven", GYRO_FREE, 64.0),
            ("rotation angle driven", FULL_STATE, 50.2),
            ("torque requirement", "", 1.117),
        ],
    )
    def test_values(self, exact: Outcome, cell: str, settings: str, expected: float) -> None:
        assert row(exact, cell, settings).measure == pytest.approx(expected, rel=1e-3, abs=1e-6)
        assert row(exact, cell, settings).verdict == "reproduced"

    def test_p_and_figures(self, exact: Outcome) -> None:
        assert row(exact, "P").measure == "diag(1.75, 0.525, 1.05)"
        titles = " ".join(panel.title for panel in exact.panels)
        assert all(f"Fig. {n}" in titles for n in ("4.1a", "4.1b", "4.2a", "4.2b"))


def test_theorem() -> None:
    outcome = shown(gyro_free_theorem.theorem(SHORT))
    assert [r.verdict for r in outcome.claims] == ["wrong in print", "reproduced"]
    assert outcome.claims[0].measure == "stays at 180°"
    assert outcome.claims[1].measure == pytest.approx(0.1053, rel=1e-3)
    (number,) = outcome.key_numbers
    assert number.value == pytest.approx(0.038787, rel=1e-4)
    assert [r[4] for r in outcome.tables[1].rows] == [30.0, 30.0, 30.0, 242.0, None]
    *rests, below = (float(r[5]) for r in outcome.tables[1].rows[:4])
    assert rests == pytest.approx([180.0] * 3, abs=1e-6)
    assert below < 0.01  # deg


def test_steps_are_of_first_order() -> None:
    (table,) = shown(gyro_free_steps.exchange_steps(SHORT)).tables
    fine, coarse = np.array(table.rows[0][2:], float), np.array(table.rows[1][2:], float)
    assert (table.rows[0][1], table.rows[1][1]) == (1.0, 10.0)
    np.testing.assert_allclose(coarse / fine, 10, rtol=0.02)


class TestNoise:
    def rows(self, own: float, full: float) -> list[Claim]:
        runs = {
            (control, angle): [made_up(10 * level if angle > HALF_ANGLE else level) for _ in range(2)]
            for control, level in ((GYRO_FREE, own), (FULL_STATE, full))
            for angle in (HALF_ANGLE, gyro_free_noise.LARGER)
        }
        exact = {GYRO_FREE: made_up(0.0), FULL_STATE: made_up(0.0)}
        steady = {key: gyro_free_noise._steady(value, Choices()) for key, value in runs.items()}
        return [
            *gyro_free_noise._transient(runs, exact),
            *gyro_free_noise._residual(steady, exact, Choices()),
            *gyro_free_noise._growth(steady),
            *gyro_free_noise._no_worse(runs, steady, Choices()),
        ]

    def test_all_reproduced(self) -> None:
        assert {r.verdict for r in self.rows(1.1e-4, 1e-4)} == {"reproduced"}

    def test_worse_than_full_state(self) -> None:
        failing = [r for r in self.rows(3e-4, 1e-4) if r.verdict != "reproduced"]
        assert [r.measure for r in failing] == pytest.approx([3, 3])
        assert all("gyro-free / full state" in r.statement for r in failing)

    def test_a_changed_transient(self) -> None:
        failing = {r.statement.partition(":")[0] for r in self.rows(0.1, 0.1) if r.verdict != "reproduced"}
        assert failing >= {"transient of the rotation angle", "transient of the angular velocity"}

    def test_random_starts(self) -> None:
        choices = Choices(starts=2, rest_stop_time=250.0, rest_from=200.0)
        outcome = shown(random_starts.random_starts(choices))
        assert [(r.measure, r.verdict) for r in outcome.claims] == [("2 of 2", "reproduced")] * 2
        starts = random_starts.draw_starts(Choices(starts=100))
        assert starts[:2] == random_starts.draw_starts(choices)
        np.testing.assert_allclose(np.linalg.norm([s.q_BN for s in starts], axis=1), 1, atol=1e-15)
        assert 0.019 < np.abs([s.omega_BN_B for s in starts]).max() <= 0.02


def test_quest_is_identical_and_keeps_its_sign() -> None:
    outcome = shown(quest.quest(SHORT))
    assert {r.verdict for r in outcome.claims} == {"reproduced"}
    assert all(float(r.measure) < 1e-7 for r in outcome.claims[:-1])  # type: ignore[arg-type]
    assert float(outcome.claims[-1].measure) < 0.06  # type: ignore[arg-type]
    assert "from 0.985 to -0.98" in outcome.claims[-1].note
    fine, coarse = outcome.tables[1].rows
    assert coarse[1] / fine[1] == pytest.approx(10, rel=0.02)


@pytest.fixture(scope="module")
def wrong_inertia() -> Outcome:
    return shown(inertia_errors.inertia_errors(Choices()))


class TestInertiaErrors:
    def test_norms(self, wrong_inertia: Outcome) -> None:
        assert row(wrong_inertia, "norm of ΔJ₁").measure == pytest.approx(0.1220, abs=1e-4)
        assert row(wrong_inertia, "norm of ΔJ₂").measure == pytest.approx(0.2054, abs=1e-4)
        assert row(wrong_inertia, "norm of ΔJ₂").verdict == "not reproduced"
        assert row(wrong_inertia, "which error is larger").verdict == "wrong in print"

    def test_transients_and_residual_sets(self, wrong_inertia: Outcome) -> None:
        assert row(wrong_inertia, "attitude estimation error converges", inertia_errors.SECOND).measure == 21.1
        assert row(wrong_inertia, "rate estimation error converges", inertia_errors.FIRST).measure == pytest.approx(
            23.6
        )
        for r in wrong_inertia.claims:
            if "steady state" in r.statement:
                assert 1e-5 < float(r.measure) < 1e-4  # type: ignore[arg-type]
                assert r.verdict == "reproduced"


class TestChapters:
    def test_only_the_chosen_ones_run(self) -> None:
        labels: list[str] = []

        def simulate(system: Any, **settings: Any) -> Any:
            labels.append(system.name)
            raise AdcsError("enough")

        for chapter, first in (("4", "gyro-free"), ("5", "full-state-pd")):
            with pytest.raises(AdcsError, match="enough"):
                study.run(Choices(chapters=chapter), lambda done, text: None, simulate)
            assert labels[-1] == first

    @pytest.mark.parametrize("text", ["", "6", "4;5", "four"])
    def test_others_are_refused(self, text: str) -> None:
        with pytest.raises(AdcsError) as error:
            Choices(chapters=text)
        assert str(error.value) == f"choice chapters = {text!r}: expected some of 3,4,5"

    @pytest.mark.parametrize(
        ("changes", "message"),
        [
            ({"vector_spread": 0.0}, "choice vector_spread = 0: expected a factor above 0 and at most 10"),
            ({"rest_stop_time": 100.0}, "choice rest_stop_time = 100: expected later than rest_from, 250 s"),
            ({"rest_rate": -1.0}, "choice rest_rate = -1: expected a positive rate"),
        ],
    )
    def test_choices_of_chapter_4(self, changes: dict[str, Any], message: str) -> None:
        with pytest.raises(AdcsError) as error:
            Choices(**changes)
        assert str(error.value) == message
