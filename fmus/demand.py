"""FMUs made when they are asked for: never one that is not of the sources that are here."""

from __future__ import annotations

import logging
import re
from pathlib import Path
from zipfile import ZipFile

from fmus import freshness, paths, toolchain
from fmus.build import build
from fmus.carried import carried_parts
from fmus.catalog import Component, brought, find, is_header, struct_name
from fmus.errors import AdcsError, Failed
from fmus.files import write_atomically
from fmus.pack import FILE_NAMES, is_own, pack
from fmus.packages import warn_once

_log = logging.getLogger("adcs")


def fmu_path(name: str, fmi_version: str = "2.0") -> Path:
    """The FMU of a component, built anew if it is not of the sources that are here.

    AdcsError if there is no such component, or it cannot be built.
    """
    return ready_made(name, fmi_version) or fmu_of(find(name), fmi_version)


def fmu_of(component: Component, fmi_version: str = "2.0") -> Path:
    """The FMU of this component, built anew if it is not of the sources that are here; AdcsError if it cannot be."""
    came = came_with(component, fmi_version)
    if came is not None:
        return came
    path = place(component, fmi_version)
    header = str(component.header) if component.outside else None
    why = freshness.outdated(path, toolchain.host().name, toolchain.compiler(), header)
    if why is not None:
        _make(component, f"{path.name} {why}")
    return path


def ready_made(name: str, fmi_version: str = "2.0") -> Path | None:
    """The FMU of this name that another package brings without a header; of two, the one of this version of FMI."""
    if fmi_version not in FILE_NAMES:
        raise AdcsError(f"FMI version {fmi_version} is not made: expected {' or '.join(FILE_NAMES)}")
    theirs = None if is_header(name) else brought(name).get(name)
    if theirs is None or theirs.header is not None:
        return None
    called = FILE_NAMES[fmi_version].format(name)
    return next((path for path in theirs.fmus if path.name == called), theirs.fmus[0])


def came_with(component: Component, fmi_version: str) -> Path | None:
    """The FMU that came beside a header from elsewhere, not built here, if its sources are that header's."""
    if component.root is None:
        return None
    path = component.header.parent / FILE_NAMES[fmi_version].format(component.name)
    record = freshness.read_record(path)
    built_here = record is not None and str(component.header) in record.sources
    return None if built_here or not path.is_file() or not _is_of(path, component, component.root) else path


def warn_if_old(fmu: Path) -> None:
    """Say so if a file that is asked for by its own path is not what would be built of the header beside it now."""
    record = freshness.read_record(fmu)
    headers = [Path(n) for n in record.sources if is_header(n) and Path(n).is_absolute()] if record is not None else []
    for header in headers:
        if header.parent != fmu.parent.absolute() or struct_name(header.stem) != fmu.name.partition(".")[0]:
            continue
        why = freshness.outdated(fmu, toolchain.host().name, "", str(header))
        if why is not None:
            warn_once(f"{fmu} {why}, and is taken as it is: {header.name} in its place is built when it is asked for")


def _is_of(fmu: Path, component: Component, root: Path) -> bool:
    """Whether an FMU has a binary for this machine, and in its sources what the header and those beside it are now."""
    if not is_own(fmu):
        return False
    machine = toolchain.host()
    with ZipFile(fmu) as archive:
        members = set(archive.namelist())
        sources = [name.removeprefix("sources/") for name in members if re.fullmatch(r"sources/.*\.hpp", name)]
        theirs = [name for name in sources if not (paths.SOURCES / name).is_file()]
        binaries = {
            f"binaries/{place}/{component.name}{machine.suffix}" for place in (machine.fmi2_folder, machine.name)
        }
        return (
            bool(binaries & members)
            and component.include in theirs
            and all((root / n).is_file() and (root / n).read_bytes() == archive.read(f"sources/{n}") for n in theirs)
        )


def place(component: Component, fmi_version: str) -> Path:
    """Where the FMU is if it is built."""
    folder = component.home or paths.DIST
    return folder / FILE_NAMES[fmi_version].format(component.name)


def _make(component: Component, why: str) -> None:
    parts = carried_parts(component)
    if parts is not None:
        record = freshness.make_record(parts.made_of, (target.name for target in parts.binaries), "")
        for version in FILE_NAMES:
            path = place(component, version)
            write_atomically(path, pack(component, parts, version))
            freshness.keep_record(path, record)
        return
    if not toolchain.is_installed():
        way_out = toolchain.INSTALL if component.outside else toolchain.without()
        raise Failed(f"{why}, and no compiler is installed to build it: {way_out}")
    _log.info(f"{why}: building {component.name}")
    build([component.source], dist=paths.DIST, work=paths.BUILD)
