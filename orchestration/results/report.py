"""Writes an HTML page that stands alone: key numbers, tables, interactive plots, and how it was run."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isnan
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from orchestration.process.writing import replacing
from orchestration.results.plots import Panel, plotly_figure

ABSENT = "\N{EN DASH}"


@dataclass(frozen=True)
class KeyNumber:
    """One number to be read first."""

    label: str
    value: float | int | str
    unit: str = ""
    note: str = ""


@dataclass(frozen=True)
class Table:
    """Rows of cells (text, numbers, None) under `columns`; `group` is a heading shared by several tables and panels.

    A table with a column `verdict` is shown before the panels of its group, with the verdicts in colours.
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Any]]
    note: str = ""
    group: str = ""


@dataclass(frozen=True)
class _Section:
    title: str
    anchor: str
    verdicts: list[Table]  # shown before the panels
    panels: list[Panel]
    tables: list[Table]  # shown after them


def write(
    path: str | Path,
    title: str,
    summary: str,
    panels: Sequence[Panel],
    tables: Sequence[Table] = (),
    manifest: Mapping[str, Any] | None = None,
    *,
    key_numbers: Sequence[KeyNumber] = (),
    command: str = "",
    tally: Mapping[Any, int] | None = None,
    tally_note: str = "",
) -> Path:
    """Writes the page and returns its path; the folder is made if it is missing.

    `manifest` may be nested as it likes: its scalars become a list, its mappings and lists of mappings tables.
    `command` is shown as the way to run again. `tally` counts verdicts, for the top; `tally_note` says of what.
    """
    import jinja2  # here, for commands without a report
    from plotly.offline import get_plotlyjs

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters.update(cell=format_cell, verdict=_verdict_class, numeric=_is_number, plot=_embedded_plot)
    manifest = manifest or {}
    page = environment.get_template("report.html.j2").render(
        title=title,
        summary=summary,
        key_numbers=key_numbers,
        tally=tally or {},
        tally_note=tally_note.strip(", "),
        sections=_sections(panels, tables),
        facts=_facts(manifest),
        manifest_tables=_manifest_tables(manifest),
        manifest_json=json.dumps(manifest, indent=2, default=_plain),
        command=command,
        plotly=Markup(get_plotlyjs()),  # the library's own code, not input
    )
    path = Path(path)
    with replacing(path) as name:
        name.write_text(page, encoding="utf-8")
    return path


def format_cell(value: Any) -> str:
    """A cell as people read it: four significant digits, a dash where there is nothing."""
    if value is None or (isinstance(value, float) and isnan(value)):
        return ABSENT
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (float, np.floating)):
        return f"{value:.4g}"
    if isinstance(value, (list, tuple)):
        return ", ".join(format_cell(item) for item in value) or ABSENT
    return str(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.number)) and not isinstance(value, bool)


def _verdict_class(value: Any) -> str:
    return {"reproduced": "good", "not reproduced": "bad", "wrong in print": "odd"}.get(str(value), "plain")


def _sections(panels: Sequence[Panel], tables: Sequence[Table]) -> list[_Section]:
    """Tables and panels gathered by group, in the order in which the groups first appear."""
    titles = list(dict.fromkeys([*(table.group for table in tables), *(panel.group for panel in panels)]))
    return [
        _Section(
            title,
            f"section-{number}",
            [table for table in tables if table.group == title and "verdict" in table.columns],
            [panel for panel in panels if panel.group == title],
            [table for table in tables if table.group == title and "verdict" not in table.columns],
        )
        for number, title in enumerate(titles)
    ]


def _embedded_plot(panel: Panel) -> Markup:
    text = json.dumps(plotly_figure(panel))
    return Markup(text.replace("<", "\\u003c"))  # no text in it can end the script element


def _is_records(value: Any) -> bool:
    return isinstance(value, (list, tuple)) and bool(value) and all(isinstance(item, Mapping) for item in value)


def _is_pairs(value: Any) -> bool:
    return (
        isinstance(value, (list, tuple))
        and bool(value)
        and all(isinstance(v, (list, tuple)) and len(v) == 2 for v in value)
    )


def _is_leaf(value: Any) -> bool:
    return not (isinstance(value, Mapping) or _is_records(value) or _is_pairs(value))


def _facts(manifest: Mapping[str, Any]) -> list[tuple[str, Any]]:
    return [(key, _plain(value)) for key, value in manifest.items() if _is_leaf(value)]


def _manifest_tables(manifest: Mapping[str, Any], above: str = "") -> list[Table]:
    """A table for each nested mapping, list of mappings, and list of pairs."""
    tables = []
    for key, value in manifest.items():
        title = f"{above}{key}"
        if _is_records(value):
            tables.append(_records(title, [], [([], item) for item in value]))
        elif _is_pairs(value):
            tables.append(Table(title, ["from", "to"], value))
        elif isinstance(value, Mapping) and value and all(isinstance(item, Mapping) for item in value.values()):
            tables.append(_records(title, ["name"], [([name], item) for name, item in value.items()]))
        elif isinstance(value, Mapping):
            if facts := _facts(value):
                tables.append(Table(title, ["name", "value"], facts))
            tables += _manifest_tables(value, f"{title}: ")
    return tables


def _records(title: str, first: list[str], records: list[tuple[list[str], Mapping[str, Any]]]) -> Table:
    """One row per mapping; the columns are the union of the keys."""
    columns = list(dict.fromkeys(key for _, item in records for key in item))
    return Table(
        title, [*first, *columns], [[*name, *(_leaf(item.get(key)) for key in columns)] for name, item in records]
    )


def _leaf(value: Any) -> Any:
    if isinstance(value, Mapping):
        return ", ".join(f"{key} = {format_cell(_plain(item))}" for key, item in value.items())
    return _plain(value)


def _plain(value: Any) -> Any:
    """Values that JSON does not know, as those it does."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    return value if isinstance(value, (str, int, float, bool, list, tuple, type(None))) else str(value)
