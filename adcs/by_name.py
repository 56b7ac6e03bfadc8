"""What can be done with a system can be done with its name, or the path of its file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import Any, Concatenate, ParamSpec, TypeVar

from adcs.catalogue import find_system, fmus_meant
from fmus.catalog import components
from fmus.check import Finding
from orchestration import named
from orchestration.checking import check as check_fmu
from orchestration.coupled import CoupledModel as CoupledModel
from orchestration.linear.linearization import linearize as linearize_system
from orchestration.running.run import run as run_system
from orchestration.running.session import Session as Session
from orchestration.running.session import steps as steps_of_system
from orchestration.ssp import write_ssp as write_system
from orchestration.ssp.names import is_ssp
from orchestration.system import System

Settings = ParamSpec("Settings")
Found = TypeVar("Found")


def _found(name: str, step: object) -> System:
    """Return a system with its times; AdcsError if there is none, or it refuses the exchange step (s)."""
    entry = find_system(name)
    if isinstance(step, float | int):
        entry.check_step(step)
    return entry.built()


def _by_name(
    function: Callable[Concatenate[System, Settings], Found], takes: Callable[[str], bool] = lambda name: True
) -> Callable[Concatenate[System | str | Path, Settings], Found]:
    """Let a function take names and files for which `takes` holds; others it takes as they are."""

    @wraps(function)
    def found(system: Any, /, *args: Settings.args, **settings: Settings.kwargs) -> Found:
        if isinstance(system, str | Path) and takes(str(system)):
            system = _found(str(system), settings.get("step"))
        return function(system, *args, **settings)

    return found


def _is_fmu(name: str) -> bool:
    return Path(name).suffix == ".fmu" or any(component.name == name for component in components())


def check(fmu: str | Path) -> list[Finding]:
    """Everything that is found in an FMU that it or a run should not have; empty if it is fine.

    `fmu` is the path of an `.fmu`, the name of a built component, whose FMUs are looked at, or a system, each of whose
    components is: its name, or the path of its `.ssp`.
    """
    if not isinstance(fmu, str | Path) or Path(fmu).suffix == ".fmu" or (Path(fmu).is_file() and not is_ssp(fmu)):
        return check_fmu(fmu)
    found = ((path.name, finding) for path in fmus_meant(str(fmu)) for finding in check_fmu(path))
    return [replace(finding, message=f"{name}: {finding.message}") for name, finding in found]


run = _by_name(run_system)
steps = _by_name(steps_of_system)
write_ssp = _by_name(write_system)
linearize = _by_name(linearize_system, lambda name: not _is_fmu(name))  # an FMU may be given start values
named.find_by(_found)  # for Session and CoupledModel, which are classes wherever they are from
