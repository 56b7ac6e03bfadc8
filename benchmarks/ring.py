"""`python -m benchmarks.ring`: what an exchange step of a ring of N rigid bodies costs as N grows."""

from __future__ import annotations

import json
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Annotated

import cyclopts
from cyclopts import Parameter
from cyclopts.validators import Number
from rich.console import Console
from rich.progress import track
from rich.table import Table

from adcs import AdcsError, Session, System

SIZES = (1, 10, 100, 300, 1000)
_STEP = 0.01  # s
_FEEBLE = 1e-9  # factor of what one body does to the next, so that none spins up


@dataclass(frozen=True)
class Cost:
    """CPU time [s] of one exchange step of the whole ring, and of wiring and opening it."""

    size: int
    step: float
    opening: float


def system(n: int) -> System:
    """Return the ring of n bodies, each under a torque that the rate of the one before it makes."""
    made = System(f"ring of {n}")
    for i in range(n):
        rate = [0.01 * (i % 7), 0.02, -0.01]
        made.add(f"body{i}", "RigidBody", {"omega_BN_B": rate, "torque_B": [0.0] * 3, "max_internal_step": _STEP})
    for i in range(n):
        made.connect(f"body{(i or n) - 1}.omega_BN_B", f"body{i}.torque_disturbance_B", factor=_FEEBLE)
    return made


def measure(n: int, component_steps: int) -> Cost:
    """Take so many steps of single bodies, all in all."""
    steps = max(1, component_steps // n)
    began = time.process_time()
    with Session(system(n), step=_STEP, steps=steps, record=[]) as simulation:
        opened = time.process_time()
        _, _, failed = simulation.loop.steps(0.0, _STEP, 0, steps, steps, None, simulation.recording.room(0))
        ended = time.process_time()
    if failed is not None:
        raise failed
    return Cost(n, (ended - opened) / steps, opened - began)


def main(
    rounds: Annotated[
        int, Parameter(validator=Number(gte=1), help="Interleaved rounds, of which medians are taken.")
    ] = 5,
    component_steps: Annotated[
        int, Parameter(validator=Number(gte=1000), help="Steps of single bodies for each size.")
    ] = 300_000,
    output: Annotated[Path, Parameter(help="Folder for the results.")] = Path("results/benchmarks"),
) -> None:
    """Time one exchange step of rings of several sizes. CPU time, not wall time."""
    console = Console()
    try:
        found = [
            [measure(n, component_steps) for n in SIZES]
            for _ in track(range(rounds), "measuring", console=console, transient=True)
        ]
    except AdcsError as error:
        Console(stderr=True).print(f"[red]error:[/red] {error}")
        raise SystemExit(1) from error
    costs = [
        Cost(n, median(r[i].step for r in found), median(r[i].opening for r in found)) for i, n in enumerate(SIZES)
    ]
    table = Table(title="CPU time of one exchange step of a ring of N rigid bodies")
    for column in ("N", "us per step", "ns per step and body", "opening, ms per body"):
        table.add_column(column, justify="right")
    for cost in costs:
        each = (1e6 * cost.step, 1e9 * cost.step / cost.size, 1e3 * cost.opening / cost.size)
        table.add_row(str(cost.size), f"{each[0]:.2f}", f"{each[1]:.0f}", f"{each[2]:.1f}")
    console.print(table)
    output.mkdir(parents=True, exist_ok=True)
    (output / "ring.json").write_text(json.dumps([asdict(c) for c in costs], indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    cyclopts.run(main)
