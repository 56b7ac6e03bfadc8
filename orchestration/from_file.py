"""A system from a file: an `.ssp`, one of several structures in it, a `.py`, one of several in it, or one `.fmu`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from orchestration.entry import SystemEntry
from orchestration.fmu.file import element_names, is_path
from orchestration.from_python import is_python, system_from_python
from orchestration.from_python import named as python_named
from orchestration.results.error_angles import is_error_quaternion, turned_by
from orchestration.results.plots import Panel, Series
from orchestration.results.report import KeyNumber
from orchestration.results.result import Result
from orchestration.single import single
from orchestration.ssp.names import is_ssp, named_structure
from orchestration.system import System, Times

_STEPS = 1000  # of a run whose file gives no exchange step
_STOP = 10.0  # s, of a run whose file gives no stop time
_IN_DEGREES = {"rad": "deg", "rad/s": "deg/s", "rad/s2": "deg/s2"}
_MOST_CURVES = 9  # in one panel: a 3 x 3 matrix


def is_file(name: str) -> bool:
    """Whether a name is that of a file that holds a system: `.ssp`, a structure in one, `.py`, `.fmu` or `.hpp`."""
    return is_ssp(name) or is_python(name) or is_path(name)


def system_from_file(name: str) -> SystemEntry:
    """Return the system in a file for which `is_file` holds."""
    if is_ssp(name):
        return _from_ssp(name)
    return _from_python(name) if is_python(name) else component_alone(name)


def from_anywhere(name: str) -> str:
    """Return the same name with the path of its file from anywhere, where it is one of a file."""
    if is_ssp(name):
        path, structure = named_structure(name)
        return str(path.absolute()) + (f"#{structure}" if structure else "")
    if is_python(name):
        path, inside = python_named(name)
        return str(path.absolute()) + (f":{inside}" if inside else "")
    return str(Path(name).absolute()) if is_path(name) else name


def _from_python(name: str) -> SystemEntry:
    """Return the system of a Python file; its name is that of the system, which is that of the results' folder."""
    system = system_from_python(name)
    return entry_of(system, system.name)


def entry_of(system: System, name: str) -> SystemEntry:
    """Return a system with a name that can be one of a folder, and with times where it has none."""
    name = re.sub(r"[^\w-]+", "-", name).strip("-") or "system"
    own = system.times or Times(0.0, _STOP, _STOP / _STEPS, ("stop_time", "step"))
    return _entry(name, system, own.start, own.stop, own.step, own.assumed)


def _from_ssp(name: str) -> SystemEntry:
    from orchestration.ssp import read_ssp

    path, structure = named_structure(name)
    file = read_ssp(path, structure=structure)
    start = file.start_time or 0.0
    stop = start + _STOP if file.stop_time is None else file.stop_time
    step = (stop - start) / _STEPS if file.step is None else file.step
    variant = f"-{Path(structure).stem}" if structure else ""
    assumed = [name for name in ("stop_time", "step") if getattr(file, name) is None]
    return _entry(f"{path.stem}{variant}", file.system, start, stop, step, assumed)


def component_alone(name: str) -> SystemEntry:
    """Return a system of one component: the path of an `.fmu`, or the name of a component that is built."""
    system = single(name)
    (component,) = system.components.values()
    system.name = Path(name).stem
    experiment = component.fmu.model.defaultExperiment
    given = {"stop_time": experiment.stopTime, "step": experiment.stepSize} if experiment else {}
    start = float(experiment.startTime or 0.0) if experiment else 0.0
    stop = float(given.get("stop_time") or start + _STOP)
    step = float(given.get("step") or (stop - start) / _STEPS)
    assumed = [name for name in ("stop_time", "step") if not given.get(name)]
    return _entry(system.name, system, start, stop, step, assumed)


def _entry(name: str, system: System, start: float, stop: float, step: float, assumed: Sequence[str]) -> SystemEntry:
    return SystemEntry(
        name, system.description, "", lambda: system, stop, step, figures, key_numbers, start, assumed=assumed
    )


def figures(result: Result) -> Sequence[Panel]:
    """A panel for each recorded variable, grouped by component; angles, their rates and attitude errors in degrees."""
    return [_panel(result, name) for name in result.names]


def _panel(result: Result, name: str) -> Panel:
    component, _, variable = name.partition(".")
    unit, values, note = result.unit(name), np.asarray(result[name], float), result.description(name)
    if is_error_quaternion(variable, unit, values):
        title, label = f"{variable} as an angle", f"angle of {variable} [deg]"
        note = "; ".join(filter(None, (note, "drawn as the angle by which it turns (scalar part first)")))
        series = [Series("angle", result.time, np.degrees(turned_by(values)))]
        return Panel(title, label, series, note=note, group=component)
    shown = _IN_DEGREES.get(unit or "", unit)
    values = values if shown == unit else np.degrees(values)
    curves = values.reshape(len(result.time), -1).T[:_MOST_CURVES]
    labels = element_names(variable, values.shape[1:])
    series = [Series(label, result.time, curve) for label, curve in zip(labels, curves, strict=False)]
    return Panel(variable, f"{variable} [{shown}]" if shown else variable, series, note=note, group=component)


def key_numbers(result: Result) -> list[KeyNumber]:
    """The last value of every scalar."""
    return [
        KeyNumber(name, float(result[name][-1]), result.unit(name) or "", f"at {result.time[-1]:g} s")
        for name in result.names
        if len(result.time) and result[name].ndim == 1
    ]
