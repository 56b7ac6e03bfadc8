"""`adcs run`: what may happen during a run, from the command line."""

import json
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest
from test_command_line import adcs

from adcs.cli.run import at_in_one


@pytest.fixture
def run(tmp_path, capsys):
    """Run with --json and without a report; return what was printed and the manifest."""

    def command(*arguments, system="observer-pd", code=0):
        capsys.readouterr()
        assert adcs("run", system, *arguments, "--no-report", "--json", "--force", "--out", tmp_path) == code
        return json.loads(capsys.readouterr().out), json.loads((tmp_path / "manifest.json").read_text())

    return command


def table(folder: Path) -> pd.DataFrame:
    return pd.read_csv(folder / "result.csv", index_col="time[s]")


def test_changes_and_a_condition(run, tmp_path):
    printed, manifest = run(
        *("--stop", 20, "--at", "5s", "controller.k_p=3", "--at", "100ms controller.k_v=6"),
        *("--until", "norm(controller.omega_BR_B) < 0.05"),
    )
    assert manifest["settings"]["changes"] == [[5.0, "controller.k_p", 3], [0.1, "controller.k_v", 6]]
    assert printed["outcome"]["met"]["time"] == table(tmp_path).index[-1] < 20


@pytest.mark.parametrize(
    ("words", "joined"),
    [
        (["--at", "1s", "a.b=2", "--stop", "3"], ["--at", "1s a.b=2", "--stop", "3"]),
        (["--at", "1s a.b=2", "--stop", "3"], ["--at", "1s a.b=2", "--stop", "3"]),
        (["--at", "1s", "--out", "x"], ["--at", "1s", "--out", "x"]),
        (["--at"], ["--at"]),
    ],
)
def test_the_two_words_after_at_are_joined(words, joined):
    assert at_in_one(["run", *words]) == ["run", *joined]
    assert at_in_one(["linearize", *words]) == ["linearize", *words]


def test_rates_delays_and_pace(run):
    printed, manifest = run(
        "--stop", 0.5, "--every", "tracker=2", "--delay", "plant.torque_B=3", "--delay", "observer.torque_B=20ms",
        "--real-time", 10,
    )  # fmt: skip
    assert manifest["system"]["components"]["tracker"]["every"] == 2
    delays = {c[1]: c[2] for c in manifest["system"]["connections"] if len(c) > 2}
    assert delays == {"plant.torque_B": {"delay_steps": 3}, "observer.torque_B": {"delay": 0.02}}
    assert printed["real_time"]["points"] == 51


def test_error_and_adaptive_steps(run):
    printed, _ = run("--stop", 1, "--step", 0.1, "--estimate-error")
    estimate = printed["error_estimate"]
    assert estimate["method"] == "coupled model exchange"
    found = {d["variable"]: d["most"] for d in estimate["deviations"]}
    assert 1e-6 < found["plant.omega_BN_B"] < 1e-2
    assert found["guidance.omega_RN_R"] < 1e-12
    printed, _ = run("--stop", 1, "--step", 0.1, "--adaptive", 1e-5)
    assert sum(printed["adaptive"]["intervals_by_exchange_step"].values()) == 10


def test_saved_and_resumed(run, tmp_path):
    state = tmp_path / "state"
    run("--stop", 1)
    whole = table(tmp_path)
    run("--stop", 0.4, "--checkpoint", state)
    run("--stop", 1, "--resume", state)
    assert table(tmp_path).equals(whole.iloc[40:])


def test_hdf5_and_every_nth_row(run, tmp_path):
    printed, _ = run("--stop", 1, "--format", "hdf5", "--record-every", 10, "--record", "plant.q_BN")
    assert printed["files"] == [str(tmp_path / "result.h5"), str(tmp_path / "manifest.json")]
    with h5py.File(tmp_path / "result.h5") as file:
        assert file["plant/q_BN"].shape == (11, 4)
        assert file["time"][1] == 0.1
    printed, _ = run("--stop", 1, "--format", "hdf5", "--format", "csv")
    with h5py.File(tmp_path / "result.h5") as file:
        assert np.array_equal(file["time"][:], table(tmp_path).index)


