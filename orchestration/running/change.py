"""A value that is set during a run, and those that are known before."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from orchestration.grid import Grid
from orchestration.system import Value

if TYPE_CHECKING:
    from orchestration.running.simulation import Simulation


@dataclass(frozen=True)
class Change:
    """A variable gets a value at point k, and the row of that point is one with it."""

    k: int
    name: str
    value: Value

    @classmethod
    def at(cls, grid: Grid, time: float, name: str, value: Value) -> Change:
        """Find the communication point of a time [s]; refuse one between two points."""
        return cls(grid.index(time, f"the change of {name}"), name, value)

    def may_follow(self, simulation: Simulation) -> bool:
        """Whether the row of its point is the same without it: then it is set after that, as FMI wants it."""
        return not simulation.shows(self.name)

    def apply(self, simulation: Simulation) -> None:
        """Set it now."""
        simulation.set(self.name, self.value)
