"""What is kept of a run, and where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from orchestration import expected
from orchestration.isolation.journal import Journal
from orchestration.results.result import Recording
from orchestration.results.stored import FileRecording
from orchestration.system import System


@dataclass(frozen=True)
class Save:
    """The variables `component.variable` of a row (None: all outputs), at every `every`-th point.

    They are kept in memory, or go `to` an HDF5 file as they come, for runs that do not fit into it.
    """

    names: Sequence[str] | None = None
    every: int = field(default=1, kw_only=True)
    to: str | Path | Journal | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if self.names is not None:
            expected.texts("Save: names", self.names)
            object.__setattr__(self, "names", tuple(self.names))
        object.__setattr__(self, "every", expected.count("Save: every", self.every, "a whole number of steps"))
        if self.to is not None and not isinstance(self.to, Journal):
            expected.path("Save: to", self.to)

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
