"""Every system and every study that has a name, and what else the command line takes for a system."""

from __future__ import annotations

import pkgutil
from difflib import get_close_matches
from importlib import import_module

from adcs import library
from adcs.library.entry import StudyEntry
from fmus.catalog import components
from fmus.errors import AdcsError
from orchestration.entry import SystemEntry
from orchestration.from_file import component_alone, is_file, system_from_file

# Each folder of `library` brings its own, in its module `catalogue`.
_BROUGHT = [
    import_module(f"{library.__name__}.{folder.name}.catalogue")
    for folder in pkgutil.iter_modules(library.__path__)
    if folder.ispkg
]
SYSTEMS: dict[str, SystemEntry] = {entry.name: entry for brought in _BROUGHT for entry in brought.SYSTEMS}
STUDIES: dict[str, StudyEntry] = {entry.name: entry for brought in _BROUGHT for entry in brought.STUDIES}


def systems() -> dict[str, SystemEntry]:
    """Return the registered systems by name; `systems()["observer-pd"].build()` is the system itself."""
    return dict(SYSTEMS)


def studies() -> dict[str, StudyEntry]:
    """Return the studies by name."""
    return dict(STUDIES)


def find_system(name: str) -> SystemEntry:
    """Return what the name of a system or component, or the path of a file, stands for; AdcsError if it is no such."""
    if is_file(name):
        return system_from_file(name)
    if name not in SYSTEMS:
        if name in (component.name for component in components()):
            return component_alone(name)
        close = get_close_matches(name, SYSTEMS, 3, 0.5)
        hint = f"did you mean {' or '.join(close)}" if close else f"choose one of {', '.join(SYSTEMS)}"
        raise AdcsError(f"no system {name!r}: {hint}, or give a component (`adcs list`), an .ssp or .fmu file")
    return SYSTEMS[name]
