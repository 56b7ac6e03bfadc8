"""What a component does to its process, and what is left of the run."""

from __future__ import annotations

import ctypes
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
from hostile import ROOT, adcs, as_file, start, system, until

from adcs import AdcsError, CoSimulation, Hook, ModelExchange, RunFailed, Save, System, run, write_ssp
from fmus.lock import Lock
from orchestration.isolation import journal

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")

SEGFAULT = "SIGSEGV, a segmentation fault"
TIMES = {"stop_time": 1.0, "step": 0.1}


@pytest.mark.parametrize(
    ("name", "message", "rows"),
    [
        ("segfault_doStep", f"failed at t = 0.5 s: doStep ended the process: {SEGFAULT}; 6 rows are kept", 6),
        ("exit_doStep", "failed at t = 0.5 s: doStep ended the process: exit code 0; 6 rows are kept", 6),
        ("quit_get", "failed at t = 0.5 s: get ended the process: exit code 0; 5 rows are kept", 5),
        ("kill_doStep", "ended the process: SIGKILL, from outside, as for lack of memory; 6 rows are kept", 6),
    ],
)
def test_a_component_that_ends_its_process_is_named_and_the_rows_are_kept(mock, name, message, rows):
    with pytest.raises(RunFailed) as failed:
        run(system(mock, name), **TIMES, isolated=True)
    assert str(failed.value).endswith(message)
    assert str(failed.value).startswith(name)
    result = failed.value.result
    assert result.time.tolist() == [0.1 * k for k in range(rows)]
    assert result[f"{name}.y"].tolist() == [1 + t / 1000 for t in result.time]
    assert result.manifest["outcome"]["component"] == name


def test_one_that_dies_while_it_is_stepped_from_python_is_named(mock):
    with pytest.raises(RunFailed, match=f"failed at t = 0.5 s: doStep ended the process: {SEGFAULT}; 6 rows are kept$"):
        run(system(mock, "segfault_doStep"), **TIMES, isolated=True, method=CoSimulation(stepping="python"))


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_one_that_dies_before_the_run_has_begun_is_named(mock, version):
    with pytest.raises(
        AdcsError, match=r"^abort_instantiate: instantiating ended the process: SIGABRT, abort"
    ) as error:
        run(system(mock, "abort_instantiate", version), **TIMES, isolated=True, fmi_version=version)
    assert not isinstance(error.value, RunFailed)


def test_one_that_dies_in_model_exchange_is_named(mock):
    name = "segfault_setTime"
    with pytest.raises(RunFailed, match=f"setTime ended the process: {SEGFAULT}; 3 rows are kept$") as failed:
        run(system(mock, name), **TIMES, isolated=True, method=ModelExchange())
    assert failed.value.result.time.tolist() == [0.1 * k for k in range(3)]


@pytest.mark.parametrize("name", ["segfault_terminate", "exit_free"])
def test_one_that_dies_at_the_end_does_not_cost_the_run(mock, name):
    result = run(system(mock, name), **TIMES, isolated=True)
    assert len(result.time) == 11
    assert result.manifest["outcome"] == {"status": "complete", "rows": 11}
    (warning,) = result.manifest["warnings"]
    assert warning.startswith(f"{name}: ")
    assert warning.endswith("; all rows are there")


def test_an_isolated_run_is_the_same_to_the_last_bit(chain, tmp_path):
    seen = []
    here = run(chain(), stop_time=10, step=0.01)
    apart = run(chain(), stop_time=10, step=0.01, isolated=True, progress=seen.append)
    assert np.array_equal(apart.time, here.time)
    assert np.array_equal(apart.data, here.data)
    assert apart.names == here.names
    assert apart.manifest["outcome"] == here.manifest["outcome"]
    filed = run(chain(), stop_time=10, step=0.01, isolated=True, save=Save(to=tmp_path / "result.h5"))
    assert np.array_equal(filed["integrator.y"], here["integrator.y"])


