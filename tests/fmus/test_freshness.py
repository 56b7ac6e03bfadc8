"""An FMU is not taken for the header that is here when it was built from another."""

import json
import os
import shutil

import pytest

import fmus
from adcs import System
from adcs.cli.app import main
from fmus import freshness
from fmus.paths import SOURCES


@pytest.fixture
def sources(tmp_path, monkeypatch):
    """A copy of src/ that may be edited, which is taken for it."""
    folder = tmp_path / "src"
    shutil.copytree(SOURCES, folder)
    monkeypatch.setattr(freshness, "SOURCES", folder)
    monkeypatch.setattr(freshness, "_said", set())
    return folder


def edit(path):
    path.write_text(path.read_text() + "// edited\n")


def outdated(component, version="2.0"):
    return freshness.outdated(component, fmus.fmu_path(component, version))


def test_what_is_built_from_what_is_here_is_fine(sources, caplog):
    for path in sources.rglob("*.hpp"):
        os.utime(path, (2e9, 2e9))  # newer, and the same
    assert outdated("RigidBody") is None
    assert outdated("PdTracking", "3.0") is None
    assert caplog.messages == []


@pytest.mark.parametrize(("version", "file"), [("2.0", "RigidBody.fmu"), ("3.0", "RigidBody.fmi3.fmu")])
def test_an_edited_header(sources, version, file):
    edit(sources / "plant" / "rigid_body.hpp")
    assert outdated("RigidBody", version) == (
        f"{file} was built from another src/plant/rigid_body.hpp: run `adcs build RigidBody`"
    )
    assert outdated("PdTracking", version) is None


def test_what_a_header_includes_counts(sources):
    edit(sources / "attitude" / "quaternion.hpp")
    assert "another src/attitude/quaternion.hpp: run" in outdated("RigidBody")
    edit(sources / "fmi" / "instance.hpp")
    assert "another src/attitude/quaternion.hpp (and 1 more): run" in outdated("RigidBody")
    (sources / "plant" / "rigid_body.hpp").unlink()
    assert "(and 2 more)" in outdated("RigidBody")


def test_it_is_said_once_where_a_component_is_taken(sources, caplog):
    edit(sources / "plant" / "rigid_body.hpp")
    text = "RigidBody.fmu was built from another src/plant/rigid_body.hpp: run `adcs build RigidBody`"
    fmus.fmu_path("RigidBody")
    assert caplog.messages == [text]
    System("s").add("plant", "RigidBody")
    assert caplog.messages == [text]


def test_a_run_says_it_and_keeps_it_in_its_manifest(sources, tmp_path, monkeypatch, capsys, caplog):
    edit(sources / "controllers" / "pd_tracking.hpp")
    monkeypatch.setattr("sys.argv", ["adcs", "run", "full-state-pd", "--stop", "0.1", "--out", str(tmp_path / "out")])
    main()
    text = "PdTracking.fmu was built from another src/controllers/pd_tracking.hpp: run `adcs build PdTracking`"
    assert caplog.messages == [text]
    assert json.loads((tmp_path / "out" / "manifest.json").read_text())["warnings"] == [text]
