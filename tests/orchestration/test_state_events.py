"""Events of coupled Model Exchange against exact event times: state events, time events, and both among components.

The FMUs refuse calls in the wrong mode, discrete inputs set in continuous time, and time that goes back.
"""

from __future__ import annotations

import zipfile
from pathlib import Path

import event_fmus
import numpy as np
import pytest

from adcs import AdcsError, ModelExchange, RunFailed, System, run
from orchestration.coupled import simulation, solution
from orchestration.coupled.crossing import first_crossing

ME = ModelExchange()
# how far event times may be off: the integrator's own error, at 1e-10 and 1e-12
SOLVERS = [("DOP853", 1e-10, 1e-12), ("CVode", 1e-12, 1e-9)]


@pytest.fixture(scope="session")
def event_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("events")


@pytest.fixture
def single(event_folder):
    """A system of one component `c`."""

    def build(model, version="2.0", start=None):
        system = System(model)
        system.add("c", event_fmus.build(model, event_folder, version), start or {})
        return system

    return build


@pytest.fixture(params=SOLVERS, ids=["DOP853", "CVode"])
def solver(request):
    name, rtol, error = request.param
    return {"solver": name, "rtol": rtol, "error": error}


def bounce_times(n, g=9.81, e=0.7, h=1.0):
    """When a ball dropped from h bounces: after each bounce it is as fast as e times before, for 2 v / g."""
    first, speed = np.sqrt(2 * h / g), np.sqrt(2 * g * h)
    return np.cumsum([first, *(2 * e ** np.arange(1, n) * speed / g)])


def heights(times, bounces, g=9.81, e=0.7, h=1.0):
    """Height at times, each after the given number of bounces."""
    at = np.concatenate([[0.0], bounce_times(100, g, e, h)])[bounces]
    speed = np.where(bounces == 0, 0.0, e**bounces * np.sqrt(2 * g * h))
    return np.where(bounces == 0, h, 0.0) + speed * (times - at) - g / 2 * (times - at) ** 2


def settings(solver):
    return {"method": ModelExchange(solver["solver"], rtol=solver["rtol"])}


@pytest.mark.parametrize("lift", [True, False])  # False: the indicator is zero after the event, and leaves it again
def test_a_ball_bounces_at_the_exact_times(single, version, solver, lift):
    result = run(single("bouncing_ball", version, {"lift": lift}), stop_time=2.5, step=0.1, **settings(solver))
    exact = bounce_times(30)
    bounces = result["c.bounces"].astype(int)
    assert bounces.tolist() == [int(np.sum(exact <= t)) for t in result.time]
    assert bounces[-1] == 11
    after = bounces > 0
    assert result["c.last"][after] == pytest.approx(exact[bounces[after] - 1], abs=solver["error"])
    assert result["c.height"] == pytest.approx(heights(result.time, bounces), abs=10 * solver["error"])


def test_both_versions_agree_to_the_last_bit(single):
    two, three = (run(single("bouncing_ball", v), stop_time=2.5, step=0.5, method=ME) for v in ("2.0", "3.0"))
    assert np.array_equal(two.data, three.data)


def test_a_ball_comes_to_rest(single, version):
    result = run(single("bouncing_ball", version, {"rest": 0.1}), stop_time=5, step=0.5, method=ME)
    assert result["c.bounces"][-1] == 11
    assert result["c.speed"][-1] == 0.0
    assert result["c.height"][-1] == pytest.approx(0.0, abs=1e-300)


@pytest.mark.parametrize(("version", "name"), [("2.0", "DOP853"), ("3.0", "CVode")])
def test_infinitely_many_bounces_end_in_one_line(single, version, name):
    with pytest.raises(RunFailed) as error:
        run(single("bouncing_ball", version), stop_time=5, step=0.5, method=ModelExchange(name))
    end = bounce_times(2000)[-1]
    assert error.value.result.time[-1] == 2.5
    outcome = error.value.result.manifest["outcome"]
    assert (outcome["component"], outcome["rows"]) == ("c", 6)
    assert outcome["time"] == pytest.approx(end, abs=1e-4 if name == "CVode" else 1e-8)
    assert "it chatters: 100 events within" in str(error.value)
    assert "the last by event indicator 1 of 1; give the model a hysteresis" in str(error.value)
    assert "\n" not in str(error.value)


