"""`adcs study`: runs a study, compares it with print, and writes its report."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn
from rich.table import Table as RichTable

from adcs.catalogue import STUDIES
from adcs.cli.command import at_work, command
from adcs.cli.progress import progress
from adcs.library.entry import StudyEntry
from adcs.library.outcome import Outcome, Row, as_json, manifest_of, write_csv
from fmus.errors import AdcsError
from fmus.spelling import hint
from orchestration.isolation.folder import new_results
from orchestration.results import plots, report

app = command("study", "adcs study thakur", "adcs study six-dof --out results/paper --json")

_VERDICT_STYLE = {"reproduced": "green", "not reproduced": "red", "wrong in print": "yellow"}


@app.default
def study(
    name: Annotated[str, Parameter(help="Name of the study: " + ", ".join(STUDIES) + ".")],
    /,
    *,
    set_: Annotated[tuple[str, ...], Parameter(name="--set", metavar="CHOICE=VALUE")] = (),
    out: Path | None = None,
    force: bool = False,
    json_: Annotated[bool, Parameter(name="--json")] = False,
) -> None:
    """Run a study: the printed numbers and claims of a document, with ours beside them.

    Args:
        set_: Change a choice of the study; may be repeated.
        out: Folder of report, pictures and CSV; one that holds results gets the next number, as in study-NAME-2.
            [default: results/study-NAME]
        force: Replace the results that the folder holds.
        json_: Print the rows as one JSON array.
    """
    entry = STUDIES.get(name)
    if entry is None:
        raise AdcsError(f"no study {name!r}: {hint(name, STUDIES, 'choose one of')}")
    choices = with_changes(entry.choices(), set_)
    bar = progress(TextColumn("{task.description:<44}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
    # The folder is refused now, rather than after a minute of work.
    with new_results(out or Path("results") / f"study-{name}", force) as results, bar, at_work():
        task = bar.add_task(entry.name, total=1.0)
        outcome, runs = entry.run(choices, lambda done, text: bar.update(task, completed=done, description=text))
        bar.update(task, completed=1.0, description="writing the report")
        command = " ".join(["adcs study", name, *(f"--set {change}" for change in set_)])
        page = write_files(results.given, entry, outcome, manifest_of(choices, runs), command)
        complete = [{"run": label, **manifest} for label, manifest in runs]
        (results.given / "runs.json").write_text(json.dumps(complete, indent=2) + "\n", encoding="utf-8")
    if json_:
        print(as_json(outcome.rows))
    else:
        console = Console()
        console.print(_table(entry.title, outcome.rows))
        counts = {v: sum(row.verdict == v for row in outcome.rows) for v in _VERDICT_STYLE}
        console.print(", ".join(f"[{_VERDICT_STYLE[v]}]{count} {v}[/]" for v, count in counts.items() if count))
        console.print(f"report: {page}", soft_wrap=True)


def with_changes(choices: Any, changes: Sequence[str]) -> Any:
    """The dataclass `choices` with `NAME=VALUE` applied to it; numbers only."""
    known = {field.name: type(getattr(choices, field.name)) for field in fields(choices)}
    values = {}
    for change in changes:
        name, _, text = change.partition("=")
        if name not in known:
            raise AdcsError(
                f"no choice {name!r}: choose one of {', '.join(known)}, as in --set {next(iter(known))}=VALUE"
            )
        try:
            values[name] = known[name](text)
        except ValueError:
            raise AdcsError(f"choice {name} = {text!r}: expected a number ({known[name].__name__})") from None
    return replace(choices, **values)


def write_files(folder: Path, entry: StudyEntry, outcome: Outcome, manifest: dict[str, Any], command: str) -> Path:
    """Write `index.html`, `rows.csv`, `rows.json` and, if Matplotlib is there, a PNG per group; return the page."""
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(folder / "rows.csv", outcome.rows)
    (folder / "rows.json").write_text(as_json(outcome.rows) + "\n", encoding="utf-8")
    for group in dict.fromkeys(panel.group for panel in outcome.panels if plots.can_draw()):
        panels = [panel for panel in outcome.panels if panel.group == group]
        plots.write_png(folder / f"{_slug(group)}.png", panels, group)
    return report.write(
        folder / "index.html",
        entry.title,
        entry.summary,
        outcome.panels,
        outcome.tables,
        manifest,
        key_numbers=outcome.key_numbers,
        command=command,
    )


def _slug(text: str) -> str:
    return "-".join("".join(c if c.isalnum() else " " for c in text.lower()).split()) or "figures"


def _table(title: str, rows: list[Row]) -> RichTable:
    table = RichTable(title=title, title_justify="left", title_style="bold")
    for column in ("where", "claim", "settings", "printed", "ours", "verdict"):
        table.add_column(column, overflow="fold")
    for row in rows:
        cells = [row.table, row.cell, row.settings, report.format_cell(row.printed), report.format_cell(row.ours)]
        table.add_row(*map(escape, cells), f"[{_VERDICT_STYLE[row.verdict]}]{row.verdict}[/]")
    return table
