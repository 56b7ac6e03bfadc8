"""The schedule in numbers: value references, places in the signal buffer, the columns of a row."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orchestration.fmu import Fmu
from orchestration.schedule import Name, Operation, schedule, split
from orchestration.system import Connection

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Call:
    """One get or set call: `where` says which signals it writes (get) or reads (set), in the order of its values."""

    kind: str
    component: str
    elements: tuple[str, ...]
    references: tuple[int, ...]
    where: NDArray[np.intp]


@dataclass(frozen=True)
class Plan:
    """All calls of one propagation, their common signal buffer, and the signals that make up a recorded row."""

    calls: tuple[Call, ...]
    signals: Floats
    row: NDArray[np.intp]


def make_plan(
    fmus: Mapping[str, Fmu],
    connections: Sequence[Connection],
    record: Collection[Name] = (),
    initial: bool = False,
) -> Plan:
    """Lower the schedule of the given connections; `initial` takes the dependencies of initialisation mode."""
    operations = schedule(connections, _depends(fmus, initial), record)
    place: dict[Name, NDArray[np.intp]] = {}
    size = 0
    for operation in operations:
        if operation.kind == "get":
            for variable in operation.variables:
                n = fmus[operation.component].ports[variable].size
                place[operation.component, variable] = np.arange(size, size + n, dtype=np.intp)
                size += n
    for connection in connections:
        place[split(connection.target)] = place[split(connection.source)]
    nothing = np.empty(0, np.intp)
    return Plan(
        calls=tuple(_call(fmus[o.component], o, place) for o in operations),
        signals=np.zeros(size),
        row=np.concatenate([nothing, *(place[name] for name in record)]),
    )


def _depends(fmus: Mapping[str, Fmu], initial: bool) -> Callable[[Name], Collection[str]]:
    def depends(name: Name) -> Collection[str]:
        component, variable = name
        fmu = fmus[component]
        port = fmu.ports[variable]
        inputs = [p.name for p in fmu.ports.values() if p.causality == "input"]
        if port.causality == "input":
            return [variable]
        if port.causality in ("parameter", "independent") or port.variability == "constant":
            return []
        if not initial:
            return fmu.dependencies.get(variable, inputs)
        if port.initial == "exact":
            return []
        return fmu.initial_dependencies.get(variable, fmu.dependencies.get(variable, inputs))

    return depends


def _call(fmu: Fmu, operation: Operation, place: Mapping[Name, NDArray[np.intp]]) -> Call:
    ports = [fmu.ports[v] for v in operation.variables]
    return Call(
        kind=operation.kind,
        component=operation.component,
        elements=tuple(element for port in ports for element in port.elements),
        references=tuple(reference for port in ports for reference in port.references),
        where=np.concatenate([place[operation.component, v] for v in operation.variables]),
    )
