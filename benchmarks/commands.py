"""`python -m benchmarks.commands`: CPU time of whole commands, the start of Python and all that they start included."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Annotated

import cyclopts
from cyclopts import Parameter
from cyclopts.validators import Number
from rich.console import Console
from rich.table import Table

PYTHON = {"python -c pass": ["-c", "pass"], "import adcs.run": ["-c", "from adcs import run"]}
ADCS = ("adcs --help", "adcs list", "adcs run observer-pd --no-report", "adcs run observer-pd")
COMMANDS = PYTHON | {text: ["-m", *shlex.split(text)] for text in (*ADCS, "adcs run observer-pd --png")}


def taken(arguments: list[str], folder: Path) -> float:
    """CPU time [s] of a command of this Python."""
    before = os.times()
    subprocess.run([sys.executable, *arguments], cwd=folder, capture_output=True, check=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def main(
    rounds: Annotated[int, Parameter(validator=Number(gte=1), help="Interleaved rounds.")] = 9,
    output: Annotated[Path, Parameter(help="Folder for the results.")] = Path("results/benchmarks"),
) -> None:
    """Time commands, in rounds that take turns."""
    with TemporaryDirectory() as folder:
        times = [{name: taken(words, Path(folder)) for name, words in COMMANDS.items()} for _ in range(rounds + 1)]
    found = {name: median(each[name] for each in times[1:]) for name in COMMANDS}  # the first one may have built FMUs
    table = Table(title=f"CPU time of a command, median of {rounds} rounds", title_justify="left")
    table.add_column("command")
    table.add_column("s", justify="right")
    for name, cpu in found.items():
        table.add_row(name, f"{cpu:.2f}")
    Console().print(table)
    output.mkdir(parents=True, exist_ok=True)
    (output / "commands.json").write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    cyclopts.run(main)
