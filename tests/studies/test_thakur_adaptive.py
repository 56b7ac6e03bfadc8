"""Chapter 3 of the study on short runs of the real components, and its measures on made-up runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from adcs import AdcsError
from adcs import run as run_system
from adcs.catalogue import SYSTEMS
from adcs.library.outcome import Claim, Outcome
from adcs.library.sections import Section, conduct
from adcs.library.thakur.adaptive import appendage as adaptive_appendage
from adcs.library.thakur.adaptive import baseline as adaptive_baseline
from adcs.library.thakur.adaptive import fuel as adaptive_fuel
from adcs.library.thakur.adaptive import readings as adaptive_readings
from adcs.library.thakur.adaptive import settings as adaptive_settings
from adcs.library.thakur.adaptive import steps as adaptive_steps
from adcs.library.thakur.adaptive import systems as adaptive_systems
from adcs.library.thakur.adaptive.baseline import COMPARISON, PROPOSED
from adcs.library.thakur.adaptive.readings import estimates
from adcs.library.thakur.adaptive.signals import ATTITUDE, RATE, SIGMA_ERROR, SIGMA_EST, THETA_ERROR, TORQUE
from adcs.library.thakur.choices import Choices
from adcs.library.trajectory import Trajectory


def shown(section: Section) -> Outcome:
    return conduct([section])[0]


def made_up(attitude: float, rate: float, *, sigma: float = 0.0, torque: Callable[..., Any] = np.cos) -> Trajectory:
    """400 s with errors that fall from 1 to a level, estimates off by `sigma`, torque between 0 and 1."""
    time = np.linspace(0, 400, 4001)
    true = np.array([1.0, 1.3])
    part = (sigma + (1 - sigma) * (1 - np.exp(-time / 50))) * (1 - sigma)
    theta = np.tile(adaptive_settings.THETA_START, (4001, 1)) - np.array(adaptive_settings.THETA)
    values = {
        ATTITUDE: np.maximum(np.exp(-time), attitude),
        RATE: np.maximum(np.exp(-time), rate),
        TORQUE: np.abs(torque(time)),
        THETA_ERROR: theta,
        SIGMA_EST: np.outer(part, true),
        SIGMA_ERROR: np.abs(part - 1),
    }
    return Trajectory(time, values)


class TestNumbers:
    """What can be computed by hand from the text."""

    def test_zeta_and_level_as_printed(self) -> None:
        """zeta* = 2 (1/(3 sqrt(2) 0.008) - 1.1832 - 0.5), and (3.46) term by term."""
        assert adaptive_baseline.zeta(1.1832) == pytest.approx(2 * (1 / (0.024 * np.sqrt(2)) - 1.6832), rel=1e-12)
        inner = 0.25 * (54.56**2 - 1) - 178 - (np.sqrt(1700) + 40) ** 2 / 16 - ((1 + np.sqrt(2)) * 0.008) ** 2 / 41
        assert adaptive_baseline.level(55.56) == pytest.approx(2 / 20.7352 * inner, rel=1e-12)

    def test_peak_rates(self) -> None:
        assert adaptive_baseline.peak_rate("printed") == pytest.approx(1.0580, abs=1e-4)
        assert adaptive_baseline.peak_rate("original") == pytest.approx(1.1856, abs=1e-4)

    def test_triangle_inequality_ends_before_the_dry_mass(self) -> None:
        impulse = adaptive_baseline.triangle_impulse()
        inertia = np.array(adaptive_settings.INERTIA) - impulse * np.diag(adaptive_settings.FUEL_RATES)
        low, middle, high = np.linalg.eigvalsh(inertia)
        assert low + middle == pytest.approx(high, abs=1e-9)
        assert low > 3

    def test_rows(self) -> None:
        rows = [*adaptive_baseline._numbers(), *adaptive_baseline.SIGNS]
        verdicts = [row.verdict for row in rows]
        assert verdicts.count("reproduced") == 5
        assert verdicts.count("wrong in print") == 5


@pytest.mark.parametrize("name", adaptive_systems.BUILDERS)
def test_every_system_builds_runs_and_is_shown(name: str) -> None:
    entry = SYSTEMS[name]
    system = entry.build()
    assert (system.name, system.description) == (entry.name, entry.description)
    result = run_system(system, stop_time=0.5, step=entry.step)
    panels = entry.figures(result)
    assert {panel.group for panel in panels} >= {"Tracking", "Control", "Adaptation"}
    assert all(np.isfinite(np.asarray(series.y)).all() for panel in panels for series in panel.series)
    numbers = {number.label: number.value for number in entry.key_numbers(result)}
    assert 3 < float(numbers["Largest torque"]) < 10
    assert ("Fuel left" in numbers) == ("fuel" in name)
    assert ("Least 1 - ‖Ĵ₁Ω‖" in numbers) == name.startswith("adaptive-fuel")


class TestKnownInertia:
    def test_both_laws_are_alike(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(adaptive_baseline, "SHOWN", 30.0)
        outcome = shown(adaptive_baseline.known_inertia(Choices()))
        similar = outcome.claims[:3]
        assert [row.verdict for row in similar] == ["reproduced"] * 3
        assert [row.measure for row in similar] == pytest.approx([1.0, 0.9275, 1.095], abs=0.01)
        assert [panel.title[:8] for panel in outcome.panels] == ["Fig. 3.3"] * 3


class TestAppendage:
    def rows(self, proposed: Trajectory, comparison: Trajectory) -> dict[str, Claim]:
        runs = {PROPOSED: proposed, COMPARISON: comparison}
        return {row.statement: row for row in adaptive_appendage._errors(runs, "printed", Choices())}

    def test_as_the_text_says(self) -> None:
        rows = self.rows(made_up(0.9e-4, 0.9e-3), made_up(1e-3, 0.5))
        assert [row.verdict for row in rows.values()] == ["reproduced"] * 8

    def test_not_as_the_text_says(self) -> None:
        rows = self.rows(made_up(2e-4, 2e-3), made_up(5e-3, 0.01))
        assert rows["rate error at 400 s [deg/s]"].verdict == "not reproduced"
        assert rows["attitude error, largest over the last 60 s"].verdict == "not reproduced"
        assert rows["attitude error saturates"].measure == pytest.approx(5e-3)
        assert rows["attitude error saturates"].verdict == "not reproduced"
        assert rows["rate error in the end: ratio"].measure == pytest.approx(5.0)
        assert rows["rate error in the end: ratio"].verdict == "not reproduced"

    def test_estimates(self) -> None:
        good, bad = made_up(1e-4, 1e-3), made_up(1e-4, 1e-3, sigma=0.5)
        rows = list(estimates("Sec. 3.4.1", good, bad, Choices()))
        assert [row.verdict for row in rows] == ["reproduced", "not reproduced", "reproduced"]
        assert good.end(SIGMA_ERROR) == pytest.approx(np.exp(-8))

    def test_short_run_of_the_components(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Values of an independent closed loop in SciPy at 100 s."""
        monkeypatch.setattr(adaptive_settings, "STOP_TIME", 100.0)
        monkeypatch.setattr(adaptive_appendage, "LATE", 60.0)
        monkeypatch.setattr(adaptive_readings, "LAST", 20.0)
        outcome = shown(adaptive_appendage.moving_appendages(Choices()))
        rows = [row for row in outcome.claims if row.settings == f"{PROPOSED}, ω₁ = 0.3 rad/s"]
        largest = {row.statement: row.measure for row in rows if "largest" in row.statement}
        assert list(largest.values()) == pytest.approx([4.94e-2, 1.33e-3], rel=0.01)
        assert [panel.title[:8] for panel in outcome.panels[:2]] == ["Fig. 3.4", "Fig. 3.5"]