def test_an_isolated_run_refuses_by_name_what_cannot_cross(chain):
    with pytest.raises(AdcsError, match=r"^hooks: Hook is part of this process"):
        run(chain(), **TIMES, isolated=True, hooks=[Hook()])
    with pytest.raises(AdcsError, match=r"^save: an isolated run has a journal of its own"):
        run(chain(), **TIMES, isolated=True, save=Save(to=journal.Journal(Path("run.journal"))))
    with pytest.raises(AdcsError, match=r"^stop_time = -1\.0 s lies before start_time"):
        run(chain(), stop_time=-1.0, step=0.1, isolated=True)


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("rounding_doStep", "changed the rounding mode, which was changed back"),
        ("denormals_doStep", "changed the flushing of denormal numbers, which was changed back"),
        ("folder_instantiate", "changed the working directory to /, which was changed back"),
        ("umask_doStep", "changed the umask to 777, which was changed back"),
        ("signals_doStep", "took SIGINT for itself, which was given back"),
        ("limits_doStep", "changed the limit RLIMIT_NOFILE, which was changed back"),
    ],
)
@pytest.mark.parametrize("stepping", ["compiled", "python"])
def test_what_a_component_changes_for_all_is_changed_back_and_reported(mock, name, changed, stepping, tmp_path):
    from benchmarks import loop

    if name == "denormals_doStep" and os.uname().machine != "x86_64":
        pytest.skip("the mock knows the control register of x86-64 only")
    alone = run(loop.system(), **TIMES)
    made = loop.system()
    made.add(name, mock("hostile"))
    folder, mask = Path.cwd(), os.umask(0o022)
    os.umask(mask)
    result = run(made, **TIMES, method=CoSimulation(stepping=stepping))
    assert f"{name}: {changed}" in result.manifest["warnings"]
    assert len([w for w in result.manifest["warnings"] if "changed the" in w]) <= 1
    assert np.array_equal(result["plant.q_BN"], alone["plant.q_BN"])
    assert Path.cwd() == folder
    assert os.umask(mask) == mask
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def _without_the_right_to_raise_limits() -> None:
    drop, resources = 24, 24  # PR_CAPBSET_DROP, CAP_SYS_RESOURCE
    ctypes.CDLL(None).prctl(drop, resources, 0, 0, 0)


def _alone(mock, folder, name):
    """As an SSP with this component only, which is the one to be named then."""
    made = System("alone")
    made.add(name, mock("hostile"))
    write_ssp(made, folder / f"{name}.ssp")


def test_a_component_that_closes_all_descriptors_is_named_and_costs_nothing(mock, tmp_path):
    name = "descriptors_doStep"
    _alone(mock, tmp_path, name)
    options = ("--stop", 1, "--step", 0.1, "--format", "csv", "--out", "out", "--json", "--no-report")
    code, out, err = adcs("run", f"{name}.ssp", *options, cwd=tmp_path)
    assert (code, err) == (0, "")
    assert json.loads(out)["outcome"] == {"status": "complete", "rows": 11}
    assert json.loads((tmp_path / "out/manifest.json").read_text())["warnings"] == [
        f"{name}: closed file descriptors of this process that were not its own"
    ]
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == ["manifest.json", "result.csv"]


def test_a_journal_that_a_component_has_closed_goes_on_and_harms_no_other_file(chain, tmp_path, monkeypatch):
    monkeypatch.setattr(journal, "_PIECE", 4096)
    kept = journal.Journal(tmp_path / "run.journal")
    victims = []

    def close(_):
        if len(victims) < 3 and kept._file.is_open:
            number = kept._file.number
            os.close(number)
            victims.append(os.open(tmp_path / f"{len(victims)}", os.O_RDWR | os.O_CREAT))
            assert victims[-1] == number

    result = run(chain(), stop_time=100, step=0.01, save=Save(to=kept), progress=close)
    assert len(result.time) == 10_001
    kept.close()
    assert [os.fstat(victim).st_size for victim in victims] == [0, 0, 0]
    for victim in victims:
        os.close(victim)
    assert np.array_equal(journal.read(kept.path).data, run(chain(), stop_time=100, step=0.01).data)


