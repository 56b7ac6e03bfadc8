"""A component may end the simulation, which is no failure: what is valid is kept, and the manifest says who and why."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import event_fmus
import pytest

import adcs
from adcs import AdcsError, CoSimulation, Hook, ModelExchange, RunFailed, Save, Session, System, linearize, run, steps
from adcs.cli import app as cli
from hil_bridge.hil.flying import fly

STEPPINGS = ("compiled", "python")
TAKEN, DISCARDED, EARLY, TAKEN_BY_DISCARD, PART_BY_DISCARD = range(5)
ME = ModelExchange()
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


class Seen(Hook):
    """Keeps number and time of each row, and c.x in it."""

    def __init__(self):
        self.rows = []

    def begin(self, simulation, hooks, watched):
        self.simulation = simulation

    def ahead(self, k):
        return 1

    def after(self, point, time):
        self.rows.append((point, time, float(self.simulation.values["c.x"])))


def ended(result):
    outcome = result.manifest["outcome"]
    assert (outcome["status"], outcome["rows"]) == ("complete", len(result.time))
    return outcome["ended"]


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_with_the_step_it_took(foreign, stepping):
    """FMI 3: the step up to 0.5 s is done, its values may be read; the others have come there, and values propagate."""
    result = run(
        pair(foreign("quitter"), {"at": 0.5}), stop_time=1.0, step=0.125, method=CoSimulation(stepping=stepping)
    )
    assert result.time.tolist() == [0.0, 0.125, 0.25, 0.375, 0.5]
    for name in ("before", "c", "after"):
        assert result[f"{name}.x"].tolist() == result.time.tolist()
    assert result["before.y"].tolist() == [2 * t for t in result.time]
    assert ended(result) == {"component": "c", "time": 0.5, "message": "landed"}
    assert repr(result).endswith("; complete, ended by c at 0.5 s: landed>")


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_with_a_step_it_discards(foreign, version, stepping):
    """FMI 2 has no other way; the values at the last time that was reached are kept."""
    system = pair(foreign("quitter", version), {"at": 0.5, "how": DISCARDED})
    if version == "3.0":  # where discard is no way to end
        with pytest.raises(RunFailed, match=r"c failed at t = 0.375 s: doStep returned discard, even in .*: landed"):
            run(system, stop_time=1.0, step=0.125, method=CoSimulation(stepping=stepping))
        return
    result = run(system, stop_time=1.0, step=0.125, method=CoSimulation(stepping=stepping))
    assert result["c.x"].tolist() == [0.0, 0.125, 0.25, 0.375]
    assert ended(result) == {"component": "c", "time": 0.375, "message": "landed"}


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("saves", [None, "true"])
def test_with_a_step_that_fmi_2_discards_at_its_end(foreign, stepping, saves):
    """The last successful time is the end of the step, so its row is kept: as for the step that FMI 3 takes."""
    fmu = foreign("quitter", "2.0", name=f"saves_{saves}", canGetAndSetFMUstate=saves)
    result = run(
        pair(fmu, {"at": 0.5, "how": TAKEN_BY_DISCARD}),
        stop_time=1.0,
        step=0.125,
        method=CoSimulation(stepping=stepping),
    )
    assert result.time.tolist() == [0.0, 0.125, 0.25, 0.375, 0.5]
    for name in ("before", "c", "after"):
        assert result[f"{name}.x"].tolist() == result.time.tolist()
    assert ended(result) == {"component": "c", "time": 0.5, "message": "landed"}


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("declared", [None, "true"])
def test_in_the_midst_of_a_step(foreign, stepping, declared):
    """Its own values have a row where it ended, the others' are of the point before; it may return early or not."""
    fmu = foreign("quitter", name=f"early_{declared}", mightReturnEarlyFromDoStep=declared)
    system = pair(fmu, {"at": 0.5, "how": EARLY, "reached": 0.4375})
    result = run(system, stop_time=1.0, step=0.125, method=CoSimulation(stepping=stepping))
    assert result.time.tolist() == [0.0, 0.125, 0.25, 0.375, 0.4375]
    assert result["c.x"].tolist() == result.time.tolist()
    assert result["before.x"].tolist() == result["after.x"].tolist() == [0.0, 0.125, 0.25, 0.375, 0.375]
    assert ended(result) == {"component": "c", "time": 0.4375, "others_at": 0.375, "message": "landed"}


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("saves", [None, "true"])
def test_in_the_midst_of_a_step_that_fmi_2_discards(foreign, stepping, saves):
    """Its last successful time lies within the step."""
    fmu = foreign("quitter", "2.0", name=f"part_{saves}", canGetAndSetFMUstate=saves)
    system = pair(fmu, {"at": 0.5, "how": PART_BY_DISCARD, "reached": 0.4375})
    result = run(system, stop_time=1.0, step=0.125, method=CoSimulation(stepping=stepping))
    assert result.time.tolist() == result["c.x"].tolist() == [0.0, 0.125, 0.25, 0.375, 0.4375]
    assert (ended(result)["time"], ended(result)["others_at"]) == (0.4375, 0.375)


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_in_the_midst_of_the_last_step_that_is_shorter(foreign, stepping):
    system = pair(foreign("quitter"), {"at": 0.55, "how": EARLY, "reached": 0.53125})
    result = run(system, stop_time=0.5625, step=0.125, method=CoSimulation(stepping=stepping))
    assert result.time.tolist() == result["c.x"].tolist() == [0.0, 0.125, 0.25, 0.375, 0.5, 0.53125]
    assert ended(result)["others_at"] == 0.5


