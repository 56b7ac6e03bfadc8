"""Co-simulation: propagate, record, step every component to the next point. Compiled, or the same from Python."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from math import inf
from pathlib import Path
from time import perf_counter
from typing import Any, Protocol

import numpy as np

from fmus.errors import AdcsError
from orchestration.fmu.file import FmiVersion
from orchestration.grid import Grid, whole_steps
from orchestration.instances.instance import EndRequested
from orchestration.instances.life import hung_failure, watched_life
from orchestration.plan.loops import LoopSolver
from orchestration.plan.lowering import Floats
from orchestration.process.guard import Guard
from orchestration.process.watch import Hung, Watched
from orchestration.process.where import Where
from orchestration.results.result import Recording
from orchestration.running import checkpoint
from orchestration.running.adaptive import Adaptive
from orchestration.running.checkpoint import Checkpoint
from orchestration.running.live import Change, Condition, Inputs, Pace
from orchestration.running.session import Session, Stepping
from orchestration.system import System

Progress = Callable[[float], Any]

_PATIENCE = 0.1  # s, between two looks at progress
_MOST = 1_000_000  # points between two looks


class Watcher(Protocol):
    """Takes part in a run, point by point."""

    def __call__(self, simulation: Session) -> Sequence[Change]:
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
    where: Where = field(default_factory=Where)
    guard: Guard | None = None


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
    begun = partial(
        Session,
        system,
        step=grid.step,
        start_time=grid.start,
        steps=grid.steps,
        stop_time=grid.stop,
        fmi_version=version,
        stepping=stepping,
        record=list(recording.ports),
        record_every=course.record_every,
        external=course.inputs.names if course.inputs else (),
        may_go_on=course.checkpoint is not None or course.resume is not None,
        solver=course.solver,
        where=course.where,
        guard=course.guard,
    )
    with watched_life(begun, course.where, course.timeout, account) as (simulation, watched):
        watched.stop = simulation.loop.stop
        if course.checkpoint is not None:
            checkpoint.check(simulation, course.checkpoint)
        if course.resume is not None:
            watched(partial(course.resume.apply, simulation))
        adaptive = None if course.adaptive is None else Adaptive(simulation, course.adaptive)
        driver = _Driver(simulation, recording, course, progress, watched)
        begin()
        try:
            if adaptive is not None:
                watched(partial(adaptive.run, recording, progress), throw=True)
            else:
                driver.run()
        finally:
            if adaptive is not None:
                account["adaptive"] = adaptive.report()
            if simulation.loop_reports:
                account["algebraic_loops"] = simulation.loop_reports
            if course.pace is not None:
                account["real_time"] = course.pace.report()
            for watcher in course.watchers:
                account |= watcher.report()
            simulation.notes += driver.saves.notes
            if driver.met_at is not None:
                account["stopped"] = driver.met_at
            if simulation.ended is not None:
                account["ended"] = simulation.ended.as_dict()


class _Driver:
    """Takes a co-simulation through its points in pieces, each until something is to be done."""

    def __init__(
        self,
        simulation: Session,
        recording: Recording,
        course: Course,
        progress: Progress,
        watched: Watched,
    ) -> None:
        self._watched = watched
        self._simulation, self._recording, self._course, self._progress = simulation, recording, course, progress
        self._pending = sorted((c for c in course.changes if c.k >= simulation.k), key=lambda change: change.k)
        self.saves = _Saves(simulation, course)
        for change in self._pending:
            change.check(simulation)
        self.met_at: dict[str, Any] | None = None

    def run(self) -> None:
        simulation, watched = self._simulation, self._watched
        if self._course.pace is not None:
            self._course.pace.start(simulation.k)
        count = 16
        try:
            while simulation.k <= simulation.last and self.met_at is None and simulation.ended is None:
                if simulation.shorter_due:
                    watched(self.saves.last)
                    if not self._shorter_step(watched):
                        break
                after = self._change(watched)
                began = perf_counter()
                try:
                    n = self._allowed(1 if after else count)
                except KeyboardInterrupt:  # while waiting for the time to go on
                    watched(self.saves.last)
                    raise
                self._advance(watched, n, after)
                simulation.check()
                for watcher in self._course.watchers:
                    self._pending = [*watcher(simulation), *self._pending]
                self._progress((simulation.k) / (simulation.last + 1))
                if watched.interrupted:
                    watched(self.saves.last)
                    raise KeyboardInterrupt
                if self.saves.are_due:
                    watched(self.saves.write)
                pace = _PATIENCE / max(perf_counter() - began, 1e-6)
                count = max(1, min(int(count * min(pace, 8.0)), _MOST))
            if simulation.ended is None:  # else nobody could go on
                watched(self.saves.last)
        except Hung as hung:
            simulation.loop.stop(at_once=True)  # the call may come back
            if watched.interrupted:
                raise
            failed = hung_failure(hung, self._course.timeout)
            failed.time = simulation.grid.time(hung.doing[0])
            raise failed from None

    def _allowed(self, count: int) -> int:
        """How many points may be taken at once."""
        simulation = self._simulation
        room = self._recording.capacity * self._course.record_every
        ahead = (simulation.grid.full if simulation.k <= simulation.grid.full else simulation.last) + 1 - simulation.k
        count = max(1, min(count, ahead, room))
        if self._pending:
            count = min(count, self._pending[0].k - simulation.k)
        count = min(count, self.saves.points())
        if self._course.watchers:
            count = 1
        if self._course.pace is not None:
            count = min(count, self._course.pace.wait(simulation.k))
        return count

    def _change(self, watched: Watched) -> list[Change]:
        """Make the changes that belong to the present point; return those that are to be made after its row."""
        after = []
        while self._pending and self._pending[0].k == self._simulation.k:
            change = self._pending.pop(0)
            if change.may_follow(self._simulation):
                after.append(change)
            else:
                self._apply(watched, change)
        return after

    def _apply(self, watched: Watched, change: Change) -> None:
        now = (self._simulation.k, change.name.partition(".")[0], f"setting {change.name}")
        watched(partial(change.apply, self._simulation), partial(tuple, now))

    def _leave(self, watched: Watched, after: Sequence[Change]) -> None:
        """Make changes after the row of a point was recorded, and go on from it."""
        for change in after:
            self._apply(watched, change)
        try:
            watched(self._simulation.leave)
        except EndRequested as end:
            self._simulation.ended = end

    def _advance(self, watched: Watched, n: int, after: Sequence[Change] = ()) -> None:
        simulation, recording, course = self._simulation, self._recording, self._course
        first = simulation.k
        every = course.record_every if first <= simulation.grid.full else 1  # the end of a shorter step is recorded
        rows = recording.room((first + n - 1) // every - (first - 1) // every)
        outside: Floats | None = None
        if course.inputs is not None:
            times = simulation.start + np.arange(first, first + n, dtype=np.float64) * simulation.step
            outside = course.inputs.at(np.minimum(times, simulation.grid.time(simulation.last)))
        try:
            k, written, failed = watched(lambda: simulation.advance(n, outside, rows, stay=bool(after)))
        except Hung as hung:
            k, _, action, *_ = hung.doing
            last = k if action == "doStep" else k - 1  # point k is recorded before it is stepped on from
            recording.commit(max(0, last // every - (first - 1) // every))
            raise
        kept = written
        if course.until is not None and (met := course.until.first(rows[:written])) is not None:
            kept, failed = met + 1, None
            met_at = ((first - 1) // every + 1 + met) * every
            self.met_at = {"condition": str(course.until), "time": simulation.grid.time(met_at)}
        recording.commit(kept)
        stays = bool(after) and k > first and failed is None and self.met_at is None
        simulation.k = first if stays else k
        if isinstance(failed, EndRequested):
            simulation.ended = failed
        elif failed is not None:
            raise failed
        if stays:
            self._leave(watched, after)

    def _shorter_step(self, watched: Watched) -> bool:
        """Take a last step that is shorter; return whether its end was reached, where no component ended before."""
        try:
            watched(self._simulation.shorter_step)
        except EndRequested as end:
            self._simulation.ended = end
        return self._simulation.ended is None


def rigid(system: System, version: FmiVersion) -> str | None:
    """Say why the last step of a co-simulation may not be shorter than the others; None if it may."""
    for component in system.components.values():
        fmu = component.open(version)
        if component.every == 1 and not fmu.interface("co-simulation").canHandleVariableCommunicationStepSize:
            return (
                f", and {component.name} ({fmu.path.name}) takes no shorter last one "
                "(canHandleVariableCommunicationStepSize is not true)"
            )
    return None


class _Saves:
    """The checkpoints of a run: every so often, and at its end.

    A file that cannot be written does not end the run: one line on stderr says so at once, and `notes` at the end.
    """

    def __init__(self, simulation: Session, course: Course) -> None:
        self._simulation, self._path = simulation, course.checkpoint
        self._missing: list[float] = []  # s, times of those that could not be written
        self._trouble = ""
        self._one_by_one = course.until is not None  # the state has to be that of the row that meets it
        self._every = None
        if self._path is not None:
            slow = any(component.every > 1 for component in simulation.system.components.values())
            if self._one_by_one and slow:
                raise AdcsError(
                    "checkpoint: not together with until, where a component communicates at some points only"
                )
            if not checkpoint.aligned(simulation, simulation.grid.full):
                raise checkpoint.not_aligned(simulation, simulation.grid.full)
        if course.checkpoint_every is not None:
            if not course.checkpoint_every > 0:
                raise AdcsError(f"checkpoint_every = {course.checkpoint_every:g} s: expected a positive time")
            self._every = whole_steps(course.checkpoint_every, simulation.step, "checkpoint_every")
            if not checkpoint.aligned(simulation, self._every):
                raise checkpoint.not_aligned(simulation, self._every)

    def points(self) -> int:
        """How many points may be taken at once."""
        if self._path is None:
            return _MOST
        if self._one_by_one:
            return 1
        return _MOST if self._every is None else self._every - self._simulation.k % self._every

    @property
    def are_due(self) -> bool:
        """Whether it is time to save."""
        simulation, k = self._simulation, self._simulation.k
        return self._path is not None and self._every is not None and k % self._every == 0 and k <= simulation.grid.full

    def write(self) -> None:
        """Save at the present point."""
        if self._path is not None:
            self._save(self._simulation.k, self._path)

    def last(self) -> None:
        """Save where the run ended, or before a last step that is shorter, which is on no grid."""
        simulation = self._simulation
        if simulation.k > simulation.grid.full and not simulation.shorter_due and simulation.grid.shorter:
            return
        k = min(simulation.k, simulation.grid.full)
        if self._path is not None and checkpoint.aligned(simulation, k):  # it was interrupted, if not
            self._save(k, self._path)

    def _save(self, k: int, path: Path) -> None:
        simulation = self._simulation
        content = checkpoint.content(simulation, k)
        try:
            checkpoint.write(content, path)
        except AdcsError as error:
            if not self._trouble:
                self._trouble = str(error)
                print(f"adcs: a checkpoint is missing, the run goes on: {error}", file=sys.stderr)
            self._missing.append(simulation.grid.time(k))

    @property
    def notes(self) -> list[str]:
        """What the manifest is to have of it."""
        if not self._missing:
            return []
        times = ", ".join([f"{time:.9g}" for time in self._missing[:3]] + ["..."] * (len(self._missing) > 3))
        return [f"no checkpoint at t = {times} s: {self._trouble}"]


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

    The values are those that `run` records, to the last bit. Time goes on only while the caller asks for more. If a
    component ends the simulation, nothing is yielded after that.
    """
    grid = Grid.make(start_time, stop_time, step, partial(rigid, system, fmi_version))
    times: dict[str, Any] = {"step": step, "start_time": grid.start, "steps": grid.steps, "stop_time": grid.stop}
    with Session(system, **times, fmi_version=fmi_version, record=record) as simulation:
        yield from simulation
