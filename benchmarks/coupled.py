"""`python -m benchmarks.coupled`: every smooth system as one differential equation, and in co-simulation."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Annotated

import cyclopts
import numpy as np
from cyclopts import Parameter
from cyclopts.validators import Number
from rich.console import Console
from rich.progress import track
from rich.table import Table
from scipy.integrate import solve_ivp

from adcs import AdcsError, CoSimulation, CoupledModel, ModelExchange, Result, Save, inputs, run, systems
from orchestration.plan.lowering import Floats
from orchestration.running.fitting import Fitting

STEP = 0.01
"""s, of co-simulation, where the system's own is not smaller."""

ALONE = "observer-pd"
"""Solved in more ways than the others."""

_TIGHT = ModelExchange(rtol=3e-14)
_SMALL = 1e-3  # outputs that stay below it are compared with it

Outputs = Mapping[str, Floats]


@dataclass(frozen=True)
class Sample:
    """CPU time [s] of the stepping alone, all outputs at the system's own rows, and evaluations of the derivatives."""

    cpu: float
    evaluations: int | None
    outputs: Outputs


@dataclass(frozen=True)
class Row:
    """Medians over the rounds; the error is the largest of all outputs, relative to the size of each."""

    system: str
    way: str
    evaluations: int | None
    cpu_ms: float
    error: float


def smooth() -> list[str]:
    """The systems that are solved as one differential equation where no method is asked for."""
    return [
        name
        for name, entry in systems().items()
        if isinstance(Fitting().choose(entry.build(), "2.0", (), stepped=False, resume=None)[0], ModelExchange)
    ]


def exact(name: str, method: ModelExchange | None = None) -> Sample:
    """Solve it as one differential equation."""
    result = run(name, method=method or ModelExchange())
    return _sample(result, result.manifest["integrator"].get("evaluations"))


def exchanged(name: str) -> Sample:
    """Let the components exchange values, more often than there are rows where rows are far apart."""
    rows = systems()[name].step
    step = min(rows, STEP)
    return _sample(run(name, method=CoSimulation(), step=step, save=Save(every=round(rows / step))), None)


def by_scipy(name: str, rtol: float = 1e-11) -> Sample:
    """Solve it by SciPy's DOP853, derivatives and rows through Python."""
    entry = systems()[name]
    times = entry.step * np.arange(round(entry.stop_time / entry.step) + 1)
    with CoupledModel(name) as model:
        rows = np.empty((len(times), sum(port.size for port in model.ports.values())))
        began = time.process_time()
        atol = 0.01 * rtol * model.nominals
        found = solve_ivp(model.rhs, times[[0, -1]], model.x0, "DOP853", times, rtol=rtol, atol=atol)
        for t, x, row in zip(times, found.y.T, rows, strict=True):
            model.row(t, x, row)
        cpu = time.process_time() - began
        ends = np.cumsum([port.size for port in model.ports.values()])[:-1]
        return Sample(cpu, found.nfev, dict(zip(model.ports, np.split(rows, ends, axis=1), strict=True)))


def fed(name: str) -> Sample:
    """Solve it with a disturbance from a table, zero at each full second: the same, with steps that end there."""
    seconds = range(round(systems()[name].stop_time) + 1)
    header = ",".join(["time", *(f"plant.torque_disturbance_B[{i}]" for i in (1, 2, 3))])
    with TemporaryDirectory() as folder:
        table = Path(folder) / "table.csv"
        table.write_text("\n".join([header, *(f"{t},0,0,0" for t in seconds)]) + "\n", encoding="utf-8")
        result = run(name, method=ModelExchange(), hooks=[inputs(table)])
    return _sample(result, result.manifest["integrator"]["evaluations"])


def error(outputs: Outputs, reference: Outputs) -> float:
    """Return the largest difference, each relative to the largest magnitude of its output."""
    return max(
        float(np.abs(values.reshape(len(values), -1) - outputs[name].reshape(len(values), -1)).max())
        / max(float(np.abs(values).max()), _SMALL)
        for name, values in reference.items()
    )


def _sample(result: Result, evaluations: int | None) -> Sample:
    return Sample(result.manifest["timing"]["cpu_s"], evaluations, {name: result[name] for name in result.names})


WAYS: dict[str, Callable[[str], Sample]] = {"exact": exact, "exchanged": exchanged}
MORE_WAYS: dict[str, Callable[[str], Sample]] = {
    "DOP853, rtol 1e-12": exact,
    "DOP853, rtol 1e-11": lambda name: exact(name, ModelExchange(rtol=1e-11)),
    "DOP853, rtol 1e-12, with a table of inputs": fed,
    "SciPy's DOP853, rtol 1e-11": by_scipy,
    "CVode, rtol 1e-10": lambda name: exact(name, ModelExchange("CVode")),
}


def measure(name: str, ways: Mapping[str, Callable[[str], Sample]], rounds: int) -> list[Row]:
    """Solve a system in several ways, one after the other in each round."""
    solved = [way(name) for way in ways.values()]  # loads what is not loaded
    times = [[way(name).cpu for way in ways.values()] for _ in range(rounds)]
    reference = exact(name, _TIGHT).outputs
    return [
        Row(name, way, sample.evaluations, 1e3 * median(r[i] for r in times), error(sample.outputs, reference))
        for i, (way, sample) in enumerate(zip(ways, solved, strict=True))
    ]


def main(
    rounds: Annotated[
        int, Parameter(validator=Number(gte=1), help="Interleaved rounds, of which medians are taken.")
    ] = 7,
    output: Annotated[Path, Parameter(help="Folder for the results.")] = Path("results/benchmarks"),
) -> None:
    """CPU time and error of all smooth systems, all outputs at their own rows. CPU time, not wall time."""
    console = Console()
    try:
        found = [measure(name, WAYS, rounds) for name in track(smooth(), "measuring", console=console, transient=True)]
        more = measure(ALONE, MORE_WAYS, rounds)
    except AdcsError as failed:
        Console(stderr=True).print(f"[red]error:[/red] {failed}")
        raise SystemExit(1) from failed
    table = Table(title=f"exact, and co-simulation at {1e3 * STEP:g} ms or less; medians of {rounds} rounds")
    for i, column in enumerate(("system", "evaluations", "ms", "error", "ms", "error", "ratio")):
        table.add_column(column, justify="right" if i else "left")
    for a, b in found:
        each = (f"{a.cpu_ms:.1f}", f"{a.error:.1e}", f"{b.cpu_ms:.1f}", f"{b.error:.1e}", f"{a.cpu_ms / b.cpu_ms:.2f}")
        table.add_row(a.system, str(a.evaluations), *each)
    console.print(table)
    table = Table(title=f"{ALONE}, 100 s, all outputs every 10 ms")
    for i, column in enumerate(("", "evaluations", "ms", "error")):
        table.add_column(column, justify="right" if i else "left")
    for row in more:
        table.add_row(row.way, str(row.evaluations or ""), f"{row.cpu_ms:.1f}", f"{row.error:.1e}")
    console.print(table)
    output.mkdir(parents=True, exist_ok=True)
    content = [asdict(row) for rows in (*found, more) for row in rows]
    (output / "coupled.json").write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    cyclopts.run(main)