@pytest.mark.parametrize("isolated", [False, True])
def test_in_the_midst_of_a_step_of_which_few_rows_are_kept(foreign, isolated):
    """There is room for its row after the last one of the grid; a process of its own hands on its time, too."""
    system = pair(foreign("quitter"), {"at": 0.5, "how": EARLY, "reached": 0.4375})
    result = run(system, stop_time=0.625, step=0.125, save=Save(every=3), isolated=isolated)
    assert result.time.tolist() == result["c.x"].tolist() == [0.0, 0.375, 0.4375]
    result = run(system, stop_time=0.625, step=0.125, save=Save(every=9), isolated=isolated)
    assert result.time.tolist() == result["c.x"].tolist() == [0.0, 0.4375]


def test_in_the_midst_of_a_step_in_a_session(foreign):
    system = pair(foreign("quitter"), {"at": 0.5, "how": EARLY, "reached": 0.4375})
    with Session(system, step=0.125) as simulation:
        rows = [(time, float(values["c.x"])) for time, values in simulation]
        assert rows[-2:] == [(0.375, 0.375), (0.4375, 0.4375)]
        assert simulation.ended.others_at == 0.375


def test_watchers_see_each_row_once_and_at_its_time(foreign):
    """At a point and between two, and at the end of a shorter step: as in the result."""
    for start, stop in (
        ({"at": 0.5}, 1.0),
        ({"at": 0.5, "how": EARLY, "reached": 0.4375}, 1.0),
        ({"at": 0.55}, 0.5625),
        ({"at": 0.55, "how": EARLY, "reached": 0.53125}, 0.5625),
        ({"at": 9.0}, 0.5625),
    ):
        seen = Seen()
        result = run(pair(foreign("quitter"), start), stop_time=stop, step=0.125, hooks=[seen])
        assert [time for _, time, _ in seen.rows] == [x for _, _, x in seen.rows] == result.time.tolist()
        assert [k for k, _, _ in seen.rows] == list(range(len(result.time)))


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("declared", [None, "true"])
def test_an_end_at_a_time_before_its_step(foreign, stepping, declared):
    """One that may return early is refused for the time only."""
    fmu = foreign("quitter", name=f"early_{declared}", mightReturnEarlyFromDoStep=declared)
    system = pair(fmu, {"at": 0.5, "how": EARLY, "reached": -1.0})
    with pytest.raises(RunFailed) as error:
        run(system, stop_time=1.0, step=0.125, method=CoSimulation(stepping=stepping))
    why = "is not within its step from 0.375 to 0.5 s" if declared else "was not allowed"
    assert f", which {why}" in str(error.value)


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_one_that_communicates_at_some_points_only(foreign, stepping):
    """It has come to 0.75 s when it asks at 0.375: the others go there, too."""
    result = run(
        pair(foreign("quitter"), {"at": 0.6}, every=3),
        stop_time=2.0,
        step=0.125,
        method=CoSimulation(stepping=stepping),
    )
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
        run(system, stop_time=1.0, step=0.125, method=CoSimulation(stepping=stepping, timeout=10.0))
    assert str(error.value).startswith(f"c failed at t = 0.5 s: doStep returned early at t = {number}")
    why = "which is not within its step from 0.5 to 0.625 s" if declared else "which was not allowed"
    assert why in str(error.value)
    assert error.value.result.time.tolist() == [0.0, 0.125, 0.25, 0.375, 0.5]


def test_long_recordings_end_in_any_piece(foreign):
    """Pieces of the compiled loop begin and end anywhere; every hundredth row is kept, and the end."""
    result = run(pair(foreign("quitter"), {"at": 30.0}), stop_time=100.0, step=0.0625, save=Save(every=100))
    assert ended(result)["time"] == 30.0
    assert result.time.tolist() == [0.0, 6.25, 12.5, 18.75, 25.0, 30.0]


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
    result = run(system, stop_time=1.0, step=0.1, hooks=[adcs.checkpoint(tmp_path / "state.npz")])
    assert ended(result)["component"] == "c"
    assert not (tmp_path / "state.npz").exists()