def test_hdf5_as_rows_come_is_whole_though_its_file_was_closed(mock, tmp_path):
    """In a process of its own, where closing all descriptors hurts nobody else."""
    _alone(mock, tmp_path, "descriptors_doStep")
    code = """
from orchestration.results import hdf5
from adcs import Save, run
from orchestration.ssp.read import read_ssp
hdf5.AT_ONCE = 2
result = run(read_ssp("descriptors_doStep.ssp").system, stop_time=1.0, step=0.1, save=Save(to="result.h5"))
print(len(result["descriptors_doStep.y"]), *result.manifest["warnings"])
"""
    ran = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    told = "11 descriptors_doStep: closed file descriptors of this process that were not its own\n"
    assert (ran.stdout, ran.stderr) == (told, "")
    with h5py.File(tmp_path / "result.h5") as file:
        assert file["descriptors_doStep/y"][:].tolist() == [1 + 0.1 * k / 1000 for k in range(11)]


@pytest.mark.skipif(sys.platform != "linux", reason="capabilities of Linux")
def test_a_limit_that_only_root_can_undo_is_named_and_the_files_are_made_all_the_same(mock, tmp_path):
    name = "filesize_doStep"
    _alone(mock, tmp_path, name)
    options = ("--stop", 1, "--step", 0.1, "--format", "csv", "--out", "out", "--no-report")
    process = start("run", f"{name}.ssp", *options, cwd=tmp_path, before=_without_the_right_to_raise_limits)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    blame = f"{name}: changed the limit RLIMIT_FSIZE, which only root can undo"
    out = tmp_path / "out"
    assert err == (
        f"adcs: cannot write {out}/result.csv: File too large ({blame}); 11 rows are kept, and another process makes "
        "them into files\n"
    )
    assert blame in json.loads((out / "manifest.json").read_text())["warnings"]
    assert len((out / "result.csv").read_text().splitlines()) == 12


@pytest.mark.parametrize("call", ["instantiate", "initialise", "doStep", "terminate", "free"])
def test_a_call_that_hangs_is_given_up_wherever_it_is(mock, call):
    name = f"hang_{call}"
    words = {"instantiate": "instantiating", "initialise": "entering initialisation", "doStep": "doStep"}
    words |= {"terminate": "terminating", "free": "freeing"}
    hung = f"{words[call]} did not return within 0.5 s"
    if call in ("terminate", "free"):
        result = run(system(mock, name), **TIMES, method=CoSimulation(timeout=0.5))
        assert len(result.time) == 11
        assert result.manifest["warnings"] == [f"{name}: {hung}; all rows are there"]
    elif call == "doStep":
        with pytest.raises(RunFailed, match=f"^{name} failed at t = 0.5 s: {hung}; 6 rows are kept$"):
            run(system(mock, name), **TIMES, method=CoSimulation(timeout=0.5))
    else:
        with pytest.raises(AdcsError, match=f"^{name}: {hung}$"):
            run(system(mock, name), **TIMES, method=CoSimulation(timeout=0.5))


def test_a_call_that_hangs_in_model_exchange_is_given_up(mock):
    with pytest.raises(RunFailed, match=r"setTime did not return within 0\.5 s; 3 rows are kept$"):
        run(system(mock, "hang_setTime"), **TIMES, method=ModelExchange(timeout=0.5))


@pytest.mark.parametrize("kind", ["csv", "mat", "hdf5"])
def test_the_command_line_makes_the_files_of_a_run_that_died(mock, tmp_path, kind):
    name = "segfault_doStep"
    as_file(mock, tmp_path, name)
    (tmp_path / "out").mkdir()
    (tmp_path / "out/result.csv").write_text("of a run before")
    options = ("--stop", 1, "--step", 0.1, "--out", "out", "--force", "--format", kind)
    code, _, err = adcs("run", f"{name}.ssp", *options, cwd=tmp_path)
    assert code == 1, err
    message = f"{name} failed at t = 0.5 s: doStep ended the process: {SEGFAULT}"
    assert err.splitlines()[-1] == f"adcs: {message}; 6 rows are kept"
    assert "Traceback" not in err
    manifest = json.loads((tmp_path / "out/manifest.json").read_text())
    assert manifest["outcome"]["status"] == "failed"
    assert manifest["outcome"]["component"] == name
    expected = [1 + 0.1 * k / 1000 for k in range(6)]
    if kind == "csv":
        table = np.genfromtxt(tmp_path / "out/result.csv", delimiter=",", names=True, deletechars="")
        assert table[f"{name}.y[-]"].tolist() == expected
    else:
        assert not (tmp_path / "out/result.csv").exists()
    if kind == "mat":
        y = scipy.io.loadmat(tmp_path / "out/result.mat", simplify_cells=True)[name]["y"]
        assert y.tolist() == expected
    if kind == "hdf5":
        with h5py.File(tmp_path / "out/result.h5") as file:
            assert file[f"{name}/y"][:].tolist() == expected
    assert not (tmp_path / "out" / journal.NAME).exists()
    assert (tmp_path / "out/previous/result.csv").read_text() == "of a run before"


