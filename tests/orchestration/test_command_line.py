"""`adcs run`: files, exit codes, one-line errors."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from adcs.cli import app as cli

ADCS = (sys.executable, "-c", "from adcs.cli.app import main; main()")


def adcs(*arguments: object) -> int:
    """Run the command line in this process and return its exit code."""
    before = sys.argv
    sys.argv = ["adcs", *map(str, arguments)]
    try:
        cli.main()
    except SystemExit as error:
        return int(error.code or 0)
    finally:
        sys.argv = before
    return 0


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("run")


def test_a_run_writes_all_its_files(folder, capsys):
    assert adcs("run", "observer-pd", "--stop", 20, "--step", 0.02, "--out", folder, "--json", "--png") == 0
    printed = json.loads(capsys.readouterr().out)
    names = ["result.csv", "result.mat", "manifest.json", "report.html", "report.png"]
    assert printed["files"] == [str(folder / name) for name in names]
    assert all((folder / name).stat().st_size > 0 for name in names)
    assert printed["outcome"] == {"status": "complete", "rows": 1001}
    assert {"label", "value", "unit", "note"} == set(printed["key_numbers"][0])
    with (folder / "result.csv").open() as file:
        rows = list(csv.reader(file))
    assert len(rows) == 1002
    assert float(rows[-1][0]) == 20.0
    attitude = scipy.io.loadmat(folder / "result.mat", simplify_cells=True)["plant"]["q_BN"]
    column = rows[0].index("plant.q_BN[1][1]")
    assert float(rows[-1][column]) == attitude[-1, 0]
    assert (folder / "report.png").read_bytes()[:4] == b"\x89PNG"


def test_a_picture_is_drawn_where_it_can_be(tmp_path, capsys, monkeypatch):
    run = ("run", "observer-pd", "--stop", 1, "--out", tmp_path / "out", "--png")
    assert adcs(*run, "--no-report") == 2
    assert capsys.readouterr().err == "adcs: --png draws the plots of the report: leave out --no-report\n"
    monkeypatch.setattr("adcs.cli.options.can_draw", lambda: False)
    assert adcs(*run) == 1
    assert capsys.readouterr().err == "adcs: --png: matplotlib is not installed: pip install 'adcs-fmus[plot]'\n"
    assert not (tmp_path / "out").exists()


def test_people_get_a_table(tmp_path, capsys):
    assert adcs("run", "full-state-pd", "--stop", 1, "--no-report", "--out", tmp_path) == 0
    out = capsys.readouterr().out
    assert "Largest torque" in out
    assert "times faster than real time" in out
    assert not (tmp_path / "report.html").exists()


def test_set_and_record(tmp_path):
    command = ("run", "observer-pd", "--stop", 1, "--no-report", "--out", tmp_path)
    assert (
        adcs(*command, "--set", "tracker.half_angle=0.05deg", "--set", "tracker.seed=7", "--record", "plant.q_BN") == 0
    )
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    start = manifest["system"]["components"]["tracker"]["start"]
    assert start["half_angle"] == pytest.approx(np.radians(0.05), rel=1e-15)
    assert manifest["seeds"] == {"tracker.seed": 7}
    with (tmp_path / "result.csv").open() as file:
        assert next(csv.reader(file)) == ["time[s]", *(f"plant.q_BN[{i}][1]" for i in range(1, 5))]


def test_options_reach_the_run(tmp_path):
    options = ("--method", "model-exchange", "--solver", "CVode", "--fmi", 3, "--stop", 1, "--step", 0.5)
    assert adcs("run", "full-state-pd", *options, "--no-report", "--out", tmp_path) == 0
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    assert manifest["settings"]["solver"] == "CVode"
    assert {c["fmi_version"] for c in manifest["system"]["components"].values()} == {"3.0"}
    assert manifest["outcome"]["rows"] == 3


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (
            ("observer-pd", "--solver", "CVode", "--method", "co-simulation"),
            2,
            "adcs: --solver CVode: an option of model-exchange, leave out --method co-simulation",
        ),
        (
            ("observer-pd", "--rtol", "1e-8", "--adaptive", "1e-6"),
            2,
            "adcs: --adaptive (co-simulation) and --rtol (model-exchange) are options of two methods: leave one out",
        ),
        (
            ("observer-pd", "--rows", "3ms", "--step", "2ms"),
            2,
            "adcs: rows, 0.003 s, is not a whole number of exchange steps of 0.002 s: use 0.002 or 0.004 s, or another",
        ),
        (("nothing",), 2, "adcs: no system 'nothing': `adcs list` shows all; or give an .ssp, .py or .fmu file"),
        (("observer-pd", "--step", "0"), 2, "adcs: step = 0.0 s: expected a positive time"),
        (("observer-pd", "--step", "nan"), 2, "adcs: Invalid value for --step: 'nan' is not a time, write 120s, 0.1s"),
        (
            ("observer-pd", "--set", "tracker.half_angle"),
            2,
            "adcs: --set tracker.half_angle: expected COMPONENT.VARIABLE=VALUE",
        ),
        (("observer-pd", "--set", "tracker.angle=1"), 2, "has no variable 'angle': did you mean half_angle?"),
        (("observer-pd", "--set", "tracker.half_angle=wide"), 2, "half_angle = 'wide' cannot be read: write a number"),
        (("observer-pd", "--record", "plant.q"), 2, "component 'plant' (RigidBody.fmu) has no variable 'q'"),
        (("observer-pd", "--set", "plant.J_B=[[1,2,3],[0,1,0],[0,0,1]]"), 1, "adcs: plant: "),
    ],
)
def test_errors_are_one_line(tmp_path, capsys, arguments, code, message):
    assert adcs("run", *arguments, "--out", tmp_path) == code
    err = capsys.readouterr().err.strip()
    assert message in err.splitlines()[-1]
    assert "Traceback" not in err


@pytest.mark.parametrize(
    "words",
    [
        ("check", "RigidBdy"),
        ("check", "none.fmu"),
        ("info", "observr-pd"),
        ("info", "none.fmu"),
        ("build", "RigidBdy"),
        ("run", "none.fmu"),
        ("run", "none.ssp"),
        ("run", "observer-pd", "--until", "plant.q < 3"),
        ("run", "observer-pd", "--fmi", "4"),
        ("run", "observer-pd", "--nonsense"),
        ("run",),
        ("runn", "observer-pd"),
        ("rerun", "none"),
        ("recover", "none"),
        ("export", "observer-pd", "--step", "0"),
        ("linearize", "observer-pd", "--inputs", "plant.torqe_B"),
        ("linearize", "observer-pd", "--at", "-1"),
        ("linearize", "observer-pd", "--out", "x.csv"),
        ("hil", "observer-pd", "--max-torque", "much"),
        ("hil", "hil-spacecraft", "--host", "here"),
        ("study", "thakr"),
        ("study", "thakur", "--set", "x=1"),
        ("bridge", "observer-pd", "--allow", "all"),
        ("bridge", "observer-pd", "--real-time", "0"),
        ("replay", "none.tlog"),
        ("replay", "none.tlog", "--to", "here"),
    ],
    ids=" ".join,
)
def test_wrong_words_end_with_2_in_every_command(tmp_path, monkeypatch, capsys, words):
    monkeypatch.chdir(tmp_path)
    assert adcs(*words) == 2
    err = capsys.readouterr().err
    assert err.startswith("adcs: ") and err.count("\n") == 1


def test_what_fails_ends_with_1(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    unstable = ("--set", "plant.max_internal_step=10", "--set", "plant.omega_BN_B=1e300,1e300,1e300")
    assert adcs("run", "full-state-pd", *unstable, "--no-report") == 1
    assert adcs("linearize", "full-state-pd", "--at", "1s", *unstable) == 1
    monkeypatch.setattr("fmus.paths.DIST", tmp_path)
    monkeypatch.setattr("fmus.toolchain.is_installed", lambda: False)
    for command in ("run", "export", "linearize"):
        assert adcs(command, "observer-pd") == 1
        assert capsys.readouterr().err.splitlines()[-1].startswith("adcs: FixedAxisReference.fmu is not built, and no")


def test_a_failed_run_leaves_no_report_of_an_earlier_one(tmp_path):
    (tmp_path / "report.html").write_text("old")
    assert adcs("run", "observer-pd", "--set", "plant.J_B=[[1,2,3],[0,1,0],[0,0,1]]", "--force", "--out", tmp_path) == 1
    assert not (tmp_path / "report.html").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--fmi", "4"), 'Invalid value "4" for --fmi. Choose from: "2", "3".'),
        (("--format", "xls"), 'Invalid value "xls" for --format. Choose from: "csv", "mat", "hdf5".'),
        (("--step", "fast"), "Invalid value for --step: 'fast' is not a time, write 120s, 0.1s, 5ms, 2min or 1h"),
        (
            ("--epoch", "tomorrow"),
            "Invalid value for --epoch: 'tomorrow' is no date, write 2026-03-21 or 2026-03-21T12:00:00",
        ),
        (("--chekpoint", "a"), "Unknown option: --chekpoint. Did you mean --checkpoint?"),
        (("--nonsense",), "Unknown option: --nonsense: `adcs run --help` shows all"),
        (("extra",), "'extra' is more than it takes: `adcs run --help` shows all"),
        (("--mavlink", "a b", "c"), "'a b', 'c' are more than it takes: `adcs run --help` shows all"),
        (("--step",), "--step needs a value: `adcs run --help` shows all"),
        (("--adaptive", "x"), "Invalid value 'x' for --adaptive: expected a number"),
        (("--force=perhaps",), "Invalid value 'perhaps' for --force: it is an option without a value"),
    ],
)
def test_usage_errors_are_one_line_and_exit_with_2(capsys, arguments, message):
    assert adcs("run", "observer-pd", *arguments) == 2
    assert capsys.readouterr().err == f"adcs: {message}\n"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("runn", "x"), "no command 'runn': did you mean run or rerun? `adcs --help` shows all"),
        (("help",), "no command 'help': `adcs --help` shows all"),
        (("frobnicate",), "no command 'frobnicate': `adcs --help` shows all"),
        (("--frobnicate",), "no command '--frobnicate': `adcs --help` shows all"),
        (("run",), "SYSTEM is missing: `adcs run --help` shows all"),
        (("rerun", "--force"), "MANIFEST is missing: `adcs rerun --help` shows all"),
        (("export", "a", "b.ssp", "c.ssp"), "'c.ssp' is more than it takes: `adcs export --help` shows all"),
    ],
)
def test_words_that_no_command_takes(capsys, words, message):
    assert adcs(*words) == 2
    assert capsys.readouterr().err == f"adcs: {message}\n"


def test_components_that_cannot_be_built(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("fmus.paths.DIST", tmp_path)
    monkeypatch.setattr("fmus.toolchain.is_installed", lambda: False)
    assert adcs("run", "observer-pd", "--out", tmp_path) == 1
    assert capsys.readouterr().err == (
        "adcs: FixedAxisReference.fmu is not built, and no compiler is installed to build it: "
        "pip install 'adcs-fmus[build]'\n"
    )


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="looks into /proc to see the loop begin")
def test_interruption_keeps_what_was_recorded(tmp_path):
    options = ("--stop", "1e5", "--record", "plant.q_BN", "--no-report", "--json")
    process = subprocess.Popen(
        [*ADCS, "run", "full-state-pd", *options, "--out", tmp_path],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])},
        # a shell's background job ignores Ctrl-C, and what it starts inherits that
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    maps = Path(f"/proc/{process.pid}/maps")
    while process.poll() is None and "RigidBody" not in maps.read_text():
        time.sleep(0.05)
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    rows = json.loads(out)["outcome"]["rows"]
    assert 10 < rows < 1e7
    assert err.strip().splitlines()[-1].startswith("adcs: interrupted at t = ")
    with (tmp_path / "result.csv").open() as file:
        assert len(list(csv.reader(file))) == rows + 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run", "observer-pd", "--out", "file"], "--out file: file is no folder: give another place"),
        (["run", "observer-pd", "--out", "file/a/b"], "--out file/a/b: file is no folder: give another place"),
        (["study", "thakur", "--out", "file"], "--out file: file is no folder: give another place"),
        (["hil", "hil-spacecraft", "--out", "file"], "--out file: file is no folder: give another place"),
        (
            ["linearize", "PdTracking", "--out", "file/x.json"],
            "--out file/x.json: file is no folder: give another place",
        ),
        (
            ["linearize", "PdTracking", "--out", "folder.json"],
            "--out folder.json: it is a folder: give the name of a file in it",
        ),
        (
            ["export", "full-state-pd", "--out", "file/x.ssp"],
            "cannot write file/x.ssp: file is no folder: give another place",
        ),
        (["export", "full-state-pd", "--out", "folder.ssp"], "folder.ssp is a folder: give the name of a file in it"),
        (
            ["export", "full-state-pd", "a.ssp", "--out", "b.ssp"],
            "--out b.ssp: the file is given as a.ssp already, leave one out",
        ),
        (
            ["run", "observer-pd", "--checkpoint", "file/x", "--out", "out"],
            "--checkpoint file/x: file is no folder: give another place",
        ),
    ],
)
def test_a_place_where_nothing_can_be_is_named_with_a_way_out(tmp_path, monkeypatch, capsys, arguments, message):
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("mine")
    for name in ("folder.json", "folder.ssp"):
        Path(name).mkdir()
    assert adcs(*arguments) == 2
    assert capsys.readouterr().err == f"adcs: {message}\n"
    assert Path("file").read_text() == "mine"


def test_export_takes_its_file_by_out_as_well(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert adcs("export", "full-state-pd", "--out", "here.ssp") == 0
    assert capsys.readouterr().out.startswith("here.ssp: 4 components, 7 connections")
    assert [file.name for file in tmp_path.iterdir()] == ["here.ssp"]


def test_an_encoding_without_our_signs_is_no_reason_to_fail(tmp_path):
    ran = subprocess.run(
        [*ADCS, "run", "observer-pd", "--stop", "1", "--no-report", "--out", tmp_path],
        capture_output=True,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[2]), "PYTHONIOENCODING": "ascii"},
    )
    assert ran.returncode == 0, ran.stderr
    assert b"Largest torque" in ran.stdout
