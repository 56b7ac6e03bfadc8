"""A change is tried on a copy of the component first: a value that the component refuses would end the run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from orchestration.running.session import Session
from orchestration.system import NUMERIC, System


class Trial:
    """Remembers the values that were set, and tries a new one together with them."""

    def __init__(self, system: System, step: float) -> None:
        self._system, self._step = system, step
        self._set: dict[str, Any] = {}

    def refused(self, name: str, value: Any) -> str | None:
        """Return why a value cannot be set, None if it can."""
        component = self._system.components[name.partition(".")[0]]
        copy = System("trial")
        try:
            copy.add(component.name, component.source, self._start(component.name))
            copy.set(name, value)
            with Session(copy, step=self._step * component.every, steps=1) as simulation:
                simulation.propagate()
                simulation.move_on()
        except AdcsError as error:
            return str(error)
        return None

    def keep(self, changes: Sequence[tuple[str, Any]]) -> None:
        """Remember values that were set."""
        self._set.update(changes)

    def _start(self, name: str) -> dict[str, Any]:
        """All start values of the component; what is connected in the system has one too, as nothing feeds it here."""
        component = self._system.components[name]
        start = {
            port.name: np.reshape(port.start, port.shape)
            for port in component.fmu.ports.values()
            if port.causality == "input" and port.type.startswith(NUMERIC) and port.start is not None
        }
        start |= {v: np.reshape(values, component.fmu.ports[v].shape) for v, values in component.start.items()}
        start |= {k.partition(".")[2]: v for k, v in self._set.items() if k.partition(".")[0] == name}
        return start
