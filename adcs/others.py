"""What other packages bring: systems by entry points of the group `adcs.systems`."""

from __future__ import annotations

from collections.abc import Collection
from importlib.metadata import EntryPoint

from fmus.errors import AdcsError, shown
from fmus.packages import package_of, points, warn_once
from orchestration.entry import SystemEntry
from orchestration.from_file import entry_of
from orchestration.system import System


def names() -> dict[str, EntryPoint]:
    """Return the systems of other packages by name; nothing of them is loaded yet."""
    return {point.name: point for point in reversed(points("adcs.systems"))}  # of one name, the first


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


def load(point: EntryPoint) -> SystemEntry:
    """Return a system that another package brings: a `SystemEntry`, a `System`, or a function that returns one."""
    try:
        found = point.load()
        if callable(found):
            found = found()
    except AdcsError:
        raise
    except (Exception, SystemExit) as error:
        why = f"{type(error).__name__}: {shown(str(error))}"
        raise AdcsError(f"the system {point.name} of {package_of(point)} cannot be loaded: {why}") from error
    if isinstance(found, System):
        return entry_of(found, point.name)
    if not isinstance(found, SystemEntry):
        raise AdcsError(
            f"{point.value} of {package_of(point)} is no system: expected one, or a function that returns one"
        )
    return found