def test_inputs_from_a_table(run, tmp_path):
    names = [f"plant.torque_disturbance_B[{i}][N.m]" for i in (1, 2, 3)]
    source = tmp_path / "inputs.csv"
    source.write_text(f"time[s],{','.join(names)}\n0,0,0,0\n1,1,2,4\n")
    run("--stop", 1, "--input-table", source, "--record", "plant.torque_disturbance_B")
    got = table(tmp_path)
    assert got["plant.torque_disturbance_B[3][N.m]"].to_numpy() == pytest.approx(4 * got.index.to_numpy(), abs=1e-15)


def test_an_exported_system_runs_to_the_same_bits(run, tmp_path, capsys):
    file = tmp_path / "t5.ssp"
    assert adcs("export", "observer-pd", "--ssp", file, "--fmi", "3", "--set", "tracker.half_angle=0.5deg") == 0
    run("--stop", 2, "--set", "tracker.half_angle=0.5deg")
    expected = (tmp_path / "result.csv").read_bytes()
    printed, manifest = run("--stop", 2, system=str(file))
    assert (tmp_path / "result.csv").read_bytes() == expected
    assert {c["fmi_version"] for c in manifest["system"]["components"].values()} == {"3.0"}
    assert printed["outcome"]["rows"] == 201


def test_an_fmu_file_runs_alone(run, tmp_path):
    from fmus import fmu_path

    printed, _ = run(
        *("--stop", 2, "--step", 0.5, "--set", "RigidBody.omega_BN_B=0,0,0.5"),
        *("--set", "RigidBody.J_B=[[10,0,0],[0,19,0],[0,0,25]]"),
        system=str(fmu_path("RigidBody")),
    )
    assert printed["outcome"] == {"status": "complete", "rows": 5}
    turned = table(tmp_path)["RigidBody.q_BN[4][1]"]
    assert turned.iloc[-1] == pytest.approx(np.sin(0.5), abs=1e-9)
    assert {k["label"] for k in printed["key_numbers"]} == {"RigidBody.kinetic_energy"}


def test_an_exchange_step_that_does_not_divide_the_control_period_is_refused(capsys):
    assert adcs("run", "trigo-bs", "--step", "0.03", "--stop", "3") == 2
    message = "adcs: the control period, 1/10 s, is not a whole number of exchange steps of 0.03 s"
    assert capsys.readouterr().err.startswith(message)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--at", "5s"), "adcs: --at 5s: expected TIME COMPONENT.VARIABLE=VALUE"),
        (("--at", "soon", "controller.k_p=3"), "adcs: --at: 'soon' is not a time, write 120s, 0.1s, 5ms, 2min or 1h"),
        (("--every", "trackers=2"), "adcs: --every trackers=2: expected COMPONENT=N, N from 1; did you mean tracker?"),
        (("--every", "tracker=0"), "adcs: --every tracker=0: expected COMPONENT=N"),
        (("--delay", "plant.torque_disturbance_B=1"), "adcs: nothing is connected to plant.torque_disturbance_B"),
        (("--delay", "plant.torque_B=late"), "adcs: --delay plant.torque_B: 'late' is not a time"),
        (("--stop", "0"), "adcs: stop = 0 s is the start time: give a later one"),
        (("--resume", "nothing"), "adcs: cannot open nothing: No such file or directory"),
        (("--input-table", "nothing.csv"), "adcs: cannot open nothing.csv: No such file or directory"),
    ],
)
def test_errors_are_one_line(tmp_path, capsys, arguments, message):
    assert adcs("run", "observer-pd", *arguments, "--out", tmp_path) == 2
    err = capsys.readouterr().err.strip()
    assert message in err.splitlines()[-1]
    assert "Traceback" not in err
