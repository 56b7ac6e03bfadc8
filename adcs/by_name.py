"""What can be done with a system can be done with its name, or the path of its file."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, Concatenate, ParamSpec, TypeVar

from adcs.catalogue import SYSTEMS, find_system
from adcs.renamed import refuse_old
from orchestration import expected
from orchestration.linear.linearization import linearize as linearize_system
from orchestration.running.run import run as run_system
from orchestration.running.session import steps as steps_of_system
from orchestration.ssp.names import is_ssp
from orchestration.system import System

Settings = ParamSpec("Settings")
Found = TypeVar("Found")


def _by_name(
    function: Callable[Concatenate[System, Settings], Found], takes: Callable[[str], bool] = lambda name: True
) -> Callable[Concatenate[System | str | Path, Settings], Found]:
    """Let a function take names and files for which `takes` holds; others it takes as they are."""

    @wraps(function)
    def found(system: Any, /, *args: Settings.args, **settings: Settings.kwargs) -> Found:
        refuse_old(function.__name__, settings)
        if isinstance(system, str | Path) and takes(str(system)):
            entry = find_system(str(system))
            if (step := settings.get("step")) is not None:
                entry.check_step(expected.seconds("step", step))
            system = entry.built()
        return function(system, *args, **settings)

    return found


run = _by_name(run_system)
steps = _by_name(steps_of_system)
linearize = _by_name(linearize_system, lambda name: name in SYSTEMS or is_ssp(name))  # an FMU may be given start values
