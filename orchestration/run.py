"""Run a system: check the arguments, choose the method, put together the result with its manifest."""

from __future__ import annotations

import platform
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib import metadata
from typing import Any, get_args

import numpy as np

from fmus.errors import AdcsError
from orchestration.cosim import Progress, Stepping, cosimulate
from orchestration.coupled import CoupledModel, SolverName, couple
from orchestration.fmu import FmiVersion, Kind
from orchestration.grid import Grid
from orchestration.instance import CallFailed
from orchestration.plan import Floats
from orchestration.results import Recording, Result, RunFailed, RunInterrupted
from orchestration.system import System

_PACKAGES = ("adcs-fmus", "fmpy", "numpy", "scipy", "ziglang")


def run(
    system: System,
    *,
    stop_time: float,
    step: float,
    start_time: float = 0.0,
    method: Kind = "co-simulation",
    solver: SolverName = "DOP853",
    rtol: float = 1e-10,
    atol: float = 1e-12,
    fmi_version: FmiVersion = "2.0",
    record: Sequence[str] | None = None,
    stepping: Stepping = "compiled",
    progress: Progress | None = None,
) -> Result:
    """Run a system from start_time to stop_time (s) and record at t_k = start_time + k*step: N steps, N+1 rows.

    `method`: "co-simulation" exchanges values every `step`; "model-exchange" integrates all components as one ordinary
    differential equation with `solver` at `rtol`, `atol`. `fmi_version` says which file of a component known by name is
    taken. `record` names `component.variable` (None: all outputs). `stepping="python"` makes the same calls as the
    compiled loop, one by one from Python, for the same result to the last bit. `progress` is called with the fraction
    done.

    Raises AdcsError when the run cannot start, RunFailed when a component fails on the way, RunInterrupted on Ctrl-C;
    the last two carry what was recorded as `.result`.
    """
    _choice("method", method, Kind)
    _choice("solver", solver, SolverName)
    _choice("stepping", stepping, Stepping)
    _choice("fmi_version", fmi_version, FmiVersion)
    for name, tolerance in (("rtol", rtol), ("atol", atol)):
        if not (np.isfinite(tolerance) and tolerance > 0):
            raise AdcsError(f"{name} = {tolerance}: expected a positive number")
    if rtol < _MIN_RTOL:
        raise AdcsError(f"rtol = {rtol} is below what double precision can hold: use {_MIN_RTOL:.1e} or more")
    grid = Grid.make(start_time, stop_time, step)
    report = progress or (lambda fraction: None)
    recording = Recording(system, record, grid.steps + 1)
    settings: dict[str, Any] = (
        {"stepping": stepping} if method == "co-simulation" else {"solver": solver, "rtol": rtol, "atol": atol}
    )
    times = {"start_time": grid.start, "stop_time": float(stop_time), "step": grid.step}
    manifest = _manifest(system, fmi_version, {"method": method, **times, **settings})
    states: Floats = np.empty((grid.steps + 1, 0))
    state_names: list[str] = []
    clock = _Clock()

    def result(outcome: dict[str, Any]) -> Result:
        n = recording.filled
        manifest["timing"] = clock.read((n - 1) * grid.step if n else 0.0)
        manifest["outcome"] = {**outcome, "rows": n}
        return Result(system, grid.times[:n], recording.data[:n], recording.ports, manifest, states[:n], state_names)

    try:
        if method == "co-simulation":
            manifest["warnings"] = cosimulate(system, grid, recording, fmi_version, stepping, report, clock.start)
        else:
            with CoupledModel(system, grid.start, grid.time(grid.steps), fmi_version, record) as model:
                state_names = model.state_names
                states = np.empty((grid.steps + 1, len(state_names)))
                clock.start()
                couple(model, grid, recording, states, solver, rtol, atol, report)
                manifest["warnings"] = model.warnings
    except CallFailed as error:
        if error.time is None:  # it failed in initialisation
            raise
        outcome = {"status": "failed", "component": error.component, "time": error.time, "message": error.text}
        raise RunFailed(f"{error}; {recording.filled} rows are kept", result(outcome)) from error
    except AdcsError as error:
        if not clock.running:
            raise
        outcome = {"status": "failed", "component": None, "time": grid.time(recording.filled), "message": str(error)}
        raise RunFailed(f"{error}; {recording.filled} rows are kept", result(outcome)) from error
    except KeyboardInterrupt as error:
        raise RunInterrupted(result({"status": "interrupted"})) from error
    return result({"status": "complete"})


_MIN_RTOL = 100 * float(np.finfo(float).eps)  # below, SciPy raises it with a warning


class _Clock:
    """Wall and CPU time of the run proper, without opening and initialising."""

    running = False

    def start(self) -> None:
        self.running = True
        self._wall, self._cpu = time.perf_counter(), time.process_time()

    def read(self, simulated: float) -> dict[str, float | None]:
        if not self.running:
            return {}
        wall, cpu = time.perf_counter() - self._wall, time.process_time() - self._cpu
        return {
            "wall_s": wall,
            "cpu_s": cpu,
            "simulated_s": simulated,
            "simulated_s_per_cpu_s": simulated / cpu if cpu > 0 else None,
        }


def _choice(name: str, value: object, options: Any) -> None:
    if value not in get_args(options):
        raise AdcsError(f"{name} = {value!r} is unknown: use {' or '.join(map(repr, get_args(options)))}")


def _manifest(system: System, fmi_version: FmiVersion, settings: dict[str, Any]) -> dict[str, Any]:
    components = {}
    seeds = {}
    for component in system.components.values():
        fmu = component.open(fmi_version)
        start = {name: _nested(values, fmu.ports[name].shape) for name, values in component.start.items()}
        components[component.name] = {
            "fmu": str(component.source),
            "file": fmu.path.name,
            "fmi_version": fmu.model.fmiVersion,
            "sha256": fmu.sha256,
            "start": start,
        }
        for port in fmu.ports.values():
            if port.name == "seed" or port.name.endswith("_seed"):
                default = None if port.start is None else _nested(port.start, port.shape)
                seeds[f"{component.name}.{port.name}"] = start.get(port.name, default)
    return {
        "system": {
            "name": system.name,
            "description": system.description,
            "components": components,
            "connections": [[c.source, c.target] for c in system.connections],
        },
        "settings": settings,
        "seeds": seeds,
        "versions": {
            **{name: _version(name) for name in _PACKAGES},
            "python": platform.python_version(),
            "platform": platform.platform(),
        },
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def _nested(values: tuple[Any, ...], shape: tuple[int, ...]) -> Any:
    return np.asarray(values).reshape(shape).tolist()


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None
