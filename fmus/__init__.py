"""Builds, lists and checks the FMUs.

import fmus
fmus.build()                              # NAME.fmu and NAME.fmi3.fmu of every component
fmus.check(fmus.fmu_path("RigidBody"))    # []
"""

from fmus.build import build, describe
from fmus.catalog import Component, components, find
from fmus.check import Finding, check
from fmus.demand import fmu_path
from fmus.errors import AdcsError

__all__ = ["AdcsError", "Component", "Finding", "build", "check", "components", "describe", "find", "fmu_path"]
