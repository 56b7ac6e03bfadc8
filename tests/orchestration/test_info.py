"""`adcs info` of what is in files."""

import json
from importlib import metadata

import pytest
from rich.console import Console

import fmus
from adcs import AdcsError, components, write_ssp
from adcs.catalogue import SYSTEMS
from adcs.cli.app import app
from fmus.build import describe
from tests.invoking import invoke


def info(*arguments):
    result = invoke(app, ["info", *map(str, arguments)])
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.stdout


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_an_fmu(version):
    path = fmus.fmu_path("RigidBody", version)
    told = json.loads(info(path, "--json"))
    assert (told["name"], told["fmi_version"]) == ("RigidBody", version)
    assert told["interfaces"] == ["co-simulation", "model-exchange"]
    assert len(told["states"]) == 7
    inertia = next(v for v in told["variables"] if v["name"] == "J_B")
    assert (inertia["shape"], inertia["unit"], inertia["causality"]) == ([3, 3], "kg.m2", "parameter")
    torque = next(v for v in told["variables"] if v["name"] == "torque_B")
    assert (torque["variability"], torque["start"]) == ("continuous", [0.0, 0.0, 0.0])
    shown = info(path)
    assert f"FMI {version}, co-simulation and model-exchange, for " in shown
    assert "omega_BN_B" in shown


def test_what_else_an_fmu_may_have(mock, version):
    told = json.loads(info(mock("typed", version), "--json"))
    kinds = {v["name"]: v["type"] for v in told["variables"]}
    assert (kinds["flag"], kinds["n"], kinds["matrix"]) == ("Boolean", "Int32", "Float64")
    assert told["interfaces"] == ["co-simulation", "model-exchange"]


def test_an_ssp_file(tmp_path):
    write_ssp(SYSTEMS["full-state-pd"].build(), tmp_path / "a.ssp", stop_time=5.0, step=0.01)
    told = json.loads(info(tmp_path / "a.ssp", "--json"))
    assert (told["start_time"], told["stop_time"], told["step"]) == (0.0, 5.0, 0.01)
    assert {"plant", "controller", "guidance"} <= {c["name"] for c in told["components"]}
    assert ["controller.torque_B", "plant.torque_B"] in told["connections"]
    assert "stop 5 s, step 0.01 s" in info(tmp_path / "a.ssp")


def test_a_system():
    told = json.loads(info("full-state-pd", "--json"))
    assert (told["start_time"], told["stop_time"], told["step"]) == (0.0, 100.0, 0.01)
    assert [c["name"] for c in told["components"]] == ["guidance", "plant", "tracker", "controller"]
    assert ["controller.torque_B", "plant.torque_B"] in told["connections"]
    assert "4 components, 7 connections" in info("full-state-pd")


def test_which_parameters_may_change_in_a_run():
    assert "tunable" in info("PdTracking")
    assert "tunable" in info(fmus.fmu_path("PdTracking"))


_COLUMNS = ["80", "100", "140", None]


def _at(columns, monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    if columns is not None:
        monkeypatch.setenv("COLUMNS", columns)
    monkeypatch.setattr("adcs.cli.columns.OUT", Console())


@pytest.mark.parametrize("columns", _COLUMNS)
@pytest.mark.parametrize("name", ["RigidBody", "PdTracking", "StarTracker", "SmoothRateObserver"])
def test_nothing_is_lost_at_any_width(name, columns, monkeypatch):
    _at(columns, monkeypatch)
    shown = info(name)
    table = shown[shown.index("Variable ") :].splitlines()
    assert max(map(len, table)) <= int(columns or 1000)
    words = " ".join(shown.split())
    for v in describe(name).variables:
        if v.causality != "independent":
            line = next(line.split() for line in table if line.split()[0] == v.name)
            assert line[1].rstrip(",") == v.causality
            assert ("tunable" in line) == (v.variability == "tunable")
            assert " ".join(f"{x:g}" for x in v.start or ()) in words
            assert (f"{v.description} ({v.bounds})" if v.bounds else v.description) in words


@pytest.mark.parametrize("columns", _COLUMNS)
@pytest.mark.parametrize("name", ["SixDofOutputFeedback", "fmu", "six-dof-saturated"])
def test_title_and_reference_are_whole_and_break_between_words(name, columns, monkeypatch):
    _at(columns, monkeypatch)
    path = fmus.fmu_path("SixDofOutputFeedback")
    shown = info(path if name == "fmu" else name)
    head = shown[: shown.index("\nVariable " if "Variable " in shown else "\nComponent ")].splitlines()
    assert max(map(len, head)) <= int(columns or 1000)
    told = describe("SixDofOutputFeedback")
    expected = {
        "SixDofOutputFeedback": [f"{told.name} (controller): {told.description}", told.reference],
        "fmu": [f"{told.name}: {told.description}", f"made by adcs-fmus {metadata.version('adcs-fmus')}"],
        "six-dof-saturated": [
            f"{name}: {SYSTEMS['six-dof-saturated'].description}",
            "start 0 s, stop 300 s, step 0.1 s",
        ],
    }[name]
    assert len(told.reference) > 100
    for text in expected:
        assert text in " ".join(head)
        if columns is None:
            assert any(text in line for line in head)


@pytest.mark.parametrize("columns", _COLUMNS)
def test_the_list_is_whole_at_any_width(columns, monkeypatch):
    _at(columns, monkeypatch)
    shown = invoke(app, ["list"]).stdout
    assert max(map(len, shown.splitlines())) <= int(columns or 1000)
    words = " ".join(shown.split())
    for name, about in {
        **{c.name: c.summary for c in components()},
        **{n: s.description for n, s in SYSTEMS.items()},
    }.items():
        assert f"\n{name}" in shown
        assert about in words


def test_how_a_variable_is_shown(monkeypatch):
    _at("80", monkeypatch)
    assert """
J_B                   parameter, tunable  3 x 3  kg.m2
    Start: 10 1.2 0.5 1.2 19 1.5 0.5 1.5 25
    inertia about the centre of mass, in B (inertia matrix)
q_BN                  output              4      1       1 0 0 0
    attitude of B relative to N (unit quaternion)
""" in info("RigidBody")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("none.fmu", "cannot open none.fmu: No such file or directory"),
        ("none.ssp", "cannot open none.ssp: No such file or directory"),
        (
            "RigidBdy",
            "no component is called RigidBdy: did you mean RigidBody or OrbitingBody, or give a system, or an .fmu, "
            ".ssp or .py file",
        ),
    ],
)
def test_what_is_not_there(name, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(AdcsError) as error:
        info(name)
    assert str(error.value) == message
