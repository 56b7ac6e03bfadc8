"""`python -m benchmarks.building`: CPU time of a first build, in an empty folder, for this machine."""

from __future__ import annotations

import json
import os
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import cyclopts
from cyclopts import Parameter
from rich.console import Console

from adcs import AdcsError
from fmus.build import build
from fmus.toolchain import compiler


def first_build(names: list[str] | None) -> tuple[int, float]:
    """How many components there are, and the CPU time [s] of this process and all that it starts."""
    with TemporaryDirectory() as folder:
        before = sum(os.times()[:4])
        made = build(names, work=Path(folder) / "build", dist=Path(folder) / "dist")
        return len({path.name.partition(".")[0] for path in made}), sum(os.times()[:4]) - before


def main(
    *names: Annotated[str, Parameter(help="Components; all, if none is named.")],
    output: Annotated[Path, Parameter(help="Folder for the results.")] = Path("results/benchmarks"),
) -> None:
    """Build components into an empty folder; the compiler keeps its cache, of the C library and the adaptor."""
    try:
        first_build(["TorqueSwitch"])  # fills the cache
        count, cpu = first_build(list(names) or None)
    except AdcsError as error:
        Console(stderr=True).print(f"[red]error:[/red] {error}")
        raise SystemExit(1) from error
    Console().print(f"{count} components: {cpu:.0f} s of CPU time, {cpu / count:.1f} s each")
    output.mkdir(parents=True, exist_ok=True)
    content = {"components": count, "cpu_s": cpu, "compiler": compiler()}
    (output / "building.json").write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    cyclopts.run(main)
