"""`python -m benchmarks.isolation`: what it costs that a run is in a process of its own, and its rows in a file."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from benchmarks import loop
from orchestration import Result, run
from orchestration.isolation.journal import Journal


def main(
    rounds: Annotated[int, typer.Option(min=1, help="Interleaved rounds, of which medians are taken.")] = 9,
    steps: Annotated[int, typer.Option(min=1000, help="Steps of a run.")] = 500_000,
) -> None:
    """Time a run in process, in process with a journal, and isolated; and the start of another process."""
    common: dict[str, Any] = {"stop_time": steps * loop.STEP, "step": loop.STEP, "record": ["plant.q_BN"]}

    def journaled() -> Result:
        with TemporaryDirectory(dir=Path.cwd()) as folder:
            return run(loop.system(), **common, journal=Journal(Path(folder) / "run.journal"))

    ways: dict[str, Callable[[], Result]] = {
        "in process": lambda: run(loop.system(), **common),
        "in process, rows in a file": journaled,
        "isolated": lambda: run(loop.system(), **common, isolated=True),
    }
    empty = {**common, "stop_time": loop.STEP}
    times: dict[str, list[float]] = {name: [] for name in ways}
    starts: list[tuple[float, float]] = []
    run(loop.system(), **empty)  # builds and loads what is not there
    for _ in range(rounds):
        for name, way in ways.items():
            timing = way().manifest["timing"]
            times[name].append(timing["cpu_s"] / steps)
        starts.append(tuple(a - b for a, b in zip(_cost(empty, True), _cost(empty, False), strict=True)))
    table = Table(title=f"{steps} steps, {rounds} rounds: CPU time", title_justify="left")
    for column in ("", "ns a step", "of in process"):
        table.add_column(column, justify="right" if column else "left")
    first = times["in process"]
    for name, values in times.items():
        ratio = median(v / f for v, f in zip(values, first, strict=True))
        table.add_row(name, f"{1e9 * median(values):.0f}", f"{ratio:.3f}")
    console = Console()
    console.print(table)
    cpu, wall = (median(values) for values in zip(*starts, strict=True))
    console.print(f"another process: {cpu:.2f} s of CPU time, {wall:.2f} s by the clock, once a run")


def _cost(settings: dict[str, Any], isolated: bool) -> tuple[float, float]:
    """CPU time of this process and the other, and time by the clock, s."""
    cpu, wall = _cpu(), time.perf_counter()
    run(loop.system(), **settings, isolated=isolated)
    return _cpu() - cpu, time.perf_counter() - wall


def _cpu() -> float:
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(u.ru_utime + u.ru_stime for u in used)


if __name__ == "__main__":
    typer.run(main)
