"""Options of the commands: the same groups in all of them, times with units, old names that are told."""

import shlex
from dataclasses import asdict, is_dataclass, replace
from importlib import metadata
from math import cos, sin
from typing import Any

import pytest
from test_command_line import adcs

from adcs import AdcsError, read_ssp, write_ssp
from adcs.cli import words
from adcs.cli.app import COMMANDS, app
from adcs.cli.options import During, GroundTools, Report, Results, Solving, StartValues, Steps, Streaming, Times, Which
from adcs.cli.run import at_in_one
from adcs.cli.slips import RENAMED
from orchestration import times
from orchestration.single import single
from tests.invoking import invoke

SYSTEM = ["run", "bridge", "hil", "linearize", "export"]
GROUPS: dict[str, list[Any]] = {
    "run": [Which, Times, Solving, During, Streaming, Results],
    "bridge": [Which, Times, GroundTools],
    "hil": [Which, Steps, Report],
    "linearize": [StartValues],
    "export": [Which, Times],
}
TIMES = {
    "run": ["--step", "--stop", "--start", "--timeout", "--max-step", "--checkpoint-every", "--rows"],
    "bridge": ["--step", "--stop", "--start"],
    "hil": ["--step", "--stop", "--wait", "--answer-timeout", "--warm-up"],
    "linearize": ["--at"],
    "export": ["--step", "--stop", "--start"],
    "replay": ["--wait"],
    "rerun": ["--timeout"],
}


OTHERWISE = {"loops": "--solve-loops", "stepping": None}
"""Fields whose option has another name, or none."""


def arguments_of(command):
    return [a for a in app[command].assemble_argument_collection() if a.show]


def options_of(command):
    return {name for argument in arguments_of(command) for name in argument.names if name.startswith("--")}


def read(command, *options):
    """What a command is called with: its options by name, those of groups among the others."""
    _, bound, _ = app.parse_args(at_in_one([command, "what", *options]))
    values = {}
    for name, value in bound.arguments.items():
        values.update(asdict(value) if is_dataclass(value) else {name: value})
    return values


def named(option):
    return option.removeprefix("--").replace("-", "_")


@pytest.mark.parametrize("command", GROUPS)
def test_a_command_takes_the_whole_group(command):
    for group in GROUPS[command]:
        wanted = {OTHERWISE.get(name, f"--{name.replace('_', '-')}") for name in asdict(group())} - {None}
        assert wanted <= options_of(command), group.__name__


def test_all_commands_that_take_a_system_are_here():
    takers = [c for c in COMMANDS if any("SYSTEM" in argument.names for argument in arguments_of(c))]
    assert sorted(takers) == sorted(SYSTEM) == sorted(GROUPS)


@pytest.mark.parametrize("command", SYSTEM)
@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--set", "plant.mass=1"), "component 'plant' (RigidBody.fmu) has no variable 'mass'"),
        (("--every", "plants=2"), "--every plants=2: expected COMPONENT=N, N from 1; did you mean plant?"),
        (("--delay", "plant.torque_disturbance_B=1"), "nothing is connected to plant.torque_disturbance_B"),
    ],
)
def test_what_is_done_to_a_system_is_done_by_every_command(command, options, message, tmp_path, monkeypatch):
    if options[0] not in options_of(command):
        assert command == "linearize"
        return
    monkeypatch.chdir(tmp_path)
    ended = invoke(app, [command, "observer-pd", *options])
    assert isinstance(ended.exception, AdcsError)
    assert message in str(ended.exception)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("option", ["--every", "--delay"])
def test_what_only_steps_have_is_no_option_of_linearize(option, capsys):
    assert {"--set", "--fmi"} <= options_of("linearize")
    assert option not in options_of("linearize")
    assert adcs("linearize", "observer-pd", option, "x=1") == 2
    assert capsys.readouterr().err.startswith(f"adcs: Unknown option: {option}")


