"""Co-simulation whose exchange step is chosen as it goes, by step doubling from saved states."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from math import isfinite
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from orchestration.instances.instance import CallFailed, EndRequested
from orchestration.plan.lowering import Floats
from orchestration.results.result import Recording
from orchestration.running.session import Session

_MOST_HALVINGS = 12
_COARSER = 0.25  # of the tolerance: below, the next interval tries twice the step


def check(simulation: Session, tolerance: float) -> None:
    """Refuse by name what cannot go back to a saved state and on with another step."""
    if not (isfinite(tolerance) and tolerance > 0):
        raise AdcsError(f"adaptive = {tolerance}: expected a positive tolerance")
    for instance in simulation.instances.values():
        interface = instance.fmu.interface("co-simulation")
        if not (instance.can_save and interface.canHandleVariableCommunicationStepSize):
            raise AdcsError(
                f"{instance.name} ({instance.fmu.path.name}) cannot go back to a saved state, or on with another step: "
                "an adaptive exchange step needs canGetAndSetFMUstate and canHandleVariableCommunicationStepSize"
            )
    for component in simulation.system.components.values():
        if component.every > 1:
            raise AdcsError(f"{component.name} communicates at every {component.every} steps: not with adaptive steps")
    for connection in simulation.system.connections:
        if connection.delayed:
            raise AdcsError(f"the connection to {connection.target} is delayed: not with adaptive exchange steps")


class Adaptive:
    """Takes a simulation from one recorded point to the next in 2^j exchange steps.

    The recorded variables after 2^j and after twice as many steps may differ by `tolerance * (1 + |value|)`; the finer
    solution is kept. Points and rows stay where they are.
    """

    def __init__(self, simulation: Session, tolerance: float) -> None:
        check(simulation, tolerance)
        self._simulation, self._tolerance = simulation, tolerance
        self._halvings = 0
        self._taken: Counter[int] = Counter()
        self._rejected = 0

    def run(self, recording: Recording, progress: Callable[[float], Any]) -> None:
        """Fill the recording up to the last point."""
        simulation = self._simulation
        simulation.propagate()
        while True:
            recording.room(1)[0] = simulation.row
            recording.commit(1)
            progress(recording.filled / (simulation.last + 1))
            if simulation.k == simulation.last or simulation.ended is not None:
                return
            try:
                self._interval()
            except EndRequested as end:
                simulation.ended = end
                return
            simulation.k += 1
            simulation.see_end()

    def report(self) -> dict[str, Any]:
        """Which exchange steps (s) were taken in how many intervals, and how many tries were rejected."""
        taken = {f"{self._simulation.step / 2 ** (j + 1):.6g}": n for j, n in sorted(self._taken.items())}
        return {"tolerance": self._tolerance, "intervals_by_exchange_step": taken, "rejected": self._rejected}

    def _interval(self) -> None:
        before = self._simulation.save()
        try:
            while True:
                coarse = self._attempt(self._halvings)
                self._simulation.restore(before)
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
                    failed.time = self._simulation.time
                    raise failed
                self._simulation.restore(before)
            self._taken[self._halvings] += 1
            if error < _COARSER:
                self._halvings = max(0, self._halvings - 1)
        finally:
            self._simulation.free(before)

    def _attempt(self, halvings: int) -> Floats:
        """From the present point to the next one; return the row there."""
        simulation = self._simulation
        n = 2**halvings
        k, grid = simulation.k, simulation.grid
        step = (grid.shorter if k == grid.full and grid.shorter else grid.step) / n
        for i in range(n):
            time = simulation.time + i * step
            if i:
                end = simulation.loop.ending(k + 1)
                if end is not None:
                    end.time = time
                    raise end
                simulation.loop.propagate(k, time)
            simulation.loop.move_on(k, k + 1, time, step)
        simulation.loop.propagate(k, grid.time(k + 1))
        return simulation.row.copy()
