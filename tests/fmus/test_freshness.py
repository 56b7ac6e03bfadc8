"""An FMU is never taken for the header that is here when it was built from another."""

import importlib
import logging
import multiprocessing
import shutil

import pytest

import fmus
from adcs import AdcsError, System, run
from fmus import catalog, freshness, paths, toolchain
from fmus.paths import SOURCES


@pytest.fixture
def sources(tmp_path, monkeypatch):
    """A copy of src/ that may be edited, and FMUs of it in a folder of their own."""
    folder = tmp_path / "src"
    shutil.copytree(SOURCES, folder)
    dist = tmp_path / "dist"
    for name in ("RigidBody", "PdTracking"):
        for version in ("2.0", "3.0"):
            fmu = fmus.fmu_path(name, version)
            for path in (fmu, freshness._place(fmu)):
                copy = dist / path.relative_to(paths.DIST)
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, copy)
    build = importlib.import_module("fmus.build")  # of which the package has a function by the same name
    for module in (build, catalog, freshness, toolchain):
        monkeypatch.setattr(module, "SOURCES", folder)
    flags = tuple(str(flag).replace(str(SOURCES), str(folder)) for flag in toolchain.COMPILE_FLAGS)
    monkeypatch.setattr(toolchain, "COMPILE_FLAGS", flags)
    monkeypatch.setattr(paths, "DIST", dist)
    monkeypatch.setattr(paths, "BUILD", tmp_path / "build")
    return folder


@pytest.fixture
def no_compiler(monkeypatch):
    monkeypatch.setattr(toolchain, "is_installed", lambda: False)


def edit(path, old="", new="// edited\n"):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new) if old else text + new)


def test_what_is_built_from_what_is_here_is_taken_as_it_is(sources, no_compiler, caplog):
    for path in sources.rglob("*.hpp"):
        path.touch()  # newer, and the same
    before = {path: path.stat().st_mtime_ns for path in paths.DIST.glob("*.fmu")}
    assert fmus.fmu_path("RigidBody") == paths.DIST / "RigidBody.fmu"
    assert fmus.fmu_path("PdTracking", "3.0") == paths.DIST / "PdTracking.fmi3.fmu"
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert caplog.messages == []


@pytest.mark.parametrize(("version", "file"), [("2.0", "RigidBody.fmu"), ("3.0", "RigidBody.fmi3.fmu")])
def test_without_a_compiler_an_edited_header_is_said_in_one_line(sources, no_compiler, version, file):
    edit(sources / "plant" / "rigid_body.hpp")
    with pytest.raises(AdcsError) as error:
        fmus.fmu_path("RigidBody", version)
    assert str(error.value) == (
        f"{file} was built from another src/plant/rigid_body.hpp, and no compiler is installed to build it: "
        "pip install 'adcs-fmus[build]'"
    )
    fmus.fmu_path("PdTracking", version)


@pytest.mark.parametrize(
    ("edited", "said"),
    [
        (["attitude/quaternion.hpp"], "was built from another src/attitude/quaternion.hpp, and"),
        (["fmi/instance.hpp", "attitude/quaternion.hpp"], "another src/attitude/quaternion.hpp (and 1 more), and"),
        (["fmi/trace.hpp"], "was built from another src/fmi/trace.hpp, and"),  # of which no binary is made, but the XML
        (["fmi/exports.map"], "was built from another src/fmi/exports.map, and"),
    ],
)
def test_all_that_goes_into_it_counts(sources, no_compiler, edited, said):
    for name in edited:
        edit(sources / name)
    with pytest.raises(AdcsError) as error:
        System("s").add("plant", "RigidBody")
    assert said in str(error.value)


def test_another_file_in_its_place_and_none_are_said(sources, no_compiler):
    (paths.DIST / "RigidBody.fmu").write_bytes(b"damaged")
    with pytest.raises(AdcsError, match=r"RigidBody\.fmu is not as it was built, and no compiler is installed"):
        fmus.fmu_path("RigidBody")
    with pytest.raises(AdcsError, match=r"Quest\.fmu is not built, and no compiler is installed to build it"):
        fmus.fmu_path("Quest")


def test_other_tools_make_another_fmu(sources, no_compiler, monkeypatch):
    fmu = paths.DIST / "RigidBody.fmu"
    monkeypatch.setattr(freshness, "_package", lambda: "another")
    assert freshness.outdated(fmu, "x86_64-linux") == "was packed by another version of adcs-fmus"
    monkeypatch.undo()
    assert freshness.outdated(fmu, toolchain.host().name, toolchain.compiler()) is None
    assert freshness.outdated(fmu, toolchain.host().name, "zig 0").startswith("was built by zig ")
    assert freshness.outdated(fmu, "riscv64-linux") == "has no binary for riscv64-linux"


def test_an_edited_law_is_what_runs(sources, caplog):
    """Half the gain is half the torque, at once: the FMU is built again where it is used."""
    caplog.set_level(logging.INFO, "adcs")

    def torque():
        system = System("s")
        at_rest = {name: [0, 0, 0] for name in ("omega_BN_B", "omega_RN_R", "omegaDot_RN_R")}
        system.add("law", "PdTracking", {"q_BN": [0.8, 0.6, 0, 0], "q_RN": [1, 0, 0, 0], **at_rest})
        return run(system, stop_time=0.01, step=0.01)["law.torque_B"][0]

    before = torque()
    edit(sources / "controllers" / "pd_tracking.hpp", "= -k_p * ", "= -0.5 * k_p * ")
    after = torque()
    assert before[0] != 0
    assert after[0] == pytest.approx(0.5 * before[0], rel=1e-15)
    assert caplog.messages == [
        "PdTracking.fmu was built from another src/controllers/pd_tracking.hpp: building PdTracking"
    ]


def test_a_deleted_component_is_gone(sources):
    (sources / "plant" / "rigid_body.hpp").unlink()
    assert (paths.DIST / "RigidBody.fmu").is_file()
    with pytest.raises(AdcsError, match="no component is called RigidBody"):
        System("s").add("plant", "RigidBody")


def _build(folder, queue):
    made = fmus.build(["RigidBody"], dist=folder / "dist", work=folder / "work")
    queue.put([path.read_bytes() for path in made])


def test_two_processes_that_build_at_once_make_the_same(tmp_path, built):
    context = multiprocessing.get_context("spawn")
    queue = context.Queue()
    processes = [context.Process(target=_build, args=(tmp_path, queue)) for _ in range(2)]
    for process in processes:
        process.start()
    made = [queue.get(timeout=300) for _ in processes]
    for process in processes:
        process.join(60)
    expected = [(built / name).read_bytes() for name in ("RigidBody.fmu", "RigidBody.fmi3.fmu")]
    assert made == [expected, expected]
    assert not (tmp_path / "work" / ".building").exists()
    for path in (tmp_path / "dist").glob("*.fmu"):
        assert freshness.outdated(path, toolchain.host().name, toolchain.compiler()) is None