def test_a_relay_without_hysteresis_chatters(single, version, solver):
    with pytest.raises(RunFailed, match=r"^c failed at t = 0\.5 s: it chatters: 100 events within .* 1 rows are kept"):
        run(single("relay", version, {"low": 0.5, "high": 0.5}), stop_time=10, step=1, **settings(solver))


def test_a_relay_switches_at_the_exact_times(single, version, solver):
    """From 0 down to -1, then a triangle between -1 and 1 of period 4."""
    result = run(single("relay", version), stop_time=10, step=0.25, **settings(solver))
    assert result["c.switches"].tolist() == np.floor((result.time + 1) / 2).tolist()  # rows at 1, 3, ... hold it
    assert result["c.y"] == pytest.approx(np.abs((result.time + 1) % 4 - 2) - 1, abs=1e-10)


def test_a_row_at_an_event_holds_the_values_after_it(single, version):
    """With g = 2 and e = 1/2 the bounces are at 1, 2, 2.5, 2.75."""
    result = run(single("bouncing_ball", version, {"g": 2.0, "e": 0.5}), stop_time=2.75, step=0.25, method=ME)
    assert result["c.bounces"].tolist() == [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 3, 4]
    assert result["c.speed"][[4, 8, 10, 11]] == pytest.approx([1.0, 0.5, 0.25, 0.125], abs=1e-13)
    assert result["c.height"][[4, 8, 10, 11]] == pytest.approx(np.zeros(4), abs=1e-13)


@pytest.mark.parametrize("period", [0.5, 0.3, 0.1, 1 / 3, 0.7])
def test_time_events_are_hit_exactly(single, version, period):
    result = run(single("stair", version, {"period": period}), stop_time=2.1, step=0.1, method=ME)
    assert result["c.late"].tolist() == [0.0] * 22  # not by one unit in the last place
    assert result["c.counter"].tolist() == np.floor(result.time / period + 1e-6).tolist()


def test_a_time_event_and_a_state_event_at_once(single, event_folder, version):
    system = single("bouncing_ball", version, {"g": 2.0, "e": 0.5})
    system.add("stair", event_fmus.build("stair", event_folder, version), {"period": 1.0})
    result = run(system, stop_time=2.25, step=0.75, method=ME)
    assert result["c.bounces"].tolist() == [0, 0, 1, 2]
    assert result["stair.counter"].tolist() == [0, 0, 1, 2]
    assert result["stair.late"].tolist() == [0.0] * 4
    assert result["c.last"] == pytest.approx([0, 0, 1, 2], abs=1e-14)


def test_values_pass_through_all_components_at_an_event(single, event_folder, version):
    """bounces -> n -> n + 1 -> n: integer, Boolean and real inputs that change only at events."""
    system = single("bouncing_ball", version, {"g": 2.0, "e": 0.5})
    tally = event_fmus.build("tally", event_folder, version)
    system.add("first", tally, {"enable": True, "level": 0.0, "u": 0.5})
    system.add("second", tally, {"u": 0.0})
    for source, target in (("c.bounces", "first.n"), ("first.more", "second.n"), ("first.odd", "second.enable")):
        system.connect(source, target)
    system.connect("c.last", "second.level")
    result = run(system, stop_time=2.5, step=0.5, method=ME)
    assert result["first.odd"].tolist() == [0, 0, 1, 1, 0, 1]
    # x' = bounces + 1/2
    assert result["first.total"] == pytest.approx([0, 0.25, 0.5, 1.25, 2.0, 3.25], abs=1e-13)
    # x' = (bounces + 1) + time of the last bounce, while bounces is odd
    assert result["second.total"] == pytest.approx([0, 0, 0, 1.5, 3.0, 3.0], abs=1e-13)
    # one update at the start, and two at each bounce: with the inputs before, and with those after
    assert result["first.updates"][-1] == result["second.updates"][-1] == 1 + 2 * 3


