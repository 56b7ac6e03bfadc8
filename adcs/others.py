"""What other packages bring: systems by entry points of the group `adcs.systems`. Nothing of them is loaded here."""

from __future__ import annotations

from collections.abc import Collection
from importlib.metadata import EntryPoint

from fmus.packages import package_of, points, warn_once


def names() -> dict[str, EntryPoint]:
    """Return the systems of other packages by name; of several of one name, the first."""
    first: dict[str, EntryPoint] = {}
    for point in points("adcs.systems"):
        first.setdefault(point.name, point)
    return first


def warn_of_clashes(own: Collection[str], what: str) -> None:
    """Tell which systems of other packages are not found by their names, as those are of this project."""
    first = names()
    for point in points("adcs.systems"):
        if point.name in own:
            told = f"{point.name} is {what} of this project"
        elif first[point.name] is not point:
            told = f"{point.name} is a system of {package_of(first[point.name])}"
        else:
            continue
        warn_once(f"{told}; that of {package_of(point)}, {point.value}, is not found by this name")
