"""What the exchange step of a co-simulation costs: a loop at several steps beside its coupled solution."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from adcs.library.attitude import norm
from adcs.library.sections import Simulation
from orchestration.results.result import Result
from orchestration.running.method import ModelExchange
from orchestration.system import System

COUPLED = 0.0
"""The step under which the coupled solution is found."""


def whole(result: Result) -> Result:
    """The view that keeps all."""
    return result


def at_steps(
    label: str, build: Callable[[], System], record: Sequence[str], steps: Sequence[float], grid: float, stop: float
) -> dict[tuple[str, float], Simulation]:
    """The coupled solution and the co-simulations by (label, step [s]), all with rows at multiples of `grid` [s]."""
    runs = {(label, COUPLED): Simulation(f"{label}, coupled", build(), whole, record, stop, grid, ModelExchange())}
    for step in steps:
        text = f"{label}, co-simulation at {1e3 * step:g} ms"
        runs[label, step] = Simulation(text, build(), whole, record, stop, step, every=round(grid / step))
    return runs


def distance(run: Result, exact: Result, name: str) -> float:
    """The largest norm of the difference of a variable."""
    return float(norm(run[name] - exact[name]).max())
