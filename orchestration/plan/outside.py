"""Values that come into a system from outside, over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from orchestration.plan.lowering import Floats


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


class Sources:
    """Several sources as one."""

    def __init__(self, sources: Sequence[Source]) -> None:
        self.names = [name for source in sources for name in source.names]
        self._sources = sources

    def at(self, times: Floats) -> Floats:
        """Return the values at these times (s), (n, number of values)."""
        return np.hstack([source.at(times) for source in self._sources])

    def jump(self, after: float) -> float:
        """Return the next time (s) at which a value jumps or bends; inf if there is none."""
        return min(source.jump(after) for source in self._sources)
