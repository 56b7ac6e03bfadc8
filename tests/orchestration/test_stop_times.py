"""What times components are given: none beyond the stop time they were told, whatever start, stop and step."""

from __future__ import annotations

import tracemalloc
from math import ulp

import event_fmus
import numpy as np
import pytest

import adcs
from adcs import AdcsError, CoSimulation, ModelExchange, Save, System, run, steps
from orchestration.grid import Grid

STEPPINGS = ("compiled", "python")
TIMES = [
    (0.0, 100.0, 0.01),
    (0.0, 60.0, 0.1),
    (0.0, 1.3, 0.1),
    (0.7, 1.4, 0.1),
    (-1.0, 0.0, 0.1),
    (0.0, 10.0, 0.001),
    (-0.35, 0.35, 0.05),
    (1e6, 1e6 + 10, 0.01),
    (1.7e9, 1.7e9 + 0.1, 0.01),
    (-1e5, -1e5 + 3, 0.1),
    (0.0, 3e5, 30.0),
]


def alone(fmu, start=None, every=1):
    system = System("alone")
    system.add("c", fmu, start, every)
    return system


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize(("start", "stop", "step"), TIMES)
def test_no_step_leads_beyond_the_stop_time_told(foreign, version, stepping, start, stop, step):
    """The component refuses it to the last bit, by the time it is told and by the time that it adds up itself."""
    if stepping == "python" and stop - start > 5000 * step:
        pytest.skip("the same as compiled, and slow")
    result = run(
        alone(foreign("punctual", version)),
        start_time=start,
        stop_time=stop,
        step=step,
        method=CoSimulation(stepping=stepping),
    )
    assert result.time[-1] == pytest.approx(stop, abs=2 * ulp(stop))
    assert result["c.step_seen"][-1] == step  # to the last bit, in all steps alike
    assert result["c.off"][-1] <= 3  # units in the last place: roundings of t_k, of t_(k-1), and of their step
    assert result["c.drift"][-1] <= len(result.time) * ulp(max(abs(start), abs(stop))) / step


def test_the_bound_is_above_all_that_can_be_computed_and_hardly_later_than_the_end():
    random = np.random.default_rng(11)
    for _ in range(300):
        step = float(random.choice([0.1, 0.05, 0.01, 1e-3, 0.3, 1 / 3, 7.0, random.uniform(1e-4, 10)]))
        start = float(random.choice([0.0, -1.0, 0.7, 1e6, -12345.678, random.uniform(-1e4, 1e4)]))
        n = int(random.integers(1, 3000))
        grid = Grid.make(start, start + n * step, step)
        assert grid.steps == n
        t = grid.times
        assert (t + step)[:-1].max() <= grid.bound
        assert np.cumsum([start, *[step] * n])[-1] <= grid.bound
        every = int(random.integers(2, 9))
        assert (t + every * step)[: n - every + 1].max(initial=start) <= grid.bound
        assert grid.bound - t[-1] <= 1.1e-6 * step + n * 1e-15 * np.abs(t).max()


@pytest.mark.parametrize("every", [3, 7])
def test_slow_components_neither(foreign, version, every):
    system = alone(foreign("punctual", version), every=every)
    result = run(system, stop_time=21.0, step=0.1)
    assert result["c.step_seen"][-1] == every * 0.1


def test_steps_neither(foreign, version):
    *_, (time, _) = steps(alone(foreign("punctual", version)), stop_time=60.0, step=0.1)
    assert time == 60.0


def test_adaptive_sub_steps_neither(foreign, version):
    result = run(
        alone(foreign("picky", version), {"u": 1.0, "longest": 1.0}),
        stop_time=1.3,
        step=0.1,
        method=CoSimulation(adaptive=1e-3),
        save=Save(["c.x"]),
    )
    assert result["c.x"][-1] == pytest.approx(1.3)


def test_steps_retried_in_halves_neither(foreign, version):
    result = run(alone(foreign("picky", version), {"u": 1.0}), stop_time=1.3, step=0.1)
    assert result["c.x"][-1] == pytest.approx(1.3)


def test_a_resumed_run_is_told_none(foreign, version, tmp_path):
    system = alone(foreign("picky", version), {"u": 1.0, "longest": 1.0})
    run(system, stop_time=0.7, step=0.1, hooks=[adcs.checkpoint(tmp_path / "state.npz")])
    result = run(system, stop_time=1.3, step=0.1, resume=tmp_path / "state.npz")
    assert result["c.x"][-1] == pytest.approx(1.3)


@pytest.mark.parametrize("solver", ["DOP853", "CVode"])
@pytest.mark.parametrize(("start", "stop", "step"), [(0.0, 1.3, 0.1), (0.7, 1.4, 0.1), (-1.0, 0.0, 0.1)])
def test_model_exchange_sets_no_time_beyond(tmp_path, version, solver, start, stop, step):
    """The bouncing ball looks for events ahead of the last point, and integrates up to it."""
    system = alone(event_fmus.build("bouncing_ball", tmp_path, version))
    times = {"start_time": start, "stop_time": stop, "step": step}
    result = run(system, **times, method=ModelExchange(solver, rtol=1e-8))
    assert result["c.bounces"][-1] >= 1


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("start", [0.0, 0.7, -2.3, 1000.1])
def test_events_announced_for_communication_points_are_handled_there(foreign, stepping, start):
    """Rounding brings t + h before or after k h; the event belongs to the row."""
    period = 0.1
    system = alone(foreign("bouncer"), {"level": 1e9, "period": period})
    result = run(
        system, start_time=start, stop_time=start + 40 * period, step=period, method=CoSimulation(stepping=stepping)
    )
    assert np.diff(result["c.hits"]).tolist() == [1] * 40


def test_a_start_time_that_leaves_few_digits_for_steps_takes_decimals():
    assert Grid.make(1.7e9, 1.7e9 + 0.1, 0.01).steps == 10
    assert Grid.make(1.7e9, 1.7e9 + 0.1, 0.01).index(1.7e9 + 0.07, "it") == 7


def test_very_many_steps_are_still_told_apart():
    with pytest.raises(AdcsError, match="is not a whole number of steps"):
        Grid.make(0.0, 1e10 + 0.5, 1.0)


def test_more_steps_than_can_be_counted():
    with pytest.raises(AdcsError) as error:
        Grid.make(-(2.0**53), 2.0**53, 1.0)
    assert str(error.value) == (
        "-9007199254740992.0 to 9007199254740992.0 s in steps of 1.0 s are 1.8e+16 steps, more than 2^53 can be "
        "counted: use a step of 1.8e+07 s, which makes 1e9, or more"
    )


@pytest.mark.parametrize("times", [(0.0, 1e18, 1e-3), (0.0, 1e16, 1.0), (1e20, 1e20 + 1e6, 1.0)])
def test_steps_that_time_does_not_resolve(times):
    with pytest.raises(AdcsError, match=r"^step = .* s is below the resolution of time at 1(\.0*1)?e\+\d\d s$"):
        Grid.make(*times)


def test_the_times_of_many_rows_take_the_room_of_one_array() -> None:
    grid = Grid(0.5, 0.01, 1_000_000)
    tracemalloc.start()
    times = grid.rows(0, 1)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 1.1 * times.nbytes
    assert times[[0, 7, 1_000_000]].tolist() == [0.5, 0.5 + 7 * 0.01, 0.5 + 1_000_000 * 0.01]
