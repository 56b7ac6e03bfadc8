"""The measured numbers as a table for people, as JSON and as Markdown."""

from __future__ import annotations

import json
import os
import platform
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from statistics import median
from typing import Any

from rich.console import Console
from rich.table import Table

from benchmarks import loop
from benchmarks.basilisk import COMPARED, Speed
from benchmarks.variants import VARIANTS


@dataclass(frozen=True)
class Row:
    """Medians over the rounds, and the extremes of the ratio."""

    key: str
    title: str
    ns_per_step: float
    ratio: float
    least_ratio: float
    greatest_ratio: float


def rows(rounds: list[dict[str, float]]) -> list[Row]:
    """`rounds` holds seconds per step by variant; ratios are taken within a round, so that drift drops out."""
    base = VARIANTS[0].key
    made = []
    for variant in VARIANTS:
        ratios = [r[variant.key] / r[base] for r in rounds]
        ns = 1e9 * median(r[variant.key] for r in rounds)
        made.append(Row(variant.key, variant.title, ns, median(ratios), min(ratios), max(ratios)))
    return made


def write(folder: Path, rounds: list[dict[str, float]], speeds: list[Speed], note: str, console: Console) -> None:
    """Print the tables and write benchmarks.json and benchmarks.md; `note` says why there are no speeds."""
    steps = rows(rounds)
    heading = f"CPU time of one exchange step of {1e3 * loop.STEP:g} ms, rigid body under PD tracking"
    columns = ("loop", "ns per step", "ratio", "of all rounds")
    cells = [
        (r.title, f"{r.ns_per_step:.0f}", f"{r.ratio:.2f}", f"{r.least_ratio:.2f} to {r.greatest_ratio:.2f}")
        for r in steps
    ]
    table = Table(title=heading)
    for i, column in enumerate(columns):
        table.add_column(column, justify="right" if i else "left")
    for row in cells:
        table.add_row(*row)
    console.print(table)

    speed: dict[str, Any] | None = None
    if speeds:
        speed = {
            "ours": median(s.ours for s in speeds),
            "basilisk": median(s.basilisk for s in speeds),
            "ratio": median(s.ours / s.basilisk for s in speeds),
            "compared": COMPARED,
        }
        note = (
            f"Simulated seconds per CPU second, plant at 100 Hz and control at 10 Hz: {speed['ours']:.0f} here, "
            f"{speed['basilisk']:.0f} in Basilisk, ratio {speed['ratio']:.0f}. {COMPARED}"
        )
    console.print(note)

    machine = {
        "platform": platform.platform(),
        "processors": os.cpu_count(),
        "python": platform.python_version(),
        **{name: metadata.version(name) for name in ("fmpy", "ziglang")},
    }
    folder.mkdir(parents=True, exist_ok=True)
    content = {"rounds": len(rounds), "machine": machine, "step": [asdict(r) for r in steps], "basilisk": speed}
    (folder / "benchmarks.json").write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    lines = [f"# {heading}", "", "| " + " | ".join(columns) + " |", "|---|--:|--:|--:|"]
    lines += ["| " + " | ".join(row) + " |" for row in cells]
    about = ", ".join(f"{name} {value}" for name, value in machine.items())
    lines += ["", f"Medians of {len(rounds)} interleaved rounds; {about}.", "", note, ""]
    (folder / "benchmarks.md").write_text("\n".join(lines), encoding="utf-8")
