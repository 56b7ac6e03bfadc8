"""A system's tunable parameters and free inputs as MAVLink parameters: names of 16 characters, ranges, units."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import isfinite
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from orchestration.fmu.file import Fmu, Port, element_names
from orchestration.fmu.ranges import declared_ranges, range_of
from orchestration.system import System

_MOST = 16  # characters
_PREFIX = 5
_SHORT = {
    "actuator": "act",
    "controller": "ctrl",
    "disturbance": "dist",
    "environment": "env",
    "estimate": "est",
    "guidance": "guid",
    "observer": "obs",
    "sensor": "sens",
    "tracker": "trk",
}
"""Of common names of components; ground stations group parameters by what is before the first `_`."""


@dataclass
class Parameter:
    """One number: `id` as ground stations know it; element `index` (flat) of `variable`; its range and present value.

    `whole` is for integers and Booleans.
    """

    id: str
    variable: str
    index: int
    element: str
    unit: str
    description: str
    low: float
    high: float
    whole: bool
    value: float

    def as_dict(self) -> dict[str, Any]:
        """All of it, as JSON can hold it."""
        return asdict(self)

    def checked(self, value: float) -> float:
        """Return the number that a float32 stands for, as it would be written; AdcsError if it cannot be it."""
        if not isfinite(value):
            raise AdcsError(f"{self.id} = {value}: not finite")
        exact = float(str(np.float32(value)))  # 0.1, not 0.10000000149
        if not self.low <= exact <= self.high:
            ends = ((self.low, "from"), (self.high, "to"))
            expected = " ".join(f"{word} {end:g}" for end, word in ends if isfinite(end))
            raise AdcsError(f"{self.id} = {exact:g}: expected a number {expected}")
        if self.whole and exact != int(exact):
            raise AdcsError(f"{self.id} = {exact:g}: expected an integer")
        return exact


def parameters(system: System, without: Sequence[str] = ()) -> list[Parameter]:
    """Return all that can be set while the system runs: tunable parameters, and inputs that nothing feeds.

    Variables in `without` are left out.
    """
    found: list[Parameter] = []
    taken: set[str] = set()
    fed = {(end.component, end.port.name) for end in (system.end(c.target) for c in system.connections)}
    for component in system.components.values():
        ports = [
            port
            for port in component.fmu.ports.values()
            if _settable(port)
            and (component.name, port.name) not in fed
            and f"{component.name}.{port.name}" not in without
        ]
        prefix = _SHORT.get(component.name, component.name)[:_PREFIX]
        for port in ports:
            values = np.ravel(component.start.get(port.name, port.start if port.start is not None else 0.0))
            for i, element in enumerate(element_names(port.name, port.shape)):
                id_ = _unique(_plain(f"{prefix}_{element}"), taken)
                found.append(
                    Parameter(
                        id_,
                        f"{component.name}.{port.name}",
                        i,
                        f"{component.name}.{element}",
                        "" if port.unit in (None, "1") else port.unit,
                        port.description,
                        *_range(component.fmu, port, port.elements[i]),
                        not port.type.startswith("Float"),
                        float(values[i]),
                    )
                )
    return found


def _settable(port: Port) -> bool:
    numeric = port.type.startswith(("Float", "Int", "UInt", "Boolean"))
    tunable = port.causality == "parameter" and port.variability == "tunable"
    return numeric and port.alias_of is None and (port.causality == "input" or tunable)


def _range(fmu: Fmu, port: Port, element: str) -> tuple[float, float]:
    """The range that the FMU declares; what else it refuses is found by trial."""
    if port.type == "Boolean":
        return 0.0, 1.0
    return range_of(declared_ranges(fmu), port, element)


def _plain(name: str) -> str:
    return re.sub(r"\W+", "_", name.replace(",", "")).strip("_").upper()


def _unique(id_: str, taken: set[str]) -> str:
    """Shorten to 16 characters, longest words first, the indices at the end kept; numbered if it is taken."""
    candidate, n = _shortened(id_, _MOST), 1
    while candidate in taken:
        n += 1
        candidate = f"{_shortened(id_, _MOST - len(str(n)) - 1)}~{n}"
    taken.add(candidate)
    return candidate


def _shortened(id_: str, most: int) -> str:
    prefix, *words = id_.split("_")
    index = [words.pop()] if len(words) > 1 and words[-1].isdecimal() else []
    while len("_".join(parts := [prefix, *words, *index])) > most:
        longest = max(range(len(words)), key=lambda i: (len(words[i]), i))
        if len(words[longest]) == 1:
            return "_".join(parts)[:most]
        words[longest] = words[longest][:-1]
    return "_".join(parts)
