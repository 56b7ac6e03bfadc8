"""Co-simulation: propagate, record, step every component to the next point. Compiled, or the same from Python."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import inf
from pathlib import Path
from time import perf_counter
from typing import Any, Protocol

import numpy as np

from fmus.errors import AdcsError
from orchestration import checkpoint
from orchestration.adaptive import Adaptive
from orchestration.checkpoint import Checkpoint
from orchestration.fmu import FmiVersion
from orchestration.grid import Grid
from orchestration.instance import CallFailed
from orchestration.live import Change, Condition, Inputs, Pace
from orchestration.loops import LoopSolver
from orchestration.plan import Floats
from orchestration.results import Recording
from orchestration.session import CoSimulation, Stepping
from orchestration.system import System
from orchestration.watch import Hung, Watched

Progress = Callable[[float], Any]

_PATIENCE = 0.1  # s, between two looks at progress
_MOST = 1_000_000  # points between two looks
_GIVEN_UP: list[CoSimulation] = []


class Watcher(Protocol):
    """Takes part in a run, point by point."""

    def __call__(self, simulation: CoSimulation) -> Sequence[Change]:
        """See the point that was recorded last, `simulation.k - 1`; return changes to make at point `simulation.k`."""
        ...

    def report(self) -> Mapping[str, Any]:
        """Return what the manifest is to have of it."""
        ...


@dataclass(frozen=True)
class Course:
    """What happens during a co-simulation, besides time going on.

    `timeout` is how long (s) a single call of a component may take.
    """

    changes: Sequence[Change] = ()
    inputs: Inputs | None = None
    until: Condition | None = None
    pace: Pace | None = None
    timeout: float = inf
    record_every: int = 1
    solver: LoopSolver | None = None
    adaptive: float | None = None
    checkpoint: Path | None = None
    checkpoint_every: float | None = None  # s
    resume: Checkpoint | None = None
    watchers: Sequence[Watcher] = ()


def cosimulate(
    system: System,
    grid: Grid,
    recording: Recording,
    version: FmiVersion = "2.0",
    stepping: Stepping = "compiled",
    course: Course | None = None,
    progress: Progress = lambda fraction: None,
    begin: Callable[[], None] = lambda: None,
    account: dict[str, Any] | None = None,
) -> None:
    """Fill the recording and the account (warnings, loops, lateness). Raises CallFailed, with what was recorded kept.

    `begin` is called between initialisation and the first row. KeyboardInterrupt comes between two steps.
    """
    course = course or Course()
    account = {} if account is None else account
    with CoSimulation(
        system,
        step=grid.step,
        start_time=grid.start,
        steps=grid.steps,
        fmi_version=version,
        stepping=stepping,
        record=list(recording.ports),
        record_every=course.record_every,
        external=course.inputs.names if course.inputs else (),
        may_go_on=course.checkpoint is not None or course.resume is not None,
        solver=course.solver,
    ) as simulation:
        if course.checkpoint is not None:
            checkpoint.check(simulation)
        if course.resume is not None:
            course.resume.apply(simulation)
        adaptive = None if course.adaptive is None else Adaptive(simulation, course.adaptive)
        driver = _Driver(simulation, recording, course, progress)
        begin()
        try:
            if adaptive is not None:
                adaptive.run(recording, progress)
            else:
                driver.run()
        finally:
            if adaptive is not None:
                account["adaptive"] = adaptive.report()
            account["warnings"] = [*account.get("warnings", ()), *simulation.warnings]
            if simulation.loop_reports:
                account["algebraic_loops"] = simulation.loop_reports
            if course.pace is not None:
                account["real_time"] = course.pace.report()
            for watcher in course.watchers:
                account |= watcher.report()
            if driver.met_at is not None:
                account["stopped"] = driver.met_at


class _Driver:
    """Takes a co-simulation through its points in pieces, each until something is to be done."""

    def __init__(self, simulation: CoSimulation, recording: Recording, course: Course, progress: Progress) -> None:
        self._simulation, self._recording, self._course, self._progress = simulation, recording, course, progress
        self._pending = sorted((c for c in course.changes if c.k >= simulation.k), key=lambda change: change.k)
        self._saves = _Saves(simulation, course)
        for change in self._pending:
            change.check(simulation)
        self.met_at: dict[str, Any] | None = None

    def run(self) -> None:
        simulation = self._simulation
        watched = Watched(lambda: simulation.loop.doing, simulation.loop.stop, self._course.timeout)
        if self._course.pace is not None:
            self._course.pace.start(simulation.k)
        count = 16
        try:
            while simulation.k <= simulation.last and self.met_at is None:
                while self._pending and self._pending[0].k == simulation.k:
                    change = self._pending.pop(0)
                    now = (simulation.k, change.name.partition(".")[0], f"setting {change.name}")
                    watched(partial(change.apply, simulation), partial(tuple, now))
                began = perf_counter()
                try:
                    n = self._allowed(count)
                except KeyboardInterrupt:  # while waiting for the time to go on
                    self._saves.last()
                    raise
                self._advance(watched, n)
                for watcher in self._course.watchers:
                    self._pending = [*watcher(simulation), *self._pending]
                self._progress((simulation.k) / (simulation.last + 1))
                if watched.interrupted:
                    self._saves.last()
                    raise KeyboardInterrupt
                self._saves.due()
                pace = _PATIENCE / max(perf_counter() - began, 1e-6)
                count = max(1, min(int(count * min(pace, 8.0)), _MOST))
            self._saves.last()
        except Hung as hung:
            k, name, action = hung.doing
            # the call may come back: nothing that it, or what comes after it, works on may be freed
            simulation.loop.stop(at_once=True)
            for instance in simulation.instances.values():
                instance.abandon()
            _GIVEN_UP.append(simulation)
            if watched.interrupted:
                raise KeyboardInterrupt from None
            failed = CallFailed(name or "the system", f"{action} did not return within {self._course.timeout:g} s")
            failed.time = simulation.start + k * simulation.step
            raise failed from None
        finally:
            watched.close()

    def _allowed(self, count: int) -> int:
        """How many points may be taken at once."""
        simulation = self._simulation
        room = self._recording.capacity * self._course.record_every
        count = max(1, min(count, simulation.last + 1 - simulation.k, room))
        if self._pending:
            count = min(count, self._pending[0].k - simulation.k)
        count = min(count, self._saves.points())
        if self._course.watchers:
            count = 1
        if self._course.pace is not None:
            count = min(count, self._course.pace.wait(simulation.k))
        return count

    def _advance(self, watched: Watched, n: int) -> None:
        simulation, recording, course = self._simulation, self._recording, self._course
        first = simulation.k
        every = course.record_every
        rows = recording.room((first + n - 1) // every - (first - 1) // every)
        outside: Floats | None = None
        if course.inputs is not None:
            times = simulation.start + np.arange(first, first + n, dtype=np.float64) * simulation.step
            outside = course.inputs.at(times)
        try:
            simulation.k, written, failed = watched(
                lambda: simulation.loop.steps(
                    simulation.start, simulation.step, first, n, simulation.last, outside, rows
                )
            )
        except Hung as hung:
            k, _, action = hung.doing
            last = k if action == "doStep" else k - 1  # point k is recorded before it is stepped on from
            recording.commit(max(0, last // every - (first - 1) // every))
            raise
        kept = written
        if course.until is not None and (met := course.until.first(rows[:written])) is not None:
            kept, failed = met + 1, None
            k = ((first - 1) // every + 1 + met) * every
            self.met_at = {"condition": str(course.until), "time": simulation.start + k * simulation.step}
        recording.commit(kept)
        if failed is not None:
            raise failed


class _Saves:
    """The checkpoints of a run: every so often, and at its end."""

    def __init__(self, simulation: CoSimulation, course: Course) -> None:
        self._simulation, self._path = simulation, course.checkpoint
        self._one_by_one = course.until is not None  # the state has to be that of the row that meets it
        self._every = None
        if self._path is not None:
            slow = any(component.every > 1 for component in simulation.system.components.values())
            if self._one_by_one and slow:
                raise AdcsError(
                    "checkpoint: not together with until, where a component communicates at some points only"
                )
            if not checkpoint.aligned(simulation, simulation.last):
                raise checkpoint.not_aligned(simulation, simulation.last)
        if course.checkpoint_every is not None:
            if not course.checkpoint_every > 0:
                raise AdcsError(f"checkpoint_every = {course.checkpoint_every:g} s: expected a positive time")
            self._every = Grid.make(0.0, course.checkpoint_every, simulation.step).steps
            if not checkpoint.aligned(simulation, self._every):
                raise checkpoint.not_aligned(simulation, self._every)

    def points(self) -> int:
        """How many points may be taken at once."""
        if self._path is None:
            return _MOST
        if self._one_by_one:
            return 1
        return _MOST if self._every is None else self._every - self._simulation.k % self._every

    def due(self) -> None:
        """Save, if it is time to."""
        k = self._simulation.k
        if self._path is not None and self._every is not None and k % self._every == 0 and k <= self._simulation.last:
            checkpoint.write(self._simulation, k, self._path)

    def last(self) -> None:
        """Save where the run ended."""
        k = min(self._simulation.k, self._simulation.last)
        if self._path is not None and checkpoint.aligned(self._simulation, k):  # it was interrupted, if not
            checkpoint.write(self._simulation, k, self._path)


def steps(
    system: System,
    *,
    stop_time: float,
    step: float,
    start_time: float = 0.0,
    fmi_version: FmiVersion = "2.0",
    record: Sequence[str] | None = None,
) -> Iterator[tuple[float, Mapping[str, Floats]]]:
    """Co-simulate step by step: yield (t_k, values by name) at every communication point, before stepping on from it.

    The values are those that `run` records, to the last bit. Time goes on only while the caller asks for more.
    """
    grid = Grid.make(start_time, stop_time, step)
    with CoSimulation(
        system, step=step, start_time=grid.start, steps=grid.steps, fmi_version=fmi_version, record=record
    ) as simulation:
        yield from simulation
