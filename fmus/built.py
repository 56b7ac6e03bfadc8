"""Which FMUs of the components are built, and where they are."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from fmus import catalog
from fmus.catalog import Component
from fmus.errors import Failed
from fmus.pack import FILE_NAMES
from fmus.paths import DIST


def paths(component: Component) -> dict[str, Path]:
    """FMI version -> where the FMU is if it is built."""
    return {version: DIST / pattern.format(component.name) for version, pattern in FILE_NAMES.items()}


def all_built() -> list[Path]:
    """Every FMU that is built; AdcsError if there is none."""
    return _existing(path for component in catalog.components() for path in paths(component).values())


def fmus_of(component: Component) -> list[Path]:
    """Return the FMUs of a component; AdcsError if there is none."""
    return _existing(paths(component).values())


def _existing(wanted: Iterable[Path]) -> list[Path]:
    wanted = list(wanted)
    existing = [path for path in wanted if path.is_file()]
    if not existing:
        raise Failed(f"{wanted[0].name} is not built: run: adcs build")
    return existing
