"""`make attack`: attacks the product and counts what survives; docs/robustness.md has the table.

A file in `rows/` with a list `ATTACKS` adds rows to it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Attack:
    """A row of the table. `tries` yields a text for each try: empty where it was survived, else what went wrong."""

    what: str
    survived: str
    """What counts as survival."""

    tries: Callable[[Path], Iterable[str]]
    """Gets an empty folder."""
