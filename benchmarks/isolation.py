"""`python -m benchmarks.isolation`: what it costs that a run is in a process of its own, with its rows in a file."""

from __future__ import annotations

import time
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import cyclopts
import numpy as np
from cyclopts import Parameter
from cyclopts.validators import Number
from rich.console import Console
from rich.table import Table

from adcs import Session, run
from benchmarks import loop
from orchestration.grid import Grid
from orchestration.isolation.journal import Journal

_SLICE = 2000  # steps: short enough that many are not interrupted
_SLICES = 200
_SETTINGS: dict[str, Any] = {"stop_time": loop.STEP, "step": loop.STEP}


def step_in_memory() -> float:
    """Time of a step [s] whose rows go to memory, in the fastest slice."""
    with Session(loop.system(), step=loop.STEP) as simulation:
        return _fastest(simulation, np.zeros((_SLICE * _SLICES, len(simulation.row))))


def step_in_journal() -> float:
    """Time of a step [s] whose rows go to a journal on the disk, in the fastest slice."""
    with TemporaryDirectory(dir=Path.cwd()) as folder:
        journal = Journal(Path(folder) / "run.journal")
        recording = journal.record(loop.system(), None)
        rows = _SLICE * _SLICES
        journal.begin(loop.system(), Grid(0.0, 1.0, rows - 1), {})
        with Session(loop.system(), step=loop.STEP, where=journal.where) as simulation:
            taken = _fastest(simulation, recording.room(rows))
        journal.close(remove=True)
    return taken


def _fastest(simulation: Session, rows: Any) -> float:
    taken = []
    for first in range(0, len(rows), _SLICE):
        began = time.perf_counter()
        simulation.loop.steps(0.0, loop.STEP, first, _SLICE, 2**53, None, rows[first : first + _SLICE])
        taken.append((time.perf_counter() - began) / _SLICE)
    return min(taken)


def start() -> float:
    """Time [s] by which a run of one step takes longer in a process of its own."""
    taken = []
    for isolated in (False, True):
        began = time.perf_counter()
        run(loop.system(), **_SETTINGS, isolated=isolated)
        taken.append(time.perf_counter() - began)
    return taken[1] - taken[0]


def main(rounds: Annotated[int, Parameter(validator=Number(gte=1), help="Interleaved rounds.")] = 9) -> None:
    """Compare both kinds of rows, in rounds that take turns, and time the start of another process."""
    measured = [(step_in_memory(), step_in_journal(), start()) for _ in range(rounds)]
    memory, journal, starts = (np.array(column) for column in zip(*measured, strict=True))
    table = Table(title=f"One step, all outputs recorded: fastest of {rounds} rounds", title_justify="left")
    for column in ("rows in", "ns a step", "of memory"):
        table.add_column(column, justify="left" if column == "rows in" else "right")
    for name, times in (("memory", memory), ("a journal on the disk", journal)):
        table.add_row(name, f"{1e9 * times.min():.1f}", f"{times.min() / memory.min():.3f}")
    console = Console()
    console.print(table)
    console.print(f"start of another process: {median(starts):.2f} s in the median, {starts.min():.2f} s at best")


if __name__ == "__main__":
    cyclopts.run(main)
