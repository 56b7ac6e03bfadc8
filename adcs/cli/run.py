"""`adcs run`: from words on the command line to a run, its files and what people see of it."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

import typer

from adcs.catalogue import find_system
from adcs.cli import ground_tools as ground
from adcs.cli.ground_tools import Options
from adcs.cli.run_files import RunFiles
from adcs.cli.showing import Format, as_json, command_line, exit_code, progress, show, write_report
from adcs.cli.words import assign, assigned, seconds, whole
from fmus.errors import AdcsError, shown
from orchestration.coupled import SolverName
from orchestration.fmu.file import Kind
from orchestration.from_file import from_anywhere
from orchestration.isolation import supervised
from orchestration.plan.loops import LoopMethod, LoopSolver
from orchestration.process import endings
from orchestration.process.writing import make_folder
from orchestration.results.result import RunFailed, RunInterrupted
from orchestration.running.accuracy import Estimate, estimate_error
from orchestration.running.run import run as run_system
from orchestration.running.session import Stepping
from orchestration.system import System

_LARGE = 20_000_000  # values; more are written, but not read again for key numbers and report
_NUMERICS, _DURING, _RESULTS = "How it is solved", "What happens during the run", "Results"
_GROUND = "Ground tools"

app = typer.Typer()

_EPILOG = """Examples:

adcs run observer-pd --step 0.001 --set tracker.half_angle=0.05deg --out results/noisy

adcs run observer-pd --at 20s controller.k_p=3 --until "norm(controller.omega_BR_B) < 1e-5" --stop 300

