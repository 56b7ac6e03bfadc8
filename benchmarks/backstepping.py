"""`python -m benchmarks.backstepping`: the twenty runs of the thesis' Tables 9.6 to 9.16, CPU time of one process."""

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

from adcs import AdcsError, Save, run
from adcs.library.trigo.catalogue import SCENARIOS
from adcs.library.trigo.metrics import measure
from adcs.library.trigo.settings import AS_MADE, CONTROL_RATE, CONTROLLERS, STOP_TIME
from adcs.library.trigo.systems import build, exchange_step, recorded

STEPS_PER_RUN = round(STOP_TIME * CONTROL_RATE)


@dataclass(frozen=True)
class Round:
    """CPU time [s] of all runs: stepping alone, and with wiring, loading, initialising and evaluating."""

    stepping: float
    whole: float


def measure_round(stop_time: float = STOP_TIME) -> Round:
    """Build, run and evaluate all twenty; `stop_time` in s."""
    began, stepping = time.process_time(), 0.0
    for scenario in SCENARIOS:
        for controller in CONTROLLERS:
            system = build(controller, scenario, AS_MADE)
            step = exchange_step(scenario, AS_MADE, CONTROL_RATE)
            result = run(system, stop_time=stop_time, step=step, save=Save(recorded(system)))
            stepping += result.manifest["timing"]["cpu_s"]
            if stop_time == STOP_TIME:
                measure(result)
    return Round(stepping, time.process_time() - began)


def main(
    rounds: Annotated[int, Parameter(validator=Number(gte=1), help="Rounds, of which medians are taken.")] = 5,
    output: Annotated[Path, Parameter(help="Folder for the results.")] = Path("results/benchmarks"),
) -> None:
    """Simulated seconds per CPU second of the five controllers in four scenarios: plant at 100 Hz, control at 10 Hz."""
    console = Console()
    try:
        measure_round(1.0)  # loads what is not loaded
        times = [measure_round() for _ in track(range(rounds), "measuring", console=console, transient=True)]
    except AdcsError as error:
        Console(stderr=True).print(f"[red]error:[/red] {error}")
        raise SystemExit(1) from error
    runs = len(SCENARIOS) * len(CONTROLLERS)
    table = Table(title=f"{runs} runs of {STOP_TIME:g} s, medians of {rounds} rounds")
    for i, column in enumerate(("", "CPU time [s]", "simulated s per CPU s", "µs per control step")):
        table.add_column(column, justify="right" if i else "left")
    found = {}
    for name, label in (("stepping", "stepping"), ("whole", "with wiring, loading and evaluating")):
        cpu = median(getattr(r, name) for r in times)
        found[name] = {"cpu_s": cpu, "simulated_s_per_cpu_s": runs * STOP_TIME / cpu}
        table.add_row(label, f"{cpu:.2f}", f"{runs * STOP_TIME / cpu:.0f}", f"{1e6 * cpu / runs / STEPS_PER_RUN:.2f}")
    console.print(table)
    output.mkdir(parents=True, exist_ok=True)
    content = {"runs": runs, "simulated_s": runs * STOP_TIME, **found, "rounds": [asdict(r) for r in times]}
    (output / "backstepping.json").write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    cyclopts.run(main)
