"""Takes a simulation through the points of a run, with all that takes part in it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from time import perf_counter
from typing import Any

from fmus.errors import AdcsError
from orchestration.instances.instance import EndRequested
from orchestration.instances.life import hung_failure
from orchestration.process.watch import Hung, Unwatched, Watched
from orchestration.results.result import Recording
from orchestration.running.asking import ask
from orchestration.running.change import Change
from orchestration.running.hook import MOST, Hook, overrides, together
from orchestration.running.simulation import Simulation

Progress = Callable[[float], Any]

_PATIENCE = 0.1  # s, between two looks at progress


class Driver:
    """Takes a simulation through its points in pieces, each until something is to be done."""

    def __init__(
        self,
        simulation: Simulation,
        recording: Recording,
        hooks: Sequence[Hook],
        watched: Watched | Unwatched,
        *,
        record_every: int = 1,
        timeout: float,
        progress: Progress = lambda fraction: None,
    ) -> None:
        self.simulation, self._recording, self._hooks = simulation, recording, hooks
        self._watched = watched
        self._every, self._timeout, self._progress = record_every, timeout, progress
        self.row_at = float("-inf")
        """The time of the last row [s]."""
        # what is asked at each point, of those only that have an answer of their own
        self._afters = [partial(ask, hook, "after") for hook in hooks if overrides(hook, "after")]
        self._changes = [partial(ask, hook, "changes") for hook in hooks if overrides(hook, "changes")]
        self._mets = [hook for hook in hooks if overrides(hook, "met")]
        paced = [hook for hook in hooks if any(overrides(hook, each) for each in ("ahead", "after", "changes"))]
        self._aheads = [partial(ask, hook, "ahead") for hook in paced]
        self.met: dict[str, Any] | None = None
        """The condition that ended the run, and when."""

    def prepare(self) -> None:
        """Let everyone see the run; AdcsError from who cannot take part in it."""
        for hook in self._hooks:
            ask(hook, "begin", self.simulation, self._hooks, self._watched)

    def report(self) -> dict[str, Any]:
        """Return what the manifest is to have of the run."""
        ended = self.simulation.ended
        reports: dict[str, Any] = {}
        for hook in self._hooks:
            try:
                reports = together(reports, ask(hook, "report"))
                self.simulation.notes += ask(hook, "notes")
            except AdcsError as error:  # the run itself is as good as it was
                self.simulation.notes.append(str(error))
        return {
            **self.simulation.report(),
            **reports,
            **({"stopped": self.met} if self.met is not None else {}),
            **({"ended": ended.as_dict()} if ended is not None else {}),
        }

    def run(self) -> None:
        """Go on to the end. Raises CallFailed, and KeyboardInterrupt between two points; the rows are kept."""
        simulation, watched = self.simulation, self._watched
        count = 16
        try:
            while simulation.k <= simulation.last and self.met is None and simulation.ended is None:
                if simulation.shorter_due and not self._shorter_step():
                    break
                after = self._change()
                began = perf_counter()
                try:
                    n = self._allowed(1 if after else count)
                except KeyboardInterrupt:  # while waiting for the time to go on
                    self._end()
                    raise
                first = simulation.k
                self._advance(n, after)
                simulation.check()
                self._progress(simulation.k / (simulation.last + 1))
                self._tell(first)
                if watched.interrupted:
                    self._end()
                    raise KeyboardInterrupt
                pace = _PATIENCE / max(perf_counter() - began, 1e-6)
                count = max(1, min(int(count * min(pace, 8.0)), MOST))
            if simulation.ended is None:  # else nobody could go on
                self._end()
        except Hung as hung:
            simulation.stop(at_once=True)  # the call may come back
            if watched.interrupted:
                raise
            failed = hung_failure(hung, self._timeout)
            failed.time = simulation.grid.time(max(hung.doing[0], simulation.k))
            raise failed from None

    def _end(self) -> None:
        for hook in self._hooks:
            ask(hook, "end")

    def _tell(self, first: int) -> None:
        """Show everyone the point that was taken last, if any from `first` on was, and an end that has a row."""
        simulation, point = self.simulation, self.simulation.k - 1
        if point >= first:
            self._show(point, simulation.grid.time(point))
        if simulation.ended is not None and self._last_row():
            self._show(point + 1, self.row_at)

    def _show(self, point: int, time: float) -> None:
        for after in self._afters:
            after(point, time)

    def _allowed(self, count: int) -> int:
        """How many points may be taken at once."""
        simulation, k = self.simulation, self.simulation.k
        room = self._recording.capacity * self._every
        ahead = (simulation.grid.full if k <= simulation.grid.full else simulation.last) + 1 - k
        count = max(1, min(count, ahead, room))
        for asked in self._aheads:
            count = min(count, asked(k))
        return count

    def _change(self) -> list[Change]:
        """Make the changes that belong to the present point; return those that are to be made after its row."""
        after: list[Change] = []
        k = self.simulation.k
        for change in [change for changes in self._changes for change in changes(k)]:
            if change.may_follow(self.simulation):
                after.append(change)
            else:
                self._apply(change)
        return after

    def _apply(self, change: Change) -> None:
        now = (self.simulation.k, change.name.partition(".")[0], f"setting {change.name}")
        self._watched(partial(change.apply, self.simulation), partial(tuple, now))

    def _advance(self, n: int, after: Sequence[Change]) -> None:
        simulation, recording = self.simulation, self._recording
        first = simulation.k
        every = self._every if first <= simulation.grid.full else 1  # the end of a shorter step is recorded
        rows = recording.room((first + n - 1) // every - (first - 1) // every)
        filled, complete = recording.filled, recording.where.place.rows
        try:
            k, kept, failed = self._watched(lambda: simulation.advance(n, rows, stay=bool(after)))
        except Hung:
            recording.commit(min(recording.where.place.rows - complete, len(rows)))
            raise
        if self._mets:
            times = simulation.grid.rows(first, every, kept)
            for hook in self._mets:
                try:
                    met = ask(hook, "met", times[:kept], rows[:kept])
                except AdcsError:
                    recording.commit(kept)
                    raise
                if met is not None and (self.met is None or met + 1 < kept):
                    kept, failed = met + 1, None
                    self.met = {"condition": str(hook)}
        recording.commit(kept)
        if recording.filled > filled:
            self.row_at = simulation.grid.time(-(-first // every) * every + (kept - 1) * every)
        if self.met is not None:
            self.met["time"] = float(self.row_at)
        stays = bool(after) and k > first and failed is None and self.met is None
        simulation.k = first if stays else k
        if failed is not None and not isinstance(failed, EndRequested):
            raise failed
        if stays:
            self._leave(after)

    def _leave(self, after: Sequence[Change]) -> None:
        """Make changes after the row of a point was recorded, and go on from it."""
        for change in after:
            self._apply(change)
        self._step(self.simulation.leave)
        if self.simulation.ended is not None:
            self.simulation.k += 1  # the point itself was taken

    def _shorter_step(self) -> bool:
        """Take a last step that is shorter; return whether its end was reached, where no component ended before."""
        self._step(self.simulation.shorter_step)
        if self.simulation.ended is not None:
            self._tell(self.simulation.k)
        return self.simulation.ended is None

    def _step(self, step: Callable[[], None]) -> None:
        try:
            self._watched(step)
        except EndRequested:
            assert self.simulation.ended is not None

    def _last_row(self) -> bool:
        """Record the end that a component asked for, unless its point is recorded; return whether it was."""
        ended = self.simulation.ended
        if ended is None or ended.time is None or ended.time <= self.row_at:
            return False
        row = self._watched(self.simulation.end_row)
        if row is None:
            return False
        self._recording.room(1)[0] = row
        self._recording.commit(1)
        self.row_at = ended.time
        return True
