"""The range for which an FMU says that it is made: min and max of its variables."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf

from orchestration.fmu.file import Fmu, Port

Range = tuple[float, float]


def declared_ranges(fmu: Fmu) -> dict[str, Range]:
    """Return the ranges of the variables that declare a bound, infinite on the side where they declare none."""
    return {
        v.name: (-inf if v.min is None else float(v.min), inf if v.max is None else float(v.max))
        for v in fmu.model.modelVariables
        if v.min is not None or v.max is not None
    }


def range_of(ranges: Mapping[str, Range], port: Port, element: str) -> Range:
    """Return the range of an element of a port: in FMI 2 its own, in FMI 3 that of the array."""
    return ranges.get(element, ranges.get(port.name, (-inf, inf)))
