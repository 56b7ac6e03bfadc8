"""Legal values that would take for ever, or all memory, are refused with what would be needed."""

from __future__ import annotations

import tracemalloc

import event_fmus
import numpy as np
import pytest

from adcs import AdcsError, ModelExchange, RunFailed, Save, System, run
from orchestration.coupled import integrators, solution
from orchestration.grid import Grid
from orchestration.instances import stepping
from orchestration.running.hooks.pace import Clock

ME = ModelExchange()


def alone(fmu, start=None):
    system = System("alone")
    system.add("c", fmu, start)
    return system


def test_rows_that_are_not_kept_take_no_memory(mock):
    """Two million points of which 2001 are rows: 16 kB of times, where all would be 16 MB."""
    system = alone(mock("ticker"))
    tracemalloc.start()
    try:
        result = run(system, stop_time=2000.0, step=1e-3, save=Save(["c.count"], every=1000))
        _, peak = tracemalloc.get_traced_memory()
        assert result.time.tolist() == list(range(2001))
        assert peak < 4e6
        tracemalloc.reset_peak()
        assert len(Grid.make(0.0, 1e5, 1e-3).rows(0, 1000)) == 100_001
        assert tracemalloc.get_traced_memory()[1] < 8e6
    finally:
        tracemalloc.stop()


def test_rows_that_fit_into_no_memory(mock):
    with pytest.raises(AdcsError, match=r"^1000000000000001 rows do not fit into memory: record not every step, or"):
        run(alone(mock("ticker")), stop_time=1e12, step=1e-3, save=Save(["c.count"]))


@pytest.mark.parametrize("solver", ["DOP853", "CVode"])
def test_a_row_that_takes_too_many_integrator_steps(mock, monkeypatch, solver):
    """A billion seconds between two rows, of an oscillator with a period of 6.3 s."""
    monkeypatch.setattr(integrators, "MOST_STEPS", 500)
    with pytest.raises(RunFailed) as error:
        run(
            alone(mock("oscillator"), {"u": 0.0}),
            stop_time=1e9,
            step=1e9,
            method=ModelExchange(solver, rtol=1e-6),
        )
    text = str(error.value)
    assert f"{solver} cannot go on from t = " in text
    assert "500 steps do not reach t = 1e+09 s, " in text
    needed = float(text.partition("1e+09 s, ")[2].partition(" would be needed")[0])
    assert 1e7 < needed < 1e11
    assert len(error.value.result.time) == 1


def test_a_row_with_too_many_events(tmp_path, monkeypatch, version):
    monkeypatch.setattr(solution, "_MOST_EVENTS", 50)
    with pytest.raises(RunFailed) as error:
        run(alone(event_fmus.build("stair", tmp_path, version)), stop_time=1e6, step=1e6, method=ME)
    assert str(error.value).startswith(
        "c failed at t = 50 s: 50 events lead from t = 0 only to 50 s, 1e+06 would be needed up to 1000000 s: choose"
    )


def test_a_step_with_too_many_ticks(foreign, monkeypatch):
    monkeypatch.setattr(stepping, "_MAX_PIECES", 50)
    with pytest.raises(RunFailed) as error:
        run(alone(foreign("counter")), stop_time=1e6, step=1e6)
    text = str(error.value)
    assert text.startswith(
        "c failed at t = 0 s: 50 events, ticks or early returns bring it from t = 0 only to 5 s, and"
    )
    assert "1e+07 would be needed for a communication step: take smaller ones" in text


@pytest.mark.parametrize("start", [1e20, -1e20, 1e15])
def test_a_start_far_away(chain, start):
    """Time has few digits there, which is enough for steps of many seconds."""
    result = run(chain(), start_time=start, stop_time=start + 10 * 2.0**20, step=2.0**20)
    assert result.time.tolist() == [start + k * 2.0**20 for k in range(11)]


@pytest.mark.parametrize("solver", ["DOP853", "CVode"])
def test_a_start_far_away_of_one_equation(mock, solver):
    """A period of 6.3 s is far below the resolution of time at 1e20 s: an end, not a wait."""
    with pytest.raises(RunFailed, match=rf"{solver} cannot go on from t = 1e\+20 s"):
        run(
            alone(mock("oscillator"), {"u": 0.0}),
            start_time=1e20,
            stop_time=1e20 + 2.0**20,
            step=2.0**20,
            method=ModelExchange(solver),
        )


def test_how_late_points_were_is_kept_of_some_only():
    """A paced run of days: percentiles of those that are kept, number and maximum of all."""
    pace = Clock(Grid(0.0, 1e-9, 0))
    pace.start(0)
    for k in range(450_000):
        pace.wait(k)
    report = pace.report()
    assert report["points"] == 450_000
    assert report["late_most_s"] >= report["late_99_percent_s"] >= report["late_median_s"] >= 0
    assert len(pace._late) < 200_000
    with pytest.raises(AdcsError, match="would last for ever"):
        Clock(Grid(0.0, 1.0, 0), 1e-309)


def test_times_of_rows():
    grid = Grid.make(0.5, 1.04, 0.1, lambda: None)
    assert (grid.steps, grid.full, grid.shorter) == (6, 5, pytest.approx(0.04))
    assert grid.rows(2, 3) == pytest.approx([0.8, 1.04])
    assert Grid.make(0.0, 1.0, 0.1).rows(1, 4) == pytest.approx([0.4, 0.8])
    assert np.array_equal(Grid.make(0.0, 1.0, 0.1).times, np.arange(11) * 0.1)
