"""What a study hands back: rows that compare with print, and what its report shows."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, Literal

from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber, Table
from orchestration.results.result import Result
from orchestration.running.method import CoSimulation
from orchestration.system import System

Verdict = Literal["reproduced", "not reproduced", "wrong in print"]
Progress = Callable[[float, str], None]
"""Called with the fraction done, in [0, 1], and what is being done."""


@dataclass(frozen=True)
class Row:
    """One printed number or claim beside ours. The names are fixed: they are what `adcs study --json` prints."""

    study: str
    table: str
    cell: str
    settings: str
    printed: float | str
    ours: float | str | None
    relative_error: float | None
    verdict: Verdict
    note: str = ""


def verdict(holds: bool) -> Verdict:
    """`reproduced` or `not reproduced`."""
    return "reproduced" if holds else "not reproduced"


@dataclass
class Outcome:
    """Rows, and panels, tables and key numbers for the report. Outcomes add up."""

    rows: list[Row] = field(default_factory=list)
    panels: list[Panel] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    key_numbers: list[KeyNumber] = field(default_factory=list)

    def __add__(self, other: Outcome) -> Outcome:
        return Outcome(
            self.rows + other.rows,
            self.panels + other.panels,
            self.tables + other.tables,
            self.key_numbers + other.key_numbers,
        )


class Runner:
    """Runs systems one after the other, says how far all is, and keeps the manifests."""

    def __init__(self, progress: Progress, runs: int, run: Callable[..., Result]) -> None:
        self._progress, self._runs, self._run, self._done = progress, runs, run, 0
        self.runs: list[tuple[str, Mapping[str, Any]]] = []  # label and manifest

    def __call__(self, label: str, system: System, **settings: Any) -> Result:
        """Run `system` with the keyword arguments of `run`: by co-simulation, unless they name another method."""
        self._progress(self._done / self._runs, label)
        result = self._run(
            system,
            **{"method": CoSimulation(), **settings},
            progress=lambda part: self._progress((self._done + part) / self._runs, label),
        )
        self._done += 1
        self.runs.append((label, result.manifest))
        return result


def manifest_of(choices: Any, runs: Sequence[tuple[str, Mapping[str, Any]]]) -> dict[str, Any]:
    """How the study was run, for its report: what the runs share once, and a line for each of them."""
    components = [component for _, manifest in runs for component in manifest["system"]["components"].values()]
    files = {c["file"]: {"fmi_version": c["fmi_version"], "sha256": c["sha256"]} for c in components}
    return {
        "started": runs[0][1]["started"],
        "choices": {
            f.name: {"value": getattr(choices, f.name), "meaning": f.metadata.get("help", "")} for f in fields(choices)
        },
        "FMUs": dict(sorted(files.items())),
        "versions": runs[0][1]["versions"],
        "runs": [
            {
                "run": label,
                "system": m["system"]["name"],
                **{name: value for name, value in m["settings"].items() if name != "record"},
                "seeds": m["seeds"],
                "CPU time [s]": m["timing"]["cpu_s"],
            }
            for label, m in runs
        ],
    }


def as_json(rows: Sequence[Row]) -> str:
    """One array with an object per row; what is not finite becomes null."""
    return json.dumps([{key: _finite(value) for key, value in asdict(row).items()} for row in rows], indent=2)


def write_csv(path: Path, rows: Sequence[Row]) -> None:
    """One line per row under the fixed names."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [column.name for column in fields(Row)])
        writer.writeheader()
        writer.writerows(asdict(row) for row in rows)


def claims_table(rows: Sequence[Row], title: str, group: str) -> Table:
    """The rows as a table of a report."""
    cells = [[r.cell, r.settings, r.printed, r.ours, r.relative_error, r.verdict, r.note] for r in rows]
    columns = ["claim", "settings", "printed", "ours", "relative error", "verdict", "note"]
    if all(row.relative_error is None for row in rows):
        columns, cells = [*columns[:4], *columns[5:]], [[*cell[:4], *cell[5:]] for cell in cells]
    return Table(title, columns, cells, group=group)


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
