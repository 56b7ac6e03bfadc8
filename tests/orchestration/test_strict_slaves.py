"""In step mode FMI forbids to read a component after it was set, before the next step: FMUs that refuse it run here."""

from collections.abc import Callable
from pathlib import Path

import foreign_fmus
import numpy as np
import pytest

import adcs
from adcs import AdcsError, CoSimulation, RunFailed, Save, Session, System, run
from orchestration.instances.instance import Instance
from orchestration.running.change import Change
from orchestration.running.hooks.changes import Changes

Foreign = Callable[..., Path]
STEPPINGS = ["compiled", "python"]
REFUSED = "returned error: get after set without doStep; before that, "
RULE = " had been set at this point, after which FMI allows no get before the next step"


@pytest.fixture(scope="session")
def foreign(tmp_path_factory: pytest.TempPathFactory) -> Foreign:
    folder = tmp_path_factory.mktemp("strict")
    return lambda version: foreign_fmus.build("strict", folder, version)


def alone(fmu, **start):
    system = System("alone")
    system.add("c", fmu, {"u": 1.0, "v": 0.0} | start)
    return system


def ring(fmu, **start):
    system = System("ring")
    for name in "ab":
        system.add(name, fmu, {"v": 0.0} | start)
    system.connect("a.x", "b.u")
    system.connect("b.x", "a.u", offset=1.0)
    return system


def failed(system, **settings):
    with pytest.raises(RunFailed) as error:
        run(system, **settings)
    return str(error.value)


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_what_depends_on_no_input_is_fetched_first(foreign, version, stepping):
    """x' of a is b.x + 1, x' of b is a.x, by Euler."""
    result = run(
        ring(foreign(version)),
        stop_time=0.3,
        step=0.1,
        method=CoSimulation(stepping=stepping),
        save=Save(["a.x", "b.x"]),
    )
    assert result["a.x"] == pytest.approx([0.0, 0.1, 0.2, 0.301], abs=1e-15)
    assert result["b.x"] == pytest.approx([0.0, 0.0, 0.01, 0.03], abs=1e-15)


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_component_that_feeds_nothing_is_read_first_too(foreign, version, stepping):
    system = System("chain")
    for name in "ab":
        system.add(name, foreign(version), {"v": 0.0} | ({"u": 1.0} if name == "a" else {}))
    system.connect("a.x", "b.u")
    result = run(system, stop_time=0.3, step=0.1, method=CoSimulation(stepping=stepping), save=Save(["b.x"]))
    assert result["b.x"] == pytest.approx([0.0, 0.0, 0.01, 0.03], abs=1e-15)


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_changes_that_no_row_shows_are_made_after_it(foreign, version, stepping):
    changes = [(0.0, "c.u", 2.0), (0.125, "c.v", 8.0), (0.125, "c.u", 3.0), (0.125, "c.u", 0.0), (0.5, "c.u", 9.0)]
    settings = {"stop_time": 0.5, "step": 0.125, "method": CoSimulation(stepping=stepping), "save": Save(["c.x"])}
    result = run(alone(foreign(version)), hooks=[Changes(changes)], **settings)
    assert result["c.x"].tolist() == [0.0, 0.25, 1.25, 2.25, 3.25]
    assert result.time.tolist() == [0.0, 0.125, 0.25, 0.375, 0.5]


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_changes_around_a_last_step_that_is_shorter(foreign, version, stepping):
    changes = [(0.25, "c.u", 2.0), (0.375, "c.u", 4.0), (0.4375, "c.u", 5.0)]
    settings = {"stop_time": 0.4375, "step": 0.125, "method": CoSimulation(stepping=stepping), "save": Save(["c.x"])}
    result = run(alone(foreign(version)), hooks=[Changes(changes)], **settings)
    assert result["c.x"].tolist() == [0.0, 0.125, 0.25, 0.5, 0.75]


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_when_a_change_is_made_makes_no_difference(foreign, version, stepping, monkeypatch):
    """For an FMU that takes both, to the last bit, whatever else happens at the points."""
    settings = {
        "stop_time": 1.03,
        "step": 0.1,
        "method": CoSimulation(stepping=stepping),
        "save": Save(["c.x", "c.unsaid"], every=3),
    }
    changes = [(0.1 * k, "c.u" if k % 3 else "c.v", 0.3 * k) for k in range(11)]
    rows = []
    for shows in (Session.shows, lambda self, name: True):
        monkeypatch.setattr(Session, "shows", shows)
        rows.append(run(alone(foreign(version), lenient=1.0), hooks=[Changes(changes)], **settings).data)
    assert np.array_equal(*rows)
    assert len(rows[0]) == 5