def test_exit_at_the_end_is_no_end_of_a_run(mock, tmp_path):
    """exit(0) ends the command with 0, which must not be taken for success unless the rows are there."""
    as_file(mock, tmp_path, "exit_terminate")
    options = ("--stop", 1, "--step", 0.1, "--format", "csv", "--out", "out", "--json")
    code, out, err = adcs("run", "exit_terminate.ssp", *options, cwd=tmp_path)
    assert code == 0, err
    assert json.loads(out)["outcome"] == {"status": "complete", "rows": 11}
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == [
        "manifest.json",
        "report.html",
        "result.csv",
    ]
    (warning,) = json.loads((tmp_path / "out/manifest.json").read_text())["warnings"]
    assert warning == "exit_terminate: terminating ended the process: exit code 0; all rows are there"


def test_what_a_component_prints_does_not_get_into_json_nor_its_folder_into_paths(mock, tmp_path):
    made = system(mock, "print_doStep")
    made.add("folder_doStep", mock("hostile", name="another"))
    write_ssp(made, tmp_path / "two.ssp")
    options = ("--stop", 1, "--step", 0.1, "--format", "csv", "--out", "out", "--json", "--no-report")
    code, out, err = adcs("run", "two.ssp", *options, cwd=tmp_path)
    assert code == 0, err
    assert json.loads(out)["files"] == ["out/result.csv", "out/manifest.json"]
    assert '{"wheel": 1}' in err
    assert (tmp_path / "out/result.csv").exists()
    warnings = json.loads((tmp_path / "out/manifest.json").read_text())["warnings"]
    assert any("changed the working directory to /" in w for w in warnings)
    assert any("prints to the standard output" in w for w in warnings)


@pytest.mark.parametrize(
    ("name", "code", "status", "rows"),
    [("stop_doStep", 1, "failed", 6), ("unload_doStep", 0, "complete", 11)],
)
def test_a_process_that_stands_still_is_ended_from_outside(mock, tmp_path, name, code, status, rows):
    """Stopped; or stuck in the loader, whose lock the import of a writer waits for, when all rows are there."""
    as_file(mock, tmp_path, name)
    options = ("--stop", 1, "--step", 0.1, "--format", "csv", "--format", "mat", "--out", "out", "--no-report")
    ended, _, err = adcs("run", f"{name}.ssp", *options, "--timeout", 2, cwd=tmp_path)
    assert ended == code, err
    assert "Traceback" not in err
    assert len((tmp_path / "out/result.csv").read_text().splitlines()) == rows + 1
    assert (tmp_path / "out/result.mat").exists()
    manifest = json.loads((tmp_path / "out/manifest.json").read_text())
    assert (manifest["outcome"]["status"], manifest["outcome"]["rows"]) == (status, rows)
    said = manifest["outcome"].get("message", "") + "".join(manifest["warnings"])
    assert "did not return within" in said


LONG = ("--stop", 1e6, "--step", 0.1, "--record", "source.y", "--out", "out", "--no-report", "--format", "csv")


def _rows(folder) -> int:
    try:
        return len(journal.read(folder / "out" / journal.NAME).times)
    except AdcsError:
        return 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_end_a_run_with_its_files_written(mock, tmp_path, number):
    as_file(mock, tmp_path, "signals_doStep")  # which takes them for itself
    pace = ("--real-time", 1, "--stop", 1000)
    process = start(
        "run",
        "signals_doStep.ssp",
        *LONG,
        *pace,
        cwd=tmp_path,
        before=lambda: signal.signal(number, signal.SIG_DFL),  # which a shell or nohup may have had ignored
    )
    until(lambda: _rows(tmp_path) > 10)
    refused, _, message = adcs("run", "signals_doStep.ssp", *LONG, "--force", cwd=tmp_path)
    assert (refused, len(message.splitlines())) == (1, 1)
    assert "out belongs to a run that goes on (process " in message
    process.send_signal(number)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 128 + number, err
    lines = (tmp_path / "out/result.csv").read_text().splitlines()
    assert len(lines) > 10
    assert json.loads((tmp_path / "out/manifest.json").read_text())["outcome"] == {
        "status": "interrupted",
        "rows": len(lines) - 1,
    }


