"""What the command line takes for a system: a registered name, an `.ssp` file (or a structure in it), or one `.fmu`."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from fmus.errors import AdcsError
from orchestration.fmu import element_names
from orchestration.plots import Panel, Series
from orchestration.report import KeyNumber
from orchestration.results import Result
from orchestration.single import single
from orchestration.ssp_names import is_ssp, named_structure
from orchestration.system import System
from studies.registry import SYSTEMS, SystemEntry

_STEPS = 1000  # of a run whose file gives no exchange step
_STOP = 10.0  # s, of a run whose file gives no stop time
_MOST_CURVES = 9  # in one panel: a 3 x 3 matrix


def find_system(name: str) -> SystemEntry:
    """Return what a name or the path of a file stands for; AdcsError with the names there are if it is neither."""
    path = Path(name)
    if is_ssp(name):
        return _from_ssp(name)
    if path.suffix == ".fmu":
        return _from_fmu(path)
    if name not in SYSTEMS:
        close = get_close_matches(name, SYSTEMS, 3, 0.5)
        hint = f"did you mean {' or '.join(close)}" if close else f"choose one of {', '.join(SYSTEMS)}"
        raise AdcsError(f"no system {name!r}: {hint}, or give an .ssp or .fmu file")
    return SYSTEMS[name]


def from_anywhere(name: str) -> str:
    """Return the same name with the path of its file from anywhere, where it is one of a file."""
    if is_ssp(name):
        path, structure = named_structure(name)
        return str(path.absolute()) + (f"#{structure}" if structure else "")
    return str(Path(name).absolute()) if Path(name).suffix == ".fmu" else name


def _from_ssp(name: str) -> SystemEntry:
    from orchestration.ssp import read_ssp

    path, structure = named_structure(name)
    file = read_ssp(path, structure=structure)
    start = file.start_time or 0.0
    stop = start + _STOP if file.stop_time is None else file.stop_time
    step = (stop - start) / _STEPS if file.step is None else file.step
    variant = f"-{Path(structure).stem}" if structure else ""
    return _entry(f"{path.stem}{variant}", file.system, start, stop, step)


def _from_fmu(path: Path) -> SystemEntry:
    system = single(path)
    (component,) = system.components.values()
    system.name = path.stem
    experiment = component.fmu.model.defaultExperiment
    start = float(experiment.startTime or 0.0) if experiment else 0.0
    stop = float(experiment.stopTime or start + _STOP) if experiment else start + _STOP
    step = float(experiment.stepSize or (stop - start) / _STEPS) if experiment else (stop - start) / _STEPS
    return _entry(path.stem, system, start, stop, step)


def _entry(name: str, system: System, start: float, stop: float, step: float) -> SystemEntry:
    return SystemEntry(name, system.description, "", lambda: system, stop, step, figures, key_numbers, start)


def figures(result: Result) -> Sequence[Panel]:
    """A panel for each recorded variable, grouped by component."""
    panels = []
    for name in result.names:
        values = np.asarray(result[name], float)
        component, _, variable = name.partition(".")
        curves = values.reshape(len(result.time), -1).T[:_MOST_CURVES]
        labels = element_names(variable, values.shape[1:])
        series = [Series(label, result.time, curve) for label, curve in zip(labels, curves, strict=False)]
        unit = result.unit(name)
        panels.append(
            Panel(
                variable,
                f"{variable} [{unit}]" if unit else variable,
                series,
                note=result.description(name),
                group=component,
            )
        )
    return panels


def key_numbers(result: Result) -> list[KeyNumber]:
    """The last value of every scalar."""
    return [
        KeyNumber(name, float(result[name][-1]), result.unit(name) or "", f"at {result.time[-1]:g} s")
        for name in result.names
        if len(result.time) and result[name].ndim == 1
    ]
