"""What walks along the solution of coupled Model Exchange."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np

from fmus.errors import AdcsError
from orchestration.coupled.model import CoupledModel
from orchestration.engine import library
from orchestration.engine.walk import Rows, Taken, Walk
from orchestration.plan.lowering import Floats

MOST_STEPS = 100_000  # from one row to the next

SolverName = Literal["DOP853", "CVode"]


@dataclass(frozen=True)
class Terms:
    """How a solution is walked along; times in s.

    `rtol` is relative to a state's value, `atol` to its nominal value. No step is longer than `longest`; times that
    differ by at most `instant` are the same; `end` is that of the run. `indicators` holds the event indicators at the
    begin of a step, if there are any: then each step is looked into at `looks` times, or more, for not more than
    `apart` between two of them.
    """

    rtol: float
    atol: float
    longest: float
    instant: float
    end: float
    looks: int
    apart: float
    indicators: Floats

    def looks_into(self, length: float) -> int:
        """Return how often a step of this length is looked into."""
        return int(library().adcs_looks(self.looks, self.apart, length))

    def covered(self, began: float, time: float) -> float:
        """Return up to where a step from `began` to `time` gives rows."""
        return float(library().adcs_covered(began, time, self.instant))


class Integrator(Protocol):
    """Walks along the solution, in steps of its own choice."""

    @property
    def began(self) -> float:
        """Where the last step began [s]."""

    @property
    def time(self) -> float:
        """Where it has come to [s]."""

    @property
    def x(self) -> Floats:
        """The state there."""

    @property
    def covered(self) -> float:
        """Up to where the last step gives rows [s]: what lies within an instant of its end waits for the next."""

    def settle(self) -> None:
        """Bring no component to a time before the present one any more."""

    @property
    def origin(self) -> tuple[float, Floats, float]:
        """Time, state and length [s] with which `restart` makes the last steps again, and goes on as a longer run."""

    def restart(self, t: float, x: Floats, length: float = 0.0) -> None:
        """Go on from (t, x), with what was learned before forgotten, but for the length of a step (s), if given."""

    def go(self, until: float, bound: float, rows: Rows) -> bool:
        """Go on to `until`, or until all rows are written, or the last step is to be looked at; return whether it is.

        No step leads beyond `bound`. None of the rows of a step that is to be looked at are taken. KeyboardInterrupt
        when it was stopped.
        """

    def sketch(self, t: float) -> Floats:
        """Return the state at a time within the last step, cheaply."""

    def at(self, t: float) -> Floats:
        """Return the state at a time within the last step as accurately as at the end of a step."""

    def back(self, t: float) -> None:
        """Let the last step end at a time within it."""

    def stop(self) -> None:
        """Let `go` return; to be called from another thread."""

    @property
    def report(self) -> dict[str, Any]:
        """What it has taken, for the manifest."""


def too_many(name: str, start: float, time: float, target: float) -> AdcsError:
    """Put into words that the way from the last row to the next one could go on for ever."""
    needed = MOST_STEPS * (target - start) / max(time - start, np.spacing(abs(target)))
    return AdcsError(
        f"{name} cannot go on from t = {time:.9g} s: {MOST_STEPS} steps do not reach t = {target:.9g} s, "
        f"{needed:.2g} would be needed: choose a shorter time between rows, or loosen the tolerances"
    )


def walk_of(model: CoupledModel, terms: Terms, taken: Taken) -> Walk:
    """Return a compiled walk on these terms."""
    return model.walk(
        relative=terms.rtol,
        longest=terms.longest,
        instant=terms.instant,
        looks=terms.looks,
        apart=terms.apart,
        indicators=terms.indicators,
        end=terms.end,
        taken=taken,
        most_steps=MOST_STEPS,
    )
