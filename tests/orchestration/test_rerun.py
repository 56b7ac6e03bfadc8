"""A run again from its manifest: the same bits, or what is not as it was."""

from __future__ import annotations

import contextlib
import json
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hostile import adcs

from adcs import AdcsError, CoSimulation, Hook, LoopSolver, RunFailed, Save, System, rerun, run, systems, write_ssp
from adcs.cli import app
from fmus import fmu_path
from orchestration.running.change import Change
from orchestration.running.hooks.changes import Changes

INPUTS = (
    "time,plant.torque_disturbance_B[1],plant.torque_disturbance_B[2],plant.torque_disturbance_B[3]\n0,0,0,0\n1,1,2,4\n"
)


def command(tmp_path: Path, *options: object, system: str = "observer-pd", out: str = "out") -> Path:
    """Run a system by the command line, in this process; return the folder of its results."""
    stop = () if "--stop" in options else ("--stop", 1)
    words = ["adcs", "run", system, *stop, "--step", 0.1, "--no-report", "--out", out, *options]
    with contextlib.chdir(tmp_path), pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", [str(word) for word in words])
        app.main()
    return tmp_path / out


def manifest_of(folder: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((folder / "manifest.json").read_text())
    return content


def change(folder: Path, manifest: dict[str, Any]) -> None:
    (folder / "manifest.json").write_text(json.dumps(manifest))


@pytest.mark.parametrize(
    "options",
    [
        (),
        ("--fmi", 3),
        ("--set", "tracker.half_angle=0.05deg", "--set", "tracker.seed=7", "--set", "plant.omega_BN_B=0,0,0.01"),
        ("--set", "plant.J_B=[[11,0,0],[0,19,0],[0,0,25]]"),
        ("--at", "0.3s controller.k_p=3", "--at", "0.7s plant.torque_disturbance_B=1,2,3"),
        ("--input-table", "inputs.csv"),
        ("--until", "norm(controller.omega_BR_B) < 0.0152"),
        ("--every", "controller=2", "--delay", "plant.torque_B=1", "--delay", "observer.torque_B=0.2s"),
        ("--record", "plant.q_BN", "--record", "plant.J_B", "--record-every", 3),
        (
            "--record",
            "plant.q_BN",
            "--record",
            "controller.omega_BR_B",
            "--until",
            "norm(controller.omega_BR_B) < 0.0152",
        ),
        ("--adaptive", 1e-4),
        ("--method", "model-exchange"),
        ("--method", "model-exchange", "--solver", "CVode", "--format", "hdf5"),
        ("--solve-loops", "newton", "--start", 0.05, "--format", "mat"),
        ("--checkpoint", "state.npz", "--checkpoint-every", 0.5),
        ("--real-time", 10),
        ("--estimate-error", "--record", "plant.q_BN"),
    ],
    ids=lambda options: " ".join(map(str, options)) or "as it is",
)
def test_a_run_of_the_command_line_is_the_same_to_the_last_bit(tmp_path: Path, options: tuple[object, ...]) -> None:
    (tmp_path / "inputs.csv").write_text(INPUTS)
    out = command(tmp_path, *options)
    before = {file.name: file.read_bytes() for file in out.iterdir()}
    again = rerun(out)
    assert (again.same, again.deviation, again.differences) == (True, None, ())
    assert again.compared is not None
    assert {file.name: file.read_bytes() for file in out.iterdir()} == before
    if "result.csv" in before:
        again.result.write_csv(tmp_path / "again.csv")
        assert (tmp_path / "again.csv").read_bytes() == before["result.csv"]


def test_noise_is_that_of_the_seeds_in_the_manifest(tmp_path: Path) -> None:
    system = systems()["observer-pd"].build()
    system.set("tracker.half_angle", 0.01)
    system.set("tracker.seed", 12345)
    result = run(system, stop_time=1, step=0.1)
    manifest = json.loads(json.dumps(result.manifest))
    assert np.array_equal(rerun(manifest).result.data, result.data)
    manifest["system"]["components"]["tracker"]["start"]["seed"] = 54321
    assert not np.array_equal(rerun(manifest).result.data, result.data)


def test_a_system_of_an_ssp(tmp_path: Path) -> None:
    write_ssp(systems()["observer-pd"].build(), tmp_path / "theirs.ssp")
    out = command(tmp_path, "--set", "tracker.half_angle=0.5deg", system="theirs.ssp")
    (tmp_path / "theirs.ssp").unlink()
    again = rerun(out / "manifest.json")
    assert (again.same, again.differences) == (True, ())


def test_the_rest_of_a_run_from_its_checkpoint(tmp_path: Path) -> None:
    command(tmp_path, "--stop", 0.5, "--checkpoint", "half.npz")
    rest = command(tmp_path, "--resume", "half.npz", out="rest")
    again = rerun(rest)
    assert (again.same, again.result.time[0], again.differences) == (True, 0.5, ())
    command(tmp_path, "--stop", 0.3, "--checkpoint", "half.npz", out="other")
    again = rerun(rest)
    assert again.differences == (f"resume: {tmp_path}/half.npz is not as it was",)
    assert again.deviation == "time at t = 0.5 s was 0.5 and is 0.30000000000000004"
    (tmp_path / "half.npz").unlink()
    with pytest.raises(AdcsError, match=r"^resume: .*half\.npz is not there: put it back"):
        rerun(rest)


def test_connections_with_all_that_they_may_have(chain: Any, mock: Any) -> None:
    system = System("scaled")
    system.add("source", mock("source"), {"offset": [1.0, 2.0, 3.0]})
    system.add("gain", mock("gain"), {"k": 1 / 3, "u": [0.1, 0.2, 0.3]}, every=2)
    system.connect("source.y", "gain.u", factor=1 / 7, offset=0.1, delay_steps=1)
    plain = System("plain")
    plain.add("source", mock("source"))
    plain.add("gain", mock("gain"))
    plain.connect("source.y", "gain.u", factor=1.0)
    for made in (system, plain, chain()):
        result = run(made, stop_time=1, step=0.1, save=Save(["gain.u", "gain.y"]))
        again = rerun(json.loads(json.dumps(result.manifest)))
        assert np.array_equal(again.result.data, result.data)
        assert again.differences == ()
        assert again.result.system.connections == made.connections


def test_algebraic_loops_are_solved_in_the_same_way() -> None:
    system = systems()["observer-pd"].build()
    result = run(system, stop_time=1, step=0.1, method=CoSimulation(loops=LoopSolver("newton", tolerance=1e-3)))
    again = rerun(result.manifest)
    assert again.result.manifest["settings"]["solve_loops"] == result.manifest["settings"]["solve_loops"]
    assert np.array_equal(again.result.data, result.data)


class Operator(Hook):
    """Sets a gain at point 4, and tells it as ground tools do."""

    def changes(self, k: int) -> list[Change]:
        return [Change(k, "controller.k_p", 3.0)] if k == 4 else []

    def ahead(self, k: int) -> int:
        return 1

    def report(self) -> dict[str, Any]:
        return {"commands": [[0.4, "controller.k_p", 3.0, "me"]], "mavlink": {}}


def test_what_ground_tools_commanded_is_commanded_again() -> None:
    system = systems()["observer-pd"].build()
    changes = [(0.4, "controller.k_p", 9.0), (0.7, "controller.k_v", 1.0)]
    result = run(system, stop_time=1, step=0.1, hooks=[Changes(changes), Operator()])
    manifest = json.loads(json.dumps(result.manifest))
    again = rerun(manifest)
    assert np.array_equal(again.result.data, result.data)
    assert again.differences == ()
    assert not np.array_equal(run(system, stop_time=1, step=0.1).data, result.data)
    manifest["commands"][0][0] = 0.45
    with pytest.raises(AdcsError, match=r"^the change of controller\.k_p") as refused:
        rerun(manifest)
    assert "\n" not in str(refused.value)
    manifest["mavlink"]["commands_not_kept"] = 3
    with pytest.raises(AdcsError, match=r"^ground tools commanded more than the manifest kept, 3 commands"):
        rerun(manifest)


def test_a_hook_of_which_the_manifest_says_nothing_is_named() -> None:
    result = run(systems()["observer-pd"].build(), stop_time=1, step=0.1, hooks=[Hook()])
    assert rerun(result.manifest).differences == (
        "Hook took part in the run, and what that did is not in the manifest",
    )


def test_an_fmu_that_is_another_one_is_named(tmp_path: Path) -> None:
    shutil.copy(fmu_path("RigidBody"), tmp_path / "body.fmu")
    out = command(tmp_path, "--set", "body.omega_BN_B=0,0,0.5", system="body.fmu")
    original = manifest_of(out)["system"]["components"]["body"]["sha256"]
    with (tmp_path / "body.fmu").open("r+b") as file:  # a comment of one character in the archive
        content = file.read()
        file.seek(len(content) - 2)
        file.write(b"\x01\x00!")
    again = rerun(out)
    (named,) = again.differences
    assert named.startswith("component body: body.fmu is another file than was run, sha256 ")
    assert named.endswith(f" instead of {original[:12]}")
    assert again.same is True
    shutil.move(tmp_path / "body.fmu", out / "body.fmu")
    assert rerun(out).differences == (named,)
    (out / "body.fmu").unlink()
    with pytest.raises(
        AdcsError, match=r"^component body: .*/body\.fmu is not there: put it back, or a file of this name"
    ):
        rerun(out)


def test_the_first_value_that_is_not_the_same_is_named(tmp_path: Path) -> None:
    out = command(tmp_path, "--format", "csv", "--format", "hdf5", "--format", "mat", "--record", "plant.omega_BN_B")
    lines = (out / "result.csv").read_text().splitlines()
    cells = lines[4].split(",")
    was = float(cells[2])
    cells[2] = repr(float(np.nextafter(was, 1)))
    lines[4] = ",".join(cells)
    (out / "result.csv").write_text("\n".join(lines) + "\n")
    name = "plant.omega_BN_B[2][rad/s]"
    assert rerun(out).deviation == f"{name} at t = 0.3 s was {cells[2]} and is {was!r}"
    for kind, column in (("h5", "plant/omega_BN_B"), ("mat", "plant.omega_BN_B")):
        for other in ("csv", "h5", "mat"):
            if other != kind and kind == "mat":
                (out / f"result.{other}").unlink(missing_ok=True)
        (out / "result.csv").unlink(missing_ok=True)
        assert rerun(out).same is True
        manifest = manifest_of(out)
        manifest["settings"]["changes"] = [[0.5, "controller.k_p", 9.0]]
        change(out, manifest)
        told = rerun(out).deviation
        assert told is not None
        assert told.startswith(f"{column} at t = 0.6 s was ")
        del manifest["settings"]["changes"]
        change(out, manifest)
    (out / "result.mat").unlink()
    assert (rerun(out).same, rerun(out).compared) == (None, None)


def test_versions_that_are_not_the_same_are_named(tmp_path: Path) -> None:
    out = command(tmp_path)
    manifest = manifest_of(out)
    now = manifest["versions"]["numpy"]
    manifest["versions"]["numpy"] = "1.0"
    change(out, manifest)
    again = rerun(out)
    assert (again.same, again.differences) == (True, (f"numpy was '1.0' and is {now!r}",))


def test_a_run_that_failed_fails_again(faulty: Any) -> None:
    with pytest.raises(RunFailed) as failed:
        run(faulty("2.0", 2), stop_time=1, step=0.1)
    manifest = json.loads(json.dumps(failed.value.result.manifest))
    again = rerun(manifest)
    assert again.result.manifest["outcome"] == manifest["outcome"]
    assert again.differences == ()


def test_the_command_line(tmp_path: Path) -> None:
    out = command(tmp_path, "--record", "plant.q_BN")
    code, printed, err = adcs("rerun", "out", cwd=tmp_path)
    assert (code, err) == (0, "")
    assert printed.splitlines() == [
        "the same as result.csv beside the manifest, to the last bit",
        *(f"out-2/{name}" for name in ("result.csv", "result.mat", "manifest.json")),
    ]
    assert (tmp_path / "out-2/result.csv").read_bytes() == (out / "result.csv").read_bytes()
    assert rerun(tmp_path / "out-2").same is True
    manifest = manifest_of(out)
    manifest["system"]["components"]["controller"]["start"]["k_p"] = 9.0
    change(out, manifest)
    code, printed, _ = adcs("rerun", "out/manifest.json", "--json", "--out", "here", cwd=tmp_path)
    told = json.loads(printed)
    assert (code, told["same"], told["differences"]) == (1, False, [])
    assert told["verdict"].startswith("not the same as result.csv beside the manifest: plant.q_BN[1][1] at t = ")
    assert told["files"] == ["here/result.csv", "here/result.mat", "here/manifest.json"]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "manifest.json: No such file or directory: give the manifest.json of a run, or its folder"),
        ("{", "manifest.json is no manifest: give the manifest.json of a run, or its folder"),
        ("[]", "manifest.json is not the manifest of a run: give the manifest.json of one, or its folder"),
        ('{"system": 1, "settings": {}}', "the manifest is not as a run writes it"),
        (
            '{"format": "x", "system": {}, "settings": {}}',
            "the manifest is of the format x, and adcs-manifest-2 is what",
        ),
        (
            '{"system": {}, "settings": {"hil": {}}}',
            "an autopilot flew this run, and what it answered is in no manifest",
        ),
    ],
)
def test_what_cannot_be_repeated_is_one_line(tmp_path: Path, content: str | None, message: str) -> None:
    if content is not None:
        (tmp_path / "manifest.json").write_text(content)
    with pytest.raises(AdcsError) as refused:
        rerun(tmp_path / "manifest.json")
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)
