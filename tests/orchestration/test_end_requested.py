"""A component may end the simulation, which is no failure: what is valid is kept, and the manifest says who and why."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import event_fmus
import pytest

from adcs import AdcsError, RunFailed, Session, System, linearize, run, steps
from adcs.cli import app as cli
from adcs.cli.bridge import _go
from hil_bridge.hil.flying import fly
from orchestration.grid import Grid
from orchestration.running.live import Pace

STEPPINGS = ("compiled", "python")
TAKEN, DISCARDED, EARLY, TAKEN_BY_DISCARD = 0, 1, 2, 3
ME = {"method": "model-exchange"}
Foreign = Callable[..., Path]


@pytest.fixture(scope="session")
def event(tmp_path_factory: pytest.TempPathFactory) -> Foreign:
    folder = tmp_path_factory.mktemp("end_events")
    return lambda model, version: event_fmus.build(model, folder, version)


def pair(fmu, start, every=1):
    """The component that ends it stands between two others, which have to come as far."""
    system = System("pair")
    system.add("before", fmu, {"at": 1e9})
    system.add("c", fmu, start, every)
    system.add("after", fmu, {"at": 1e9, "u": 1.0})
    system.connect("c.x", "before.u")
    system.connect("after.x", "c.u")
    return system


def ended(result):
    outcome = result.manifest["outcome"]
    assert (outcome["status"], outcome["rows"]) == ("complete", len(result.time))
    return outcome["ended"]


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_with_the_step_it_took(foreign, stepping):
    """FMI 3: the step up to 0.5 s is done, its values may be read; the others have come there, and values propagate."""
    result = run(pair(foreign("quitter"), {"at": 0.5}), stop_time=1.0, step=0.125, stepping=stepping)
    assert result.time.tolist() == [0.0, 0.125, 0.25, 0.375, 0.5]
    for name in ("before", "c", "after"):
        assert result[f"{name}.x"].tolist() == result.time.tolist()
    assert result["before.y"].tolist() == [2 * t for t in result.time]
    assert ended(result) == {"component": "c", "time": 0.5, "message": "landed"}


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_with_a_step_it_discards(foreign, version, stepping):
    """FMI 2 has no other way; the values at the last time that was reached are kept."""
    system = pair(foreign("quitter", version), {"at": 0.5, "how": DISCARDED})
    if version == "3.0":  # where discard is no way to end
        with pytest.raises(RunFailed, match=r"c failed at t = 0.375 s: doStep returned discard, even in .*: landed"):
            run(system, stop_time=1.0, step=0.125, stepping=stepping)
        return
    result = run(system, stop_time=1.0, step=0.125, stepping=stepping)
    assert result["c.x"].tolist() == [0.0, 0.125, 0.25, 0.375]
    assert ended(result) == {"component": "c", "time": 0.375, "message": "landed"}


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("saves", [None, "true"])
def test_with_a_step_that_fmi_2_discards_at_its_end(foreign, stepping, saves):
    """The last successful time is the end of the step, so its row is kept: as for the step that FMI 3 takes."""
    fmu = foreign("quitter", "2.0", name=f"saves_{saves}", canGetAndSetFMUstate=saves)
    result = run(pair(fmu, {"at": 0.5, "how": TAKEN_BY_DISCARD}), stop_time=1.0, step=0.125, stepping=stepping)
    assert result.time.tolist() == [0.0, 0.125, 0.25, 0.375, 0.5]
    for name in ("before", "c", "after"):
        assert result[f"{name}.x"].tolist() == result.time.tolist()
    assert ended(result) == {"component": "c", "time": 0.5, "message": "landed"}


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("declared", [None, "true"])
def test_in_the_midst_of_a_step(foreign, stepping, declared):
    """The rows up to the step, and the time at which it ended; whether it says that it may return early or not."""
    fmu = foreign("quitter", name=f"early_{declared}", mightReturnEarlyFromDoStep=declared)
    system = pair(fmu, {"at": 0.5, "how": EARLY, "reached": 0.4375})
    result = run(system, stop_time=1.0, step=0.125, stepping=stepping)
    assert result.time.tolist() == [0.0, 0.125, 0.25, 0.375]
    assert ended(result)["time"] == 0.4375


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("declared", [None, "true"])
def test_an_end_at_a_time_before_its_step(foreign, stepping, declared):
    """One that may return early is refused for the time only."""
    fmu = foreign("quitter", name=f"early_{declared}", mightReturnEarlyFromDoStep=declared)
    system = pair(fmu, {"at": 0.5, "how": EARLY, "reached": -1.0})
    with pytest.raises(RunFailed) as error:
        run(system, stop_time=1.0, step=0.125, stepping=stepping)
    why = "is not within its step from 0.375 to 0.5 s" if declared else "was not allowed"
    assert f", which {why}" in str(error.value)


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_one_that_communicates_at_some_points_only(foreign, stepping):
    """It has come to 0.75 s when it asks at 0.375: the others go there, too."""
    result = run(pair(foreign("quitter"), {"at": 0.6}, every=3), stop_time=2.0, step=0.125, stepping=stepping)
    assert result.time[-1] == 0.75
    assert result["after.x"][-1] == 0.75
    assert ended(result)["time"] == 0.75


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("declared", [None, "true"])
@pytest.mark.parametrize("number", ["nan", "inf", "-1"])
def test_a_step_that_returns_at_no_time_of_its_own_is_refused(foreign, stepping, declared, number):
    """With and without the permission to return early."""
    system = System("alone")
    fmu = foreign("short", name=f"bad_time_{declared}", mightReturnEarlyFromDoStep=declared)
    system.add("c", fmu, {"wrong": {"nan": 1, "inf": 2, "-1": 3}[number], "longest": 1.0})
    with pytest.raises(RunFailed) as error:
        run(system, stop_time=1.0, step=0.125, stepping=stepping, timeout=10.0)
    assert str(error.value).startswith(f"c failed at t = 0.5 s: doStep returned early at t = {number}")
    why = "which is not within its step from 0.5 to 0.625 s" if declared else "which was not allowed"
    assert why in str(error.value)
    assert error.value.result.time.tolist() == [0.0, 0.125, 0.25, 0.375, 0.5]


def test_long_recordings_end_in_any_piece(foreign):
    """Pieces of the compiled loop begin and end anywhere; every hundredth row is kept."""
    result = run(pair(foreign("quitter"), {"at": 30.0}), stop_time=100.0, step=0.0625, record_every=100)
    assert ended(result)["time"] == 30.0
    assert result.time.tolist() == [0.0, 6.25, 12.5, 18.75, 25.0]


def test_steps_yield_nothing_after_it(foreign):
    times = [t for t, _ in steps(pair(foreign("quitter"), {"at": 0.5}), stop_time=1.0, step=0.25, fmi_version="3.0")]
    assert times == [0.0, 0.25, 0.5]


def test_a_session_says_who(foreign):
    with Session(pair(foreign("quitter"), {"at": 0.5}), step=0.25) as simulation:
        times = [time for time, _ in simulation]
        assert times[-1] == 0.5
        assert str(simulation.ended) == "c ended the simulation at t = 0.5 s: landed"


def test_no_checkpoint_is_written_of_what_nobody_can_go_on_with(foreign, tmp_path):
    system = System("alone")
    system.add("c", foreign("picky"), {"u": 1.0, "stop": 0.5})
    result = run(system, stop_time=1.0, step=0.1, checkpoint=tmp_path / "state.npz")
    assert ended(result)["component"] == "c"
    assert not (tmp_path / "state.npz").exists()


def test_with_adaptive_steps(foreign, version):
    system = System("alone")
    system.add("c", foreign("picky", version), {"u": 1.0, "stop": 0.5, "longest": 1.0})
    result = run(system, stop_time=1.0, step=0.125, adaptive=1e-3, record=["c.x"])
    assert result.time.tolist() == [0.0, 0.125, 0.25, 0.375, 0.5]
    assert ended(result)["time"] == pytest.approx(0.5)


# Coupled Model Exchange


@pytest.mark.parametrize(("period", "last", "time"), [(0.5, 3, 1.5), (0.35, 3, 1.05)])
def test_at_a_time_event(event, version, period, last, time):
    """The row at the time of the event is kept, on the grid or not."""
    system = System("alone")
    system.add("c", event("stair", version), {"period": period, "last": last})
    result = run(system, stop_time=9.0, step=0.25, **ME)
    assert result.time[-1] == pytest.approx(time, abs=1e-15)
    assert result["c.counter"].tolist()[-1] == last
    assert len(result.time) == int(time / 0.25) + 1 + (time % 0.25 > 1e-9)
    assert ended(result) == {"component": "c", "time": pytest.approx(time), "message": "it gave no reason"}


@pytest.mark.parametrize("solver", ["DOP853", "CVode"])
def test_after_an_integrator_step(event, version, solver):
    system = System("alone")
    system.add("c", event("watcher", version), {"ends_at": 0.9, "threshold": 1e9})
    result = run(system, stop_time=2.0, step=0.25, solver=solver, **ME)
    assert 0.9 <= result.time[-1] <= 1.0
    assert result["c.y"] == pytest.approx(result.time, abs=1e-9)
    assert ended(result)["time"] == result.time[-1]


def test_a_linearisation_beyond_it_is_refused(event, version):
    system = System("alone")
    system.add("c", event("watcher", version), {"ends_at": 0.5, "threshold": 1e9})
    with pytest.raises(AdcsError, match=r"^c ended the simulation at t = .* linearise at a time before that$"):
        linearize(system, 2.0, fmi_version=version)


# What people see


def test_on_the_terminal(foreign, tmp_path, capsys, monkeypatch):
    fmu = foreign("quitter")
    arguments = ["run", str(fmu), "--stop", "1", "--step", "0.125", "--out", str(tmp_path), "--no-report"]
    monkeypatch.setattr("sys.argv", ["adcs", *arguments])
    with pytest.raises(SystemExit) as end:
        cli.main()
    assert end.value.code == 0
    assert "ended at t = 0.5 s by quitter: landed" in capsys.readouterr().out
    assert json.loads((tmp_path / "manifest.json").read_text())["outcome"]["ended"]["time"] == 0.5
    assert len((tmp_path / "result.csv").read_text().splitlines()) == 6


def test_in_a_flight(foreign):
    class Flight:
        def __call__(self, simulation): ...

        def report(self):
            return {}

    result = fly(pair(foreign("quitter"), {"at": 0.5}), Flight(), stop_time=1.0, step=0.25, fmi_version="3.0")
    assert result.time.tolist() == [0.0, 0.25, 0.5]
    assert ended(result)["component"] == "c"


# Comparisons that NaN passes


@pytest.mark.parametrize("method", ["co-simulation", "model-exchange"])
def test_a_next_event_at_no_time_is_refused(foreign, event, method):
    system = System("alone")
    fmu = foreign("bouncer") if method == "co-simulation" else event("stair", "3.0")
    system.add("c", fmu, {"period": 0.5, "nowhere": 1.0})
    with pytest.raises(RunFailed, match=r"^c failed at t = 0\.2?5 s: its next event(, at| is at) t = nan s"):
        run(system, stop_time=2.0, step=0.25, method=method)


def test_under_a_bridge(foreign):
    seen = []

    def watcher(simulation):
        seen.append(simulation.k - 1)
        return ()

    with Session(pair(foreign("quitter"), {"at": 0.5}), step=0.25) as simulation:
        pace = Pace(Grid(0.0, 1e-4, 0))
        pace.start(0)
        _go(simulation, watcher, pace)
        assert seen == [0, 1, 2]
        assert simulation.ended.as_dict() == {"component": "c", "time": 0.5, "message": "landed"}
