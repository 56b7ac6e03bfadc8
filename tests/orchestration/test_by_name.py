"""What is done with a system is done with its name, or its file, at its own times."""

from __future__ import annotations

import json
import pickle

import numpy as np
import pytest

from adcs import AdcsError, CoupledModel, Session, System, check, linearize, read_ssp, run, steps, systems, write_ssp
from adcs.cli.app import app
from fmus.check import Finding
from orchestration.single import single
from tests.invoking import invoke


def test_a_name_is_a_system_with_its_times():
    plain = run(systems()["hil-spacecraft"].build(), stop_time=60.0, step=0.004)
    named = run("hil-spacecraft")
    assert np.array_equal(named.data, plain.data)
    assert np.array_equal(named.time, plain.time)
    assert [t for t, _ in steps("observer-pd", stop_time=0.03)] == [0.0, 0.01, 0.02, 0.03]
    assert linearize("full-state-pd").system == "full-state-pd"


def test_a_file_is_a_system_with_its_times(tmp_path):
    write_ssp(systems()["observer-pd"].build(), tmp_path / "x.ssp", start_time=1.0, stop_time=2.0, step=0.25)
    assert run(tmp_path / "x.ssp").time.tolist() == [1.0, 1.25, 1.5, 1.75, 2.0]
    assert run(str(tmp_path / "x.ssp"), start_time=0.0, stop_time=1.0, step=0.5).time.tolist() == [0.0, 0.5, 1.0]


@pytest.mark.parametrize(
    ("system", "settings", "message"),
    [
        ("observer-dp", {}, "no system 'observer-dp': did you mean observer-pd"),
        (System("mine"), {}, "stop_time: mine has none of its own, give it"),
        (System("mine"), {"stop_time": 1.0}, "step: mine has none of its own, give it"),
        ("trigo-bs", {"step": 0.3}, "step"),
    ],
)
def test_refused(system, settings, message):
    with pytest.raises(AdcsError) as error:
        run(system, **settings)
    assert message in str(error.value)


def test_a_system_of_ones_own_may_have_times():
    from orchestration.system import Times

    system = systems()["observer-pd"].build()
    system.times = Times(0.0, 0.5, 0.25)
    assert run(system).time.tolist() == [0.0, 0.25, 0.5]
    assert run(system, stop_time=0.25).time.tolist() == [0.0, 0.25]


def test_a_session_has_the_names_and_times_of_its_system():
    with Session("observer-pd", record=["controller.torque_B"]) as named:
        assert (named.step, named.start) == (0.01, 0.0)
        times = [t for t, _ in zip(named, range(3), strict=False)]
    assert [t for t, _ in times] == [0.0, 0.01, 0.02]
    with Session("observer-pd", step=0.5) as named:
        assert named.step == 0.5


def test_a_session_is_of_one_class_wherever_it_comes_from():
    from orchestration.running.session import Session as of_orchestration

    assert Session is of_orchestration
    assert pickle.loads(pickle.dumps(Session)) is Session


def test_a_coupled_model_by_name_is_that_of_the_system(tmp_path, monkeypatch):
    with CoupledModel("observer-pd") as named, CoupledModel(systems()["observer-pd"].build()) as plain:
        assert named.state_names == plain.state_names
        assert np.array_equal(named.x0, plain.x0)
    told = []

    def started(system, kind, start, *given, **more):
        told.append(start)
        raise ZeroDivisionError

    monkeypatch.setattr("orchestration.coupled.model.initialised", started)
    write_ssp("observer-pd", tmp_path / "x.ssp", start_time=3.0)
    for start in (None, 4.0):
        with pytest.raises(ZeroDivisionError):
            CoupledModel(tmp_path / "x.ssp", start)
    assert told == [3.0, 4.0]