@pytest.mark.parametrize("command", SYSTEM)
def test_a_name_that_is_no_system_is_told_alike(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    told = str(invoke(app, [command, "observr-pd"]).exception)
    assert told.startswith("no system 'observr-pd': did you mean observer-pd or ")
    assert told.endswith("? `adcs list` shows all; or give an .ssp, .py or .fmu file")


@pytest.mark.parametrize(("command", "option"), [(c, option) for c, options in TIMES.items() for option in options])
def test_every_time_takes_a_unit(command, option):
    units = {"250us": 2.5e-4, "5ms": 5e-3, "0.1s": 0.1, "2min": 120.0, "1h": 3600.0, "7": 7.0, "1e-3": 1e-3}
    assert {text: read(command, option, text)[named(option)] for text in units} == units
    if option not in ("--timeout", "--max-step") or command != "run":  # which are looked at when they are read
        assert read(command, f"{option}=-2.5 s")[named(option)] == -2.5
    ended = invoke(app, [command, "what", option, "soon"])
    expected = f"Invalid value for {option}: 'soon' is not a time, write 120s, 0.1s, 5ms, 2min or 1h"
    assert str(ended.exception) == expected


@pytest.mark.parametrize("command", COMMANDS)
def test_no_option_is_a_time_without_unit(command):
    times = [a.names[0] for a in arguments_of(command) if a.parameter.metavar == "TIME"]
    assert times == TIMES.get(command, [])
    assert not [a.names[0] for a in arguments_of(command) if "[s]" in (a.parameter.help or "")]


@pytest.mark.parametrize(
    ("text", "unit"), [("20parsec", "parsec"), ("5 m", "m"), ("5sec", "sec"), ("1e3S", "S"), ("1e", "e"), ("2µs", "µs")]
)
def test_what_is_no_unit_of_time(text, unit):
    with pytest.raises(ValueError, match="no unit") as error:
        times.seconds(text)
    assert str(error.value) == f"{text!r} is not a time: {unit!r} is no unit, use us or ms or s or min or h"


@pytest.mark.parametrize("text", ["", "s", "1e999", "nan", "inf", "٣s", "1min2s", "1..2s", "--1"])
def test_what_is_no_time(text):
    with pytest.raises(ValueError, match="is not a time, write 120s"):
        times.seconds(text)


@pytest.mark.parametrize("text", ["1.5", "2.0", "1e3", "two", ""])
def test_what_is_no_whole_number_is_not_rounded(text, capsys):
    assert adcs("run", "observer-pd", "--record-every", text) == 2
    assert f"{text!r} is no whole number" in capsys.readouterr().err


def test_a_delay_is_a_number_of_steps_or_a_time_with_its_unit(capsys):
    assert adcs("run", "observer-pd", "--delay", "plant.torque_B=2.0") == 2
    assert capsys.readouterr().err == (
        "adcs: --delay plant.torque_B=2.0: give a whole number of steps, or a time as in 0.1s\n"
    )


def test_steps_beyond_counting_are_told_their_limit(capsys):
    assert adcs("run", "observer-pd", "--every", "controller=99999999999") == 2
    assert capsys.readouterr().err == "adcs: --every controller=99999999999: expected at most 999999999 steps\n"


@pytest.mark.parametrize(("command", "old"), [(c, old) for c, names in RENAMED.items() for old in names])
def test_an_old_name_is_told_the_new_one(command, old, capsys):
    new = RENAMED[command][old]
    assert new in options_of(command) and old not in options_of(command)
    for words_ in ((old, "1"), (f"{old}=1",)):
        assert adcs(command, "observer-pd", *words_) == 2
        assert capsys.readouterr().err == f"adcs: {old} is {new} now\n"


@pytest.mark.parametrize("command", COMMANDS)
def test_help_fits_80_columns_and_ends_with_examples_that_are_good(command, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert adcs(command, "--help") == 0
    shown = capsys.readouterr().out
    assert max(map(len, shown.splitlines())) <= 80
    head, _, _ = shown.rpartition("Examples:")
    assert all(f"{option} " in head for option in options_of(command))
    below = [line.rstrip() for line in shown.rpartition("Examples:")[2].strip().splitlines()]
    assert below == [
        line.strip(" `") for line in app[command].help_epilogue.splitlines()[1:]
    ]  # each in a line of its own
    usage, *_ = shown.splitlines()
    assert usage.startswith(f"Usage: adcs {command} ") and "ARGS" not in usage
    for argument in arguments_of(command):
        if not argument.names[0].startswith("-"):
            assert argument.names[0] in usage
    examples = [shlex.split(line.strip(" `")) for line in app[command].help_epilogue.splitlines() if "adcs" in line]
    assert examples
    for name, *arguments in examples:
        assert name == "adcs" and arguments[0] == command
        app.parse_args(at_in_one(arguments), exit_on_error=False, print_error=False)


def test_changes_before_zero():
    assert read("run", "--at", "-1s", "a.b=-2", "--at", "-0.5s a.b=3")["at"] == ("-1s a.b=-2", "-0.5s a.b=3")


def test_version(capsys):
    assert adcs("--version") == 0
    assert capsys.readouterr().out == metadata.version("adcs-fmus") + "\n"


def test_ground_tools_of_a_run_need_mavlink(capsys):
    assert adcs("run", "observer-pd", "--peer", "127.0.0.1", "--frame", "eci") == 2
    assert capsys.readouterr().err == "adcs: --peer, --frame: for ground tools, add --mavlink\n"


class TestExport:
    def export(self, tmp_path, *arguments):
        ended = invoke(app, ["export", *map(str, arguments), "--force", "--set", "omega_BN_B=0,0,0.5"])
        assert ended.exit_code == 0, ended.exception
        return read_ssp(tmp_path / "a.ssp")

    def test_a_component_and_a_file_of_one(self, tmp_path, monkeypatch):
        from fmus import fmu_path

        monkeypatch.chdir(tmp_path)
        for name in ("RigidBody", fmu_path("RigidBody")):
            file = self.export(tmp_path, name, "a.ssp", "--stop", "2min")
            assert file.system.components["RigidBody"].start["omega_BN_B"] == (0.0, 0.0, 0.5)
            assert (file.stop_time, file.step) == (120.0, 0.01)

    def test_times_that_a_file_does_not_give_are_not_made_up(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        write_ssp(single("RigidBody"), "none.ssp")
        file = self.export(tmp_path, "none.ssp", "a.ssp")
        assert (file.stop_time, file.step) == (None, None)
        file = self.export(tmp_path, "none.ssp", "a.ssp", "--step", "10ms")
        assert (file.stop_time, file.step) == (None, 0.01)

    def test_rates_and_delays(self, tmp_path):
        options = ("--every", "tracker=2", "--delay", "plant.torque_B=20ms", "--start", "1s")
        assert adcs("export", "observer-pd", tmp_path / "a.ssp", *options) == 0
        file = read_ssp(tmp_path / "a.ssp")
        assert file.start_time == 1.0
        assert file.system.components["tracker"].every == 2
        assert [c.delay for c in file.system.connections if c.target == "plant.torque_B"] == [0.02]


def test_a_component_is_a_system_by_its_name(tmp_path):
    start = ("--set", "omega_BN_B=0,0,0.5", "--set", "J_B=[[10,0,0],[0,19,0],[0,0,25]]")
    options = (*start, "--stop", "2s", "--step", "500ms", "--no-report", "--record", "RigidBody.q_BN")
    assert adcs("run", "RigidBody", *options, "--out", tmp_path) == 0
    last = [float(value) for value in (tmp_path / "result.csv").read_text().splitlines()[-1].split(",")]
    assert last == pytest.approx([2.0, cos(0.5), 0.0, 0.0, sin(0.5)], abs=1e-9)


def test_of_one_component_the_variable_is_enough():
    assert words.change(single("PdTracking"), "5s k_p=3") == (5.0, "PdTracking.k_p", 3.0)
    assert words.full_name(single("PdTracking"), "PdTracking.k_p") == "PdTracking.k_p"


def test_groups_are_frozen():
    """So that one default value serves all calls."""
    assert replace(Which(), fmi="3") != Which()
    with pytest.raises(AttributeError):
        Which().fmi = "3"
