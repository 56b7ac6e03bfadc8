"""Which FMUs of the components are built, and those of a name."""

from __future__ import annotations

from pathlib import Path

from fmus import catalog
from fmus.catalog import Component
from fmus.demand import came_with, fmu_path, place
from fmus.errors import Failed
from fmus.pack import FILE_NAMES


def built(component: Component) -> dict[str, Path]:
    """FMI version -> the FMU, of those that are built."""
    places = {version: came_with(component, version) or place(component, version) for version in FILE_NAMES}
    return {version: path for version, path in places.items() if path.is_file()}


def all_built() -> list[Path]:
    """Every FMU that is built, anew if need be; AdcsError if there is none."""
    found = [fmu_path(component.source, version) for component in catalog.components() for version in built(component)]
    if not found:
        raise Failed("no FMU is built yet: name a component, as in: adcs check RigidBody")
    return found


def fmus_of(component: Component) -> list[Path]:
    """Return the FMUs of a component, built if need be; AdcsError if they cannot be."""
    return [fmu_path(component.source, version) for version in FILE_NAMES]