def test_simultaneous_events_are_one(single, event_folder, version):
    system = single("bouncing_ball", version)
    system.add("twin", event_fmus.build("bouncing_ball", event_folder, version))
    system.add("tally", event_fmus.build("tally", event_folder, version), {"enable": True, "level": 0.0, "u": 0.0})
    system.connect("twin.bounces", "tally.n")
    result = run(system, stop_time=2, step=0.5, method=ME)
    assert np.array_equal(result["c.last"], result["twin.last"])
    assert np.array_equal(result["c.height"], result["twin.height"])
    bounces = result["c.bounces"]
    assert bounces[-1] == np.sum(bounce_times(30) <= 2)
    assert result["tally.updates"].tolist() == (1 + 2 * bounces).tolist()


def test_crossings_there_and_back_within_a_step(single, version, solver):
    """sin(t) is above 0.99 for 0.28 s around each peak, and rows are 20 s apart."""
    result = run(single("peaks", version), stop_time=20, step=20, **settings(solver))
    assert (result["c.rises"][-1], result["c.falls"][-1]) == (3, 3)
    assert result["c.last"][-1] == pytest.approx(
        5 * np.pi - np.arcsin(0.99), abs=1e-7 if solver["error"] > 1e-10 else 1e-9
    )


def test_that_looking_into_steps_is_what_finds_them(single, monkeypatch):
    monkeypatch.setattr(solution, "LOOKS", 1)
    monkeypatch.setattr(simulation, "LOOKS", 1)
    result = run(single("peaks"), stop_time=20, step=20, method=ModelExchange(rtol=1e-3))
    assert result["c.rises"][-1] < 3


def test_indicators_without_continuous_states(single, version):
    result = run(single("wave", version), stop_time=10, step=0.5, method=ME)
    assert result["c.crossings"][-1] == 4  # from 0 to above, and at pi, 2 pi, 3 pi
    assert result["c.last"][-1] == pytest.approx(3 * np.pi, abs=2e-15)


def test_zero_belongs_to_the_negative_side(single, version):
    result = run(single("ramp", version), stop_time=5, step=0.3125, method=ME)
    assert result["c.events"][-1] == 2  # 1 -> 0 is one, 0 -> negative is none, negative -> positive is one
    assert result["c.sum"][-1] == pytest.approx(1.0 + 4.0, abs=2e-15)


def test_nominal_values_scale_the_tolerance(single, version, solver):
    """A state of the size 1e-9 is integrated as accurately as one of the size 1, if its nominal value says so."""
    chosen = {"stop_time": 5, "step": 5, "method": ModelExchange(solver["solver"], rtol=1e-6, atol=1e-6)}
    exact = 1e-9 * np.exp(-5)

    def error(nominal, **more):
        start = {"x": 1e-9, "nominal": nominal, "nominal_after": nominal, **more}
        return abs(run(single("decay", version, start), **chosen)["c.y"][-1] / exact - 1)

    assert error(1e-9) < 1e-4
    assert error(1.0) > 0.1
    assert error(1.0, nominal_after=1e-9, change_at=0.01) < 1e-3  # nominals change at an event
    assert error(0.0) == error(1.0)  # of no use


def test_components_hear_of_completed_steps(single, version, solver):
    """Rows are 3 s apart: the component sees x pass its threshold only because it is asked after every step."""
    result = run(single("watcher", version, {"threshold": 0.5}), stop_time=3, step=3, **settings(solver))
    assert result["c.steps"][-1] > 3
    assert result["c.fired"][-1] == 1
    fired_at = result["c.fired_at"][-1]
    assert 0.5 < fired_at < 3.0
    assert result["c.y"][-1] == pytest.approx(3.0 - fired_at, abs=1e-9)


