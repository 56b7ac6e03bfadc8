"""A whole flight: the system at the pace of its autopilot, and what was recorded kept however it ends."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from math import inf
from typing import Any

from fmus.errors import AdcsError
from hil_bridge.hil.lockstep import Flight
from orchestration.fmu.file import FmiVersion
from orchestration.grid import Grid
from orchestration.instances.instance import CallFailed
from orchestration.process.watch import Unwatched
from orchestration.process.where import Where
from orchestration.results.manifest import make_manifest
from orchestration.results.result import Recording, Result, RunFailed, RunInterrupted
from orchestration.running.change import Change
from orchestration.running.driver import Driver
from orchestration.running.hook import Hook, Watched
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
    grid = Grid.make(0.0, stop_time, step)
    recording = Recording(system, None, grid.steps + 1)
    times = grid.times
    manifest = make_manifest(
        system,
        fmi_version,
        {"method": "co-simulation", "stop_time": float(stop_time), "step": grid.step, "hil": settings or {}},
    )

    def result(outcome: dict[str, Any]) -> Result:
        n = recording.filled
        wall, cpu = time.perf_counter() - began[0], time.process_time() - began[1]
        simulated = float(times[n - 1]) if n else 0.0
        manifest["timing"] = {"wall_s": wall, "cpu_s": cpu, "simulated_s": simulated}
        manifest["outcome"] = {**outcome, "rows": n}
        manifest["hardware_in_the_loop"] = flight.report()
        return Result(system, times[:n], recording.data[:n], recording.ports, manifest)

    with Session(system, step=grid.step, steps=grid.steps, fmi_version=fmi_version) as simulation:
        began = time.perf_counter(), time.process_time()
        driver = Driver(simulation, recording, [_Flying(flight)], Unwatched(), Where(), timeout=inf, progress=progress)
        driver.prepare()
        try:
            driver.run()
            if simulation.ended is not None:
                times[recording.filled - 1] = driver.row_at
        except AdcsError as error:
            failed = error if isinstance(error, CallFailed) else None
            outcome = {
                "status": "failed",
                "component": failed.component if failed else None,
                "time": grid.time(simulation.k),
                "message": failed.text if failed else str(error),
            }
            raise RunFailed(f"{error}; {recording.filled} rows are kept", result(outcome)) from error
        except KeyboardInterrupt as error:
            raise RunInterrupted(result({"status": "interrupted"})) from error
        finally:
            manifest["warnings"] += simulation.warnings
    ended = {} if simulation.ended is None else {"ended": simulation.ended.as_dict()}
    return result({"status": "complete", **ended})


def check(system: System, *, stop_time: float, step: float, fmi_version: FmiVersion = "2.0") -> None:
    """Refuse now what would be refused when an autopilot is there: open and initialise the system, and close it."""
    grid = Grid.make(0.0, stop_time, step)
    with Session(system, step=grid.step, steps=grid.steps, fmi_version=fmi_version):
        pass


class _Flying(Hook):
    """The flight takes part in the run: at each point, before it is recorded and stepped on from."""

    def __init__(self, flight: Flight) -> None:
        self._flight = flight

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
