"""Coupled Model Exchange over the points of a run: what drives a co-simulation drives it as well."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.errors import AdcsError
from orchestration.coupled.integrators import SolverName
from orchestration.coupled.model import CoupledModel
from orchestration.coupled.solution import LOOKS, Solution
from orchestration.engine.walk import Rows
from orchestration.fmu.file import Port
from orchestration.grid import SNAP, Grid
from orchestration.instances.instance import EndRequested, Instance, failing_at
from orchestration.plan.lowering import Floats
from orchestration.process.where import Where
from orchestration.system import Value

_LONGEST = 100  # points in one step of the integrator: what begins of itself is not stepped over


class CoupledSimulation:
    """A coupled model that is integrated from point to point, at point `k` of `last`; a context manager.

    A row at the time of an event holds the values after it. If a component ends the simulation, `ended` has the time at
    which it does so, and the row of the point that comes next is one of that time. `states` (rows, number of states)
    are those of the rows.
    """

    def __init__(
        self,
        model: CoupledModel,
        grid: Grid,
        solver: SolverName,
        rtol: float,
        atol: float,
        *,
        longest: float | None = None,
        record_every: int = 1,
        where: Where | None = None,
    ) -> None:
        """`longest` is the longest step of the integrator (s): 100 points if none is given."""
        self.model, self.grid = model, grid
        self.system, self.last = model.system, grid.steps
        self.k = 0
        self._every, self._where = record_every, where or Where()
        self._solution = Solution(
            model,
            grid.start,
            SNAP * grid.step,
            solver,
            rtol,
            atol,
            end=grid.time(grid.steps),
            longest=_LONGEST * grid.step if longest is None else longest,
            apart=grid.step / LOOKS,
        )
        self._row = np.empty(sum(port.size for port in model.ports.values()))
        self._kept: list[Rows] = []
        self.notes: list[str] = []
        self.ended: EndRequested | None = None
        """The wish of a component to end the simulation, once it has come about."""

    def __enter__(self) -> CoupledSimulation:
        return self

    def __exit__(self, *error: Any) -> None:
        self.model.__exit__(*error)

    @property
    def ports(self) -> Mapping[str, Port]:
        """The recorded variables by name, in the order of a row."""
        return self.model.ports

    @property
    def states(self) -> Floats:
        """Those of the rows; behind them there may be room for more, where it has not come to an end."""
        if not self._kept:
            return np.empty((0, len(self.state_names)))
        return np.concatenate([*(rows.states[: rows.written] for rows in self._kept[:-1]), self._kept[-1].states])

    @property
    def state_names(self) -> list[str]:
        """The names of `states`."""
        return self.model.state_names

    @property
    def instances(self) -> Mapping[str, Instance]:
        """The components by name."""
        return self.model.instances

    @property
    def warnings(self) -> list[str]:
        """What the FMUs warned of, what they changed that was not theirs, and what else there is to be told."""
        return self.model.warnings + self.notes

    @property
    def time(self) -> float:
        """The time of the present point [s]."""
        return self.grid.time(self.k)

    @property
    def row(self) -> Floats:
        """The row of the point that was taken last."""
        return self._row

    @property
    def shorter_due(self) -> bool:
        """No step is a special one."""
        return False

    def check(self) -> None:
        """Nothing is to be looked at between two points."""

    def check_change(self, name: str, value: Value) -> object:
        """Refuse a variable that may not be set during a run."""
        return self.model.check_change(name, value)

    def shows(self, name: str) -> bool:
        """Everything that is set at a point shows in its row, which holds the values after an event."""
        return True

    def set(self, name: str, value: Value) -> None:
        """Set an unconnected input or a tunable parameter at the present point."""
        with failing_at(self.time):
            self._solution.reach(self.time)
            if self.model.ended is None:
                self._solution.change(name, value)

    def advance(self, count: int, rows: Floats, *, stay: bool = False) -> tuple[int, int, AdcsError | None]:
        """Take `count` points from the present one on, recorded in `rows`.

        Returns the point that comes next, the number of rows, and what failed.
        """
        if count == 0:
            return self.k, 0, None
        points = np.arange(self.k, self.k + count)
        kept = self._asked(points[(points % self._every == 0) | (points > self.grid.full)], rows, self._where)
        self._kept.append(kept)
        failed: AdcsError | None = None
        stopped = False
        try:
            self._solution.record(kept)
            if kept.written and kept.points[-1] == points[-1]:
                self._row[:] = rows[kept.written - 1]
            else:  # the last point is to be seen, though it is not kept
                self._solution.record(self._asked(points[-1:], self._row[None, :], None))
        except AdcsError as error:
            failed = error
        except KeyboardInterrupt:
            stopped = True
        if self.model.ended is not None and failed is None:
            self.model.row(self._solution.time, self._solution.x, self._row)
            failed = self.ended = self.model.ended
        return self._come_to(count) if failed or stopped else self.k + count, kept.written, failed

    def _asked(self, points: NDArray[np.int64], rows: Floats, where: Where | None) -> Rows:
        return Rows(self.grid.at(points), points, rows, len(self.state_names), where)

    def _come_to(self, count: int) -> int:
        """Return the first of the next points that could not be taken, or the one after them."""
        covered = self._solution.time - SNAP * self.grid.step
        return next((k for k in range(self.k, self.k + count) if self.grid.time(k) >= covered), self.k + count)

    def end_row(self) -> Floats:
        """Return the row of the time at which a component ended the simulation."""
        end = Rows(np.array([self._solution.time]), np.array([self.k]), self._row[None, :], len(self.state_names))
        end.take(lambda _, row: self._solution.x)
        self._kept.append(end)
        return self._row

    def leave(self) -> None:
        """Go on to the next point."""
        self.k += 1

    def shorter_step(self) -> None:
        """Steps of the integrator are as long as it likes."""

    @property
    def external(self) -> Sequence[str]:
        """The inputs whose values come from outside."""
        return self.model.external

    def memory(self) -> dict[str, NDArray[Any]]:
        """Return what has to be kept to go on from here, besides the components' states."""
        time, x, length = self._solution.origin
        events = [self.model.next_events[name] for name in sorted(self.model.next_events)]
        return {"walk": np.array([time, length]), "x": x, "next_events": np.array(events)}

    def remember(self, k: int, memory: Mapping[str, NDArray[Any]]) -> None:
        """Go on at point k with what `memory` gave; the components are there already."""
        self.k = k
        self.model.next_events = dict(zip(sorted(self.model.next_events), memory["next_events"].tolist(), strict=True))
        time, length = memory["walk"].tolist()
        self._solution.resume(time, memory["x"], length)

    def report(self) -> dict[str, Any]:
        """Return what the manifest is to have of it."""
        loops = {"algebraic_loops": self.model.loop_reports} if self.model.loop_reports else {}
        return {"integrator": self._solution.report, **loops}

    def stop(self, at_once: bool = False) -> None:
        """Let `advance` return; to be called from another thread."""
        self._solution.stop()
