"""What other packages bring: systems by entry points of the group `adcs.systems`."""

from __future__ import annotations

from importlib.metadata import EntryPoint, entry_points

from fmus.errors import AdcsError, shown
from orchestration.entry import SystemEntry
from orchestration.from_file import entry_of
from orchestration.system import System


def names() -> dict[str, EntryPoint]:
    """Return the systems of other packages by name; nothing of them is loaded yet."""
    return {point.name: point for point in entry_points(group="adcs.systems")}


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
        raise AdcsError(f"the system {point.name} of {_package(point)} cannot be loaded: {why}") from error
    if isinstance(found, System):
        return entry_of(found, point.name)
    if not isinstance(found, SystemEntry):
        raise AdcsError(
            f"{point.value} of {_package(point)} is no system: expected one, or a function that returns one"
        )
    return found


def _package(point: EntryPoint) -> str:
    return "a package" if point.dist is None else f"the package {point.dist.name}"
