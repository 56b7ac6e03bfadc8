"""One component as a system, for what is done with systems."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fmus.catalog import find
from fmus.demand import ready_made
from orchestration.system import NUMERIC, System


def single(fmu: str | Path, start: Mapping[str, Any] | None = None) -> System:
    """Return a system of one component: a name in `fmus/dist` or the path of an `.fmu`.

    Inputs that have no start value, here or in the FMU, are zero. `start` may name variables without the component.
    """
    path = Path(fmu)
    ready = path if path.suffix == ".fmu" else ready_made(str(fmu))
    name = find(str(fmu)).name if ready is None else ready.name.partition(".")[0]
    system = System(name)
    system.add(name, fmu)
    component = system.components[name]
    system.description = component.fmu.model.description or ""
    for variable, value in (start or {}).items():
        system.set(variable if variable.startswith(f"{name}.") else f"{name}.{variable}", value)
    for port in component.fmu.ports.values():
        given = component.has_start(port)
        if port.causality == "input" and port.type.startswith(NUMERIC) and not given:
            zero = (False if port.type == "Boolean" else 0,) * port.size
            system.set(f"{name}.{port.name}", np.reshape(port.start or zero, port.shape))
    return system
