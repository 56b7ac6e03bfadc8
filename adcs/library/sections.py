"""A study as a sequence of sections: each names the runs that its claims need, and is shown when they are there."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, TypeVar

from adcs.library.outcome import Outcome, Progress, Shown
from orchestration.results.result import Result, RunFailed
from orchestration.running.method import CoSimulation, Method
from orchestration.running.run import run
from orchestration.running.save import Save
from orchestration.system import System

C = TypeVar("C")
Manifests = list[tuple[str, Mapping[str, Any]]]
"""Label and manifest of each run."""


@dataclass(frozen=True)
class Simulation:
    """A run that is needed: the system, how it is run, and `view`, what is kept of its result.

    `record` are the variables of the result; None: all outputs. Of a run that `may_fail` the view gets what was
    recorded until then.
    """

    label: str
    system: System
    view: Callable[[Result], Any]
    stop_time: float
    step: float
    method: Method = field(default_factory=CoSimulation)
    every: int = 1
    may_fail: bool = False
    record: Sequence[str] | None = None

    @property
    def key(self) -> tuple[Any, ...]:
        """Equal for runs that are one and the same, however they are viewed."""
        parts = [(p.name, str(p.source), tuple(p.start.items()), p.every) for p in self.system.components.values()]
        kept = None if self.record is None else tuple(self.record)
        how = (self.stop_time, self.step, self.method, self.every, self.may_fail)
        return (tuple(parts), tuple(self.system.connections), kept, *how)

    def run(self, simulate: Callable[..., Result], progress: Callable[[float], None]) -> Result:
        """Run it by `simulate`, a function like `run`."""
        times = {"stop_time": self.stop_time, "step": self.step}
        save = Save(self.record, every=self.every)
        try:
            return simulate(self.system, **times, method=self.method, save=save, progress=progress)
        except RunFailed as failure:
            if not self.may_fail:
                raise
            return failure.result


def failed_at(result: Result) -> float | None:
    """The time at which a run that may fail did [s]; None if it went to its end."""
    outcome = result.manifest.get("outcome", {})
    return float(outcome["time"]) if outcome.get("status") == "failed" else None


@dataclass(frozen=True)
class Section:
    """A part of a document: `runs` by the names that `show` gets them under, already as they were to be viewed.

    `group` is its heading in the report, `title` that of the table of its claims; `counted` names the reading that
    makes the score, where claims are judged in several.
    """

    group: str
    title: str
    show: Callable[[Any], Iterable[Shown]]
    runs: Mapping[Any, Simulation] = field(default_factory=dict)
    counted: str = ""


def conduct(
    sections: Sequence[Section], progress: Progress = lambda done, text: None, simulate: Callable[..., Result] = run
) -> tuple[Outcome, Manifests]:
    """Make the runs of all sections, equal ones once, and say how far all is; return what they show, and the runs."""
    planned: dict[tuple[Any, ...], set[Callable[[Result], Any]]] = {}
    for section in sections:
        for simulation in section.runs.values():
            planned.setdefault(simulation.key, set()).add(simulation.view)
    seen: dict[tuple[Any, ...], dict[Callable[[Result], Any], Any]] = {}
    manifests: Manifests = []

    def view(simulation: Simulation) -> Any:
        key, label = simulation.key, simulation.label
        if key not in seen:
            done, total = len(seen), len(planned)
            progress(done / total, label)
            result = simulation.run(simulate, lambda part: progress((done + part) / total, label))
            manifests.append((label, result.manifest))
            seen[key] = {look: look(result) for look in planned[key]}
        return seen[key][simulation.view]

    outcome = Outcome()
    for section in sections:
        shown = section.show({name: view(simulation) for name, simulation in section.runs.items()})
        outcome += Outcome.of(shown, section.counted).within(section.group, section.title)
    return outcome, manifests


def study_of(sections: Callable[[C], Sequence[Section]]) -> Callable[..., tuple[Outcome, Manifests]]:
    """What runs a study whose sections follow from its choices: as `conduct`, with choices in their place."""

    def study(choices: C, progress: Progress, simulate: Callable[..., Result] = run) -> tuple[Outcome, Manifests]:
        return conduct(sections(choices), progress, simulate)

    return study


def manifest_of(choices: Any, runs: Manifests) -> dict[str, Any]:
    """How the study was run, for its report: what the runs share once, and a line for each of them."""
    components = [component for _, manifest in runs for component in manifest["system"]["components"].values()]
    files = {c["file"]: {"fmi_version": c["fmi_version"], "sha256": c["sha256"]} for c in components}
    return {
        "started": runs[0][1]["started"],
        "choices": {
            f.name: {"value": getattr(choices, f.name), "meaning": f.metadata.get("help", "")} for f in fields(choices)
        },
        "FMUs": dict(sorted(files.items())),
        "versions": runs[0][1]["versions"],
        "runs": [
            {
                "run": label,
                "system": m["system"]["name"],
                **{name: value for name, value in m["settings"].items() if name != "record"},
                "seeds": m["seeds"],
                "CPU time [s]": m["timing"]["cpu_s"],
            }
            for label, m in runs
        ],
    }
