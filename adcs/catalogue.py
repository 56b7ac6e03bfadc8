"""Every system and every study that has a name, and what else the command line takes for a system."""

from __future__ import annotations

import logging
import pkgutil
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

from adcs import library, others
from adcs.library.entry import StudyEntry
from fmus import catalog
from fmus.built import fmus_of
from fmus.catalog import Component
from fmus.demand import ready_made
from fmus.errors import AdcsError, shown
from fmus.spelling import close
from orchestration.entry import SystemEntry
from orchestration.from_file import component_alone, is_file, system_from_file
from orchestration.from_python import is_python
from orchestration.ssp.names import is_ssp

_log = logging.getLogger("adcs")

# Each folder of `library` brings its own, in its module `catalogue`.
_BROUGHT = [
    import_module(f"{library.__name__}.{folder.name}.catalogue")
    for folder in pkgutil.iter_modules(library.__path__)
    if folder.ispkg
]
SYSTEMS: dict[str, SystemEntry] = {entry.name: entry for brought in _BROUGHT for entry in brought.SYSTEMS}
STUDIES: dict[str, StudyEntry] = {entry.name: entry for brought in _BROUGHT for entry in brought.STUDIES}


def systems() -> dict[str, SystemEntry]:
    """Return the systems by name, those of other packages, too; `systems()["observer-pd"].build()` is the system."""
    found = dict(SYSTEMS)
    for name, entry in _brought():
        if isinstance(entry, AdcsError):
            _log.warning(str(entry))
        else:
            found[name] = entry
    return found


def descriptions() -> dict[str, str]:
    """Return what each system is; of one that another package brings, and that cannot be loaded, why."""
    told = {name: entry.description for name, entry in SYSTEMS.items()}
    return told | {name: str(e) if isinstance(e, AdcsError) else e.description for name, e in _brought()}


def _brought() -> Iterator[tuple[str, SystemEntry | AdcsError]]:
    """Yield the systems of other packages, and for what cannot be loaded why: that is no reason to hide the others."""
    own = _own_components()
    others.warn_of_clashes(SYSTEMS, "a system")
    others.warn_of_clashes(own, "a component")
    for name, point in others.names().items():
        if name not in SYSTEMS and name not in own:
            try:
                yield name, others.load(point)
            except AdcsError as error:
                yield name, error


def _own_components() -> set[str]:
    return {component.name for component in catalog.components()}


def studies() -> dict[str, StudyEntry]:
    """Return the studies by name."""
    return dict(STUDIES)


def find_component(name: str) -> Component:
    """Return the component of this name; AdcsError, for whom a system or a file would do as well, if there is none."""
    try:
        return catalog.find(name, SYSTEMS)
    except AdcsError as error:
        raise AdcsError(f"{str(error).rstrip('?')}, or give a system, or an .fmu, .ssp or .py file") from None


def names_system(name: str) -> bool:
    """Whether a name is that of a system, or of a file with one; not that of a component, which can be one as well."""
    if name in SYSTEMS or is_ssp(name) or is_python(name):
        return True
    return name in others.names() and name not in _own_components()


def fmus_meant(name: str) -> list[Path]:
    """Return the FMUs of a component, of all components of a system, in a folder, or the one that has this path."""
    if names_system(name):
        parts = find_system(name).build().components.values()
        return list(dict.fromkeys(path for part in parts for path in fmus_meant(str(part.source))))
    if ready_made(name) is not None:
        return list(catalog.brought(name)[name].fmus)
    if Path(name).suffix != ".fmu" and Path(name).is_dir():
        return _in_folder(Path(name))
    if Path(name).suffix != ".fmu":
        return fmus_of(find_component(name))
    if not Path(name).is_file():
        raise AdcsError(f"{name} is no file")
    return [Path(name)]


def _in_folder(folder: Path) -> list[Path]:
    """Return the FMUs of the headers in a folder, built if need be, and what else lies there as an .fmu."""
    there = sorted(folder.glob("*.fmu"))
    try:
        of_headers = [path for component in catalog.meant(str(folder)) for path in fmus_of(component)]
    except AdcsError:
        if not there or any(folder.glob("*.hpp")):
            raise
        of_headers = []
    known = {path.resolve() for path in of_headers}
    return [*of_headers, *(path for path in there if path.resolve() not in known)]


_WAY_OUT = "`adcs list` shows all; or give an .ssp, .py or .fmu file"


def find_system(name: str) -> SystemEntry:
    """Return what the name of a system or component, or the path of a file, stands for; AdcsError if it is no such."""
    if is_file(name):
        return system_from_file(name)
    if name not in SYSTEMS:
        own, theirs = _own_components(), others.names()
        others.warn_of_clashes(own & {name}, "a component")
        if name in theirs and name not in own:
            return others.load(theirs[name])
        components = [*own, *catalog.brought(name)]
        if name in components:
            return component_alone(name)
        meant = close(name, [*SYSTEMS, *theirs, *components])
        hint = f"did you mean {meant}? " if meant else ""
        raise AdcsError(f"no system {shown(repr(name))}: {hint}{_WAY_OUT}")
    others.warn_of_clashes({name}, "a system")
    return SYSTEMS[name]
