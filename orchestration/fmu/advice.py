"""What FMUs say of how they are to be used, where a run does otherwise: warnings for its manifest."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from typing import Any, Protocol

from orchestration.fmu.file import FmiVersion, Port
from orchestration.fmu.ranges import Range, declared_ranges, range_of

_NEAR = 1e-9  # how far, relative, a step may be from a multiple of another


class _System(Protocol):
    components: dict[str, Any]
    """By name, as in `System`."""


def outside_range(system: _System) -> list[str]:
    """Say which start values of a system are outside of their range; FMI leaves it to the FMU what comes of that."""
    found: list[str] = []
    for component in system.components.values():
        ranges = declared_ranges(component.fmu)
        for name, values in component.start.items() if ranges else ():
            port = component.fmu.ports[name]
            found += (text for _, text in outside(component.name, ranges, port, port.elements, values))
    return found


def outside(
    component: str,
    ranges: Mapping[str, Range],
    port: Port,
    elements: Sequence[str],
    values: Sequence[Any],
    when: str = "",
) -> Iterator[tuple[str, str]]:
    """Yield the elements of a variable that are given a number outside of their range, and what to say of each."""
    for element, value in zip(elements, values, strict=True) if port.type.startswith(("Float", "Int", "UInt")) else ():
        low, high = range_of(ranges, port, element)
        if not low <= value <= high:
            yield (
                element,
                f"{component}.{element} = {value:g}{when} is outside of the range its FMU is made for, "
                f"{low:g} to {high:g}",
            )


def odd_steps(system: _System, fmi_version: FmiVersion, settings: Mapping[str, Any]) -> list[str]:
    """Say which components are stepped by no multiple of their declared internal step (fixedInternalStepSize)."""
    found = []
    step = settings.get("step")
    if settings.get("method") != "co-simulation" or step is None:
        return []
    for component in system.components.values():
        interface = component.open(fmi_version).model.coSimulation
        internal = float(getattr(interface, "fixedInternalStepSize", None) or 0.0)
        whole = component.every * step
        if not (
            internal > 0 and isfinite(internal) and isfinite(whole / internal)
        ):  # none is declared, or nothing that is a time
            continue
        if abs(whole - max(round(whole / internal), 1) * internal) > _NEAR * whole:
            found.append(
                f"{component.name} is stepped by {whole:g} s, no multiple of its internal step of {internal:g} s: "
                "its values are those of another time"
            )
    return found
