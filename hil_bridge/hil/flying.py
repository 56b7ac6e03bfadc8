"""A whole flight: the system at the pace of its autopilot, and what was recorded kept however it ends."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from fmus.errors import AdcsError
from hil_bridge.hil.lockstep import Flight
from orchestration.fmu.file import FmiVersion
from orchestration.grid import Grid
from orchestration.instances.instance import CallFailed, EndRequested
from orchestration.results.manifest import make_manifest
from orchestration.results.result import Recording, Result, RunFailed, RunInterrupted
from orchestration.running.session import Session
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
        try:
            while simulation.k <= grid.steps and simulation.ended is None:
                flight(simulation)
                _take(simulation, recording)
                progress(simulation.k / (grid.steps + 1))
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


def _take(simulation: Session, recording: Recording) -> None:
    """Propagate and record the present point, and step on from it."""
    simulation.k, written, failed = simulation.loop.steps(
        simulation.start, simulation.step, simulation.k, 1, simulation.last, None, recording.room(1)
    )
    recording.commit(written)
    if isinstance(failed, EndRequested):
        simulation.ended = failed
    elif failed is not None:
        raise failed
