"""Seeds that nobody chose: a system gives each component one of its own, by the component's name."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from typing import Any, Protocol

from fmus.model_description import SEED_TYPE
from orchestration.fmu.file import Port


def is_seed(port: Port) -> bool:
    """Whether the FMU declares it to be a seed; a variable may be called `seed` and mean anything."""
    return (port.declared_type, port.type, port.causality, port.alias_of) == (SEED_TYPE, "Int32", "parameter", None)


def seeds_of(ports: Iterable[Port]) -> list[Port]:
    """Return the parameters that are declared to be seeds."""
    return [port for port in ports if is_seed(port)]


def default_seed(component: str, port: Port) -> tuple[int, ...]:
    """Return the seed of a component in a system, from 0 to 2^31 - 1; several if it is an array.

    It depends on the name `component.variable` alone: neither on what else is in the system, nor on the order, the
    platform or Python's hash. Two names get the same one in 1 of 2^31 cases.
    """
    names = (f"{component}.{element}" for element in port.elements)
    return tuple(int.from_bytes(hashlib.sha256(name.encode()).digest()[:4], "big") >> 1 for name in names)


class _System(Protocol):
    components: dict[str, Any]
    """By name, as in `System`."""


def shared_seeds(system: _System) -> list[str]:
    """Say which components of the same kind have the same seed, and so the same noise; a line for each seed."""
    found: dict[tuple[str, str, Any], list[str]] = {}
    for component in system.components.values():
        for port in seeds_of(component.fmu.ports.values()):
            kind = component.fmu.model.modelName
            found.setdefault((kind, port.name, component.start.get(port.name, port.start)), []).append(component.name)
    return [
        f"{' and '.join(names)} ({kind}) have the same {variable} = {', '.join(map(str, seed or ()))}, and so the same "
        f"noise: give them different ones, as in --set {names[1]}.{variable}=2"
        for (kind, variable, seed), names in found.items()
        if len(names) > 1
    ]
