"""`python -m benchmarks`: measures all ways to run the loop in interleaved rounds; results go to results/benchmarks."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import cyclopts
from cyclopts import Parameter
from cyclopts.validators import Number
from rich.console import Console
from rich.progress import track

from adcs import AdcsError
from benchmarks import basilisk, report
from benchmarks.variants import VARIANTS


def main(
    rounds: Annotated[
        int, Parameter(validator=Number(gte=1), help="Interleaved rounds, of which medians are taken.")
    ] = 9,
    steps: Annotated[
        int, Parameter(validator=Number(gte=1000), help="Steps of the fastest loops in each round.")
    ] = 200_000,
    output: Annotated[Path, Parameter(help="Folder for the results.")] = Path("results/benchmarks"),
) -> None:
    """Time one exchange step in different ways, and the whole against Basilisk. CPU time, not wall time."""
    console = Console()
    try:
        note, python = "", None
        try:
            python = basilisk.interpreter()
        except AdcsError as error:
            note = str(error)
        for variant in VARIANTS:
            variant.run(max(1, round(variant.share * 1000)))  # builds what is not built, loads what is not loaded
        times, speeds = [], []
        for _ in track(range(rounds), "measuring", console=console, transient=True):
            times.append({v.key: v.run(max(1, round(v.share * steps))).cpu for v in VARIANTS})
            if python is not None:
                speeds.append(basilisk.compare(python, 200.0 * steps / 200_000))
        report.write(output, times, speeds, note, console)
    except AdcsError as error:
        Console(stderr=True).print(f"[red]error:[/red] {error}")
        raise SystemExit(1) from error


if __name__ == "__main__":
    cyclopts.run(main)
