"""The study on short runs of the real components, and its measures on made-up signals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from adcs import AdcsError
from adcs import run as run_system
from adcs.catalogue import SYSTEMS
from adcs.library.outcome import Claim, Outcome
from adcs.library.sections import Section, conduct
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.observer import exchange_step, noise, noise_free, random_starts
from adcs.library.thakur.observer.noise_free import FULL_STATE, OBSERVER
from adcs.library.thakur.observer.signals import (
    ATTITUDE,
    ATTITUDE_ESTIMATE,
    ERRORS,
    RATE,
    RATE_ESTIMATE,
    TORQUE,
)
from adcs.library.thakur.sequences import residual_set, spread, steady
from adcs.library.trajectory import Trajectory


def shown(section: Section) -> Outcome:
    return conduct([section])[0]


def made_up(size: float, time: np.ndarray, *, observer: bool = True) -> Trajectory:
    """All errors decay from 1 and stay at `size`."""
    norm = np.maximum(np.exp(-time), size)
    names = (*ERRORS, TORQUE) if observer else (ATTITUDE, RATE, TORQUE)
    return Trajectory(time, {name: np.outer(norm, [0.6, 0.0, 0.8]) for name in names})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"settled": 0.0}, "choice settled = 0: expected a part between 0 and 1"),
        ({"settled": float("nan")}, "choice settled = nan: expected a part between 0 and 1"),
        ({"stop_time": 100.0}, "choice stop_time = 100: expected later than steady_from, 120 s"),
        ({"steady_from": 10.0}, "choice steady_from = 10: expected 60 s or later"),
        ({"draws": 0}, "choice draws = 0: expected 1 or more"),
    ],
)
def test_choices_that_cannot_be_judged_are_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(AdcsError) as error:
        Choices(**changes)
    assert str(error.value) == message


@pytest.mark.parametrize("name", ["observer-pd", "full-state-pd", "quest-observer-pd"])
def test_every_tracking_system_builds_runs_and_is_shown(name: str) -> None:
    entry = SYSTEMS[name]
    result = run_system(entry.build(), stop_time=1.0, step=entry.step)
    panels = entry.figures(result)
    assert all(np.isfinite(np.asarray(series.y)).all() for panel in panels for series in panel.series)
    assert {panel.group for panel in panels} >= {"Tracking", "Control"}
    numbers = {number.label: number.value for number in entry.key_numbers(result)}
    assert numbers["Largest torque"] > 10
    assert entry.name == name
    assert entry.build().name == name
    assert entry.build().description == entry.description


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    return shown(noise_free.noise_free(Choices(stop_time=100.0, steady_from=90.0)))


class TestNoiseFree:
    @pytest.mark.parametrize(
        ("cell", "control", "expected"),
        [
            ("attitude tracking error", OBSERVER, 42.5),
            ("attitude tracking error", FULL_STATE, 42.9),
            ("rate tracking error", OBSERVER, 49.1),
            ("rate tracking error", FULL_STATE, 50.2),
            ("attitude estimation error", OBSERVER, 36.7),
            ("rate estimation error", OBSERVER, 32.0),
        ],
    )
    def test_convergence(self, outcome: Outcome, cell: str, control: str, expected: float) -> None:
        """Values of an independent closed loop in SciPy, to the output step."""
        (row,) = [r for r in outcome.claims if r.statement == f"{cell} converges [s]" and r.settings == control]
        assert row.measure == pytest.approx(expected, abs=0.1)
        assert row.verdict == "reproduced"

    @pytest.mark.parametrize(
        ("start", "expected", "verdict"),
        [
            ("transient of the attitude tracking error: ratio", 0.998, "not reproduced"),
            ("transient of the rate tracking error: ratio", 1.127, "reproduced"),
            ("oscillation of the rate tracking error (total variation)", 1.738, "reproduced"),
            ("control effort over 60 s: ratio of the integrals of the control torque", 0.986, "not reproduced"),
            ("control effort over 60 s: ratio of the integrals of the feedback torque", 1.046, "reproduced"),
        ],
    )
    def test_comparison(self, outcome: Outcome, start: str, expected: float, verdict: str) -> None:
        row = next(row for row in outcome.claims if row.statement.startswith(start))
        assert row.measure == pytest.approx(expected, abs=0.002)
        assert row.verdict == verdict

    def test_figures(self, outcome: Outcome) -> None:
        titles = [panel.title for panel in outcome.panels]
        assert sum(title.startswith("Fig. 5.1") for title in titles) == 2
        assert sum(title.startswith("Fig. 5.2") for title in titles) == 2
        assert {number.label: number.value for number in outcome.key_numbers} == {
            "Tracking errors converged": pytest.approx(50.2, abs=0.1),
            "Estimation errors converged": pytest.approx(36.7, abs=0.1),
        }

    def test_larger_initial_error_scales_from_the_true_rate(self) -> None:
        np.testing.assert_allclose(noise_free._start(1.0).omega_EN_E, [-0.03, 0.01, -0.02], atol=1e-17)
        np.testing.assert_allclose(noise_free._start(2.0).omega_EN_E, [-0.065, 0.014, -0.044], atol=1e-15)

    def test_an_error_that_does_not_settle_is_not_reproduced(self) -> None:
        time = np.linspace(0, 100, 1001)
        pair = {OBSERVER: made_up(0.03, time), FULL_STATE: made_up(1e-3, time, observer=False)}
        rows = list(noise_free._convergence(pair, Choices()))
        assert [row.verdict for row in rows if row.settings == OBSERVER] == ["not reproduced"] * 4
        assert [row.verdict for row in rows if row.settings == FULL_STATE] == ["reproduced"] * 2
        assert all(np.isnan(row.measure) for row in rows if row.settings == OBSERVER)  # type: ignore[arg-type]


class TestExchangeStep:
    def test_order_of_a_power_law(self) -> None:
        steps = (0.001, 0.01, 0.1)
        assert exchange_step.fitted_order(steps, [3 * h**2 for h in steps]) == pytest.approx(2)
        # the coarse step is not fitted
        assert exchange_step.fitted_order(steps, [1e-3, 1e-2, 5.0]) == pytest.approx(1)

    def test_first_order(self, monkeypatch: pytest.MonkeyPatch) -> None:
        steps = (0.005, 0.01)
        monkeypatch.setattr(exchange_step, "STEPS", steps)
        monkeypatch.setattr(exchange_step, "DRAWN", steps)
        outcome = shown(exchange_step.exchange_step(Choices(stop_time=61.0, steady_from=60.0, shown=60.0)))
        orders = [float(row[-1]) for table in outcome.tables[:2] for row in table.rows]
        assert len(orders) == 6
        assert orders == pytest.approx([1.0] * 6, abs=0.02)
        floors = outcome.tables[2]
        assert [row[1] for row in floors.rows] == [5.0, 10.0, "coupled"] * 2


class TestNoise:
    time = np.linspace(0, 200, 401)

    def rows(self, observer: float, full: float) -> list[Claim]:
        runs = {
            (control, angle): [made_up(10 * size if angle == noise.LARGE else size, self.time) for _ in range(2)]
            for control, size in ((OBSERVER, observer), (FULL_STATE, full))
            for angle in (noise.SMALL, noise.LARGE)
        }
        level = {key: steady(value, Choices().steady_from) for key, value in runs.items()}
        return [
            *noise._bounded(runs, level, Choices()),
            *noise._slightly_better(runs, level, Choices()),
            *noise._angles(level),
        ]

    def judged(self, rows: list[Claim], text: str) -> dict[Any, set[str]]:
        found = [row for row in rows if text in row.statement]
        assert found
        return {"ours": {f"{row.measure:.3g}" for row in found}, "verdict": {row.verdict for row in found}}

    def test_all_reproduced(self) -> None:
        assert {row.verdict for row in self.rows(1.5e-4, 1e-4)} == {"reproduced"}

    def test_much_worse_than_full_state(self) -> None:
        judged = self.judged(self.rows(3e-4, 1e-4), ", observer / full state")
        assert "not reproduced" in judged["verdict"]
        assert "3" in judged["ours"]

    def test_better_than_full_state(self) -> None:
        rows = [row for row in self.rows(0.5e-4, 1e-4) if row.printed == "full state only slightly better (> 1)"]
        assert {row.verdict for row in rows} == {"not reproduced"}
        assert all(row.note.startswith("full state is not better") for row in rows)

    def test_growth(self) -> None:
        judged = self.judged(self.rows(1.5e-4, 1e-4), "0.5 deg / 0.05 deg")
        assert judged == {"ours": {"10"}, "verdict": {"reproduced"}}

    def test_ratios_are_taken_sequence_by_sequence(self) -> None:
        assert spread([3.0, 2.0], [2.0, 4.0]) == "0.5 to 1.5 over 2 noise sequences"

    def test_real_noise_keeps_the_errors_from_vanishing(self) -> None:
        choices = Choices(stop_time=100.0, steady_from=90.0, draws=1)
        runs = {angle: noise.drawn(OBSERVER, angle, 0.5, 1, choices) for angle in (0.05, 0.5)}
        found: dict[float, Trajectory] = {}
        conduct([Section("", "", lambda seen: found.update(seen) or [], runs)])
        a, b = (steady([run], choices.steady_from) for run in found.values())
        assert 1e-5 < a[RATE_ESTIMATE] < 1e-3  # 1e-8 without noise
        assert b[ATTITUDE_ESTIMATE] / a[ATTITUDE_ESTIMATE] == pytest.approx(10, rel=0.05)


class TestRandomStarts:
    def test_starts_are_unit_and_within_the_range_and_reproducible(self) -> None:
        choices = Choices(starts=200)
        starts = random_starts.draw_starts(choices)
        q = np.array([start.q_BN for start in starts])
        np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1, atol=1e-15)
        # uniform over rotations: E[q0^2] = 1/4, and the angle is beyond 90 deg in 1/2 + 1/pi of the cases
        assert np.mean(q[:, 0] ** 2) == pytest.approx(0.25, abs=0.05)
        assert np.mean(q[:, 0] < np.cos(np.pi / 4)) == pytest.approx(0.5 + 1 / np.pi, abs=0.08)
        rates = np.array([[start.omega_BN_B, start.omega_EN_E] for start in starts])
        assert 0.09 < np.abs(rates).max() <= choices.start_rate
        assert starts == random_starts.draw_starts(choices)
        assert starts[:10] == random_starts.draw_starts(Choices(starts=10))

    def test_noise_differs_from_run_to_run(self) -> None:
        choices = Choices(seed=5, draws=3)
        assert [random_starts._noise(choices, i)["seed"] for i in range(3)] == [8, 9, 10]

    def test_a_run_that_stays_large_is_counted(self) -> None:
        time = np.linspace(0, 200, 401)
        row = residual_set("Sec. 5.4.2", "a", 0.05, RATE, [made_up(1e-3, time), made_up(0.5, time)], 120.0, 0.02)
        assert (row.measure, row.verdict) == ("1 of 2", "not reproduced")
