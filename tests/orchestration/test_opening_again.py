"""What is the same each time an FMU is opened is done once in the life of a process."""

import shutil
import subprocess
import sys
from importlib import metadata
from pathlib import Path

from fmpy import fmi1

from adcs import System, run
from fmus import fmu_path
from orchestration.fmu.file import open_fmu
from orchestration.fmu.unpacked import unpacked
from orchestration.results.manifest import versions


def places(path: Path) -> tuple[Path, Path]:
    with unpacked(open_fmu(path), "co-simulation") as found:
        assert found[1].is_file()
        return found


def test_what_is_built_here_is_unpacked_once(version: str) -> None:
    path = fmu_path("RigidBody", version)
    folder, binary = places(path)
    assert places(path) == (folder, binary)
    shutil.rmtree(folder)  # as a machine does that clears up what is temporary
    assert places(path) != (folder, binary)
    assert places(fmu_path("PdTracking", version)) != places(path)


def test_others_have_a_folder_for_themselves(mock) -> None:
    folder, _ = places(mock("gain"))
    assert not folder.exists()
    assert places(mock("gain"))[0] != folder


def test_folders_go_with_the_process(tmp_path: Path) -> None:
    program = "from adcs import run; run('observer-pd', stop_time=0.01)"
    subprocess.run([sys.executable, "-c", program], check=True, env={"TMPDIR": str(tmp_path)})
    assert list(tmp_path.iterdir()) == []


def test_functions_and_versions_are_looked_at_once(version: str, monkeypatch) -> None:
    system = System("alone", "")
    system.add("plant", "RigidBody", {"torque_B": [0, 0, 0], "torque_disturbance_B": [0, 0, 0]})
    first = run(system, stop_time=1.0, step=0.1, fmi_version=version)

    def again(*_: object, **__: object) -> None:
        raise AssertionError("it is known")

    known = versions()
    monkeypatch.setattr(fmi1._FMU, "_loadFunctions", again)
    monkeypatch.setattr(metadata, "version", again)
    assert versions() == known
    assert run(system, stop_time=1.0, step=0.1, fmi_version=version) == first
