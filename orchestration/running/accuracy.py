"""What the exchange step costs in accuracy: against the coupled solution, or by halving the step."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from orchestration import expected
from orchestration.results.result import Result
from orchestration.running.method import ModelExchange
from orchestration.running.parts import parts
from orchestration.running.save import Save
from orchestration.system import System


@dataclass(frozen=True)
class Deviation:
    """By how much a recorded variable is off: at most, at which time (s), and root mean square over time."""

    variable: str
    unit: str | None
    most: float
    at: float
    rms: float


@dataclass(frozen=True)
class Estimate:
    """How the error was estimated, and what came out for each variable."""

    method: str
    note: str
    deviations: tuple[Deviation, ...]

    def as_dict(self) -> dict[str, Any]:
        """For the manifest."""
        return asdict(self)


def estimate_error(
    result: Result, run: Callable[..., Result], progress: Callable[[float], Any] = lambda fraction: None
) -> Estimate:
    """Estimate the error of a co-simulation, by running its system again with `run`, which is `adcs.run`.

    If all components can be integrated as one differential equation, that solution is taken for the truth. Else the
    exchange step is halved: the error of co-simulation is of first order in it, so it is twice the difference.
    """
    if not isinstance(result, Result):
        raise expected.refused("result", result, "a Result, as adcs.run returns it")
    if not callable(run):
        raise expected.refused("run", run, "adcs.run, or what calls it")
    settings = dict(result.manifest["settings"])
    if settings["method"] != "co-simulation":
        raise AdcsError("the error of the exchange step is a matter of co-simulation: model-exchange has none")
    for name in ("until", "record"):
        settings.pop(name, None)
    settings["stop_time"] = float(result.time[-1])
    obstacle = _obstacle(result.system, settings)
    asked, _ = parts(settings)
    if obstacle is None:
        coupled = ModelExchange(loops=asked["method"].loops)
        times = {name: asked[name] for name in ("start_time", "stop_time", "step", "fmi_version")}
        reference = run(result.system, method=coupled, save=Save(result.names), **times, progress=progress)
        at = np.searchsorted(reference.time, result.time - 1e-6 * settings["step"])  # where rows were recorded
        at = at[at < len(reference.time)]  # a component may end the simulation, here a little sooner
        truth: Mapping[str, Any] = {name: reference[name][at] for name in result.names}
        return _compare(result, truth, 1.0, "coupled model exchange", "compared with the solution as one equation")
    if "adaptive" in settings or "resume" in settings:
        raise AdcsError("the error of an adaptive or a resumed run cannot be estimated by halving the step")
    asked["step"] /= 2
    asked["save"] = Save(result.names, every=2 * asked["save"].every)
    finer = run(result.system.refined(), **asked, progress=progress)
    note = f"twice the difference to half the exchange step, because {obstacle}"
    return _compare(result, {name: finer[name] for name in result.names}, 2.0, "step halving", note)


def _obstacle(system: System, settings: Mapping[str, Any]) -> str | None:
    """Say why there is no coupled solution."""
    for component in system.components.values():
        if component.fmu.model.modelExchange is None:
            return f"{component.name} has no Model Exchange interface"
        if component.every > 1:
            return f"{component.name} communicates at every {component.every} steps only"
    for connection in system.connections:
        if connection.delayed:
            return f"the connection to {connection.target} is delayed"
    for name in ("changes", "inputs", "resume"):
        if name in settings:
            return f"the run has {name}"
    return None


def _compare(result: Result, truth: Mapping[str, Any], factor: float, method: str, note: str) -> Estimate:
    deviations = []
    rows = min(len(result.time), *(len(values) for values in truth.values())) if truth else len(result.time)
    for name in result.names:
        here, there = (np.asarray(values[name], float)[:rows] for values in (result, truth))
        off = np.abs(here - there).reshape(rows, -1) * factor
        off = off.max(axis=1)
        worst = int(off.argmax())
        deviations.append(
            Deviation(
                name, result.unit(name), float(off[worst]), float(result.time[worst]), float(np.sqrt(np.mean(off**2)))
            )
        )
    return Estimate(method, note, tuple(deviations))