def test_a_signal_sent_twice_is_one(mock, tmp_path):
    as_file(mock, tmp_path, "fine_never")
    process = start("run", "fine_never.ssp", *LONG, "--real-time", 1, "--stop", 1000, cwd=tmp_path)
    until(lambda: _rows(tmp_path) > 10)
    process.send_signal(signal.SIGTERM)
    time.sleep(0.05)
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 128 + signal.SIGTERM, err
    assert json.loads((tmp_path / "out/manifest.json").read_text())["outcome"]["status"] == "interrupted"
    assert not (tmp_path / "out" / journal.NAME).exists()


def test_a_run_that_hangs_ends_without_its_supervisor(mock, tmp_path):
    as_file(mock, tmp_path, "hang_doStep")
    process = start("run", "hang_doStep.ssp", *LONG, cwd=tmp_path)
    until(lambda: _rows(tmp_path) == 6)
    child = int(Lock(tmp_path / "out/run.lock").holder)
    process.kill()
    process.communicate(timeout=60)
    until(lambda: not Path(f"/proc/{child}").exists(), 30.0)
    assert len((tmp_path / "out/result.csv").read_text().splitlines()) == 7
    assert json.loads((tmp_path / "out/manifest.json").read_text())["outcome"]["rows"] == 6


def test_a_run_stops_and_goes_on_with_its_command(mock, tmp_path):
    as_file(mock, tmp_path, "fine_never")
    options = ("--real-time", 1, "--stop", 4, "--timeout", 0.5)
    process = start("run", "fine_never.ssp", *LONG, *options, cwd=tmp_path)
    until(lambda: _rows(tmp_path) > 5)
    child = int(Lock(tmp_path / "out/run.lock").holder)
    process.send_signal(signal.SIGTSTP)
    until(lambda: {_state(process.pid), _state(child)} == {"T"})
    rows = _rows(tmp_path)
    time.sleep(1.5)  # longer than a call may take
    assert _rows(tmp_path) == rows
    process.send_signal(signal.SIGCONT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert len((tmp_path / "out/result.csv").read_text().splitlines()) == 42


def _state(pid: int) -> str:
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]


@pytest.mark.parametrize("who", ["run", "supervisor", "both"])
def test_kill_leaves_the_rows_up_to_the_last_step(mock, tmp_path, who):
    as_file(mock, tmp_path, "fine_never")
    process = start("run", "fine_never.ssp", *LONG, "--real-time", 1, "--stop", 1000, cwd=tmp_path)
    until(lambda: _rows(tmp_path) > 5)
    assert json.loads((tmp_path / "out/manifest.json").read_text())["outcome"]["status"] == "running"
    child = int(Lock(tmp_path / "out/run.lock").holder)
    assert child != process.pid
    before = _rows(tmp_path)
    if who != "run":
        process.kill()
    if who != "supervisor":
        os.kill(child, signal.SIGKILL)
    process.communicate(timeout=60)
    if who == "run":
        assert process.returncode == 1
    if who == "supervisor":  # the run notices, and ends as after Ctrl-C
        until(lambda: not (tmp_path / "out/run.lock").exists())
    if who == "both":
        kept = _rows(tmp_path)
        code, _, err = adcs("recover", "out", cwd=tmp_path)
        assert code == 0, err
        assert f"; {kept} rows are kept" in err
    lines = (tmp_path / "out/result.csv").read_text().splitlines()
    assert len(lines) - 1 >= before
    times = [float(line.split(",")[0]) for line in lines[1:]]
    assert times == [0.1 * k for k in range(len(times))]
    code, _, err = adcs("recover", "out", cwd=tmp_path)
    assert (code, err.count("\n")) == (2, 1)
    assert err.startswith("adcs: out has no run.journal")
