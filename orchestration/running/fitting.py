"""The choice of a method, where none is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

from fmus.errors import AdcsError
from orchestration.coupled import CoupledModel
from orchestration.fmu.file import FmiVersion
from orchestration.running.checkpoint import Checkpoint
from orchestration.running.method import CoSimulation, Method, ModelExchange
from orchestration.system import System

if TYPE_CHECKING:
    from orchestration.running.hook import Hook


@dataclass(frozen=True)
class Fitting(Method):
    """The one that fits: all components as one differential equation, where that is what they are.

    It is solved to many digits for less than an exchange of values costs. Co-simulation is taken where something is
    sampled, delayed or from elsewhere, or happens outside; and where a step is asked for.
    """

    def choose(
        self,
        system: System,
        fmi_version: FmiVersion,
        hooks: Sequence[Hook],
        *,
        stepped: bool,
        resume: str | Path | None,
    ) -> tuple[Method, str]:
        """Return the method, and why; `stepped` says whether a step is asked for."""
        if resume is not None:
            saved = Checkpoint.read(Path(resume)).method
            again = CoSimulation() if saved is None else Method.of_manifest(saved)
            return replace(again, loops=again.loops or self.loops, timeout=self.timeout), "the checkpoint is of it"
        obstacle = _asked(hooks, stepped) or _obstacle(system, fmi_version)
        kind = CoSimulation if obstacle else ModelExchange
        return kind(loops=self.loops, timeout=self.timeout), obstacle or "all components are continuous"


def _asked(hooks: Sequence[Hook], stepped: bool) -> str | None:
    """Say what is asked for that only co-simulation has."""
    if stepped:
        return "an exchange step is asked for"
    return next((hook.exchanges for hook in hooks if hook.exchanges), None)


def _obstacle(system: System, fmi_version: FmiVersion) -> str | None:
    """Say what of the system is no differential equation, or may not be one."""
    for connection in system.connections:
        if connection.delayed:
            return f"the connection to {connection.target} is delayed"
    for component in system.components.values():
        if component.every > 1:
            return f"{component.name} communicates at every {component.every} steps"
    candidates = 0
    for component in system.components.values():
        fmu = component.open(fmi_version)
        if not fmu.ours:
            return f"{component.name} is of another tool"
        if fmu.model.modelExchange is None:
            return f"{component.name} has no Model Exchange interface"
        candidates += any(port.variability == "discrete" for port in fmu.ports.values())
    return _sampled(system, fmi_version) if candidates else None


def _sampled(system: System, fmi_version: FmiVersion) -> str | None:
    """Say what has a time event ahead once it is initialised, which may depend on its parameters; remembered."""
    components = system.components.values()
    key = (
        fmi_version,
        tuple((c.name, c.open(fmi_version).sha256, tuple(c.start.items())) for c in components),
        system.connections,
    )
    if key not in _known:
        try:
            with CoupledModel(system, 0.0, fmi_version=fmi_version, record=[]) as model:
                _known[key] = f"{model.next_event_of} is sampled" if model.next_event < inf else None
        except AdcsError:  # of which the run itself will tell
            _known[key] = "it cannot be initialised as one differential equation"
    return _known[key]


_known: dict[tuple[object, ...], str | None] = {}
