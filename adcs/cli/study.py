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
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn
from rich.table import Table as RichTable

from adcs.catalogue import STUDIES
from adcs.cli.command import at_work, command
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
    progress = Progress(
        TextColumn("{task.description:<44}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        console=Console(stderr=True),
        transient=True,
    )
    # The folder is refused now, rather than after a minute of work.
    with new_results(out or Path("results") / f"study-{name}", force) as results, progress, at_work():
        task = progress.add_task(entry.name, total=1.0)
        outcome, runs = entry.run(choices, lambda done, text: progress.update(task, completed=done, description=text))
        progress.update(task, completed=1.0, description="writing the report")
        command = " ".join(["adcs study", name, *(f"--set {change}" for change in set_)])
        page = write_files(results.given, entry, outcome, manifest_of(choices, runs), command)
        complete = [{"run": label, **manifest} for label, manifest in runs]
        (results.given / "runs.json").write_text(json.dumps(complete, indent=2) + "\n", encoding="utf-8")
    if json_:
        print(as_json(name, outcome.claims))
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
    write_csv(folder / "rows.csv", entry.name, outcome.claims)
    (folder / "rows.json").write_text(as_json(entry.name, outcome.claims) + "\n", encoding="utf-8")
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
    shown = outcome.claims if everything else [claim for claim in scored if not claim.holds and claim.holds is not None]
    if shown:
        most = len(shown) if everything else _MISSES
        console.print(_claims("All claims" if everything else "Not reproduced", shown[:most]))
        if len(shown) > most:
            console.print(f"and {len(shown) - most} more: the report has all, and so have --all and --json")
    score = ", ".join(f"[{_VERDICT_STYLE[v]}]{count} {v}[/]" for v, count in tally(scored).items())
    console.print(f"{len(scored)} claims{_of_reading(outcome)}: {score}")


def _of_reading(outcome: Outcome) -> str:
    return f", {outcome.counted}" if outcome.counted else ""


def _counts(title: str, claims: Sequence[Claim]) -> RichTable:
    """A line for each place, and for each reading of it where there are several."""
    table = RichTable(title=title, title_justify="left", title_style="bold")
    readings = any(claim.reading for claim in claims)
    for column in ("where", *(["reading"] if readings else [])):
        table.add_column(column, overflow="fold")
    for style in _VERDICT_STYLE:
        table.add_column(style, justify="right")
    for where, reading in dict.fromkeys((claim.where, claim.reading) for claim in claims):
        counts = tally(claim for claim in claims if (claim.where, claim.reading) == (where, reading))
        names = (where, reading) if readings else (where,)
        cells = [f"[{style}]{counts[v]}[/]" if v in counts else "" for v, style in _VERDICT_STYLE.items()]
        table.add_row(*map(escape, names), *cells)
    return table


def _claims(title: str, claims: Sequence[Claim]) -> RichTable:
    table = RichTable(title=title, title_justify="left", title_style="bold")
    for column in ("where", "claim", "settings", "printed", "ours", "verdict"):
        table.add_column(column, overflow="fold")
    for claim in claims:
        values = [report.format_cell(value) for value in (claim.printed, claim.measure)]
        verdict = f"[{_VERDICT_STYLE[claim.verdict]}]{claim.verdict}[/]"
        table.add_row(*map(escape, (claim.where, claim.statement, claim.settings, *values)), verdict)
    return table
