"""Values that come into a system from outside, over time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from fmus.errors import AdcsError, shown
from orchestration.plan.lowering import Floats


@runtime_checkable
class Source(Protocol):
    """Gives the inputs `names` their values, one after the other."""

    @property
    def names(self) -> Sequence[str]:
        """The inputs, `component.variable` or an element."""
        ...

    def at(self, times: Floats) -> Floats:
        """Return the values at these times (s), (n, number of values)."""
        ...

    def jump(self, after: float) -> float:
        """Return the next time (s) at which a value jumps or bends; inf if there is none."""
        ...


@dataclass(frozen=True)
class Lines:
    """Values on straight lines between `times` (n,), in s; before the first and after the last they hold.

    `values` (n, number of values) are those at the times, `slopes` (n, number of values) those from each to the next.
    """

    times: Floats
    values: Floats
    slopes: Floats

    def only(self, columns: NDArray[np.bool_]) -> Lines:
        """Return some of the values."""
        return Lines(self.times, self.values[:, columns], self.slopes[:, columns])


class Straight:
    """A source that need not be asked between two jumps, since its values are on straight lines.

    Sources of others are none, whatever attributes they have: the lines are followed without being looked at.
    """

    lines: Sequence[Lines] | None
    """Those that `at` goes by, side by side; None if it has to be asked after all."""


class Sources(Straight):
    """Several sources as one, whose answers are looked at: they may be anybody's."""

    def __init__(self, sources: Sequence[Source], size: Callable[[str], int]) -> None:
        """`size` tells how many values a name stands for."""
        self.names = [name for source in sources for name in source.names]
        self._sources = [(source, sum(size(name) for name in source.names)) for source in sources]
        lines = [lines_of(source) for source in sources]
        self.lines = None if None in lines else [line for some in lines for line in some or ()]

    def at(self, times: Floats) -> Floats:
        """Return the values at these times (s), (n, number of values)."""
        return np.hstack([_asked(source, times, width) for source, width in self._sources])

    def jump(self, after: float) -> float:
        """Return the next time (s) at which a value jumps or bends; inf if there is none."""
        return min(source.jump(after) for source, _ in self._sources)


def lines_of(source: Source | None) -> Sequence[Lines] | None:
    """Return the lines that a source follows; None if it has to be asked."""
    return source.lines if isinstance(source, Straight) else None


def _asked(source: Source, times: Floats, width: int) -> Floats:
    name = f"{type(source).__name__}.at"
    try:
        values = np.asarray(source.at(times), float)
    except AdcsError:
        raise
    except Exception as error:
        raise AdcsError(f"{name} raised {type(error).__name__}: {shown(str(error))}") from error
    if values.shape != (len(times), width):
        raise AdcsError(
            f"{name} returned values of shape {values.shape}: expected {(len(times), width)}, a row for each time"
        )
    return values
