"""`adcs bridge`, `adcs replay` and the options of `adcs run`."""

import json

import pytest

from adcs.cli import app as cli

from .live import Udp


def call(monkeypatch, capsys, *arguments):
    monkeypatch.setattr("sys.argv", ["adcs", *map(str, arguments)])
    code: str | int | None = 0
    try:
        cli.main()
    except SystemExit as end:
        code = end.code
    out = capsys.readouterr()
    return code, out.out, out.err


def test_what_is_shown_is_listed(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "160")
    code, out, _ = call(monkeypatch, capsys, "bridge", "observer-pd", "--list")
    assert code == 0
    for word in ("tracker.q_BN_meas", "CTRL_K_P", "controller.k_p", "N.m", "PLANT_J_B_12"):
        assert word in out


def test_a_bridge_runs_for_a_while_and_counts(monkeypatch, capsys):
    station = Udp()
    out = f"udpout:127.0.0.1:{station.port}"
    code, _, err = call(monkeypatch, capsys, "bridge", "observer-pd", "--stop", 1, "--real-time", 4, "--to", out)
    assert code == 0
    assert "messages sent, 0 not" in err.replace("\n", " ")
    assert station.count("ATTITUDE") > 5


def test_a_run_writes_a_log_without_network_and_a_replay_sends_it(monkeypatch, capsys, tmp_path):
    log = tmp_path / "a.tlog"
    options = ("--stop", 2, "--tlog", log, "--out", tmp_path, "--no-report", "--json")
    code, out, _ = call(monkeypatch, capsys, "run", "full-state-pd", *options)
    assert code == 0
    assert json.loads(out)["outcome"]["status"] == "complete"
    assert json.loads((tmp_path / "manifest.json").read_text())["tlog"] == str(log)
    kept = log.read_bytes()
    code, _, err = call(monkeypatch, capsys, "run", "full-state-pd", *options)
    assert (code, err) == (2, f"adcs: --tlog {log} is there already: give another name\n")
    assert log.read_bytes() == kept
    station = Udp()
    to = f"udpout:127.0.0.1:{station.port}"
    code, _, err = call(monkeypatch, capsys, "replay", log, "--to", to, "--real-time", 4)
    assert code == 0 and "frames of 2 s sent to" in err
    assert station.count("ATTITUDE") > 50


def test_a_port_in_use_is_one_line(monkeypatch, capsys):
    station = Udp()
    code, _, err = call(monkeypatch, capsys, "bridge", "full-state-pd", "--to", f"udpin:127.0.0.1:{station.port}")
    assert code == 1 and err.count("\n") == 1
    assert f"udpin:127.0.0.1:{station.port}: Address already in use; is another program there?" in err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run", "full-state-pd", "--to", "udpout:127.0.0.1:9"], "add --mavlink"),
        (["run", "full-state-pd", "--mavlink", "--estimate-error"], "--estimate-error repeats the run"),
        (["bridge", "full-state-pd", "--to", "udpin:0.0.0.0:14550"], "add --remote"),
        (["bridge", "full-state-pd", "--key", "/nonexistent"], "cannot read the signing key"),
        (["run", "full-state-pd", "--mavlink", "--to", "udpin:0.0.0.0:14550"], "add --remote"),
        (["replay", "/nonexistent.tlog"], "cannot read"),
    ],
)
def test_refusals_are_one_line(monkeypatch, capsys, tmp_path, arguments, message):
    monkeypatch.chdir(tmp_path)
    code, _, err = call(monkeypatch, capsys, *arguments)
    assert code == 2
    assert message in err and err.count("\n") == 1
