"""What people see of a run: its files, its report, and what is printed."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Sequence
from math import isfinite
from pathlib import Path
from typing import Any, Literal

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.table import Table

from adcs.cli.progress import progress
from orchestration.entry import SystemEntry
from orchestration.process import endings
from orchestration.results import plots, report
from orchestration.results.result import Result, RunFailed, RunInterrupted
from orchestration.running.accuracy import Estimate
from orchestration.running.hook import listed

Format = Literal["csv", "mat", "hdf5"]

RESULT_FILES: dict[Format, str] = {"csv": "result.csv", "mat": "result.mat", "hdf5": "result.h5"}
"""The name of a result's file of each kind."""


def run_progress() -> Progress:
    """Progress of a run, with the time that remains."""
    return progress(TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())


def write_files(result: Result, folder: Path, formats: Sequence[Format]) -> list[Path]:
    """Write the result in these formats, and the manifest."""
    write = {"csv": result.write_csv, "mat": result.write_mat, "hdf5": result.write_hdf5}
    wanted = {kind: folder / name for kind, name in RESULT_FILES.items() if kind in formats}
    for kind, path in wanted.items():
        write[kind](path)
    result.write_manifest(folder / "manifest.json")
    return [*wanted.values(), folder / "manifest.json"]


def command_line() -> str:
    """The command as it was given."""
    return shlex.join(["adcs", *sys.argv[1:]])


def write_report(
    entry: SystemEntry,
    result: Result,
    numbers: Sequence[report.KeyNumber],
    errors: Estimate | None,
    folder: Path,
    command: str | None = None,
    *,
    png: bool = False,
) -> list[Path]:
    """Write report.html, and report.png if it is wanted.

    `command` is what made the run, this command line by default.
    """
    panels = entry.figures(result)
    files = [folder / "report.html"]
    report.write(
        files[0],
        entry.name,
        ". ".join(text for text in (entry.description, entry.reference) if text),
        panels,
        [] if errors is None else [_error_table(errors)],
        manifest={key: value for key, value in result.manifest.items() if key != "error_estimate"},
        key_numbers=numbers,
        command=command or command_line(),
    )
    if png:
        files.append(folder / "report.png")
        plots.write_png(files[1], panels, entry.name)
    return files


def _error_table(errors: Estimate) -> report.Table:
    rows = [[d.variable, d.unit or "", d.most, d.at, d.rms] for d in errors.deviations]
    columns = ["variable", "unit", "largest", "at [s]", "root mean square"]
    return report.Table(f"Error of the exchange step, by {errors.method}: {errors.note}", columns, rows)


def as_json(result: Result, numbers: Sequence[report.KeyNumber], files: Sequence[Path]) -> str:
    """Return key numbers, outcome and files for a program."""
    optional = (
        "real_time",
        "algebraic_loops",
        "adaptive",
        "error_estimate",
        "commands",
        "mavlink",
        "tlog",
        "tlog_incomplete",
    )
    content: dict[str, Any] = {
        "system": result.system.name,
        "outcome": result.manifest["outcome"],
        "timing": result.manifest["timing"],
        **{name: result.manifest[name] for name in optional if name in result.manifest},
        **({"warnings": result.manifest["warnings"]} if result.manifest.get("warnings") else {}),
        "key_numbers": [{"label": n.label, "value": _finite(n.value), "unit": n.unit, "note": n.note} for n in numbers],
        "files": [str(file) for file in files],
    }
    return json.dumps(content, indent=2)


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not isfinite(value) else value


def show(result: Result, numbers: Sequence[report.KeyNumber], errors: Estimate | None, files: Sequence[Path]) -> None:
    """Print key numbers, errors, what else there is to say, and the files."""
    console = Console()
    if numbers:
        title = result.system.description or result.system.name
        _print_table(console, title, ["", "value", "unit", ""], [[n.label, n.value, n.unit, n.note] for n in numbers])
    if errors is not None:
        table = _error_table(errors)
        _print_table(console, table.title, list(table.columns), [list(row) for row in table.rows])
    for line in _lines(result):
        console.print(line, soft_wrap=True, highlight=False)
    for file in files:
        console.print(str(file), soft_wrap=True, highlight=False)


def _print_table(console: Console, title: str, columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    table = Table(title=escape(title), title_justify="left", title_style="bold")
    for i, column in enumerate(columns):
        number = any(isinstance(row[i], float) for row in rows)
        table.add_column(escape(column), justify="right" if number else "left", overflow="fold")
    for row in rows:
        table.add_row(*(report.format_cell(cell) for cell in row))
    console.print(table)


def _lines(result: Result) -> list[str]:
    """What else there is to say about a run, a line each."""
    manifest = result.manifest
    lines = []
    lines += [f"warning: {text}" for text in manifest.get("warnings", [])]
    if chosen := manifest.get("chosen"):
        how = "as one differential equation" if chosen["method"] == "model-exchange" else "by co-simulation"
        lines.append(f"solved {how}: {chosen['because']}")
    timing = manifest["timing"]
    if timing.get("simulated_s_per_cpu_s"):
        lines.append(
            f"{timing['simulated_s']:g} s in {timing['cpu_s']:.3g} s of CPU time, "
            f"{timing['simulated_s_per_cpu_s']:,.0f} times faster than real time"
        )
    if met := manifest["outcome"].get("met"):
        lines.append(f"ended at t = {met['time']:.9g} s, where {met['condition']}")
    elif "until" in manifest["settings"] and manifest["outcome"]["status"] == "complete":
        lines.append(f"the condition was not met: {' or '.join(listed(manifest['settings']['until']))}")
    if ended := manifest["outcome"].get("ended"):
        lines.append(f"ended at t = {ended['time']:.9g} s by {ended['component']}: {ended['message']}")
    if pace := manifest.get("real_time"):
        lines.append(
            f"paced at {pace['speed']:g} times real time: late by {1e3 * pace['late_median_s']:.3g} ms in the median, "
            f"{1e3 * pace['late_99_percent_s']:.3g} ms at 99 %, {1e3 * pace['late_most_s']:.3g} ms at most"
        )
    lines += [f"t = {t:.9g} s: {name} = {value} by {who}" for t, name, value, who in manifest.get("commands", [])[:10]]
    lines += [
        f"{each['endpoint']}: {each['sent']} messages sent, {each['not_sent']} not, {each['received']} received"
        for each in manifest.get("mavlink", {}).get("endpoints", [])
        if isinstance(each, dict)
    ]
    lines += [
        f"algebraic loop of {loop['path']}: solved {loop['solved']} times by {loop['method']} in "
        f"{loop['iterations'] / max(loop['solved'], 1):.3g} iterations on average, {loop['most_iterations']} at "
        f"most, relative residual {loop['residual']:.1e}"
        for loop in manifest.get("algebraic_loops", [])
    ]
    if adaptive := manifest.get("adaptive"):
        steps = ", ".join(f"{step} s in {n}" for step, n in adaptive["intervals_by_exchange_step"].items())
        lines.append(f"exchange step {steps} intervals; {adaptive['rejected']} tries rejected")
    return lines


def exit_code(stopped: RunFailed | RunInterrupted) -> int:
    """Say why a run stopped; return what the command ends with."""
    print(f"adcs: {stopped}", file=sys.stderr)
    return 1 if isinstance(stopped, RunFailed) else 128 + endings.last
