"""What the exchange step of a co-simulation costs: loops at several steps beside their coupled solutions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

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
    loops: Mapping[str, Callable[[], System]], steps: Sequence[float], grid: float, stop: float
) -> dict[tuple[str, float], Simulation]:
    """Coupled solutions and co-simulations by (label, step [s]), all with rows at multiples of `grid` [s]."""
    runs = {}
    for label, build in loops.items():
        runs[label, COUPLED] = Simulation(f"{label}, coupled", build(), whole, stop, grid, ModelExchange())
        for step in steps:
            text = f"{label}, co-simulation at {1e3 * step:g} ms"
            runs[label, step] = Simulation(text, build(), whole, stop, step, every=round(grid / step))
    return runs


def distance(run: Result, exact: Result, name: str) -> float:
    """The largest norm of the difference of a variable."""
    return float(norm(run[name] - exact[name]).max())
