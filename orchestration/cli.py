"""The command `adcs`: what fmus and studies bring, and `run`."""

from __future__ import annotations

import json as json_
import shlex
import sys
from collections.abc import Sequence
from math import isfinite
from pathlib import Path
from typing import Annotated, Any, Literal

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.table import Table

import fmus.cli
import studies.cli
from fmus.errors import AdcsError
from orchestration import plots, report
from orchestration.cosim import Stepping
from orchestration.coupled import SolverName
from orchestration.fmu import Kind
from orchestration.results import Result, RunFailed, RunInterrupted
from orchestration.run import run as run_system
from orchestration.system import System
from orchestration.values import parse_value
from studies.registry import SYSTEMS, SystemEntry

_REPORT_FILES = ("report.html", "report.png")

app = typer.Typer(
    help="Spacecraft attitude control as native FMI components: build them, wire them, run them.",
    no_args_is_help=True,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
)
for _part in (fmus.cli.app, studies.cli.app):
    app.registered_commands += _part.registered_commands


@app.command(epilog="Example: adcs run observer-pd --step 0.001 --set tracker.half_angle=0.05deg --out results/noisy")
def run(
    system: Annotated[str, typer.Argument(help=f"Name of the system: {', '.join(SYSTEMS)}.")],
    method: Annotated[
        Kind, typer.Option(help="Exchange values every step, or integrate all components as one differential equation.")
    ] = "co-simulation",
    solver: Annotated[SolverName, typer.Option(help="Integrator of model-exchange.")] = "DOP853",
    step: Annotated[float | None, typer.Option(help="Time between two exchanges and two rows [s].")] = None,
    stop: Annotated[float | None, typer.Option(help="Stop time [s].")] = None,
    fmi: Annotated[Literal["2", "3"], typer.Option(help="FMI version of the components.")] = "2",
    stepping: Annotated[
        Stepping, typer.Option(help="Loop of co-simulation; both give the same to the last bit.")
    ] = "compiled",
    record: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Write this variable only; may be repeated. [default: all outputs]"),
    ] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="Start value of a COMPONENT.VARIABLE; may be repeated. VALUE is 1.5, 0.05deg, 1,2,3 or [[1,2],[3,4]].",
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results. [default: results/SYSTEM]")] = None,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write no report.html and report.png.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print key numbers, outcome and files as JSON.")] = False,
) -> None:
    """Run a system: write result.csv, result.mat, manifest.json, report.html, report.png, and print the key numbers."""
    entry = SYSTEMS.get(system)
    if entry is None:
        raise AdcsError(f"no system {system!r}: choose one of {', '.join(SYSTEMS)}")
    built = entry.build()
    for assignment in set_ or []:
        _assign(built, assignment)
    folder = out or Path("results") / system
    folder.mkdir(parents=True, exist_ok=True)  # refused now, rather than after the run
    with _progress() as progress:
        for name in _REPORT_FILES:  # those of an earlier run would not belong to the other files
            (folder / name).unlink(missing_ok=True)
        task = progress.add_task(system, total=1.0)
        stopped: RunFailed | RunInterrupted | None = None
        try:
            result = run_system(
                built,
                stop_time=entry.stop_time if stop is None else stop,
                step=entry.step if step is None else step,
                method=method,
                solver=solver,
                fmi_version="2.0" if fmi == "2" else "3.0",
                stepping=stepping,
                record=_with_outputs(built, record),  # report and key numbers need more than what is written
                progress=lambda part: progress.update(task, completed=part),
            )
        except (RunFailed, RunInterrupted) as error:
            stopped, result = error, error.result
        progress.update(task, completed=1.0, description="writing the results")
        files = _write(result if record is None else result.select(record), folder)
        numbers = [] if stopped else list(entry.key_numbers(result))
        if not (stopped or no_report):
            files += _write_report(entry, result, numbers, folder)
    if json:
        typer.echo(_as_json(result, numbers, files))
    else:
        _show(result, numbers, files)
    if stopped is not None:
        _complain(stopped)
        raise typer.Exit(1 if isinstance(stopped, RunFailed) else 130)


def main() -> None:
    """Run the command line; an AdcsError becomes one line and exit code 1."""
    try:
        app(prog_name="adcs")
    except AdcsError as error:
        _complain(error)
        sys.exit(1)


def _complain(error: BaseException) -> None:
    print(f"adcs: {error}", file=sys.stderr)


def _progress() -> Progress:
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    return Progress(*columns, console=Console(stderr=True), transient=True)


def _assign(system: System, assignment: str) -> None:
    name, equals, text = assignment.partition("=")
    if not equals:
        raise AdcsError(f"--set {assignment}: expected COMPONENT.VARIABLE=VALUE")
    component, port = system.port(name)
    system.set(name, parse_value(system.components[component].fmu, port, text))


def _with_outputs(system: System, record: Sequence[str] | None) -> list[str] | None:
    return None if record is None else list(dict.fromkeys([*system.outputs(), *record]))


def _write(result: Result, folder: Path) -> list[Path]:
    files = [folder / name for name in ("result.csv", "result.mat", "manifest.json")]
    for write, file in zip((result.write_csv, result.write_mat, result.write_manifest), files, strict=True):
        write(file)
    return files


def _write_report(entry: SystemEntry, result: Result, numbers: Sequence[report.KeyNumber], folder: Path) -> list[Path]:
    panels = entry.figures(result)
    files = [folder / name for name in _REPORT_FILES]
    report.write(
        files[0],
        entry.name,
        f"{entry.description}. {entry.reference}",
        panels,
        manifest=result.manifest,
        key_numbers=numbers,
        command=shlex.join(["adcs", *sys.argv[1:]]),
    )
    plots.write_png(files[1], panels, entry.name)
    return files


def _as_json(result: Result, numbers: Sequence[report.KeyNumber], files: Sequence[Path]) -> str:
    content: dict[str, Any] = {
        "system": result.system.name,
        "outcome": result.manifest["outcome"],
        "timing": result.manifest["timing"],
        "key_numbers": [{"label": n.label, "value": _finite(n.value), "unit": n.unit, "note": n.note} for n in numbers],
        "files": [str(file) for file in files],
    }
    return json_.dumps(content, indent=2)


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not isfinite(value) else value


def _show(result: Result, numbers: Sequence[report.KeyNumber], files: Sequence[Path]) -> None:
    console = Console()
    if numbers:
        table = Table(title=result.system.description or result.system.name, title_justify="left", title_style="bold")
        for column, justify in (("", "left"), ("value", "right"), ("unit", "left"), ("", "left")):
            table.add_column(column, justify=justify)  # type: ignore[arg-type]
        for number in numbers:
            table.add_row(number.label, report.format_cell(number.value), number.unit, number.note)
        console.print(table)
    timing = result.manifest["timing"]
    if timing.get("simulated_s_per_cpu_s"):
        console.print(
            f"{timing['simulated_s']:g} s in {timing['cpu_s']:.3g} s of CPU time, "
            f"{timing['simulated_s_per_cpu_s']:,.0f} times faster than real time"
        )
    for file in files:
        console.print(str(file), soft_wrap=True, highlight=False)
