"""DOP853, compiled: the usual integrator."""

from __future__ import annotations

from typing import Any

from fmus.errors import AdcsError
from orchestration.coupled import integrators
from orchestration.coupled.integrators import Terms, too_many
from orchestration.coupled.model import CoupledModel
from orchestration.engine.walk import Outcome, Rows, Taken
from orchestration.plan.lowering import Floats


class Dop853:
    """Its continuous extension gives rows; where an event was, the step that leads there is made again, shorter."""

    def __init__(self, model: CoupledModel, terms: Terms) -> None:
        self._model, self._terms = model, terms
        self._taken = Taken()
        self._walk, self._spare = (integrators.walk_of(model, terms, self._taken) for _ in range(2))

    @property
    def began(self) -> float:
        """Where the last step began [s]."""
        return self._walk.began

    @property
    def time(self) -> float:
        """Where it has come to [s]."""
        return self._walk.time

    @property
    def x(self) -> Floats:
        """The state there."""
        return self._walk.x

    @property
    def covered(self) -> float:
        """Up to where the last step gives rows [s]."""
        return self._terms.covered(self.began, self.time)

    def settle(self) -> None:
        """Bring no component to a time before the present one any more."""
        self._walk.settle()

    @property
    def origin(self) -> tuple[float, Floats, float]:
        """Time, state and length [s] with which `restart` makes the last steps again, and goes on as a longer run."""
        return self._walk.origin

    def restart(self, t: float, x: Floats, length: float = 0.0) -> None:
        """Go on from (t, x), with what was learned before forgotten, but for the length of a step (s), if given."""
        for walk in (self._walk, self._spare):
            walk.tolerances[:] = self._terms.atol * self._model.nominals
        self._walk.restart(t, x, length)
        if self._taken.since == 0:
            self._taken.row = t

    def go(self, until: float, bound: float, rows: Rows) -> bool:
        """Go on; see Integrator."""
        outcome = self._walk.go(until, bound, rows)
        if outcome == Outcome.STOPPED:
            raise KeyboardInterrupt
        if outcome == Outcome.TOO_SHORT:
            raise AdcsError(
                f"DOP853 cannot go on from t = {self.time:.9g} s: its steps become too small for time to "
                "go on; loosen the tolerances, or look for a state that diverges or jumps"
            )
        if outcome == Outcome.TOO_MANY:
            raise too_many("DOP853", self._taken.row, self.time, min(rows.next, bound))
        return outcome == Outcome.LOOK

    def sketch(self, t: float) -> Floats:
        """Return the state at a time within the last step, from the continuous extension."""
        return self._walk.between(t)

    def at(self, t: float) -> Floats:
        """Return the state at a time within the last step, by a shorter step."""
        if t == self.time:
            return self.x
        return self._walk.shorter(t, self._spare).copy()

    def back(self, t: float) -> None:
        """Let the last step end at a time within it."""
        if t != self.time:
            self._walk.shorter(t, self._spare)
            self._walk, self._spare = self._spare, self._walk

    def stop(self) -> None:
        """Let `go` return; to be called from another thread."""
        self._model.stop()

    @property
    def report(self) -> dict[str, Any]:
        """What it has taken, for the manifest."""
        return self._taken.report
