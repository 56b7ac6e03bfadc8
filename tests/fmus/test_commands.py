import json

import pytest

from adcs import AdcsError
from adcs.cli import build as build_command
from adcs.cli.app import app
from tests.invoking import invoke


@pytest.fixture
def run(built, monkeypatch):
    monkeypatch.setattr("fmus.paths.DIST", built)

    def run(*arguments):
        result = invoke(app, arguments)
        if result.exception and not isinstance(result.exception, SystemExit):
            raise result.exception
        return result

    return run


def test_list_names_components_and_systems(run):
    listed = json.loads(run("list", "--json").stdout)
    kinds = {c["name"]: c["kind"] for c in listed["components"]}
    assert kinds["StarTracker"] == "sensor"
    assert {"observer-pd", "full-state-pd"} <= {s["name"] for s in listed["systems"]}
    assert all(s["description"] for s in listed["systems"])
    built = {c["name"]: sorted(c["fmus"]) for c in listed["components"]}
    assert built["RigidBody"] == ["2.0", "3.0"]
    assert built["PdTracking"] == []
    assert "RigidBody" in run("list").stdout


def test_info_shows_the_declaration(run):
    told = json.loads(run("info", "RigidBody", "--json").stdout)
    inertia = next(v for v in told["variables"] if v["name"] == "J_B")
    assert (told["kind"], inertia["shape"], inertia["unit"]) == ("plant", [3, 3], "kg.m2")
    assert "kg.m2" in run("info", "RigidBody").stdout


def test_build_tells_what_it_made(run, built, monkeypatch):
    made = [built / "RigidBody.fmu", built / "RigidBody.fmi3.fmu"]
    asked = []
    monkeypatch.setattr(
        build_command, "build", lambda names, all_platforms, progress: asked.append((names, all_platforms)) or made
    )
    told = json.loads(run("build", "RigidBody", "--all-platforms", "--json").stdout)
    assert asked == [(["RigidBody"], True)]
    assert told == [{"path": str(path), "bytes": path.stat().st_size} for path in made]
    assert "RigidBody.fmi3.fmu" in run("build").stdout


def test_check_ends_with_1_if_something_is_wrong(run, tmp_path):
    good = run("check", "RigidBody", "--json")
    assert good.exit_code == 0
    assert [report["findings"] for report in json.loads(good.stdout)] == [[], []]

    bad = tmp_path / "bad.fmu"
    bad.write_bytes(b"no zip")
    result = run("check", str(bad), "--json")
    assert result.exit_code == 1
    assert json.loads(result.stdout)[0]["findings"][0]["rule"] == "archive"
    assert run("check", str(bad)).exit_code == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["info", "Rigidbody"], "did you mean RigidBody"),
        (["check", "absent.fmu"], "absent.fmu is no file"),
        (["check", "RigidBdy"], "no component is called RigidBdy: did you mean RigidBody or OrbitingBody, or give a"),
        (["check", "observr-pd"], "no component is called observr-pd: did you mean observer-pd or"),
        (["build", "Nothing"], "no component is called Nothing"),
    ],
)
def test_errors_are_one_line_with_a_way_out(run, arguments, message):
    with pytest.raises(AdcsError) as error:
        run(*arguments)
    assert message in str(error.value)
    assert "\n" not in str(error.value)
