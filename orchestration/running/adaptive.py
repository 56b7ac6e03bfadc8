"""Co-simulation whose exchange step is chosen as it goes, by step doubling from saved states."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from orchestration.instances.instance import CallFailed, EndRequested
from orchestration.plan.lowering import Floats
from orchestration.running.session import Session
from orchestration.system import System, Value

_MOST_HALVINGS = 12
_COARSER = 0.25  # of the tolerance: below, the next interval tries twice the step


def _check(simulation: Session) -> None:
    """Refuse by name what cannot go back to a saved state and on with another step."""
    for instance in simulation.instances.values():
        interface = instance.fmu.interface("co-simulation")
        if not (instance.can_save and interface.canHandleVariableCommunicationStepSize):
            raise AdcsError(
                f"{instance.name} ({instance.fmu.path.name}) cannot go back to a saved state, or on with another step: "
                "an adaptive exchange step needs canGetAndSetFMUstate and canHandleVariableCommunicationStepSize"
            )


def refuse(system: System) -> None:
    """Refuse by name what counts exchange steps, before any component is there."""
    for component in system.components.values():
        if component.every > 1:
            raise AdcsError(f"{component.name} communicates at every {component.every} steps: not with adaptive steps")
    for connection in system.connections:
        if connection.delayed:
            raise AdcsError(f"the connection to {connection.target} is delayed: not with adaptive exchange steps")


class AdaptiveSession(Session):
    """A session that goes from one point to the next in 2^j exchange steps.

    The recorded variables after 2^j and after twice as many steps may differ by `tolerance * (1 + |value|)`; the finer
    solution is kept. Points and rows stay where they are.
    """

    def __init__(self, system: System, tolerance: float, *, record_every: int = 1, **settings: Any) -> None:
        """`settings` are those of a session."""
        super().__init__(system, **settings)
        self._every = record_every
        self._tolerance = tolerance
        self._halvings = 0
        self._taken: Counter[int] = Counter()
        self._rejected = 0
        self._stopped = False
        self._time = self.start
        self._row = self._propagated.copy()
        self._seen = -1  # the point that was propagated last, if nothing was set since
        try:
            _check(self)
        except AdcsError:
            self.__exit__(None, None, None)
            raise

    @property
    def shorter_due(self) -> bool:
        """No step is a special one."""
        return False

    def stop(self, at_once: bool = False) -> None:
        """Let `advance` return before its next step, or before its next call; to be called from another thread."""
        self._stopped = True
        super().stop(at_once)

    def advance(self, count: int, rows: Floats, *, stay: bool = False) -> tuple[int, int, CallFailed | None]:
        """Take `count` points from the present one on, recorded in `rows`.

        Returns the point that comes next, the number of rows, and what failed. With `stay` no component is stepped on
        from the last of them; `leave` does that.
        """
        written = 0
        for k in range(self.k, end := self.k + count):
            try:
                self.k = k
                if self._seen != k:
                    self._propagate(k, self.time)
                self._row = self._propagated.copy()
                if k % self._every == 0 or k > self.grid.full:
                    rows[written] = self._row
                    written += 1
                    self._where.place.rows += 1
                self.see_end()
                if self.ended is not None:
                    return k + 1, written, self.ended
                if k < self.last and not (stay and k == end - 1):
                    self._interval()
            except EndRequested as ended:
                self.ended = ended
                return k + 1, written, ended  # the point itself was taken
            except CallFailed as failed:
                return k, written, failed
            except KeyboardInterrupt:
                return k, written, None
        return end, written, None

    def set(self, name: str, value: Value) -> None:
        """Set an input that nothing feeds, or a tunable parameter, at the present point."""
        self._seen = -1
        super().set(name, value)

    def leave(self) -> None:
        """Go on to the next point."""
        if self.k < self.last:
            try:
                self._interval()
            except EndRequested as end:
                self.ended = end
                raise
        self.k += 1

    @property
    def row(self) -> Floats:
        """The recorded variables at the point that was taken last, which is not the one propagated last."""
        return self._row

    def end_row(self) -> Floats | None:
        """Return the row of the time at which a component ended the simulation."""
        row = super().end_row()
        if row is not None:
            self._row = row
        return row

    @property
    def _propagated_at(self) -> float:
        """The time to which the values belong that were last handed on [s]."""
        return self._time

    def report(self) -> dict[str, Any]:
        """Which exchange steps (s) were taken in how many intervals, and how many tries were rejected."""
        taken = {f"{self.step / 2 ** (j + 1):.6g}": n for j, n in sorted(self._taken.items())}
        adaptive = {"tolerance": self._tolerance, "intervals_by_exchange_step": taken, "rejected": self._rejected}
        return {"adaptive": adaptive, **super().report()}

    def _propagate(self, k: int, time: float) -> None:
        """Propagate at a time, with the values from outside that belong to it."""
        if self.source is not None:
            self.signals[: self.n_external] = self.source.at(np.array([time]))[0]
        self.loop.propagate(k, time)
        self._time = time

    def _interval(self) -> None:
        before = self.save()
        try:
            while True:
                coarse = self._attempt(self._halvings)
                self.restore(before)
                fine = self._attempt(self._halvings + 1)
                error = float(np.max(np.abs(fine - coarse) / (self._tolerance * (1 + np.abs(fine))), initial=0.0))
                if error <= 1:
                    break
                self._rejected += 1
                self._halvings += 1
                if self._halvings > _MOST_HALVINGS:
                    failed = CallFailed(
                        "the system",
                        f"the tolerance {self._tolerance:g} is not met with 2^{_MOST_HALVINGS} exchange steps in one "
                        "interval: look for a value that jumps, or loosen it",
                    )
                    failed.time = self.time
                    raise failed
                self.restore(before)
            self._taken[self._halvings] += 1
            if error < _COARSER:
                self._halvings = max(0, self._halvings - 1)
        finally:
            self.free(before)

    def _attempt(self, halvings: int) -> Floats:
        """From the present point to the next one; return the row there."""
        n = 2**halvings
        k, grid = self.k, self.grid
        step = (grid.shorter if k == grid.full and grid.shorter else grid.step) / n
        for i in range(n):
            if self._stopped:
                raise KeyboardInterrupt
            time = self.time + i * step
            if i:
                end = self.loop.ending(k + 1)
                self._propagate(k, time)
                if end is not None:
                    end.time = time
                    raise end
            self.loop.move_on(k, k + 1, time, step)
        self._propagate(k, grid.time(k + 1))
        self._seen = k + 1
        return self._propagated.copy()
