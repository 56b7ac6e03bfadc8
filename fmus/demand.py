"""FMUs made when they are asked for: never one that is not of the sources that are here."""

from __future__ import annotations

import logging
from pathlib import Path

from fmus import freshness, paths, toolchain
from fmus.build import build
from fmus.carried import carried_parts
from fmus.catalog import Component, find
from fmus.errors import AdcsError, Failed
from fmus.files import write_atomically
from fmus.pack import FILE_NAMES, pack

_log = logging.getLogger("adcs")


def fmu_path(name: str, fmi_version: str = "2.0") -> Path:
    """The FMU of a component, built anew if it is not of the sources that are here.

    AdcsError if there is no such component, or it cannot be built.
    """
    if fmi_version not in FILE_NAMES:
        raise AdcsError(f"FMI version {fmi_version} is not made: expected {' or '.join(FILE_NAMES)}")
    component = find(name)
    path = place(component, fmi_version)
    header = str(component.header) if component.outside else None
    why = freshness.outdated(path, toolchain.host().name, toolchain.compiler(), header)
    if why is not None:
        _make(component, f"{path.name} {why}")
    return path


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
        raise Failed(f"{why}, and no compiler is installed to build it: {toolchain.INSTALL}")
    _log.info(f"{why}: building {component.name}")
    build([component.source], dist=paths.DIST, work=paths.BUILD)
