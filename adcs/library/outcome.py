"""What a study hands back: claims that compare with print, and what its report shows."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, get_args

from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber, Table

Verdict = Literal["reproduced", "not reproduced", "wrong in print"]
Progress = Callable[[float, str], None]
"""Called with the fraction done, in [0, 1], and what is being done."""


@dataclass(frozen=True)
class Claim:
    """A number or statement of a document: where, what it says, what is printed, what we measure, whether that holds.

    `holds` is None where print is wrong. `settings` says of which run; `reading` how the text was read, if that matters
    to all of the study; `note` by what it is judged; `error` is that of the measure relative to print.
    """

    where: str
    statement: str
    settings: str
    printed: float | str
    measure: float | str | None
    holds: bool | None
    note: str = ""
    error: float | None = None
    reading: str = ""

    @property
    def verdict(self) -> Verdict:
        """What is said of it."""
        if self.holds is None:
            return "wrong in print"
        return "reproduced" if self.holds else "not reproduced"


Shown = Claim | Panel | Table | KeyNumber
"""What a section of a study shows."""


@dataclass
class Outcome:
    """Claims, and panels, tables and key numbers for the report. Outcomes add up.

    Where claims are judged in several readings of the text, `counted` names the one that makes the score.
    """

    claims: list[Claim] = field(default_factory=list)
    panels: list[Panel] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    key_numbers: list[KeyNumber] = field(default_factory=list)
    counted: str = ""

    @classmethod
    def of(cls, shown: Iterable[Shown], counted: str = "") -> Outcome:
        """What a section shows, by its kind."""
        things = list(shown)
        return cls(
            [thing for thing in things if isinstance(thing, Claim)],
            [thing for thing in things if isinstance(thing, Panel)],
            [thing for thing in things if isinstance(thing, Table)],
            [thing for thing in things if isinstance(thing, KeyNumber)],
            counted,
        )

    def __add__(self, other: Outcome) -> Outcome:
        return Outcome(
            self.claims + other.claims,
            self.panels + other.panels,
            self.tables + other.tables,
            self.key_numbers + other.key_numbers,
            self.counted or other.counted,
        )

    def within(self, group: str, title: str) -> Outcome:
        """The same under a heading of the report, its claims as a table of this title; "": they are shown otherwise."""
        tables = [claims_table(self.claims, title), *self.tables] if title and self.claims else self.tables
        return replace(
            self,
            panels=[panel if panel.group else replace(panel, group=group) for panel in self.panels],
            tables=[table if table.group else replace(table, group=group) for table in tables],
        )

    def scored(self) -> list[Claim]:
        """The claims that make the score: those of the reading that counts, and those of no reading."""
        return [claim for claim in self.claims if self._counts(claim)]

    def rows(self, study: str) -> list[dict[str, Any]]:
        """The claims as `rows.json` and `rows.csv` have them; `counted` says whether one belongs to the score."""
        return [
            {
                "study": study,
                "table": claim.where,
                "cell": claim.statement,
                "settings": claim.settings,
                "reading": claim.reading,
                "counted": self._counts(claim),
                "printed": claim.printed,
                "ours": claim.measure,
                "relative_error": claim.error,
                "verdict": claim.verdict,
                "note": claim.note,
            }
            for claim in self.claims
        ]

    def _counts(self, claim: Claim) -> bool:
        return claim.reading in ("", self.counted)


def tally(claims: Iterable[Claim]) -> dict[Verdict, int]:
    """How many claims have each verdict, of those that occur."""
    verdicts = [claim.verdict for claim in claims]
    return {verdict: verdicts.count(verdict) for verdict in get_args(Verdict) if verdict in verdicts}


def as_json(rows: Sequence[Mapping[str, Any]]) -> str:
    """One array with an object per row; what is not finite becomes null."""
    return json.dumps([{key: _finite(value) for key, value in row.items()} for row in rows], indent=2)


def write_csv(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """One line per row, under its keys."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]) if rows else [])
        writer.writeheader()
        writer.writerows(rows)


def claims_table(claims: Sequence[Claim], title: str, group: str = "") -> Table:
    """The claims as a table of a report."""
    cells = [[c.statement, c.settings, c.printed, c.measure, c.error, c.verdict, c.note] for c in claims]
    columns = ["claim", "settings", "printed", "ours", "relative error", "verdict", "note"]
    if all(claim.error is None for claim in claims):
        columns, cells = [*columns[:4], *columns[5:]], [[*cell[:4], *cell[5:]] for cell in cells]
    return Table(title, columns, cells, group=group)


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
