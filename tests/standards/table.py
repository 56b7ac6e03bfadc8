"""What is done with each element and attribute of the standards: `fmi2.csv`, `fmi3.csv`, `ssp1.csv`, `ssp2.csv`.

A line holds for each of its attributes of each of its elements, named as in `schemas`; `-` is an element itself.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from .schemas import ITSELF

HERE = Path(__file__).parent
DOES = {
    "read": "it has an effect",
    "checked": "it is looked at, by `adcs check` or as the file is opened, and has no other effect",
    "refused": "a file with it is refused, by name",
    "without effect": "a file with it does what it does without it",
}


@dataclass(frozen=True)
class Row:
    """A line of a table; `test` is relative to the folder of the tests."""

    elements: tuple[str, ...]
    attributes: tuple[str, ...]
    what: str
    why: str
    test: str

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """Every element and attribute for which it holds."""
        return [(element, attribute) for element in self.elements for attribute in self.attributes]


@cache
def rows(standard: str) -> tuple[Row, ...]:
    """Return the table of a standard."""
    with (HERE / f"{standard}.csv").open(encoding="utf-8", newline="") as file:
        return tuple(
            Row(
                tuple(line["elements"].split()),
                tuple(ITSELF if name == "-" else name for name in line["attributes"].split()),
                line["what"],
                line["why"],
                line["test"],
            )
            for line in csv.DictReader(file)
        )
