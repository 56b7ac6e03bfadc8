"""Builds, lists and checks the FMUs.

import fmus
fmus.build()                              # NAME.fmu and NAME.fmi3.fmu of every component
fmus.check(fmus.fmu_path("RigidBody"))    # []
"""

from pathlib import Path

from fmus.build import build, describe
from fmus.catalog import Component, components, find
from fmus.check import Finding, check
from fmus.errors import AdcsError
from fmus.freshness import warn_if_outdated
from fmus.pack import FILE_NAMES
from fmus.paths import DIST

__all__ = ["AdcsError", "Component", "Finding", "build", "check", "components", "describe", "fmu_path"]


def fmu_path(name: str, fmi_version: str = "2.0") -> Path:
    """The built FMU of a component; AdcsError if there is no such component or it is not built.

    It is logged as a warning if the FMU was built from other sources than those that are here.
    """
    if fmi_version not in FILE_NAMES:
        raise AdcsError(f"FMI version {fmi_version} is not made: expected {' or '.join(FILE_NAMES)}")
    path = DIST / FILE_NAMES[fmi_version].format(find(name).name)
    if not path.is_file():
        raise AdcsError(f"{path.name} is not built: run: adcs build")
    warn_if_outdated(name, path)
    return path