@pytest.fixture(scope="module")
def fuel_outcome() -> Outcome:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(adaptive_settings, "STOP_TIME", 70.0)
        patch.setattr(adaptive_readings, "FREQUENCIES", {"printed": 0.3})
        patch.setattr(adaptive_fuel, "DECAY_FROM", 25.0)
        return shown(adaptive_fuel.losing_fuel(Choices()))


class TestFuel:
    def test_bound_is_reached_and_not_passed(self, fuel_outcome: Outcome) -> None:
        (row,) = [row for row in fuel_outcome.claims if row.statement.startswith("‖Ĵ₁‖")]
        assert row.measure == pytest.approx(0.008 * np.sqrt(2), rel=1e-3)
        assert row.verdict == "reproduced"

    def test_law_is_defined(self, fuel_outcome: Outcome) -> None:
        (row,) = [row for row in fuel_outcome.claims if row.statement.startswith("least implementability")]
        assert row.measure == pytest.approx(0.9883, abs=1e-4)

    def test_torque_peaks_fall(self, fuel_outcome: Outcome) -> None:
        rows = [row for row in fuel_outcome.claims if row.statement.startswith("peaks of the control torque")]
        assert [row.verdict for row in rows] == ["reproduced"] * 2

    def test_torque_that_grows_is_seen(self) -> None:
        falling = made_up(1e-4, 1e-3, torque=lambda t: np.cos(t) * np.exp(-t / 400))
        growing = made_up(1e-4, 1e-3, torque=lambda t: np.cos(t) * np.exp(t / 400))
        assert (np.diff(adaptive_fuel.torque_peaks(falling, np.pi)) < 0).all()
        assert (np.diff(adaptive_fuel.torque_peaks(growing, np.pi)) > 0).all()


class TestSteps:
    def test_sampled_limits(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """The law for fuel loss diverges where its adaptation is sampled at 10 ms, not with a short internal step."""
        monkeypatch.setattr(adaptive_steps, "FUEL_CASES", [(0.01, 0.01), (0.01, 1e-4), (0.001, 1e-4)])
        monkeypatch.setattr(adaptive_steps, "FUEL_STOP_TIME", 3.0)
        (table,) = shown(adaptive_steps.fuel_limits(Choices())).tables
        outcome = [str(cells[2]) for cells in table.rows]
        assert outcome == ["diverges at 1 s", "runs", "runs"]
        assert float(table.rows[2][3]) < 1e-4

    def test_first_order(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(adaptive_steps, "STOP_TIME", 10.0)
        appendage = {"appendage": adaptive_steps.SYSTEMS["appendage"]}
        monkeypatch.setattr(adaptive_steps, "SYSTEMS", appendage)
        fine, coarse = shown(adaptive_steps.exchange_steps(Choices())).tables[0].rows
        assert float(coarse[2]) / float(fine[2]) == pytest.approx(10, rel=0.05)


def test_choice_is_checked() -> None:
    with pytest.raises(AdcsError, match="choice estimated = 0: expected a part between 0 and 1"):
        Choices(estimated=0.0)
