"""A system that is worth running as it is: under a name, or from a file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from orchestration import expected
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

    def __post_init__(self) -> None:
        for name in ("name", "description", "reference"):
            expected.text(name, getattr(self, name))
        for name in ("stop_time", "step", "start_time"):
            object.__setattr__(self, name, expected.number(name, getattr(self, name)))
        for name in ("make", "figures", "key_numbers", "check_step"):
            if not callable(getattr(self, name)):
                raise expected.refused(name, getattr(self, name), "a function")

    def build(self) -> System:
        """Return the system, with its times."""
        system = self.make()
        if not isinstance(system, System):
            raise expected.refused(f"what make of the system {self.name} returns", system, "an adcs.System")
        system.times = Times(self.start_time, self.stop_time, self.step, self.assumed)
        return system
