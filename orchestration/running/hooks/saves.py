"""Checkpoints of a run: every so often, and at its end."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from fmus.errors import AdcsError
from orchestration import expected
from orchestration.grid import whole_steps
from orchestration.running import checkpoint as file
from orchestration.running.hook import MOST, Hook, Watched, overrides, together
from orchestration.running.outline import Outline
from orchestration.running.simulation import Simulation
from orchestration.times import Seconds


class Saves(Hook):
    """The state is saved to a file at the end of the run, and every so many seconds before.

    A file that cannot be written does not end the run: one line on stderr says so at once, and `notes` at the end.
    """

    _repeatable = True

    def __init__(self, path: str | Path, every: Seconds | None = None) -> None:
        """`every` is in s of simulated time."""
        expected.path("checkpoint", path)
        self._path = Path(path)
        self._seconds = None if every is None else expected.seconds("checkpoint: every", every)
        self._every: int | None = None
        self._one_by_one = False
        self._missing: list[float] = []  # s, times of those that could not be written
        self._trouble = ""

    def __repr__(self) -> str:
        return f"<Saves path = {str(self._path)!r}{'' if self._seconds is None else f' every = {self._seconds:g} s'}>"

    def prepare(self, outline: Outline) -> None:
        """Refuse what is no time."""
        self._every, self._missing, self._trouble = None, [], ""
        if self._seconds is not None:
            if not self._seconds > 0:
                raise AdcsError(f"checkpoint: every = {self._seconds:g} s: expected a positive time")
            self._every = whole_steps(self._seconds, outline.grid.step, "checkpoint: every")
        self._method = outline.method
        if unsaved := self._method.unsaved:
            raise AdcsError(f"checkpoint: not together with {unsaved}")
        if self._path.is_dir():
            raise AdcsError(f"checkpoint = {self._path}: it is a folder: give the name of a file in it")
        if self._path.is_file() and not file.is_checkpoint(self._path):
            raise AdcsError(f"checkpoint = {self._path}: a file that is no checkpoint is there: give another name")
        outline.may_go_on = True
        outline.about = together(outline.about, {"checkpoint": {"path": str(self._path), "every": self._seconds}})

    def begin(self, simulation: Simulation, hooks: Sequence[Hook], watched: Watched) -> None:
        """Refuse by name what cannot be saved, or not then."""
        self._simulation, self._watched = simulation, watched
        file.check(simulation, self._path)
        self._one_by_one = any(
            overrides(hook, "met") for hook in hooks
        )  # the state has to be that of the row that meets it
        if self._one_by_one and any(component.every > 1 for component in simulation.system.components.values()):
            raise AdcsError("checkpoint: not together with until, where a component communicates at some points only")
        for k in (simulation.grid.full, *([] if self._every is None else [self._every])):
            if not file.aligned(simulation, k):
                raise file.not_aligned(simulation, k)

    def ahead(self, k: int) -> int:
        """Go on to the next point at which to save."""
        if self._one_by_one:
            return 1
        return MOST if self._every is None else self._every - k % self._every

    def after(self, point: int, time: float) -> None:
        """Save, if it is time to, or if a last step comes that is shorter, since its end is on no grid."""
        simulation, k = self._simulation, self._simulation.k
        if point == simulation.grid.full and simulation.grid.shorter:
            self._save(point)
        elif self._every is not None and k % self._every == 0 and k <= simulation.grid.full:
            self._save(k)

    def end(self) -> None:
        """Save where the run ended, or before a last step that is shorter."""
        simulation = self._simulation
        if simulation.k > simulation.grid.full and simulation.grid.shorter:
            return
        k = min(simulation.k, simulation.grid.full)
        if file.aligned(simulation, k):  # it was interrupted, if not
            self._save(k)

    def _save(self, k: int) -> None:
        content = self._watched(partial(file.content, self._simulation, k, self._method))
        try:
            file.write(content, self._path)
        except AdcsError as error:
            if not self._trouble:
                self._trouble = str(error)
                print(f"adcs: a checkpoint is missing, the run goes on: {error}", file=sys.stderr)
            if (time := self._simulation.grid.time(k)) not in self._missing[-1:]:
                self._missing.append(time)

    def notes(self) -> list[str]:
        """Say which checkpoints are missing."""
        if not self._missing:
            return []
        times = ", ".join([f"{time:.9g}" for time in self._missing[:3]] + ["..."] * (len(self._missing) > 3))
        return [f"no checkpoint at t = {times} s: {self._trouble}"]


checkpoint = Saves