def test_a_name_is_written_with_its_times(tmp_path):
    write_ssp("observer-pd", tmp_path / "x.ssp", step=0.5)
    file = read_ssp(tmp_path / "x.ssp")
    assert (file.start_time, file.stop_time, file.step) == (0.0, 100.0, 0.5)
    write_ssp(tmp_path / "x.ssp", tmp_path / "y.ssp")
    assert (tmp_path / "y.ssp").read_bytes() == (tmp_path / "x.ssp").read_bytes()


def test_times_that_nobody_gave_are_not_written(tmp_path):
    write_ssp(single("RigidBody"), tmp_path / "none.ssp")
    write_ssp(tmp_path / "none.ssp", tmp_path / "again.ssp")
    write_ssp(tmp_path / "none.ssp", tmp_path / "given.ssp", step=0.5)
    found = [read_ssp(tmp_path / f"{name}.ssp") for name in ("none", "again", "given")]
    assert [(file.stop_time, file.step) for file in found] == [(None, None), (None, None), (None, 0.5)]


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda: linearize("observer-dp"), "no system 'observer-dp': did you mean observer-pd"),
        (lambda: Session("observer-dp"), "no system 'observer-dp': did you mean observer-pd"),
        (lambda: CoupledModel("observer-dp"), "no system 'observer-dp': did you mean observer-pd"),
        (lambda: write_ssp("observer-dp", "x.ssp"), "no system 'observer-dp': did you mean observer-pd"),
        (lambda: Session(System("mine")), "step: mine has none of its own, give it"),
        (lambda: Session("trigo-bs", step=0.3), "step"),
    ],
)
def test_names_of_none_are_refused(made, message):
    with pytest.raises(AdcsError) as error:
        made()
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (
            "observr-pd",
            "no system 'observr-pd': did you mean observer-pd or quest-observer-pd or observer-inertia-error? "
            "`adcs list` shows all; or give an .ssp, .py or .fmu file",
        ),
        (
            "rigidbody",
            "no system 'rigidbody': did you mean RigidBody? `adcs list` shows all; or give an .ssp, .py or .fmu file",
        ),
        ("x\ny", "no system 'x\\ny': `adcs list` shows all; or give an .ssp, .py or .fmu file"),
    ],
)
def test_a_wrong_name_costs_one_line(name, message):
    with pytest.raises(AdcsError) as error:
        run(name)
    assert str(error.value) == message


def test_a_component_and_a_system_are_checked_by_name(tmp_path, monkeypatch):
    seen = []
    monkeypatch.setattr("adcs.by_name.check_fmu", lambda path: seen.append(path.name) or [Finding("run", "odd")])
    assert check("RigidBody") == [Finding("run", f"{name}: odd") for name in ("RigidBody.fmu", "RigidBody.fmi3.fmu")]
    write_ssp("observer-pd", tmp_path / "x.ssp")
    parts = {part.source for part in systems()["observer-pd"].build().components.values()}
    assert len(parts) == 5
    for system, versions in (("observer-pd", ("", ".fmi3")), (tmp_path / "x.ssp", ("",))):
        seen.clear()
        check(system)
        assert sorted(seen) == sorted(f"{part}{version}.fmu" for part in parts for version in versions)


def test_the_command_checks_a_system(monkeypatch):
    monkeypatch.setattr("adcs.cli.check.check", lambda path: [])
    told = json.loads(invoke(app, ["check", "observer-pd", "--json"]).stdout)
    assert len(told) == 10
    assert all(report["findings"] == [] and report["path"].endswith(".fmu") for report in told)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (
            "RigidBdy",
            "no component is called RigidBdy: did you mean RigidBody or OrbitingBody, or give a system, or an",
        ),
        ("none.ssp", "cannot open none.ssp: No such file or directory"),
    ],
)
def test_what_cannot_be_checked_is_refused(name, message):
    with pytest.raises(AdcsError) as error:
        check(name)
    assert str(error.value).startswith(message)
    assert [finding.rule for finding in check("none.fmu")] == ["archive", "run"]
