"""A run before its components are there."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from orchestration.fmu.file import FmiVersion
from orchestration.grid import Grid
from orchestration.plan.changing import checked_change
from orchestration.plan.lowering import Floats
from orchestration.plan.outside import Source, Sources
from orchestration.results.result import Recording
from orchestration.running.change import Change
from orchestration.running.checkpoint import Checkpoint
from orchestration.running.method import Method
from orchestration.running.save import Save
from orchestration.system import System


@dataclass
class Outline:
    """What is to be run: `first` is the point at which it begins.

    What takes part in the run adds to the rest, before any component is there.
    """

    system: System
    grid: Grid
    recording: Recording
    method: Method
    save: Save
    fmi_version: FmiVersion
    first: int = 0
    times: Floats = field(default_factory=lambda: np.empty(0))
    """Of all rows that there may be [s]."""
    saved: Checkpoint | None = None
    """The state from which it goes on."""
    may_go_on: bool = False
    """Whether it may go on after its stop time: then components are told of none."""
    warnings: list[str] = field(default_factory=list)
    """For the manifest."""
    changes: list[Change] = field(default_factory=list)
    """Those that are known before the run."""
    sources: list[Source] = field(default_factory=list)
    """What gives inputs their values at every point."""
    files: dict[str, Path] = field(default_factory=dict)
    """What is read, for the manifest."""
    about: dict[str, Any] = field(default_factory=dict)
    """Further entries of the manifest."""

    @classmethod
    def of(
        cls,
        system: System,
        grid: Grid,
        method: Method,
        save: Save,
        fmi_version: FmiVersion,
        resume: str | Path | None = None,
    ) -> Outline:
        """Put it together; AdcsError if the run cannot go on from the checkpoint `resume`."""
        saved = None if resume is None else Checkpoint.read(Path(resume))
        first = 0 if saved is None else saved.k
        if saved is not None and method.unsaved:
            raise AdcsError(f"resume: not together with {method.unsaved}")
        if first > grid.full:
            stop = grid.time(grid.steps)
            raise AdcsError(f"{resume} is at t = {grid.time(first):g} s, after stop_time = {stop:g} s")
        times = grid.places(first, save.every)
        recording = save.recording(system, len(times))
        made = cls(system, grid, recording, method, save, fmi_version, first, times, saved, saved is not None)
        if resume is not None:
            made.reads("resume", Path(resume))
        return made

    def reads(self, name: str, path: Path) -> None:
        """Note a file that is read, for the manifest; several of one name are numbered."""
        others = sum(other.partition("-")[0] == name for other in self.files)
        self.files[f"{name}-{others + 1}" if others else name] = path

    def check(self) -> None:
        """Refuse changes that could not be made when their time comes, with all that is known now."""
        names = [name for source in self.sources for name in source.names]
        for change in self.changes:
            checked_change(self.system, names, change.name, change.value)

    @property
    def source(self) -> Source | None:
        """What gives inputs their values at every point, if anything does."""
        return Sources(self.sources, lambda name: len(self.system.end(name).elements)) if self.sources else None
