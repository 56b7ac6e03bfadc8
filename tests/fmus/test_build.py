import json
import zipfile

import pytest
from fmpy.validation import validate_fmu
from lxml import etree

import fmus
from adcs import AdcsError, System
from fmus.pack import _binaries
from fmus.paths import BUILD, CHECKOUT
from fmus.toolchain import TARGETS, compile_step, host, run_steps, universal_binary

FMUS = ["RigidBody.fmu", "RigidBody.fmi3.fmu", "StarTracker.fmu", "StarTracker.fmi3.fmu"]


def test_two_fmus_for_each_component(built):
    assert sorted(path.name for path in built.glob("*") if path.is_file()) == sorted(FMUS)


@pytest.mark.parametrize("fmu", FMUS)
def test_an_fmu_has_everything(built, fmu):
    assert validate_fmu(str(built / fmu)) == []
    name = fmu.split(".")[0]
    folder = host().fmi2_folder if fmu.count(".") == 1 else host().name
    with zipfile.ZipFile(built / fmu) as archive:
        files = set(archive.namelist())
    assert {
        "modelDescription.xml",
        "documentation/index.html",
        "documentation/licenses/license.txt",
        "documentation/licenses/adcs-fmus.txt",
        "documentation/licenses/Eigen.txt",
        "documentation/licenses/FMI.txt",
        "terminalsAndIcons/terminalsAndIcons.xml",
        "terminalsAndIcons/icon.png",
        "terminalsAndIcons/icon.svg",
        "sources/buildDescription.xml",
        "sources/model.cpp",
        "sources/Eigen/Core",
        f"binaries/{folder}/{name}{host().suffix}",
    } <= files
    assert ("model.png" in files) == (fmu.count(".") == 1)


def test_sources_are_those_of_one_fmi_version(built):
    for fmu, own, other in (("RigidBody.fmu", "fmi2", "fmi3"), ("RigidBody.fmi3.fmu", "fmi3", "fmi2")):
        with zipfile.ZipFile(built / fmu) as archive:
            listed = etree.fromstring(archive.read("sources/buildDescription.xml")).iterfind(".//SourceFile")
            assert [file.get("name") for file in listed] == [
                "model.cpp",
                *(f"fmi/{name}.cpp" for name in ("messages", "instance", "access", "events", "derivatives")),
                *(f"fmi/{name}.cpp" for name in ("saved_state", "runtime", own)),
            ]
            assert f"sources/fmi/{other}.cpp" not in archive.namelist()


def test_vectors_are_terminals(built):
    members = {}
    for fmu in ("RigidBody.fmu", "RigidBody.fmi3.fmu"):
        with zipfile.ZipFile(built / fmu) as archive:
            root = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        members[fmu] = {
            terminal.get("name"): [(m.get("memberName"), m.get("variableName")) for m in terminal]
            for terminal in root.iter("Terminal")
        }
    assert members["RigidBody.fmu"]["torque_B"] == [(str(i), f"torque_B[{i}]") for i in (1, 2, 3)]
    assert members["RigidBody.fmi3.fmu"]["torque_B"] == [("1", "torque_B")]
    assert "kinetic_energy" not in members["RigidBody.fmu"]


def test_the_same_sources_give_the_same_bytes(built, tmp_path):
    for path in fmus.build(["RigidBody"], dist=tmp_path):
        assert path.read_bytes() == (built / path.name).read_bytes()


def test_binaries_do_not_know_where_they_were_made(built):
    for fmu in FMUS:
        with zipfile.ZipFile(built / fmu) as archive:
            for name in archive.namelist():
                if not name.startswith("sources/Eigen/"):
                    assert str(BUILD.parent).encode() not in archive.read(name), name


def test_nothing_is_written_when_nothing_changed(built):
    fmus.build(["StarTracker"], dist=built)
    before = (built / "StarTracker.fmu").stat().st_mtime_ns
    steps = []
    fmus.build(["StarTracker"], dist=built, progress=lambda done, total, what: steps.append((done, total, what)))
    assert (built / "StarTracker.fmu").stat().st_mtime_ns == before
    assert [done for done, _, _ in steps] == list(range(1, steps[0][1] + 1))
    assert steps[-1][2] == "StarTracker.fmi3.fmu"


