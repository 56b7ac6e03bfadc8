"""Every system and every study that has a name, and what else the command line takes for a system."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TypeVar

from adcs import library, listed, others
from adcs.library.entry import StudyEntry
from adcs.loaded import load
from fmus import catalog
from fmus.built import fmus_of
from fmus.catalog import Component
from fmus.demand import ready_made
from fmus.errors import AdcsError, shown
from fmus.nearby import instead
from fmus.spelling import close, some
from orchestration.entry import SystemEntry
from orchestration.from_file import component_alone, is_file, system_from_file
from orchestration.from_python import is_python
from orchestration.ssp.names import is_ssp

_Entry = TypeVar("_Entry")


class _Entries(Mapping[str, _Entry]):
    """What has a name, each loaded when it is asked for; the names cost nothing."""

    def __init__(self, names: Iterable[str], load: Callable[[str], _Entry]) -> None:
        self._names, self._load = dict.fromkeys(names), load

    def __getitem__(self, name: str) -> _Entry:
        if name not in self._names:
            raise KeyError(name)
        return self._load(name)

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __repr__(self) -> str:
        return f"<{some(self)}>"


def _own(name: str) -> ModuleType:
    return import_module(f"{library.__name__}.{listed.FOLDERS[name]}.entries")


def _system(name: str) -> SystemEntry:
    found: list[SystemEntry] = _own(name).SYSTEMS
    return next(entry for entry in found if entry.name == name)


def _study(name: str) -> StudyEntry:
    found: list[StudyEntry] = _own(name).STUDIES
    return next(entry for entry in found if entry.name == name)


SYSTEMS: Mapping[str, SystemEntry] = _Entries(listed.SYSTEMS, _system)
STUDIES: Mapping[str, StudyEntry] = _Entries(listed.STUDIES, _study)


def systems() -> Mapping[str, SystemEntry]:
    """Return the systems by name, those of other packages, too; `systems()["observer-pd"].build()` is the system.

    Each is loaded when it is asked for; AdcsError then, if one of another package cannot be.
    """
    return _Entries([*SYSTEMS, *listed.theirs(listed.own_components())], find_system)


def studies() -> Mapping[str, StudyEntry]:
    """Return the studies by name."""
    return STUDIES


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
    return name in others.names() and name not in listed.own_components()


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
        raise AdcsError(f"{name} is no file{instead(name)}")
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


def _files_here() -> list[str]:
    """Return the files with systems that are in this folder, whose suffix may have been left out."""
    with suppress(OSError):
        return [path.name for path in sorted(Path().iterdir()) if path.suffix in (".py", ".ssp", ".fmu", ".hpp")]
    return []


def find_system(name: str) -> SystemEntry:
    """Return what the name of a system or component, or the path of a file, stands for; AdcsError if it is no such."""
    if is_file(name):
        return system_from_file(name)
    if name not in SYSTEMS:
        own, theirs = listed.own_components(), others.names()
        others.warn_of_clashes(own & {name}, "a component")
        if name in theirs and name not in own:
            return load(theirs[name])
        components = [*own, *catalog.brought(name)]
        if name in components:
            return component_alone(name)
        meant = close(name, [*SYSTEMS, *theirs, *components, *_files_here()])
        hint = f"did you mean {meant}? " if meant else ""
        raise AdcsError(f"no system {shown(repr(name))}: {hint}{_WAY_OUT}")
    others.warn_of_clashes({name}, "a system")
    return SYSTEMS[name]
