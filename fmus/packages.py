"""What other packages bring by entry points: headers and FMUs of components by those of one group."""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterable, Iterator
from functools import cache, lru_cache
from importlib.machinery import ModuleSpec, PathFinder
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

from fmus.callables import unfit
from fmus.errors import AdcsError, shown

GROUP = "adcs.components"
"""Of the entry points whose values say where headers and FMUs are."""

_EXPECTED = "a path, or several"
_log = logging.getLogger("adcs")


def points(group: str) -> tuple[EntryPoint, ...]:
    """Return the entry points of a group; those of the packages that can be imported now."""
    return _points(group, tuple(sys.path))


@lru_cache(maxsize=8)
def _points(group: str, _path: tuple[str, ...]) -> tuple[EntryPoint, ...]:
    return tuple(entry_points(group=group))


def package_of(point: EntryPoint) -> str:
    """Return who brings it, in words."""
    return "a package" if point.dist is None else f"the package {point.dist.name}"


def told(point: EntryPoint) -> str:
    """Say what is loaded for an entry point when it is asked for, and whose it is."""
    return f"{point.value}, of {package_of(point)}"


@cache
def warn_once(text: str) -> None:
    """Say something that is no reason to stop, however often it is come upon."""
    _log.warning(text)


def told_by_code() -> list[EntryPoint]:
    """Return the entry points of components of which only the package's own code says where they are."""
    return [point for point in points(GROUP) if point.attr]


def component_files(quiet: bool = False, run_code: bool = True) -> Iterator[tuple[Path, str]]:
    """Yield the headers and FMUs that packages bring, and whose they are.

    What cannot be found hides no others, and is told unless quiet. Without `run_code` those that only code of the
    packages would find are left out.
    """

    def tell(point: EntryPoint, why: str) -> None:
        if not quiet:
            warn_once(f"the components {point.name} of {package_of(point)} cannot be found: {shown(why)}")

    for point in points(GROUP):
        package = package_of(point)
        if point.attr and not run_code:
            continue
        try:
            places = _places(point)
        except (Exception, SystemExit) as error:
            why = str(error) if isinstance(error, AdcsError) else f"{type(error).__name__}: {error}"
            tell(point, why)
            continue
        for place in places:
            if place.is_dir():
                yield from ((path, package) for suffix in ("hpp", "fmu") for path in sorted(place.glob(f"*.{suffix}")))
            elif place.is_file():
                yield place, package
            else:
                tell(point, f"there is no {place}")


def _places(point: EntryPoint) -> list[Path]:
    """Return the folders and files that are meant: those of a module, or those that a name in it stands for."""
    spec = _spec(point.module)
    if spec is None:
        raise AdcsError(f"there is no module {point.module}")
    folders = [Path(place) for place in spec.submodule_search_locations or ()]
    folders = folders or ([Path(spec.origin).parent] if spec.origin else [])
    if not point.attr:
        return folders
    found: Any = point.load()
    if isinstance(found, ModuleType):
        return [Path(place) for place in found.__path__]
    if callable(found) and not isinstance(found, Path):
        if why := unfit(found, _EXPECTED):
            raise AdcsError(f"{point.value} {why}")
        found = found()
    each = [found] if isinstance(found, str | Path) else list(found) if isinstance(found, Iterable) else []
    if not each or not all(isinstance(path, str | Path) for path in each):
        raise AdcsError(f"{point.value} is {shown(repr(found))}: expected {_EXPECTED}, or what returns them")
    return [folders[0] / path for path in each]  # one that is absolute stays what it is


def _spec(name: str) -> ModuleSpec | None:
    """Find a module without importing the packages around it, as `find_spec` alone would."""
    outermost, *inner = name.split(".")
    spec = find_spec(outermost)
    for depth, _ in enumerate(inner, 2):
        if spec is None or spec.submodule_search_locations is None:
            return None
        spec = PathFinder.find_spec(".".join(name.split(".")[:depth]), spec.submodule_search_locations)
    return spec
