"""`adcs study`: runs a study, compares it with print, and writes its report."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
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
from adcs.library.outcome import Claim, Outcome, as_json, tally, write_csv
from adcs.library.sections import manifest_of
from fmus.errors import AdcsError
from fmus.spelling import hint
from orchestration.isolation.folder import new_results
from orchestration.results import plots, report

app = command("study", "adcs study thakur", "adcs study six-dof --out results/paper --json")

_VERDICT_STYLE = {"reproduced": "green", "not reproduced": "red", "wrong in print": "yellow"}
_MISSES = 20  # shown at most
_CELLS = ("where", "claim", "settings", "printed", "ours")


@app.default
def study(
    name: Annotated[str, Parameter(help="Name of the study: " + ", ".join(STUDIES) + ".")],
    /,
    *,
    set_: Annotated[tuple[str, ...], Parameter(name="--set", metavar="CHOICE=VALUE")] = (),
    out: Path | None = None,
    force: bool = False,
    json_: Annotated[bool, Parameter(name="--json")] = False,
    all_: Annotated[bool, Parameter(name="--all")] = False,
) -> None:
    """Run a study: the printed numbers and claims of a document, with ours beside them.

    Shown are the verdicts counted by where the claims stand, and what is not reproduced; the report has everything.

    Args:
        set_: Change a choice of the study; may be repeated.
        out: Folder of report, pictures and CSV; one that holds results gets the next number, as in study-NAME-2.
            [default: results/study-NAME]
        force: Replace the results that the folder holds.
        json_: Print all claims as one JSON array.
        all_: Show all claims, not only what is not reproduced.
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
        print(as_json(outcome.rows(name)))
    else:
        _show(Console(), entry.title, outcome, all_)
        Console().print(f"report: {page}", soft_wrap=True)


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
    rows = outcome.rows(entry.name)
    write_csv(folder / "rows.csv", rows)
    (folder / "rows.json").write_text(as_json(rows) + "\n", encoding="utf-8")
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
        tally=tally(outcome.scored()),
        tally_note=_of_reading(outcome),
    )


def _slug(text: str) -> str:
    return "-".join("".join(c if c.isalnum() else " " for c in text.lower()).split()) or "figures"


def _show(console: Console, title: str, outcome: Outcome, everything: bool) -> None:
    """The verdicts by where the claims stand; the misses, or all claims; and the score."""
    console.print(_counts(title, outcome.claims))
    scored = outcome.scored()
    missed = [claim for claim in scored if claim.verdict == "not reproduced"]
    if everything:
        console.print(_claims("All claims", outcome.claims, [*_CELLS, "verdict"]))
    elif missed:
        console.print(_claims("Not reproduced", missed[:_MISSES], _CELLS))
        if len(missed) > _MISSES:
            console.print(f"and {len(missed) - _MISSES} more: the report has all, and so have --all and --json")
    score = ", ".join(f"[{_VERDICT_STYLE[v]}]{count} {v}[/]" for v, count in tally(scored).items())
    console.print(f"{len(scored)} claims{_of_reading(outcome)}: {score}")


def _of_reading(outcome: Outcome) -> str:
    return f", {outcome.counted}" if outcome.counted else ""


def _counts(title: str, claims: Sequence[Claim]) -> RichTable:
    """A line for each place, and for each reading of it where there are several, with what these come to."""
    readings = dict.fromkeys(claim.reading for claim in claims)
    shown = len(readings) > 1
    table = RichTable(title=title, title_justify="left", title_style="bold")
    for column in ("where", *(["reading"] if shown else [])):
        table.add_column(column, overflow="fold")
    for verdict in _VERDICT_STYLE:
        table.add_column(verdict, justify="right")

    def add(where: str, reading: str, those: Iterable[Claim]) -> None:
        counts = tally(those)
        cells = [f"[{style}]{counts[v]}[/]" if v in counts else "" for v, style in _VERDICT_STYLE.items()]
        table.add_row(*map(escape, (where, reading) if shown else (where,)), *cells)

    for where, reading in dict.fromkeys((claim.where, claim.reading) for claim in claims):
        add(where, reading, [claim for claim in claims if (claim.where, claim.reading) == (where, reading)])
    if shown:
        table.add_section()
        for reading in readings:
            add("all", reading, [claim for claim in claims if claim.reading == reading])
    return table


def _claims(title: str, claims: Sequence[Claim], columns: Sequence[str]) -> RichTable:
    """The claims; without the run they are of where that is but the reading."""
    columns = [name for name in columns if name != "settings" or any(c.settings not in ("", c.reading) for c in claims)]
    table = RichTable(title=title, title_justify="left", title_style="bold")
    for column in columns:
        table.add_column(column, overflow="fold")
    for claim in claims:
        cells = {
            "where": escape(claim.where),
            "claim": escape(claim.statement),
            "settings": escape(claim.settings),
            "printed": escape(report.format_cell(claim.printed)),
            "ours": escape(report.format_cell(claim.measure)),
            "verdict": f"[{_VERDICT_STYLE[claim.verdict]}]{claim.verdict}[/]",
        }
        table.add_row(*(cells[column] for column in columns))
    return table
