"""What a change would do to a run: tried on a copy of the whole system, some time ahead of the run itself."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from time import monotonic
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from hil_bridge.wire import FLOAT32_MOST
from orchestration.running.session import Session

_POINTS = 2000
_PATIENCE = 0.03  # s on the clock; the run waits meanwhile
_AT_ONCE = 50  # points, between two looks at the clock

Changes = Sequence[tuple[str, Any]]


class Forecast:
    """Runs a copy of a co-simulation ahead from where it is, with what a ground station wants to change.

    The run itself is only read: its components give their states, and those of the copy take them. Where a component
    cannot do that (canSerializeFMUstate) there is no forecast, and `possible` is False.
    """

    def __init__(self, live: Session) -> None:
        self._live = live
        self._copy: Session | None = None
        self.possible = all(instance.can_serialize for instance in live.instances.values())

    def refused(self, changes: Changes) -> str | None:
        """Return how the run would end with the changes made now, None if it would not as far as can be seen.

        Looked at are the next 2000 points, or those that 30 ms are enough for. A value beyond what float32 holds counts
        as an end: no message could tell it, and what grows so far grows on.
        """
        live = self._live
        count = min(_POINTS, live.last - live.k)
        if not self.possible or count <= 0:
            return None
        healthy = False
        try:
            copy = self._at_present()
            for name, value in changes:
                copy.set(name, value)
            ended = self._ahead(copy, count)
            healthy = ended is None
        except AdcsError as error:
            ended = str(error)
        finally:
            if not healthy:  # after a failure FMI lets a component do little else than end
                self.close()
        return ended

    def close(self) -> None:
        """Free the copy; it is made anew when it is needed."""
        if self._copy is not None:
            with suppress(AdcsError):
                self._copy.__exit__(None, None, None)
            self._copy = None

    def _at_present(self) -> Session:
        """The copy, in the state of the run."""
        live = self._live
        if self._copy is None:
            version = next(iter(live.instances.values())).fmu.major_version
            self._copy = Session(
                live.system,
                step=live.step,
                start_time=live.start,
                fmi_version="3.0" if version == 3 else "2.0",
                record=list(live.recording.ports),
                external=live.external,
                loops="newton",
            )
        copy = self._copy
        copy.k = live.k
        copy.signals[:] = live.signals
        for here, there in zip(copy.rings, live.rings, strict=True):
            here.values[:] = there.values
        for name, instance in live.instances.items():
            state = instance.save()
            try:
                content = instance.serialize(state)
            finally:
                instance.free(state)
            other = copy.instances[name]
            taken = other.deserialize(content)
            other.restore(taken)
            other.free(taken)
        return copy

    def _ahead(self, copy: Session, count: int) -> str | None:
        until = monotonic() + _PATIENCE
        rows = np.empty((_AT_ONCE, copy.recording.size))
        while count > 0 and monotonic() < until:
            first, n = copy.k, min(_AT_ONCE, count)
            copy.k, written, failed = copy.loop.steps(copy.start, copy.step, first, n, copy.last, None, rows[:n])
            high = np.argwhere(~(np.abs(rows[:written]) <= FLOAT32_MOST))
            if len(high):
                row, column = high[0]
                copy.k = first + int(row)
                return f"{_element(copy, int(column))} grows beyond {FLOAT32_MOST:.1e} by t = {copy.time:.6g} s"
            if failed is not None:
                return str(failed)
            count -= n
        return None


def _element(copy: Session, column: int) -> str:
    for name, port in copy.recording.ports.items():
        if column < port.size:
            return name if port.size == 1 else f"an element of {name}"
        column -= port.size
    raise AssertionError(column)
