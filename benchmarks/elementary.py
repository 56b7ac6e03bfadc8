"""`python -m benchmarks.elementary`: sin, cos, exp and log of src/math beside those of the C library."""

from __future__ import annotations

import json
import subprocess
from functools import cache
from pathlib import Path
from statistics import median
from typing import Annotated

import cyclopts
from cyclopts import Parameter
from cyclopts.validators import Number
from rich.console import Console
from rich.progress import track
from rich.table import Table

from fmus.paths import BUILD
from fmus.toolchain import compile_step, host, program_step, run_steps

Times = tuple[float, float, float, float]
"""Nanoseconds per call: ours and theirs one after the other, ours and theirs independent of each other."""


@cache
def program() -> Path:
    """The compiled measurement, with the compiler and flags of the FMUs."""
    target, folder = host(), BUILD / "benchmarks"
    compiled = compile_step(Path(__file__).with_suffix(".cpp"), folder / "elementary.o", target)
    linked = program_step([compiled.output], folder / "elementary", target)
    run_steps([compiled])
    run_steps([linked])
    return linked.output


def measure_round() -> dict[str, Times]:
    """The times of every function."""
    printed = subprocess.run([program()], capture_output=True, text=True, check=True).stdout
    lines = (line.split() for line in printed.splitlines())
    return {name: (float(a), float(b), float(c), float(d)) for name, a, b, c, d in lines}


def main(
    rounds: Annotated[int, Parameter(validator=Number(gte=1), help="Rounds, of which medians are taken.")] = 7,
    output: Annotated[Path, Parameter(help="Folder for the results.")] = Path("results/benchmarks"),
) -> None:
    """CPU time per call, and its ratio to the C library's within a round."""
    console = Console()
    measured = [measure_round() for _ in track(range(rounds), "measuring", console=console, transient=True)]
    table = Table(title=f"ns per call, medians of {rounds} rounds")
    for i, column in enumerate(("", "chained", "C library", "ratio", "independent", "C library", "ratio")):
        table.add_column(column, justify="right" if i else "left")
    found = {}
    for name in measured[0]:
        columns = list(zip(*(r[name] for r in measured), strict=True))
        a, b, c, d = map(median, columns)
        chained, independent = (
            median(ours / theirs for ours, theirs in zip(columns[i], columns[i + 1], strict=True)) for i in (0, 2)
        )
        table.add_row(
            name, *(f"{x:.1f}" for x in (a, b)), f"{chained:.2f}", f"{c:.1f}", f"{d:.1f}", f"{independent:.2f}"
        )
        found[name] = {"chained": {"ns": a, "ratio": chained}, "independent": {"ns": c, "ratio": independent}}
    console.print(table)
    output.mkdir(parents=True, exist_ok=True)
    (output / "elementary.json").write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    cyclopts.run(main)
