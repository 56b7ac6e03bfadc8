"""What can be done with a system can be done with its name, or the path of its file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import ParamSpec, TypeVar

from adcs.catalogue import find_system, fmus_meant, names_system
from adcs.renamed import refuse_unknown
from fmus.catalog import is_header
from fmus.check import Finding
from orchestration import expected, named
from orchestration.checking import check as check_fmu
from orchestration.coupled import CoupledModel as CoupledModel
from orchestration.linear.linearization import linearize as linearize_system
from orchestration.running.run import run as run_system
from orchestration.running.session import Session as Session
from orchestration.running.session import steps as steps_of_system
from orchestration.ssp import write_ssp as write_ssp
from orchestration.system import System
from orchestration.times import Seconds

Arguments = ParamSpec("Arguments")
Returned = TypeVar("Returned")


def _found(name: str, step: Seconds | None) -> System:
    """Return a system with its times; AdcsError if there is none, or it refuses the exchange step."""
    entry = find_system(name)
    if step is not None:
        entry.check_step(expected.seconds("step", step))
    return entry.build()


def _telling(function: Callable[Arguments, Returned]) -> Callable[Arguments, Returned]:
    """Let a function tell what stands for arguments that it does not have."""

    @wraps(function)
    def told(*args: Arguments.args, **given: Arguments.kwargs) -> Returned:
        refuse_unknown(function, given)
        return function(*args, **given)

    return told


def check(fmu: str | Path) -> list[Finding]:
    """Everything that is found in an FMU that it or a run should not have; empty if it is fine.

    `fmu` is the path of an `.fmu`, the name of a built component, whose FMUs are looked at, or a system, each of whose
    components is: its name, or the path of its `.ssp` or `.py`; or a folder of headers or FMUs.
    """
    meant = isinstance(fmu, str | Path) and (names_system(str(fmu)) or is_header(fmu) or not Path(fmu).is_file())
    if not meant or Path(fmu).suffix == ".fmu":
        return check_fmu(fmu)
    found = ((path.name, finding) for path in fmus_meant(str(fmu)) for finding in check_fmu(path))
    return [replace(finding, message=f"{name}: {finding.message}") for name, finding in found]


run = _telling(run_system)
steps = _telling(steps_of_system)
linearize = _telling(linearize_system)
named.find_by(_found)
