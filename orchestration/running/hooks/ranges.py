"""Values that are set during a run outside of the range that an FMU is made for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from orchestration.fmu.advice import outside
from orchestration.fmu.ranges import declared_ranges
from orchestration.system import System


def outside_range(system: System, given: Iterable[tuple[float, str, Sequence[Any]]]) -> Iterator[tuple[Any, str]]:
    """Yield element and warning for each value outside; `given` are times (s), names, and flat values."""
    ranges = {component.name: declared_ranges(component.fmu) for component in system.components.values()}
    for time, name, values in given:
        end = system.end(name)
        if declared := ranges[end.component]:
            elements = [end.port.elements[k] for k in end.elements]
            for element, text in outside(end.component, declared, end.port, elements, values, f" at {time:g} s"):
                yield (end.component, element), text