adcs run system.ssp --estimate-error --format hdf5
"""


@app.command(epilog=_EPILOG)
def run(
    system: Annotated[str, typer.Argument(help="Name of a system (`adcs list`), or an .ssp or .fmu file.")],
    step: Annotated[
        float | None,
        typer.Option(
            help="Time between two exchanges and two rows [s]. [default: that of the system]",
            rich_help_panel=_NUMERICS,
        ),
    ] = None,
    start: Annotated[
        float | None, typer.Option(help="Start time [s]. [default: that of the system]", rich_help_panel=_NUMERICS)
    ] = None,
    stop: Annotated[
        float | None,
        typer.Option(
            help="Stop time [s]; the last step is shorter, if need be. [default: that of the system]",
            rich_help_panel=_NUMERICS,
        ),
    ] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="Start value of a COMPONENT.VARIABLE; may be repeated. VALUE is 1.5, 0.05deg, 1,2,3 or [[1,2],[3,4]].",
        ),
    ] = None,
    method: Annotated[
        Kind,
        typer.Option(
            help="Exchange values every step, or integrate all components as one differential equation.",
            rich_help_panel=_NUMERICS,
        ),
    ] = "co-simulation",
    solver: Annotated[
        SolverName, typer.Option(help="Integrator of model-exchange.", rich_help_panel=_NUMERICS)
    ] = "DOP853",
    fmi: Annotated[
        Literal["2", "3"], typer.Option(help="FMI version of the components.", rich_help_panel=_NUMERICS)
    ] = "2",
    stepping: Annotated[
        Stepping,
        typer.Option(help="Loop of co-simulation; both give the same to the last bit.", rich_help_panel=_NUMERICS),
    ] = "compiled",
    every: Annotated[
        list[str] | None,
        typer.Option(
            metavar="COMPONENT=N",
            help="Let a component communicate at every N-th step only; may be repeated.",
            rich_help_panel=_NUMERICS,
        ),
    ] = None,
    delay: Annotated[
        list[str] | None,
        typer.Option(
            metavar="INPUT=N|TIME",
            help="Delay what arrives at a connected input by N steps, or by a time as in 0.1s; may be repeated.",
            rich_help_panel=_NUMERICS,
        ),
    ] = None,
    solve_loops: Annotated[
        LoopMethod | None, typer.Option(help="Solve algebraic loops by this method.", rich_help_panel=_NUMERICS)
    ] = None,
    adaptive: Annotated[
        float | None,
        typer.Option(
            metavar="TOLERANCE",
            help="Choose exchange steps of --step/2^j so that halving them changes no output by more than "
            "TOLERANCE * (1 + its size).",
            rich_help_panel=_NUMERICS,
        ),
    ] = None,
    estimate: Annotated[
        bool,
        typer.Option(
            "--estimate-error",
            help="Say what the exchange step costs in accuracy, output by output.",
            rich_help_panel=_NUMERICS,
        ),
    ] = False,
    at: Annotated[
        list[str] | None,
        typer.Option(
            metavar="TIME NAME=VALUE",
            help="Set an unconnected input or a tunable parameter at a time, as in 120s; may be repeated.",
            rich_help_panel=_DURING,
        ),
    ] = None,
    inputs: Annotated[
        Path | None,
        typer.Option(
            help="CSV table of unconnected inputs: columns `time` and COMPONENT.VARIABLE.", rich_help_panel=_DURING
        ),
    ] = None,
    until: Annotated[
        str | None,
        typer.Option(
            metavar="CONDITION",
            help='End at the first row where "norm(NAME) < 1e-4" holds; also max(), min(), <=, >, >=.',
            rich_help_panel=_DURING,
        ),
    ] = None,
    real_time: Annotated[
        float | None,
        typer.Option(metavar="SPEED", help="Keep pace with the clock, SPEED times as fast.", rich_help_panel=_DURING),
    ] = None,
    timeout: Annotated[
        float,
        typer.Option(help="Give up when one call of a component takes longer [s].", rich_help_panel=_DURING),
    ] = 120.0,
    checkpoint: Annotated[
        Path | None, typer.Option(help="Save the state at the end to this file.", rich_help_panel=_DURING)
    ] = None,
    checkpoint_every: Annotated[
        float | None,
        typer.Option(help="Save it every so many simulated seconds, too [s].", rich_help_panel=_DURING),
    ] = None,
    resume: Annotated[Path | None, typer.Option(help="Go on from a saved state.", rich_help_panel=_DURING)] = None,
    mavlink: Annotated[
        bool,
        typer.Option(
            "--mavlink",
            help="Stream the run by MAVLink, in real time unless --real-time says otherwise.",
            rich_help_panel=_GROUND,
        ),
    ] = False,
    to: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KIND:HOST:PORT",
            help="Where ground tools are: udpout:, udpin: or tcpin:; may be repeated. "
            "[default: udpout:127.0.0.1:14550 and :14540]",
            rich_help_panel=_GROUND,
        ),
    ] = None,
    allow: Annotated[
        str,
        typer.Option(metavar="WHAT,...", help="Let them: arm, param, attitude.", rich_help_panel=_GROUND),
    ] = "",
    frame: Annotated[
        Literal["ned", "lvlh", "eci"],
        typer.Option(help="Frame of the attitude that they are shown.", rich_help_panel=_GROUND),
    ] = "ned",
    map_: Annotated[
        list[str] | None,
        typer.Option(
            "--map",
            metavar="ROLE=NAME",
            help="Variable that they are shown as attitude, rate, ...; or a TOML file; may be repeated.",
            rich_help_panel=_GROUND,
        ),
    ] = None,
    tlog: Annotated[
        Path | None,
        typer.Option(help="Write a telemetry log, with or without --mavlink.", rich_help_panel=_GROUND),
    ] = None,
    record: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Write this variable only; may be repeated. [default: all outputs]",
            rich_help_panel=_RESULTS,
        ),
    ] = None,
    record_every: Annotated[
        int, typer.Option(metavar="N", help="Write every N-th row only.", rich_help_panel=_RESULTS)
    ] = 1,
    format_: Annotated[
        list[str] | None,
        typer.Option(
            "--format",
            metavar="[csv|mat|hdf5]",
            help="Kind of result file; may be repeated. With hdf5 alone a run may be larger than memory. "
            "[default: csv, mat]",
            rich_help_panel=_RESULTS,
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the results. [default: results/SYSTEM]", rich_help_panel=_RESULTS)
    ] = None,
    no_report: Annotated[
        bool, typer.Option("--no-report", help="Write no report.html and report.png.", rich_help_panel=_RESULTS)
    ] = False,
    json: Annotated[
        bool, typer.Option("--json", help="Print key numbers, outcome and files as JSON.", rich_help_panel=_RESULTS)
    ] = False,
    in_process: Annotated[
        bool,
        typer.Option(
            "--in-process",
            help="Do without a process of its own for the run, as for a debugger.",
            rich_help_panel=_DURING,
        ),
    ] = False,
) -> None:
    """Run a system: write the result, manifest.json, report.html, report.png, and print the key numbers."""
    entry = find_system(system)
    built = entry.build()
    assign(built, set_ or [])
    for assignment in every or []:
        _every(built, assignment)
    for assignment in delay or []:
        _delay(built, assignment)
    changes = [_change(built, text) for text in at or []]
    formats = _formats(format_)
    given = out or Path("results") / entry.name
    folder = given.absolute()  # a component may change the working directory
    make_folder(given, f"--out {given}")  # refused now, rather than after the run
    no_report = no_report or (record is not None and formats == ["hdf5"])  # whose file holds what is recorded
    if estimate and method != "co-simulation":
        raise AdcsError("--estimate-error is a matter of co-simulation: model-exchange has no exchange step")
    if checkpoint is not None:
        make_folder(checkpoint.parent, f"--checkpoint {checkpoint}")
        checkpoint = checkpoint.absolute()
    wanted = record if no_report else _with_outputs(built, record)  # the report needs more than what is written
    settings: dict[str, Any] = {
        "start_time": entry.start_time if start is None else start,
        "stop_time": entry.stop_time if stop is None else stop,
        "step": entry.step if step is None else step,
        "method": method,
        "solver": solver,
        "fmi_version": "2.0" if fmi == "2" else "3.0",
        "stepping": stepping,
        "changes": changes,
        "inputs": inputs,
        "until": until,
        "real_time": real_time,
        "solve_loops": None if solve_loops is None else LoopSolver(solve_loops),
        "timeout": timeout,
        "adaptive": adaptive,
        "checkpoint": checkpoint,
        "checkpoint_every": checkpoint_every,
        "resume": resume,
        "record_every": record_every,
    }
    if settings["stop_time"] == settings["start_time"]:
        raise AdcsError(f"stop = {settings['start_time']:g} s is the start time: give a later one")
    if settings["step"] > 0:
        entry.check_step(settings["step"])
    errors: Estimate | None = None
    attached: AbstractContextManager[Any] = nullcontext()
    if mavlink or tlog is not None:
        if estimate:
            raise AdcsError("--estimate-error repeats the run, which --mavlink and --tlog would show: leave one out")
        if mavlink and real_time is None:
            settings["real_time"] = 1.0
        log = None if tlog is None else tlog.absolute()
        options = Options(to or (), allow, frame, maps=map_ or (), tlog=log, network=mavlink)
        pace = {"step": settings["step"], "start": settings["start_time"], "speed": settings["real_time"] or 1.0}
        attached = watcher = ground.attached(built, options, **pace)
        settings["watchers"] = [watcher]
        wanted = _with_outputs(built, wanted)
    elif to or allow or map_:
        raise AdcsError("--to, --allow and --map are for ground tools: add --mavlink")
    about = {
        "system": from_anywhere(system),
        "folder": str(given),
        "record": record,
        "report": not no_report,
        "json": json,
    }
    with (
        endings.heard(),
        RunFiles(folder, formats, {**about, "command": command_line()}, timeout, supervised.printed) as run_files,
        attached,
        progress() as bar,
    ):
        task = bar.add_task(entry.name, total=1.0)
        stopped: RunFailed | RunInterrupted | None = None

        def update(part: float) -> None:
            bar.update(task, completed=part)

        try:
            result = run_system(built, **settings, record=wanted, progress=update, journal=run_files.journal)
        except (RunFailed, RunInterrupted) as error:
            stopped, result = error, error.result
        bar.update(task, completed=1.0, description="writing the results")
        written = result if record in (None, result.names) else result.select(record)
        files = run_files.write(written, stopped is not None)
        if estimate and stopped is None:
            bar.update(task, completed=0.0, description="estimating the error")
            errors = estimate_error(result, run_system, update)
            result.manifest["error_estimate"] = errors.as_dict()
            written.write_manifest(folder / "manifest.json")
        large = len(result.time) * sum(port.size for port in result.ports.values()) > _LARGE
        whole = (record is None or not no_report) and not large  # key numbers need all outputs
        numbers = list(entry.key_numbers(result)) if whole and not stopped else []
        if not (stopped or no_report or large):
            files += write_report(entry, result, numbers, errors, folder)
    files = [given / file.name for file in files]
    if json:
        typer.echo(as_json(result, numbers, files))
    else:
        show(result, numbers, errors, files)
    if stopped is not None:
        raise typer.Exit(exit_code(stopped))
    if endings.noted:
        raise typer.Exit(128 + endings.last)


def _formats(wanted: Sequence[str] | None) -> list[Format]:
    known = {name: name for name in get_args(Format)}
    for name in wanted or ():
        if name not in known:
            raise AdcsError(f"--format {name}: expected {', '.join(known)}")
    return [known[name] for name in dict.fromkeys(wanted or ("csv", "mat"))]


def _change(system: System, text: str) -> tuple[float, str, Any]:
    time, blank, assignment = text.strip().partition(" ")
    if not blank:
        raise AdcsError(f"--at {shown(text)}: expected TIME COMPONENT.VARIABLE=VALUE, as in --at 120s controller.k_p=2")
    return seconds(time, "--at"), *assigned(system, assignment.strip(), "--at")


def at_in_one(arguments: Sequence[str]) -> list[str]:
    """Join the two words after each `--at` of `run`, since an option that may be repeated takes one."""
    joined: list[str] = []
    if arguments[:1] != ["run"]:
        return list(arguments)
    for word in arguments:
        time_alone = joined[-2:-1] == ["--at"] or any(last.startswith("--at=") for last in joined[-1:])
        if time_alone and " " not in joined[-1] and not word.startswith("-"):
            joined[-1] += f" {word}"
        else:
            joined.append(word)
    return joined


def _every(system: System, assignment: str) -> None:
    name, _, text = assignment.partition("=")
    number = whole(text)
    if name not in system.components or not number:
        raise AdcsError(
            f"--every {shown(assignment)}: expected COMPONENT=N, one of {', '.join(system.components)}, N from 1"
        )
    system.components[name].every = number


def _delay(system: System, assignment: str) -> None:
    name, _, text = assignment.partition("=")
    if (number := whole(text)) is not None:
        system.delay(name, steps=number)
    else:
        system.delay(name, seconds=seconds(text, f"--delay {shown(name)}"))


def _with_outputs(system: System, record: Sequence[str] | None) -> list[str] | None:
    return None if record is None else list(dict.fromkeys([*system.outputs(), *record]))
