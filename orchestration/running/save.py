"""What is kept of a run, and where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Self

from fmus.errors import AdcsError
from orchestration import expected
from orchestration.grid import whole_steps
from orchestration.isolation.journal import Journal
from orchestration.results.result import Recording
from orchestration.results.stored import FileRecording
from orchestration.system import System
from orchestration.times import Seconds


@dataclass(frozen=True)
class Save:
    """The variables `component.variable` of a row (None: all outputs), at every `every`-th point or every `rows` (s).

    They are kept in memory, or go `to` an HDF5 file as they come, for runs that do not fit into it.
    """

    names: Sequence[str] | None = None
    every: int = field(default=1, kw_only=True)
    rows: Seconds | None = field(default=None, kw_only=True)
    to: str | Path | Journal | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if self.names is not None:
            expected.texts("Save: names", self.names)
            object.__setattr__(self, "names", tuple(self.names))
        object.__setattr__(self, "every", expected.count("Save: every", self.every, "a whole number of steps"))
        if self.rows is not None:
            expected.seconds("Save: rows", self.rows)
            if self.every > 1:
                raise AdcsError("Save: every and rows say both how far rows are apart: leave one out")
        if self.to is not None and not isinstance(self.to, Journal):
            expected.path("Save: to", self.to)

    def spaced(self, step: float, exchanges: bool) -> tuple[float, Self]:
        """Return the time between two points (s), and this with its rows at some of them.

        Where nothing is exchanged at the points, they are the rows.
        """
        if self.rows is None:
            return step, self
        rows = expected.seconds("Save: rows", self.rows)
        if not exchanges:
            return rows, replace(self, rows=None)
        return step, replace(self, rows=None, every=whole_steps(rows, step, "rows"))

    def recording(self, system: System, rows: int) -> Recording:
        """Return what takes so many rows."""
        if isinstance(self.to, Journal):
            return self.to.record(system, self.names)
        return (
            Recording(system, self.names, rows) if self.to is None else FileRecording(system, self.names, Path(self.to))
        )

    def for_manifest(self) -> dict[str, Any]:
        """Return what the manifest has to know to repeat it."""
        names = {} if self.names is None else {"record": list(self.names)}
        return {**names, **({"record_every": self.every} if self.every > 1 else {})}

    @classmethod
    def of_manifest(cls, settings: dict[str, Any]) -> Self:
        """Take what `for_manifest` gave out of the settings of a manifest."""
        return cls(settings.pop("record", None), every=settings.pop("record_every", 1))
