"""What comes of a run, however it ends: its rows and its manifest, as a result or with the error that ended it."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from fmus.errors import AdcsError
from orchestration.instances.instance import CallFailed
from orchestration.plan.lowering import Floats
from orchestration.process.guard import explained
from orchestration.results.manifest import completed, make_manifest
from orchestration.results.result import Result, RunFailed, RunInterrupted
from orchestration.running.asking import ask
from orchestration.running.driver import Driver
from orchestration.running.hook import Hook, together
from orchestration.running.outline import Outline


class Account:
    """Keeps the account of a run from the moment at which it was found right."""

    def __init__(self, outline: Outline, hooks: Sequence[Hook]) -> None:
        self.outline = outline
        self._recording, self.times, grid = outline.recording, outline.times, outline.grid
        self.manifest = make_manifest(
            outline.system,
            outline.fmi_version,
            _settings(outline, hooks),
            outline.files,
        )
        self.manifest["warnings"] += outline.warnings
        self.manifest |= outline.about
        if unknown := [type(hook).__name__ for hook in hooks if not hook.repeatable]:
            self.manifest["watchers"] = unknown
        self._began: tuple[float, float] | None = None  # wall and CPU time [s]
        self._ended: tuple[float, float] | None = None
        self._driver: Driver | None = None
        self._recording.begin(grid, self.manifest, outline.first, outline.save.every)

    def begin(self, driver: Driver) -> None:
        """See the run proper begin, after opening and initialising."""
        self._driver, self._began = driver, (time.perf_counter(), time.process_time())
        self._recording.where.place.started = 1

    def end(self) -> None:
        """Note what everyone has to report, before the components are gone."""
        self._ended = time.perf_counter(), time.process_time()
        assert self._driver is not None
        simulation, told = self._driver.simulation, self._driver.report()
        simulation.notes += [
            f"{name} of a report is left out: the manifest has it" for name in told if name in self.manifest
        ]
        self.manifest.update({name: value for name, value in told.items() if name not in self.manifest})
        if simulation.ended is not None and self._recording.filled:
            self.times[self._recording.filled - 1] = self._driver.row_at

    @contextmanager
    def told(self) -> Iterator[None]:
        """Let what ends the run carry what was recorded."""
        try:
            yield
        except CallFailed as error:
            if error.time is None and self._began is not None:  # it hung in model-exchange
                error.time = float(self.times[max(self._recording.filled - 1, 0)])
            if error.time is None:  # it failed in initialisation
                raise
            left = self._failed(error.component, error.time, error.text)
            raise RunFailed(f"{error}; {len(left.time)} rows are kept", left) from error
        except AdcsError as error:
            if self._began is None:
                raise
            text = explained(error, self.manifest["warnings"])
            at = self.times[min(self._recording.filled, len(self.times) - 1)]
            left = self._failed(None, float(at), text)
            raise RunFailed(f"{text}; {len(left.time)} rows are kept", left) from error
        except KeyboardInterrupt as error:
            raise RunInterrupted(self._result({"status": "interrupted"})) from error

    def complete(self) -> Result:
        """Return the result of a run that came to its end."""
        return self._result(completed(self.manifest))

    def _failed(self, component: str | None, at: float, message: str) -> Result:
        outcome = {"status": "failed", "component": component, "time": at, "message": message}
        self._recording.fail(outcome)
        return self._result(outcome)

    def _result(self, outcome: Mapping[str, Any]) -> Result:
        recording = self._recording
        try:
            recording.flush()
        except AdcsError as error:  # the disk is full, too; less is kept
            self.manifest["warnings"].append(str(error))
        times = self.times[: recording.filled]
        self.manifest["timing"] = self._timing(times)
        self.manifest["outcome"] = {**outcome, "rows": len(times)}
        result = recording.result(times, self.manifest)
        if self._driver is not None:
            simulation = self._driver.simulation
            result.state_names = simulation.state_names
            result.states = simulation.states[: len(times)].reshape(len(times), len(result.state_names))
        return result

    def _timing(self, times: Floats) -> dict[str, float | None]:
        """Wall and CPU time of the run proper, without opening, initialising and closing."""
        if self._began is None or self._ended is None:
            return {}
        wall, cpu = (ended - began for began, ended in zip(self._began, self._ended, strict=True))
        simulated = float(times[-1] - times[0]) if len(times) else 0.0
        per_cpu = simulated / cpu if cpu > 0 else None
        return {"wall_s": wall, "cpu_s": cpu, "simulated_s": simulated, "simulated_s_per_cpu_s": per_cpu}


def _settings(outline: Outline, hooks: Sequence[Hook]) -> dict[str, Any]:
    """Return what the manifest has to know to repeat the run."""
    own = {
        "fmi_version": outline.fmi_version,
        "start_time": outline.grid.start,
        "stop_time": outline.grid.time(outline.grid.steps),
        "step": outline.grid.step,
        **outline.method.for_manifest(),
        **outline.save.for_manifest(),
        **({} if outline.saved is None else {"resume": str(outline.saved.path)}),
    }
    given = [ask(hook, "for_manifest") for hook in hooks]
    for hook, settings in zip(hooks, given, strict=True):
        for name in settings.keys() & own:
            raise AdcsError(f"{type(hook).__name__}.for_manifest has {name!r}, which the run has: give it another name")
    return {**own, **together(*given)}
