"""What the exchange step of a co-simulation costs: loops at several steps beside their coupled solutions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from adcs.library.attitude import norm
from adcs.library.sections import Simulation
from orchestration.results.result import Result
from orchestration.running.method import CoSimulation, ModelExchange
from orchestration.system import System

COUPLED = 0.0
"""The step under which the coupled solution is found."""


def whole(result: Result) -> Result:
    """The view that keeps all."""
    return result


def at_steps(
    loops: Mapping[str, Callable[[], System]], record: Sequence[str], steps: Sequence[float], grid: float, stop: float
) -> dict[tuple[str, float], Simulation]:
    """Coupled solutions and co-simulations by (label, step [s]), all with rows at multiples of `grid` [s].

    Of `record` each loop has what it has.
    """
    runs = {}
    for label, build in loops.items():
        for step in (COUPLED, *steps):
            text = f"{label}, co-simulation at {1e3 * step:g} ms" if step else f"{label}, coupled"
            system = build()
            names = [name for name in record if name in system.outputs()]
            method, every = (CoSimulation(), round(grid / step)) if step else (ModelExchange(), 1)
            runs[label, step] = Simulation(text, system, whole, names, stop, step or grid, method, every)
    return runs


def distance(run: Result, exact: Result, name: str) -> float:
    """The largest norm of the difference of a variable."""
    return float(norm(run[name] - exact[name]).max())