def test_a_damaged_fmu_is_made_again(built, tmp_path):
    path, _ = fmus.build(["StarTracker"], dist=tmp_path)
    path.write_bytes(b"damaged")
    fmus.build(["StarTracker"], dist=tmp_path)
    assert path.read_bytes() == (built / path.name).read_bytes()


def test_zip_times_follow_source_date_epoch(tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    path, _ = fmus.build(["StarTracker"], dist=tmp_path)
    with zipfile.ZipFile(path) as archive:
        assert {entry.date_time for entry in archive.infolist()} == {(2023, 11, 14, 22, 13, 20)}
        assert b'generationDateAndTime="2023-11-14T22:13:20Z"' in archive.read("modelDescription.xml")


def test_path_of_an_fmu(built, monkeypatch):
    monkeypatch.setattr("fmus.paths.DIST", built)
    assert fmus.fmu_path("RigidBody") == built / "RigidBody.fmu"
    assert fmus.fmu_path("RigidBody", "3.0") == built / "RigidBody.fmi3.fmu"
    with pytest.raises(fmus.AdcsError, match=r"FMI version 1\.0 is not made: expected 2.0 or 3.0"):
        fmus.fmu_path("RigidBody", "1.0")


def test_what_is_not_built_is_built_when_it_is_asked_for(tmp_path, monkeypatch):
    monkeypatch.setattr("fmus.paths.DIST", tmp_path)
    path = fmus.fmu_path("StarTracker", "3.0")
    assert validate_fmu(str(path)) == []
    assert path.parent == tmp_path


def test_a_system_builds_only_the_components_that_it_has(tmp_path, monkeypatch):
    monkeypatch.setattr("fmus.paths.DIST", tmp_path)
    System("s").add("plant", "RigidBody")
    assert sorted(path.name for path in tmp_path.glob("*.fmu")) == ["RigidBody.fmi3.fmu", "RigidBody.fmu"]


def test_the_fmu_of_a_deleted_component_is_removed_when_all_are_built(tmp_path, monkeypatch):
    (old,) = (path for path in fmus.build(["StarTracker"], dist=tmp_path) if path.name == "StarTracker.fmu")
    mine = tmp_path / "Mine.fmu"
    mine.write_bytes(old.read_bytes())
    only = [fmus.find("RigidBody")]
    monkeypatch.setattr("fmus.catalog.components", lambda: only)
    fmus.build(dist=tmp_path)
    assert sorted(path.name for path in tmp_path.glob("*.fmu")) == ["Mine.fmu", "RigidBody.fmi3.fmu", "RigidBody.fmu"]


def test_records_are_readable(built):
    record = json.loads((BUILD / "objects" / host().name / "RigidBody.o.json").read_text())
    assert record["command"].startswith("zig 0.")
    assert str(CHECKOUT / "src" / "plant" / "rigid_body.hpp") in record["inputs"]


def test_a_sensor_that_draws_under_the_name_of_another_is_refused(tmp_path):
    """Copied from another's header, it would have the same noise as that one."""
    model = tmp_path / "model.cpp"
    copied = "template <class T>\nstruct Compass : Magnetometer<T> {};\n"
    include = '#include "sensors/magnetometer.hpp"\n#include "fmi/export.hpp"\n'
    model.write_text(f"{include}namespace adcs {{ {copied} }}\nADCS_EXPORT(Compass)\n")
    with pytest.raises(AdcsError, match="stream has another component's name"):
        run_steps([compile_step(model, tmp_path / "model.o", host(), "-fsyntax-only")])


def test_a_mac_of_either_kind_finds_its_library_once():
    macs = [target for target in TARGETS if target.fmi2_folder == "darwin64"]
    libraries = {target: bytes(4) + number.to_bytes(4, "little") * 2 for number, target in enumerate(macs, 1)}
    (both,) = _binaries("X", "2.0", libraries).items()
    assert both == ("binaries/darwin64/X.dylib", universal_binary(list(libraries.values())))
    for target, library in libraries.items():
        assert _binaries("X", "2.0", {target: library}) == {"binaries/darwin64/X.dylib": library}
        assert f"binaries/{target.name}/X.dylib" in _binaries("X", "3.0", libraries)
