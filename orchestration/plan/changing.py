"""Which variables may be set during a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fmus.errors import AdcsError
from orchestration.fmu.file import Port
from orchestration.system import System, Value, checked_value


def checked_change(
    system: System, external: Sequence[str], name: str, value: Value
) -> tuple[str, Port, tuple[Any, ...]]:
    """Return component, port and flat value of a variable that may be set during a run; refuse any other.

    `external` are the inputs that get their values from a table.
    """
    component, port = system.port(name)
    if name.partition(".")[2] != port.name:
        raise AdcsError(f"{name} is one element: give all values of {component}.{port.name}")
    if port.causality == "input":
        places = system.places(name)
        outside = next((n for n in external if places & system.places(n)), None)
        if outside is not None:
            raise AdcsError(f"{name} gets its values from a table: it cannot be set during a run")
        fed = next((c for c in system.connections if places & system.places(c.target)), None)
        if fed is not None:
            raise AdcsError(f"{name} is connected to {fed.source}: it cannot be set during a run")
    elif not (port.causality == "parameter" and port.variability == "tunable"):
        raise AdcsError(
            f"{name} cannot be set during a run: it is {system.components[component].fmu.called(port)}, only "
            "inputs and tunable parameters can"
        )
    return component, port, checked_value(name, port, value)
