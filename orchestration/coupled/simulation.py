"""Coupled Model Exchange over the points of a run: what drives a co-simulation drives it as well."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from orchestration.coupled.integrators import SolverName
from orchestration.coupled.model import CoupledModel
from orchestration.coupled.solution import Solution
from orchestration.fmu.file import Port
from orchestration.grid import Grid
from orchestration.instances.instance import EndRequested, Instance, failing_at
from orchestration.plan.lowering import Floats
from orchestration.process.where import Where
from orchestration.system import Value


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
        solver: SolverName = "DOP853",
        rtol: float = 1e-10,
        atol: float = 1e-12,
        *,
        record_every: int = 1,
        where: Where | None = None,
    ) -> None:
        self.model, self.grid = model, grid
        self.system, self.last = model.system, grid.steps
        self.k = 0
        self._every, self._where = record_every, where or Where()
        self._solution = Solution(model, grid.start, 1e-9 * grid.step, solver, rtol, atol)
        self._row = np.empty(sum(port.size for port in model.ports.values()))
        self.states: list[Floats] = []
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
        written = 0
        for k in range(self.k, self.k + count):
            try:
                self._solution.reach(self.grid.time(k))
                self.model.row(self._solution.time, self._solution.x, self._row)
            except AdcsError as failed:
                return k, written, failed
            except KeyboardInterrupt:
                return k, written, None
            if self.model.ended is not None:
                self.ended = self.model.ended
                return k, written, self.ended
            if k % self._every == 0 or k > self.grid.full:
                rows[written] = self._row
                self.states.append(self._solution.x.copy())
                written += 1
                self._where.place.rows += 1
        return self.k + count, written, None

    def end_row(self) -> Floats:
        """Return the row of the time at which a component ended the simulation."""
        self.states.append(self._solution.x.copy())
        return self._row

    def leave(self) -> None:
        """Go on to the next point."""
        self.k += 1

    def shorter_step(self) -> None:
        """Steps of the integrator are as long as it likes."""

    def report(self) -> dict[str, Any]:
        """Return what the manifest is to have of it."""
        return {"algebraic_loops": self.model.loop_reports} if self.model.loop_reports else {}

    def stop(self, at_once: bool = False) -> None:
        """Let `advance` return; to be called from another thread."""
        self._solution.stopped = True
