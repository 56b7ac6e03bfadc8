"""A system that is worth running as it is: under a name, or from a file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber
from orchestration.results.result import Result
from orchestration.system import System, Times


@dataclass(frozen=True)
class SystemEntry:
    """A system by name, how long it is worth running, and how its result is shown."""

    name: str
    description: str
    reference: str
    make: Callable[[], System]
    stop_time: float  # s
    step: float  # s
    figures: Callable[[Result], Sequence[Panel]]
    key_numbers: Callable[[Result], Sequence[KeyNumber]]
    start_time: float = 0.0  # s
    check_step: Callable[[float], object] = lambda step: None  # refuses an exchange step [s]
    assumed: Sequence[str] = ()  # which of stop_time and step its file does not give

    def build(self) -> System:
        """Return the system, with its times."""
        system = self.make()
        system.times = Times(self.start_time, self.stop_time, self.step, self.assumed)
        return system