def test_events_that_change_nothing_do_not_hold_up_the_integration(single, version, solver):
    """One is asked for after every step, which are as many as without."""
    calm, asking = (
        run(single("watcher", version, {"threshold": 9.0, "always": always}), stop_time=3, step=3, **settings(solver))
        for always in (0.0, 1.0)
    )
    assert asking["c.steps"].tolist() == calm["c.steps"].tolist()
    assert asking["c.y"].tolist() == calm["c.y"].tolist()


def test_a_step_that_leads_out_of_bounds_is_made_shorter(single, version, solver):
    method = ModelExchange(solver["solver"], rtol=1e-12)
    result = run(single("bounded", version, {"status": True}), stop_time=3.5, step=0.7, method=method)
    assert result["c.resets"].tolist() == [0, 0, 1, 2, 2, 3]
    assert result["c.y"] == pytest.approx([0, 0.7, 0.4, 0.1, 0.8, 0.5], abs=1e-10)


def test_an_error_is_not_tried_again(single, version, solver):
    method = ModelExchange(solver["solver"], max_step=0.35)
    with pytest.raises(RunFailed, match="getDerivatives returned error: x is out of bounds; 2 rows are kept"):
        run(single("bounded", version, {"status": False}), stop_time=3.5, step=0.7, method=method)


def test_states_that_change_dimension_are_refused(single):
    with pytest.raises(AdcsError, match=r"^c: it has 3 continuous states, but 1 in its modelDescription\.xml: states"):
        run(single("growing", "3.0", {"more": 2}), stop_time=1, step=0.5, method=ME)


def test_clocks_are_refused(event_folder, tmp_path):
    clock = (
        '<Clock name="tick" valueReference="900" causality="input" intervalVariability="constant" intervalDecimal="1"/>'
    )
    path = tmp_path / "clocked.fmu"
    with zipfile.ZipFile(event_fmus.build("growing", event_folder, "3.0")) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            new.writestr(name, old.read(name).replace(b"</ModelVariables>", f"{clock}</ModelVariables>".encode()))
    system = System("clocked")
    system.add("c", path)
    with pytest.raises(
        AdcsError, match=r"^c \(clocked\.fmu\) has clocks \(tick\), .*: it has none, export it with event mode$"
    ):
        run(system, stop_time=1, step=0.5, method=ME)


def test_an_event_that_does_not_settle(single, version):
    with pytest.raises(AdcsError, match="the event does not settle in 100 iterations: c keep changing"):
        run(single("restless", version), stop_time=1, step=0.5, method=ME)


@pytest.mark.parametrize(
    ("z", "expected"),
    [
        (lambda t: [np.cos(t)], np.pi / 2),
        (lambda t: [t - 1.0], 1.0),
        (lambda t: [-1.0 + (1e8 * t) ** 3], 1e-8),
        (lambda t: [(t - 0.5) ** 5], 0.5),
        (lambda t: [1.0 if t < 0.3 else -1e-12], 0.3),
        (lambda t: [1.9 - t, np.cos(t), t - 1.7], np.pi / 2),  # the first of several
        (lambda t: [t * (t - 1.2)], 1.2),  # zero at the start, on the negative side
        (lambda t: [t**2], 0.0),  # leaves zero at once
    ],
)
def test_the_first_crossing(z, expected):
    calls = []

    def counted(t):
        calls.append(t)
        return np.array(z(t))

    found = first_crossing(counted, 0.0, np.array(z(0.0)), 2.0, np.array(z(2.0)))
    positive = np.array(z(0.0)) > 0
    assert np.any((np.array(z(found)) > 0) != positive)  # on the far side
    flat = 1e-3 if z(0.25)[0] == (0.25 - 0.5) ** 5 else 1e-15  # where rounding makes a fifth power zero
    assert found == pytest.approx(expected, abs=flat)
    assert found >= expected - flat
    assert len(calls) <= 54
