"""`python -m benchmarks.opening`: CPU time of a run of one step, which is all opening and closing."""

from __future__ import annotations

import json
import time
from pathlib import Path
from statistics import median
from typing import Annotated

import cyclopts
from cyclopts import Parameter
from cyclopts.validators import Number
from rich.console import Console
from rich.table import Table

from adcs import System, run
from benchmarks import loop

SYSTEMS = {"rigid body under PD tracking": loop.system(), "observer-pd": "observer-pd"}


def one_step(system: System | str) -> float:
    """CPU time [s] of a run of one step."""
    began = time.process_time()
    run(system, stop_time=loop.STEP, step=loop.STEP)
    return time.process_time() - began


def main(
    rounds: Annotated[int, Parameter(validator=Number(gte=1), help="Interleaved rounds.")] = 30,
    output: Annotated[Path, Parameter(help="Folder for the results.")] = Path("results/benchmarks"),
) -> None:
    """Time runs of one step: the first of a process, and medians of those that follow."""
    first = {name: one_step(system) for name, system in SYSTEMS.items()}
    times = [{name: one_step(system) for name, system in SYSTEMS.items()} for _ in range(rounds)]
    table = Table(title=f"A run of one step, CPU time in ms, median of {rounds} rounds", title_justify="left")
    for column in ("system", "first", "later"):
        table.add_column(column, justify="left" if column == "system" else "right")
    found = {name: {"first_s": first[name], "later_s": median(t[name] for t in times)} for name in SYSTEMS}
    for name, taken in found.items():
        table.add_row(name, *(f"{1e3 * taken[which]:.1f}" for which in ("first_s", "later_s")))
    Console().print(table)
    output.mkdir(parents=True, exist_ok=True)
    (output / "opening.json").write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    cyclopts.run(main)
