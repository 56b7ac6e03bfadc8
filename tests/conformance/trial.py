"""One Reference-FMU by one method: the same run here and by fmpy, every numeric output at every common time."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

from adcs import AdcsError, CoSimulation, ModelExchange, System, run
from orchestration.fmu.file import Fmu, Kind, Port, open_fmu
from orchestration.system import NUMERIC

CLOSE: dict[Kind, float] = {"co-simulation": 1e-12, "model-exchange": 1e-4}
"""How far the two may differ, relative to the largest value of the output: the same calls give the same bits but for
the time of a step, k*h here and a sum there; two integrators with a tolerance of 1e-8 differ by what events add."""

ONE_INTERNAL_STEP = {"Roberts": 1e-7}
"""FMUs with a fixed internal step that count how many of them fit: fmpy asks for the next point less the last, whose
last bit varies, and so once for a step more or less than with a constant step."""

TOLERANCE = 1e-8
POINTS = 200  # where the default experiment names no step
MOST = 2000  # points of a run: Roberts' default experiment has 10^11


@dataclass(frozen=True)
class Trial:
    """What came of it: the largest relative difference, or why there is none."""

    model: str
    version: int
    kind: Kind
    rows: int
    difference: float
    remark: str = ""

    @property
    def good(self) -> bool:
        """Whether both agree."""
        return self.difference <= max(CLOSE[self.kind], ONE_INTERNAL_STEP.get(self.model, 0.0))


def trial(path: Path, kind: Kind) -> Trial | None:
    """Run it both ways; None where the FMU has no such interface."""
    fmu = open_fmu(path)
    model = fmu.model
    if (model.coSimulation if kind == "co-simulation" else model.modelExchange) is None:
        return None
    version = fmu.major_version
    start, stop, step = _experiment(model)
    method = CoSimulation() if kind == "co-simulation" else ModelExchange(rtol=TOLERANCE, atol=TOLERANCE)
    try:
        system = System(path.stem)
        system.add("it", path)
        inputs = _inputs(fmu)
        for name, value in inputs.items():
            system.set(f"it.{name}", value)
        result = run(system, start_time=start, stop_time=stop, step=step, method=method)
    except AdcsError as error:
        return Trial(path.stem, version, kind, 0, inf, f"here: {error}")
    names = [n for n, p in fmu.ports.items() if p.causality == "output" and p.type.startswith(NUMERIC)]
    try:
        theirs: Any = fmpy.simulate_fmu(
            str(path),
            start_time=start,
            stop_time=stop,
            output_interval=step,
            start_values=inputs,
            relative_tolerance=TOLERANCE,
            fmi_type="CoSimulation" if kind == "co-simulation" else "ModelExchange",
            output=[n for name in names for n in ([name] if version == 3 else fmu.ports[name].elements)],
        )
    except Exception as error:
        return Trial(path.stem, version, kind, len(result.time), inf, f"fmpy: {error}")
    rows, difference = _difference(result, theirs, names, step)
    return Trial(path.stem, version, kind, rows, difference)


def _experiment(model: Any) -> tuple[float, float, float]:
    experiment = model.defaultExperiment
    start, stop = float(experiment.startTime or 0.0), float(experiment.stopTime or 1.0)
    internal = getattr(model.coSimulation, "fixedInternalStepSize", None) if model.coSimulation else None
    step = float(experiment.stepSize or internal or (stop - start) / POINTS)
    return start, min(stop, start + MOST * step), step


def _inputs(fmu: Fmu) -> dict[str, Any]:
    """A value that is not the start value for every input, so that what is set is seen to arrive."""
    inputs = {n: p for n, p in fmu.ports.items() if p.causality == "input" and p.type.startswith(NUMERIC)}
    return {n: _filled(p, True if p.type == "Boolean" else 2 if p.items else 7) for n, p in inputs.items()}


def _filled(port: Port, value: Any) -> Any:
    return np.full(port.shape, value) if port.shape else value


def _difference(result: Any, theirs: Any, names: list[str], step: float) -> tuple[int, float]:
    """Compare at the points of the grid, which have to be the same.

    At an event fmpy has a row before and one after, of which the later counts. Where an event ends the simulation
    it has none after, and there is nothing to compare the last row with.
    """
    start, last = float(result.time[0]), {}
    for i, time in enumerate(np.asarray(theirs["time"])):
        k = round((float(time) - start) / step)
        if abs(float(time) - start - k * step) < 1e-6 * step:
            last[k] = i
    rows = len(result.time)
    if sorted(last) != list(range(rows)):
        return rows, inf
    ends_in_event = "ended" in result.manifest["outcome"] and result.manifest["settings"]["method"] == "model-exchange"
    compared = rows - 1 if ends_in_event else rows
    others = [last[k] for k in range(compared)]
    largest = 0.0
    for name in names:
        mine = np.asarray(result[f"it.{name}"][:compared], float)
        its = np.asarray(theirs[name][others], float)
        scale = max(1.0, float(np.abs(its).max(initial=0.0)))
        largest = max(largest, float(np.abs(mine - its).max(initial=0.0)) / scale)
    return rows, largest
