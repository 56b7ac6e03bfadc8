"""Run a system: check the arguments, choose the method, put together the result with its manifest."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from orchestration.coupled import CoupledModel, CoupledSimulation, SolverName
from orchestration.engine import ThreadControl
from orchestration.expected import choice
from orchestration.fmu.file import FmiVersion, Kind
from orchestration.grid import Grid
from orchestration.instances.instance import CallFailed
from orchestration.instances.life import watched_life
from orchestration.isolation.apart import run_apart
from orchestration.isolation.journal import Journal
from orchestration.plan.loops import LoopSolver
from orchestration.plan.lowering import Floats
from orchestration.plan.outside import Sources
from orchestration.process.guard import Guard, explained
from orchestration.process.where import Where
from orchestration.results.manifest import completed, make_manifest
from orchestration.results.result import Recording, Result, RunFailed, RunInterrupted
from orchestration.results.stored import FileRecording, FileResult
from orchestration.running import arguments
from orchestration.running.adaptive import AdaptiveSession
from orchestration.running.checkpoint import Checkpoint
from orchestration.running.driver import Driver, Progress
from orchestration.running.hook import Hook, Outline
from orchestration.running.hooks.changes import Changes
from orchestration.running.hooks.inputs import Inputs
from orchestration.running.hooks.pace import Pace
from orchestration.running.hooks.saves import Saves
from orchestration.running.hooks.until import Until
from orchestration.running.session import Session, Stepping, rigid
from orchestration.running.simulation import Simulation
from orchestration.system import System, Value


def run(
    system: System,
    *,
    stop_time: float | None = None,
    step: float | None = None,
    start_time: float | None = None,
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
    watchers: Sequence[Hook] = (),
    progress: Progress | None = None,
    isolated: bool = False,
    journal: Journal | None = None,
) -> Result:
    """Run a system from start_time to stop_time (s) and record at t_k = start_time + k*step: N steps, N+1 rows.

    Times that are not given are the system's own; start_time is 0 if it has none. If the times are no whole number
    of steps apart, the last step is shorter, where all components can take one.

    `method`: "co-simulation" exchanges values every `step`; "model-exchange" integrates all components as one
    ordinary differential equation with `solver` at `rtol`, `atol`. `fmi_version` says which file of a component
    known by name is taken. `record` names `component.variable` (None: all outputs), `record_every` keeps every n-th
    row. `stepping="python"` makes the same calls as the compiled loop, one by one from Python, for the same result
    to the last bit. `hdf5` names a file to which rows go as they come, for runs that do not fit into memory.
    `solve_loops` solves algebraic loops, which are refused without it. `progress` is called with the fraction done.

    By every method `changes` (time in s, `component.variable`, value) set unconnected inputs and tunable parameters
    at communication points; `inputs` is a CSV table of inputs over time; `until`, as in "norm(plant.omega_BN_B) <
    1e-3 and time > 20", ends the run at the first row that meets it; `real_time` paces it, 1 for real time, 2 for
    twice as fast; `timeout` (s) gives up a component of which one call takes longer. `watchers` are hooks
    (`adcs.Hook`): they see each point, and may ask for changes at the next; they are in this process.

    In co-simulation `adaptive` is a tolerance: between two rows 2^j exchange steps are taken, chosen by step
    doubling. With steps of one size `checkpoint` names a file for the state at the end, and every
    `checkpoint_every` seconds of simulated time; `resume` goes on from such a file, at whose time is the first row.

    `isolated` runs the components in a process of their own: one that crashes or ends its process becomes
    RunFailed, with the rows until then; `watchers` cannot cross to it. `journal` keeps the rows in a file, whatever
    comes.

    A component may end the simulation: the manifest's outcome says which, when and why. Raises AdcsError when the
    run cannot start, RunFailed when a component fails on the way, RunInterrupted on Ctrl-C; the last two carry what
    was recorded as `.result`.
    """
    asked = dict(locals())
    arguments.check(run, asked)
    choice("method", method, Kind)
    choice("solver", solver, SolverName)
    choice("stepping", stepping, Stepping)
    choice("fmi_version", fmi_version, FmiVersion)
    for name, tolerance in (("rtol", rtol), ("atol", atol), ("timeout", timeout)):
        if not tolerance > 0 or (name != "timeout" and not np.isfinite(tolerance)):
            raise AdcsError(f"{name} = {tolerance}: expected a positive number")
    if rtol < _MIN_RTOL:
        raise AdcsError(f"rtol = {rtol} is below what double precision can hold: use {_MIN_RTOL:.1e} or more")
    if isolated:
        return run_apart(asked)
    start_time, stop_time, step = system.run_times(start_time, stop_time, step)
    free = method == "model-exchange"
    grid = Grid.make(start_time, stop_time, step, lambda: None if free else rigid(system, fmi_version))
    report = progress or (lambda fraction: None)
    if isinstance(solve_loops, Mapping):
        solve_loops = LoopSolver(**solve_loops)
    if checkpoint_every is not None and checkpoint is None:
        raise AdcsError("checkpoint_every: there is no checkpoint to be written, name its file")
    if free and adaptive is not None:
        raise AdcsError(
            "adaptive: model-exchange has no exchange step, and chooses those of its integrator by rtol and atol"
        )
    saved = None if resume is None else Checkpoint.read(Path(resume))
    first = 0 if saved is None else saved.k
    if saved is not None and (free or adaptive is not None):
        raise AdcsError("resume: a checkpoint is of a co-simulation with steps of one size, go on with that")
    if first > grid.full:
        raise AdcsError(f"{resume} is at t = {grid.time(first):g} s, after stop_time = {stop_time:g} s")
    times = grid.rows(first, record_every)
    if record_every > 1:  # room for an end between the last of these points and that of the run
        times = np.append(times, grid.time(grid.steps))
    rows = len(times)
    recording: Recording
    if journal is not None:
        recording = journal.record(system, record)
    else:
        recording = Recording(system, record, rows) if hdf5 is None else FileRecording(system, record, Path(hdf5))
    where = Where() if journal is None else journal.where
    guard = Guard(ThreadControl(), None if journal is None else journal.printed)
    hooks: list[Hook] = [*watchers]
    hooks += [Changes(changes)] if changes else []
    hooks += [Inputs(inputs)] if inputs is not None else []
    hooks += [Until(until)] if until is not None else []
    hooks += [Pace(real_time)] if real_time is not None else []
    hooks += [Saves(checkpoint, checkpoint_every)] if checkpoint is not None else []
    outline = Outline(system, grid, recording, method, first)
    for hook in hooks:
        hook.prepare(outline)
    sources = [hook.source for hook in hooks if hook.source is not None]
    source = Sources(sources) if sources else None
    settings = {
        "method": method,
        "fmi_version": fmi_version,
        "start_time": grid.start,
        "stop_time": float(stop_time),
        "step": grid.step,
        **({"stepping": stepping} if method == "co-simulation" else {"solver": solver, "rtol": rtol, "atol": atol}),
        **({"record": list(record)} if record is not None else {}),
        **({"record_every": record_every} if record_every > 1 else {}),
        **{name: value for hook in hooks for name, value in hook.for_manifest().items()},
        **({"adaptive": adaptive} if adaptive is not None else {}),
        **({"resume": str(resume)} if resume is not None else {}),
        **({"solve_loops": asdict(solve_loops)} if solve_loops is not None else {}),
    }
    manifest = make_manifest(system, fmi_version, settings, {"inputs": inputs, "resume": resume})
    manifest["warnings"] += outline.warnings
    if checkpoint is not None:  # components are not told of a stop time then
        manifest["checkpoint"] = {"path": str(checkpoint), "every": checkpoint_every}
    if watchers:
        manifest["watchers"] = [type(watcher).__name__ for watcher in watchers]
    if journal is not None:
        journal.begin(system, grid, manifest, first, record_every)

    def make() -> Simulation:
        watching: dict[str, Any] = {"where": where, "guard": guard}
        if free:
            model = CoupledModel(
                system, grid.start, grid.bound, fmi_version, record, loops=solve_loops, source=source, **watching
            )
            accuracy: dict[str, Any] = {"solver": solver, "rtol": rtol, "atol": atol}
            return CoupledSimulation(model, grid, record_every=record_every, where=where, **accuracy)
        session: dict[str, Any] = {
            "step": grid.step,
            "start_time": grid.start,
            "steps": grid.steps,
            "stop_time": grid.stop,
            "fmi_version": fmi_version,
            "stepping": stepping,
            "record": list(recording.ports),
            "record_every": record_every,
            "external": () if source is None else source.names,
            "may_go_on": checkpoint is not None or resume is not None,
            "solver": solve_loops,
            **watching,
        }
        made = Session(system, **session) if adaptive is None else AdaptiveSession(system, adaptive, **session)
        made.source = source
        return made

    states: list[Floats] = []
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
        kept = np.array(states[:n]).reshape(-1, len(state_names)) if state_names else np.empty((n, 0))
        return Result(system, times[:n], recording.data[:n], recording.ports, manifest, kept, state_names)

    try:
        with watched_life(make, where, timeout, manifest) as (simulation, watched):
            watched.stop = simulation.stop
            if isinstance(simulation, CoupledSimulation):
                states, state_names = simulation.states, simulation.model.state_names
            if saved is not None and isinstance(simulation, Session):
                watched(partial(saved.apply, simulation))
            driver = Driver(
                simulation, recording, hooks, watched, where,
                record_every=record_every, timeout=timeout, progress=report,
            )  # fmt: skip
            driver.prepare()
            begin()
            try:
                driver.run()
            finally:
                told = driver.report()
                simulation.notes += [
                    f"{name} of a report is left out: the manifest has it" for name in told if name in manifest
                ]
                manifest.update({name: value for name, value in told.items() if name not in manifest})
                if simulation.ended is not None and recording.filled:
                    times[recording.filled - 1] = driver.row_at
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
