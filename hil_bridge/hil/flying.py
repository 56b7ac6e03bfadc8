"""A whole flight: the system at the pace of its autopilot, and what was recorded kept however it ends."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from hil_bridge.hil.lockstep import Flight
from orchestration.fmu.file import FmiVersion
from orchestration.grid import Grid
from orchestration.process.watch import Unwatched
from orchestration.results.result import Result
from orchestration.running.account import Account
from orchestration.running.change import Change
from orchestration.running.hook import Hook, Watched
from orchestration.running.method import CoSimulation
from orchestration.running.outline import Outline
from orchestration.running.run import drive
from orchestration.running.save import Save
from orchestration.running.session import Session
from orchestration.running.simulation import Simulation
from orchestration.system import System


def fly(
    system: System,
    flight: Flight,
    *,
    stop_time: float,
    step: float,
    fmi_version: FmiVersion = "2.0",
    settings: dict[str, Any] | None = None,
    progress: Callable[[float], Any] = lambda fraction: None,
) -> Result:
    """Run a system from 0 to stop_time [s] with what flies it, and record all outputs at t_k = k*step.

    `settings` go into the manifest. Raises RunFailed when a component or the autopilot fails, RunInterrupted on Ctrl-C;
    both carry what was recorded as `.result`.
    """
    method, grid = CoSimulation(), Grid.make(0.0, stop_time, step)
    outline = Outline.of(system, grid, method, Save(), fmi_version)
    hooks = [Flying(flight, settings or {})]
    account = Account(outline, hooks)
    with account.told(), method.simulation(outline) as simulation:
        try:
            drive(simulation, hooks, Unwatched(), account, progress)
        finally:
            account.manifest["warnings"] += simulation.warnings
    return account.complete()


def check(system: System, *, stop_time: float, step: float, fmi_version: FmiVersion = "2.0") -> None:
    """Refuse now what would be refused when an autopilot is there: open and initialise the system, and close it."""
    grid = Grid.make(0.0, stop_time, step)
    with Session(system, step=grid.step, steps=grid.steps, fmi_version=fmi_version):
        pass


class Flying(Hook):
    """The flight takes part in the run: at each point, before it is recorded and stepped on from."""

    def __init__(self, flight: Flight, settings: Mapping[str, Any]) -> None:
        self._flight, self._settings = flight, settings

    def for_manifest(self) -> Mapping[str, Any]:
        """Return how it was flown."""
        return {"hil": self._settings}

    def begin(self, simulation: Simulation, hooks: Sequence[Hook], watched: Watched) -> None:
        """See the run."""
        assert isinstance(simulation, Session)
        self._simulation = simulation

    def ahead(self, k: int) -> int:
        """Every point is flown."""
        return 1

    def changes(self, k: int) -> Sequence[Change]:
        """Tell the autopilot of the point, and do what it answers."""
        self._flight(self._simulation)
        return ()

    def report(self) -> Mapping[str, Any]:
        """Return what was counted."""
        return {"hardware_in_the_loop": self._flight.report()}
