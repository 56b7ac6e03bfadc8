"""Measures of known curves, by value."""

from __future__ import annotations

import numpy as np
import pytest

from adcs.library.trajectory import Quantity, Trajectory, component_panel, norm_panel, pooled_rms

ERROR = Quantity("rate error", "ω_e", "rad/s", floor=1e-3)
ANGLE = Quantity("angle", "φ", "deg")
TIME = np.linspace(0, 10, 1001)
RUN = Trajectory(TIME, {ERROR: np.outer(np.exp(-TIME), [3.0, 0.0, -4.0]), ANGLE: 2 * TIME})


def test_a_quantity_is_its_name_and_knows_its_unit() -> None:
    assert f"{ERROR} [{ERROR.unit}]" == "rate error [rad/s]"
    assert (ERROR.title, ERROR.in_unit, ERROR.size) == ("Rate error", " [rad/s]", "‖ω_e‖ [rad/s]")
    assert Quantity("part", "p").in_unit == ""


def test_measures() -> None:
    assert (RUN.start(ERROR), RUN.peak(ERROR), RUN.end(ANGLE)) == (pytest.approx(5), pytest.approx(5), 20)
    assert RUN.least(ERROR) == RUN.end(ERROR) == pytest.approx(5 * np.exp(-10))
    assert RUN.settled(ERROR, 0.02) == pytest.approx(-np.log(0.02), abs=0.01)
    assert RUN.settled(ERROR, 0.02, of=50.0) == pytest.approx(-np.log(0.2), abs=0.01)
    assert np.isnan(RUN.settled(ANGLE, 0.5))
    assert RUN.area(ERROR) == pytest.approx(5 * (1 - np.exp(-10)), rel=1e-5)
    assert RUN.oscillation(ERROR) == pytest.approx(7 * (1 - np.exp(-10)), rel=1e-12)
    assert RUN.speed(ERROR) == pytest.approx(5, rel=0.006)
    assert RUN.rms(ANGLE) == pytest.approx(20 / np.sqrt(3), rel=1e-3)
    assert RUN.at(ANGLE, 3.0) == pytest.approx(6)
    assert RUN.at(ANGLE, 3.005) == pytest.approx(6)


def test_parts() -> None:
    assert RUN.after(4.0).time[[0, -1]].tolist() == [4.0, 10.0]
    assert RUN.until(4.0).time[[0, -1]].tolist() == [0.0, 4.0]
    assert RUN.between(3.0, 4.0).time[[0, -1]].tolist() == [3.0, 4.0]
    assert RUN.every(100).time.tolist() == list(range(11))
    assert RUN.after(4.0)[ERROR].shape == (601, 3)
    assert ERROR in RUN
    assert Quantity("other", "o") not in RUN


def test_runs_are_pooled() -> None:
    short = Trajectory(np.zeros(1), {ANGLE: np.array([3.0])})
    long = Trajectory(np.zeros(3), {ANGLE: np.array([4.0, 0.0, 0.0])})
    assert pooled_rms([short, long], ANGLE) == 2.5


def test_panels() -> None:
    other = Trajectory(TIME, {ANGLE: TIME})
    panel = norm_panel(ERROR, {"bare": other, "own": RUN}, group="g")
    assert (panel.title, panel.y_label, panel.log, panel.group) == ("Rate error", "‖ω_e‖ [rad/s]", True, "g")
    assert [(series.label, series.color) for series in panel.series] == [("own", 1)], "each run keeps its colour"
    assert np.nanmin(np.asarray(panel.series[0].y)) >= ERROR.floor, "no rounding is drawn"
    assert np.asarray(norm_panel(ERROR, {"": RUN}, log=False).series[0].y).min() < ERROR.floor
    assert norm_panel(ANGLE, {"": RUN}).y_label == "φ [deg]"
    components = component_panel(ERROR, {"": RUN, "bare": other}, "t")
    assert [series.label for series in components.series] == ["1", "2", "3"]
    assert components.y_label == "ω_e [rad/s]"
