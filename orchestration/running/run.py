"""Run a system: check the arguments, choose the method, put together the result with its manifest."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from math import inf
from pathlib import Path
from typing import Any, get_args

import numpy as np

from fmus.errors import AdcsError
from orchestration.coupled import CoupledModel, SolverName, couple
from orchestration.engine import ThreadControl
from orchestration.fmu.advice import changed_outside_range
from orchestration.fmu.file import FmiVersion, Kind
from orchestration.grid import Grid
from orchestration.instances.instance import CallFailed
from orchestration.instances.life import watched_life
from orchestration.isolation.apart import run_apart
from orchestration.isolation.journal import Journal
from orchestration.plan.loops import LoopSolver
from orchestration.plan.lowering import Floats
from orchestration.process.guard import Guard, explained
from orchestration.process.where import Where
from orchestration.results.hdf5 import FileRecording, FileResult
from orchestration.results.manifest import completed, make_manifest
from orchestration.results.result import Recording, Result, RunFailed, RunInterrupted
from orchestration.running.checkpoint import Checkpoint
from orchestration.running.cosim import Course, Progress, Watcher, cosimulate, rigid
from orchestration.running.live import Change, Condition, Inputs, Pace, refuse_two_names
from orchestration.running.session import Stepping
from orchestration.system import System, Value


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
    record_every: int = 1,
    stepping: Stepping = "compiled",
    changes: Sequence[tuple[float, str, Value]] = (),
    inputs: str | Path | None = None,
    until: str | None = None,
    real_time: float | None = None,
    solve_loops: LoopSolver | Mapping[str, Any] | None = None,
    timeout: float = inf,
    hdf5: str | Path | None = None,
    adaptive: float | None = None,
    checkpoint: str | Path | None = None,
    checkpoint_every: float | None = None,
    resume: str | Path | None = None,
    watchers: Sequence[Watcher] = (),
    progress: Progress | None = None,
    isolated: bool = False,
    journal: Journal | None = None,
) -> Result:
    """Run a system from start_time to stop_time (s) and record at t_k = start_time + k*step: N steps, N+1 rows.

    If the times are no whole number of steps apart, the last step is shorter, where all components can take one.

    `method`: "co-simulation" exchanges values every `step`; "model-exchange" integrates all components as one ordinary
    differential equation with `solver` at `rtol`, `atol`. `fmi_version` says which file of a component known by name is
    taken. `record` names `component.variable` (None: all outputs), `record_every` keeps every n-th row.
    `stepping="python"` makes the same calls as the compiled loop, one by one from Python, for the same result to the
    last bit. `hdf5` names a file to which rows go as they come, for runs that do not fit into memory. `solve_loops`
    solves algebraic loops, which are refused without it. `progress` is called with the fraction done.

    In co-simulation `changes` (time in s, `component.variable`, value) set unconnected inputs and tunable parameters at
    communication points; `inputs` is a CSV table of inputs over time; `until`, as in "norm(plant.omega_BN_B) < 1e-3",
    ends the run at the first row that meets it; `real_time` paces it, 1 for real time, 2 for twice as fast; `timeout`
    (s) gives up a component of which one call takes longer. `adaptive` is a tolerance: between two rows 2^j exchange
    steps are taken, chosen by step doubling. `checkpoint` names a file for the state at the end, and every
    `checkpoint_every` seconds of simulated time; `resume` goes on from such a file, at whose time is the first row.
    `watchers` are called after each point, and may ask for changes at the next; they are in this process.

    `isolated` runs the components in a process of their own: one that crashes or ends its process becomes RunFailed,
    with the rows until then; `watchers` cannot cross to it. `journal` keeps the rows in a file, whatever comes.

    A component may end the simulation: the manifest's outcome says which, when and why. Raises AdcsError when the run
    cannot start, RunFailed when a component fails on the way, RunInterrupted on Ctrl-C; the last two carry what was
    recorded as `.result`.
    """
    asked = dict(locals())
    _choice("method", method, Kind)
    _choice("solver", solver, SolverName)
    _choice("stepping", stepping, Stepping)
    _choice("fmi_version", fmi_version, FmiVersion)
    for name, tolerance in (("rtol", rtol), ("atol", atol), ("timeout", timeout)):
        if not tolerance > 0 or (name != "timeout" and not np.isfinite(tolerance)):
            raise AdcsError(f"{name} = {tolerance}: expected a positive number")
    if rtol < _MIN_RTOL:
        raise AdcsError(f"rtol = {rtol} is below what double precision can hold: use {_MIN_RTOL:.1e} or more")
    if not isinstance(record_every, int) or record_every < 1:
        raise AdcsError(f"record_every = {record_every!r}: expected a whole number of steps from 1")
    if isolated:
        return run_apart(asked)
    free = method == "model-exchange"
    grid = Grid.make(start_time, stop_time, step, lambda: None if free else rigid(system, fmi_version))
    report = progress or (lambda fraction: None)
    if isinstance(solve_loops, Mapping):
        solve_loops = LoopSolver(**solve_loops)
    if checkpoint_every is not None and checkpoint is None:
        raise AdcsError("checkpoint_every: there is no checkpoint to be written, name its file")
    saved = None if resume is None else Checkpoint.read(Path(resume))
    first = 0 if saved is None else saved.k
    if first > grid.full:
        raise AdcsError(f"{resume} is at t = {grid.time(first):g} s, after stop_time = {stop_time:g} s")
    for time_, name, _ in changes:
        if grid.index(time_, f"the change of {name}") < first:
            raise AdcsError(f"the change of {name} at {time_:g} s lies before the checkpoint, {grid.time(first):g} s")
    times = grid.rows(first, record_every)
    rows = len(times)
    recording: Recording
    if journal is not None:
        recording = journal.record(system, record)
    else:
        recording = Recording(system, record, rows) if hdf5 is None else FileRecording(system, record, Path(hdf5))
    where = Where() if journal is None else journal.where
    guard = Guard(ThreadControl(), None if journal is None else journal.printed)
    course = Course(
        changes=[Change.at(grid, *change) for change in changes],
        inputs=None if inputs is None else Inputs.from_csv(system, Path(inputs)),
        until=None if until is None else Condition.parse(until, system, recording),
        pace=None if real_time is None else Pace(grid, real_time),
        timeout=timeout,
        record_every=record_every,
        solver=solve_loops,
        adaptive=adaptive,
        checkpoint=None if checkpoint is None else Path(checkpoint),
        checkpoint_every=checkpoint_every,
        resume=saved,
        watchers=watchers,
        where=where,
        guard=guard,
    )
    refuse_two_names(system, course.changes)
    if adaptive is not None:
        others: dict[str, Any] = {"record_every": record_every > 1, "until": until, "real_time": real_time}
        others |= {"inputs": inputs, "changes": changes, "checkpoint": checkpoint, "resume": resume}
        others |= {"watchers": watchers}
        for name in (name for name, given in others.items() if given):
            raise AdcsError(f"{name}: not together with adaptive exchange steps")
    if method == "model-exchange":
        _only_in_cosimulation(course, hdf5 is not None)
    settings = {
        "method": method,
        "fmi_version": fmi_version,
        "start_time": grid.start,
        "stop_time": float(stop_time),
        "step": grid.step,
        **({"stepping": stepping} if method == "co-simulation" else {"solver": solver, "rtol": rtol, "atol": atol}),
        **({"record_every": record_every} if record_every > 1 else {}),
        **({"changes": [[t, name, _plain(value)] for t, name, value in changes]} if changes else {}),
        **({"inputs": str(inputs)} if inputs is not None else {}),
        **({"until": until} if until is not None else {}),
        **({"real_time": real_time} if real_time is not None else {}),
        **({"adaptive": adaptive} if adaptive is not None else {}),
        **({"resume": str(resume)} if resume is not None else {}),
        **({"solve_loops": asdict(solve_loops)} if solve_loops is not None else {}),
    }
    manifest = make_manifest(system, fmi_version, settings)
    manifest["warnings"] += changed_outside_range(system, changes, course.inputs)
    if journal is not None:
        journal.begin(system, grid, manifest, first, record_every)
    states: Floats = np.empty((grid.steps + 1, 0))
    state_names: list[str] = []
    clock = _Clock()

    def begin() -> None:
        clock.start()
        where.place.started = 1

    def failed(component: str | None, time: float, message: str) -> Result:
        outcome = {"status": "failed", "component": component, "time": time, "message": message}
        if journal is not None:
            journal.fail(outcome)
        return result(outcome)

    def result(outcome: dict[str, Any]) -> Result:
        if isinstance(recording, FileRecording):
            try:
                recording.flush()
            except AdcsError as error:  # the disk is full, too; less is kept
                manifest["warnings"].append(str(error))
        n = recording.filled
        manifest["timing"] = clock.read(float(times[n - 1] - times[0]) if n else 0.0)
        manifest["outcome"] = {**outcome, "rows": n}
        if isinstance(recording, FileRecording) and recording.close(times[:n], manifest):
            return FileResult.of(system, times[:n], recording, manifest)
        return Result(system, times[:n], recording.data[:n], recording.ports, manifest, states[:n], state_names)

    try:
        if method == "co-simulation":
            cosimulate(system, grid, recording, fmi_version, stepping, course, report, begin, manifest)
        else:
            make = partial(
                CoupledModel,
                system,
                grid.start,
                grid.bound,
                fmi_version,
                record,
                loops=solve_loops,
                where=where,
                guard=guard,
            )
            with watched_life(make, where, timeout, manifest) as (model, watched):
                state_names = model.state_names
                states = np.empty((grid.steps + 1, len(state_names)))
                begin()
                try:
                    watched(lambda: couple(model, grid, recording, states, solver, rtol, atol, report), throw=True)
                finally:
                    if model.ended is not None:
                        times[recording.filled - 1] = model.ended.time
                        manifest["ended"] = model.ended.as_dict()
                    if model.loop_reports:
                        manifest["algebraic_loops"] = model.loop_reports
                if watched.interrupted:
                    raise KeyboardInterrupt
        if isinstance(recording, FileRecording):
            recording.flush()
    except CallFailed as error:
        if error.time is None and clock.running:  # it hung in model-exchange
            error.time = float(times[max(recording.filled - 1, 0)])
        if error.time is None:  # it failed in initialisation
            raise
        left = failed(error.component, error.time, error.text)
        raise RunFailed(f"{error}; {recording.filled} rows are kept", left) from error
    except AdcsError as error:
        if not clock.running:
            raise
        text = explained(error, manifest["warnings"])
        left = failed(None, float(times[min(recording.filled, rows - 1)]), text)
        raise RunFailed(f"{text}; {recording.filled} rows are kept", left) from error
    except KeyboardInterrupt as error:
        raise RunInterrupted(result({"status": "interrupted"})) from error
    finally:
        guard.close()
    return result(completed(manifest))


def _only_in_cosimulation(course: Course, to_file: bool) -> None:
    """Refuse by name what has no meaning in coupled Model Exchange."""
    asked = {
        "changes": bool(course.changes),
        "inputs": course.inputs is not None,
        "until": course.until is not None,
        "real_time": course.pace is not None,
        "record_every": course.record_every > 1,
        "hdf5": to_file,
        "adaptive": course.adaptive is not None,
        "checkpoint": course.checkpoint is not None,
        "resume": course.resume is not None,
        "watchers": bool(course.watchers),
    }
    for name in (name for name, given in asked.items() if given):
        raise AdcsError(f"{name}: only co-simulation has it, not model-exchange")


def _plain(value: Value) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value


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
