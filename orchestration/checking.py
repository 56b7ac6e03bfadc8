"""What `adcs run` refuses of an FMU, as findings beside those of `fmus.check`: both judge alike."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

from fmus.check import Finding
from fmus.check import check as check_file
from fmus.checks import Failure, Note
from fmus.checks.behaviour import check_behaviour, doing, initialised, report
from fmus.errors import AdcsError, Unsupported
from orchestration import expected
from orchestration.entry import SystemEntry
from orchestration.fmu.file import Fmu, Kind, open_fmu
from orchestration.from_file import system_from_file
from orchestration.grid import Grid
from orchestration.running.method import method_of
from orchestration.running.run import run
from orchestration.running.session import rigid

_RUN_BY = "a run by "
_UNREAD = "modelDescription.xml cannot be read: "


def check(path: Path | str) -> list[Finding]:
    """Everything found in the FMU at `path` that `fmus.check` or a run finds; empty if it is fine."""
    expected.path("path", path)
    findings = check_file(path, lambda p: (_with_call(p, finding) for finding in check_behaviour(p, __name__)))
    try:
        open_fmu(Path(path))
    except AdcsError as error:
        text = str(error)
        found = [f for f in findings if not f.message.startswith(_UNREAD)]  # which is less than what `text` says
        if any(f.severity == "fault" and f.message in text for f in found):
            return found
        return [*found, Finding("run", text, "note" if isinstance(error, Unsupported) else "fault")]
    return findings


def _with_call(path: Path, finding: str) -> str:
    """Name the call in which a run ended its process, which a run in one of its own tells."""
    for kind in get_args(Kind):
        if finding.startswith(f"{_RUN_BY}{kind} ended the process"):
            try:
                entry = system_from_file(str(path))
                end = entry.start_time + entry.step
                run(entry.build(), stop_time=end, method=method_of(kind), isolated=True)
            except AdcsError as error:
                return f"{_RUN_BY}{kind} ends: {error}"
    return finding


def first_steps(path: Path) -> Iterator[str]:
    """Initialise it as a run does, by each of its interfaces, and take one step."""
    try:
        fmu = open_fmu(path)
    except AdcsError:  # of which there is a finding as well
        return
    interfaces: dict[Kind, object] = {
        "co-simulation": fmu.model.coSimulation,
        "model-exchange": fmu.model.modelExchange,
    }
    kinds: list[Kind] = [kind for kind, there in interfaces.items() if there]
    for kind in kinds or ["co-simulation"]:  # which is refused then
        doing(f"{_RUN_BY}{kind}")
        try:
            entry = system_from_file(str(path))
            start, step = entry.start_time, entry.step
            Grid.make(start, entry.stop_time, step, lambda: None)
            step = min(step, _internal_step(fmu) or step)
            run(entry.build(), start_time=start, stop_time=start + step, step=step, method=method_of(kind))
        except Unsupported as error:
            yield Note(str(error))
        except AdcsError as error:
            text = f"{_RUN_BY}{kind} ends: {error}"
            yield Note(text) if getattr(interfaces[kind], "needsExecutionTool", False) else text
        else:
            if kind == "co-simulation":
                yield from _last_step(entry)


def _internal_step(fmu: Fmu) -> float | None:
    """Return the step (s) of an FMU with a fixed one, where its default experiment names none: a run may be long."""
    experiment = fmu.model.defaultExperiment
    internal = getattr(fmu.model.coSimulation, "fixedInternalStepSize", None)
    return float(internal) if internal and not (experiment and experiment.stepSize) else None


def _last_step(entry: SystemEntry) -> Iterator[str]:
    """Say whether the default experiment is no whole number of steps that have to be alike; others can be asked for."""
    try:
        Grid.make(entry.start_time, entry.stop_time, entry.step, lambda: rigid(entry.build(), "3.0"))
    except AdcsError as error:
        yield Note(str(error))


def behaviour(path: Path) -> Iterator[str]:
    """What is found by running it, in this process."""
    sound = True
    for finding in initialised(path):
        sound = sound and not isinstance(finding, Failure)
        yield finding
    if sound:  # else a run fails for what is said already
        yield from first_steps(path)


if __name__ == "__main__":
    report(behaviour(Path(sys.argv[1])))