def test_which_changes_come_after_their_row(foreign, version):
    def early(record, name):
        with Session(alone(foreign(version)), step=0.1, record=record) as simulation:
            return not Change(0, name, 1.0).may_follow(simulation)

    assert not early(["c.x"], "c.u")
    assert not early(["c.x", "c.w"], "c.v")
    assert early(["c.w"], "c.u")
    assert early(["c.unsaid"], "c.v")  # of which the FMU says nothing
    assert early(["c.x"], "c.gain")  # of parameters, no FMU says anything


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_inputs_come_from_a_table_after_what_does_not_depend_on_them(foreign, version, stepping, tmp_path):
    (tmp_path / "u.csv").write_text("time,c.u\n0,0\n1,8\n")
    settings = {"stop_time": 0.5, "step": 0.125, "method": CoSimulation(stepping=stepping), "save": Save(["c.x"])}
    result = run(alone(foreign(version)), hooks=[adcs.inputs(tmp_path / "u.csv")], **settings)
    assert result["c.x"].tolist() == [0.0, 0.0, 0.125, 0.375, 0.75]


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_change_ends_no_run_that_is_to_be_saved_or_stopped(foreign, version, stepping, tmp_path):
    settings = {"step": 0.125, "method": CoSimulation(stepping=stepping), "save": Save(["c.x"])}
    changes = [(0.25, "c.u", 2.0), (0.375, "c.u", 4.0)]
    result = run(alone(foreign(version)), stop_time=1.0, hooks=[Changes(changes), adcs.until("c.x >= 0.5")], **settings)
    assert result["c.x"].tolist() == [0.0, 0.125, 0.25, 0.5]
    whole = run(alone(foreign(version), lenient=1.0), stop_time=0.5, hooks=[Changes(changes)], **settings)
    saved = tmp_path / "state.npz"
    run(
        alone(foreign(version), lenient=1.0),
        stop_time=0.25,
        hooks=[Changes(changes[:1]), adcs.checkpoint(saved)],
        **settings,
    )
    rest = run(alone(foreign(version), lenient=1.0), stop_time=0.5, hooks=[Changes(changes)], resume=saved, **settings)
    assert rest["c.x"].tolist() == whole["c.x"].tolist()[2:]


def test_adaptive_steps_read_every_point_once(foreign, version):
    result = run(
        ring(foreign(version)), stop_time=0.5, step=0.125, method=CoSimulation(adaptive=1e-4), save=Save(["a.x", "b.x"])
    )
    assert result["a.x"][-1] == pytest.approx(np.sinh(0.5), rel=1e-3)


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_refusal_says_what_was_tried(foreign, version, stepping):
    """An output that depends on an input directly is fetched after it was set; there is no other way."""
    settings = {"stop_time": 0.3, "step": 0.1, "method": CoSimulation(stepping=stepping)}
    text = failed(ring(foreign(version)), save=Save(["a.x", "b.w"]), **settings)
    assert text == (
        f"b failed at t = 0 s: getting w {REFUSED}u{RULE}, but by its ModelStructure w depends on them: leave it out "
        "of what is recorded (--record), or use an FMU that takes it; 0 rows are kept"
    )
    system = ring(foreign(version))
    system.add("c", foreign(version), {"v": 0.0})
    system.connect("b.w", "c.u")
    text = failed(system, save=Save(["c.x"]), **settings)
    assert f"getting x, w {REFUSED}u{RULE}, but by its ModelStructure w depends on them: connect others, or" in text


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_refusal_names_what_was_changed(foreign, version, stepping):
    settings = {"stop_time": 0.3, "step": 0.1, "method": CoSimulation(stepping=stepping)}
    text = failed(alone(foreign(version)), hooks=[Changes([(0.1, "c.gain", 2.0)])], save=Save(["c.x"]), **settings)
    assert text == f"c failed at t = 0.1 s: getting x {REFUSED}gain{RULE}; 1 rows are kept"
    text = failed(alone(foreign(version)), hooks=[Changes([(0.1, "c.u", 2.0)])], save=Save(["c.x", "c.w"]), **settings)
    assert f"getting x, w {REFUSED}u{RULE}, but by its ModelStructure w depends on them: leave it out" in text


def test_what_is_set_step_by_step_is_set_after_the_point(foreign, version):
    with Session(alone(foreign(version)), step=0.125, steps=3, record=["c.x"]) as simulation:
        seen = []
        for time, values in simulation:
            seen.append(values["c.x"].item())
            if time == 0.125:
                simulation.set("c.gain", 3.0)
    assert seen == [0.0, 0.125, 0.5, 0.875]


def test_reading_after_setting_would_be_seen(foreign, version, monkeypatch):
    monkeypatch.setattr(Session, "shows", lambda self, name: True)
    text = failed(
        alone(foreign(version)), hooks=[Changes([(0.1, "c.u", 2.0)])], save=Save(["c.x"]), stop_time=0.3, step=0.1
    )
    assert text.startswith(f"c failed at t = 0.1 s: getting x {REFUSED}u{RULE}")


def test_saying_that_no_step_is_gone_back_behind_would_be_seen(foreign, version, monkeypatch):
    """An FMU may forget what it needs for that, if it is told so."""
    monkeypatch.setattr(Instance, "never_returns", True)
    with pytest.raises(AdcsError, match="a state is restored that would not be any more"):
        run(
            ring(foreign(version)),
            stop_time=0.5,
            step=0.125,
            method=CoSimulation(adaptive=1e-4),
            save=Save(["a.x", "b.x"]),
        )