def test_with_adaptive_steps(foreign, version):
    system = System("alone")
    system.add("c", foreign("picky", version), {"u": 1.0, "stop": 0.5, "longest": 1.0})
    result = run(system, stop_time=1.0, step=0.125, method=CoSimulation(adaptive=1e-3), save=Save(["c.x"]))
    assert result.time.tolist() == [0.0, 0.125, 0.25, 0.375, 0.5]
    assert ended(result)["time"] == pytest.approx(0.5)


def test_with_adaptive_steps_in_the_midst_of_one(foreign):
    fmu = foreign("quitter", name="adapts", canGetAndSetFMUState="true")
    system = pair(fmu, {"at": 0.5, "how": EARLY, "reached": 0.4375})
    result = run(system, stop_time=1.0, step=0.25, method=CoSimulation(adaptive=1e-3))
    assert result.time.tolist() == result["c.x"].tolist() == [0.0, 0.25, 0.4375]
    assert ended(result)["others_at"] == result["before.x"][-1] == 0.25


# Coupled Model Exchange


@pytest.mark.parametrize(("period", "last", "time"), [(0.5, 3, 1.5), (0.35, 3, 1.05)])
def test_at_a_time_event(event, version, period, last, time):
    """The row at the time of the event is kept, on the grid or not."""
    system = System("alone")
    system.add("c", event("stair", version), {"period": period, "last": last})
    result = run(system, stop_time=9.0, step=0.25, method=ME)
    assert result.time[-1] == pytest.approx(time, abs=1e-15)
    assert result["c.counter"].tolist()[-1] == last
    assert len(result.time) == int(time / 0.25) + 1 + (time % 0.25 > 1e-9)
    assert ended(result) == {"component": "c", "time": pytest.approx(time), "message": "it gave no reason"}


def test_at_a_time_event_in_a_process_of_its_own(event):
    system = System("alone")
    system.add("c", event("stair", "3.0"), {"period": 0.35, "last": 3})
    result = run(system, stop_time=9.0, step=0.25, isolated=True, method=ME)
    assert result.time[-1] == pytest.approx(1.05)


@pytest.mark.parametrize("solver", ["DOP853", "CVode"])
def test_after_an_integrator_step(event, version, solver):
    system = System("alone")
    system.add("c", event("watcher", version), {"ends_at": 0.9, "threshold": 1e9})
    result = run(system, stop_time=2.0, step=0.25, method=ModelExchange(solver, max_step=0.1))
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
    cli.main()  # which raises SystemExit for any exit code but 0
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
    system = pair(foreign("quitter"), {"at": 0.5, "how": EARLY, "reached": 0.375})
    result = fly(system, Flight(), stop_time=1.0, step=0.25, fmi_version="3.0")
    assert result.time.tolist() == result["c.x"].tolist() == [0.0, 0.25, 0.375]
    assert ended(result)["others_at"] == 0.25


# Comparisons that NaN passes


@pytest.mark.parametrize("method", ["co-simulation", "model-exchange"])
def test_a_next_event_at_no_time_is_refused(foreign, event, method):
    system = System("alone")
    fmu = foreign("bouncer") if method == "co-simulation" else event("stair", "3.0")
    system.add("c", fmu, {"period": 0.5, "nowhere": 1.0})
    with pytest.raises(RunFailed, match=r"^c failed at t = 0\.2?5 s: its next event(, at| is at) t = nan s"):
        run(
            system,
            stop_time=2.0,
            step=0.25,
            method=CoSimulation() if method == "co-simulation" else ModelExchange(max_step=0.25),
        )


@pytest.mark.parametrize("method", ["co-simulation", "model-exchange"])
def test_everyone_sees_the_last_row_at_its_time(foreign, event, method):
    seen = []

    class Watcher(Hook):
        def begin(self, simulation, hooks, watched):
            self.simulation = simulation

        def ahead(self, k):
            return 1

        def after(self, point, time):
            seen.append((point, time, self.simulation.row.tolist()))

    system = pair(foreign("quitter"), {"at": 0.5})
    if method == "model-exchange":
        system = System("alone")
        system.add("c", event("watcher", "3.0"), {"ends_at": 0.6, "threshold": 1e9})
    result = run(
        system,
        stop_time=1.0,
        step=0.25,
        fmi_version="3.0",
        method=CoSimulation() if method == "co-simulation" else ModelExchange(max_step=0.1),
        hooks=[Watcher()],
    )
    assert [point for point, _, _ in seen] == ([0, 1, 2] if method == "co-simulation" else [0, 1, 2, 3])
    assert [time for _, time, _ in seen] == result.time.tolist()
    assert [row for _, _, row in seen] == result.data.tolist()
