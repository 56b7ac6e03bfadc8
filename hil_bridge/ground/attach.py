"""The simulation's side of a bridge: sends it every point, and brings the changes it asks for into the run."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from time import monotonic, sleep
from types import TracebackType
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from hil_bridge.ground.commands import Commandable
from hil_bridge.ground.endpoints import Place
from hil_bridge.ground.forecast import Forecast
from hil_bridge.ground.link import Link
from hil_bridge.ground.mapping import Signals
from hil_bridge.ground.parameters import Parameter, parameters
from hil_bridge.ground.security import Bucket
from hil_bridge.ground.settings import ALLOWED, Settings, Snapshot
from hil_bridge.ground.trial import Trial
from hil_bridge.ground.vehicle import Vehicle
from orchestration.running.change import Change
from orchestration.running.hook import Hook, Watched
from orchestration.running.outline import Outline
from orchestration.running.session import ENDLESS, Session
from orchestration.running.simulation import Simulation
from orchestration.system import System

_SHARE = 0.2  # of the run's time that trials of what ground stations want may take; what is beyond waits
_MOST_WAITING = 200
_MOST_COMMANDS = 100_000  # that are kept of a run without an end
_PATIENCE = 20.0  # s, for a process to start


class Bridge(Hook):
    """Takes part in a run as one of its hooks; a context manager that starts and ends the process of the bridge.

        system = SYSTEMS["observer-pd"].build()
        with Bridge(system, find(system), Settings("observer-pd", ..., step=0.01)) as bridge:
            run(system, stop_time=100.0, step=0.01, hooks=[pace(), bridge])

    When the process dies, the run goes on.
    """

    exchanges = "ground tools take part"

    def __init__(
        self, system: System, signals: Signals, settings: Settings, commandable: Commandable | None = None
    ) -> None:
        """`columns`, `parameters`, `arm` and `point` of the settings are filled in."""
        for what in settings.allow:
            if what not in ALLOWED:
                raise AdcsError(f"--allow {what}: expected some of {', '.join(ALLOWED)}")
        self.signals = signals
        own = commandable.own_variables if commandable is not None else []
        self.parameters: list[Parameter] = parameters(system, without=own)
        self.settings = replace(
            settings,
            columns=_columns(system, signals),
            base=signals.base,
            parameters=self.parameters,
            arm=None if commandable is None else commandable.arm,
            point=None if commandable is None else commandable.point,
        )
        Vehicle(self.settings, lambda number, kind, changes, source: None)  # refuses what is wrong here and now
        for text in settings.endpoints:
            Place.parse(text, settings.exposed)
        self.commands: list[list[Any]] = []
        self._trial = Trial(system, settings.step)
        self._where: np.ndarray[Any, Any] | None = None
        self._waiting: list[dict[str, Any]] = []
        self._last: dict[str, Any] = {}
        self._engaged = False
        self._engaged_at = 0.0
        self._link: Link | None = None
        self._process: subprocess.Popen[str] | None = None
        self._report: dict[str, Any] = {}
        self._not_taken = 0
        self._forecast: Forecast | None = None
        self._trials = Bucket(_SHARE, _SHARE)
        self._tried, self._tried_for, self._longest = 0, 0.0, 0.0  # s
        self._commands_not_kept = 0
        self.endpoints: list[str] = []

    def __enter__(self) -> Bridge:
        self._link = Link()
        command = [sys.executable, "-P", "-m", "hil_bridge.ground.process"]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert self._process.stdin is not None and self._process.stdout is not None
        start = {"token": self._link.token.hex(), "port": self._link.port, "settings": self.settings.dumped()}
        try:
            self._process.stdin.write(json.dumps(start) + "\n")
            self._process.stdin.flush()
            answer = json.loads(self._process.stdout.readline() or '{"error": "it ended at once"}')
        except OSError as error:
            answer = {"error": str(error)}
        if "error" in answer:
            self._end_process()
            self._link.close()
            raise AdcsError(f"the bridge did not start: {answer['error']}")
        self.endpoints = answer["endpoints"]
        deadline = monotonic() + _PATIENCE
        while not any(True for _ in self._link.received()) and monotonic() < deadline and self._process.poll() is None:
            sleep(0.005)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end(error)

    @property
    def pid(self) -> int:
        """Process of the bridge."""
        assert self._process is not None
        return self._process.pid

    def prepare(self, outline: Outline) -> None:
        """Refuse a run whose states cannot be saved."""
        if outline.method.kind != "co-simulation":
            raise AdcsError("mavlink: only co-simulation has it, whose states can be saved to try what tools ask for")

    def begin(self, simulation: Simulation, hooks: Sequence[Hook], watched: Watched) -> None:
        """Find what is shown in the rows of the run."""
        assert isinstance(simulation, Session)
        self._simulation, self._wanted = simulation, list[Change]()
        self._where = _places(simulation, self.signals)

    def ahead(self, k: int) -> int:
        """Every point is shown."""
        return 1

    def changes(self, k: int) -> Sequence[Change]:
        """Return what ground tools ask for."""
        changes, self._wanted = self._wanted, []
        return changes

    def after(self, point: int, time: float) -> None:
        """Send the point that was taken last; find the changes for the next."""
        self._wanted = self._seen(self._simulation, point, time)

    def _seen(self, simulation: Session, point: int, time: float) -> list[Change]:
        assert self._link is not None and self._where is not None
        self._link.snapshot(Snapshot(point, time, simulation.row[self._where]))
        for note in self._link.received():
            if not isinstance(note, dict) or note["what"] != "change":
                continue
            if len(self._waiting) < _MOST_WAITING:
                self._waiting.append(note)
            elif note["kind"] == "param":
                self._answer(note, "Too many changes at once: one was left out")
        if simulation.k > simulation.last or simulation.ended is not None:
            return []
        changes = [change for note in self._next() for change in self._made(simulation, note)]
        return [*changes, *self._released(simulation)]

    def report(self) -> dict[str, Any]:
        """End, and return what the manifest is to have: commands as [time, name, value, source], and counters."""
        self._end(sys.exc_info()[1])
        counters = {"endpoints": self.endpoints, **self._report, "points_not_taken": self._not_taken}
        if self._tried:
            counters |= {"trials": self._tried, "trials_s": self._tried_for, "longest_trial_s": self._longest}
        if self._commands_not_kept:
            counters["commands_not_kept"] = self._commands_not_kept
        return {"commands": self.commands, "mavlink": counters}

    def _end(self, error: BaseException | None) -> None:
        text, failed = _ending(error)
        if failed and self.commands:
            time, name, value, source = self.commands[-1]
            text += f"; the last change was {name} = {value} at t = {time:.6g} s by {source}"
        self.close(text, failed)

    def close(self, text: str = "Run ended", failed: bool = False) -> None:
        """End the process and fetch its counters."""
        if self._forecast is not None:
            self._forecast.close()
        if self._link is None or self._process is None:
            return
        self._link.note({"what": "end", "text": text, "failed": failed})
        self._end_process()
        self._not_taken = self._link.lost
        self._link.close()
        self._link = None

    def _end_process(self) -> None:
        assert self._process is not None and self._process.stdin is not None and self._process.stdout is not None
        with suppress(OSError):
            self._process.stdin.close()
        try:
            self._process.wait(3.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        with suppress(ValueError):
            self._report = json.loads(self._process.stdout.read() or "{}")
        self._process.stdout.close()

    def _next(self) -> list[dict[str, Any]]:
        """What is to be done at this point, parameters in their order; of all else only the newest of a kind counts.

        At most one of those that are to be tried is among them, and none while trials have had their share of the time.
        """
        newest = {note["kind"]: note["number"] for note in self._waiting}
        now: list[dict[str, Any]] = []
        later: list[dict[str, Any]] = []
        may_try = self._trials.take(monotonic(), 0.0)
        for note in self._waiting:
            if note["kind"] != "param" and note["number"] != newest[note["kind"]]:
                continue
            if not self._is_tried(note):
                now.append(note)
            elif may_try:
                may_try = False
                now.append(note)
            else:
                later.append(note)
        self._waiting = later
        return now

    def _is_tried(self, note: dict[str, Any]) -> bool:
        """Parameters, and rates of a target: any attitude is one that the law can turn to, but not any rate."""
        if note["kind"] == "param":
            return True
        point = self.settings.point
        if point is None or point.rate is None:
            return False
        rate = next((value for name, value in note["changes"] if name == point.rate), ())
        return any(rate) and rate != self._last.get(point.rate)

    def _refused(self, simulation: Session, changes: Sequence[tuple[str, Any]], param: bool) -> str | None:
        """Try values: on a copy of the component, which says by itself what it refuses, then on one of the system."""
        began = monotonic()
        self._forecast = self._forecast or Forecast(simulation)
        try:
            if param:
                for name, value in changes:
                    if (refused := self._trial.refused(name, value)) is not None:
                        return refused
            ended = self._forecast.refused(changes)
            if ended is not None:
                values = ", ".join(f"{name} = {_plain(value)}" for name, value in changes)
                return f"{values} refused: the run would end with it: {ended}"
            if param:
                self._trial.keep(changes)
            return None
        finally:
            took = monotonic() - began
            self._trials.spend(took)
            self._tried, self._tried_for = self._tried + 1, self._tried_for + took
            self._longest = max(self._longest, took)

    def _made(self, simulation: Session, note: dict[str, Any]) -> list[Change]:
        """Changes for the next point, recorded and confirmed; none if the component would refuse them."""
        changes = []
        refused: str | None = None
        try:
            for name, flat in note["changes"]:
                value = _shaped(simulation.system, name, flat)
                simulation.check_change(name, value)
                changes.append(Change(simulation.k, name, value))
            if self._is_tried(note):
                refused = self._refused(simulation, [(c.name, c.value) for c in changes], note["kind"] == "param")
        except AdcsError as error:
            refused = str(error)
        if refused is None:
            if note["kind"] != "param":  # is repeated all the time: only what is new counts
                changes = [c for c in changes if self._last.get(c.name) != _plain(c.value)]
            self._last.update({c.name: _plain(c.value) for c in changes})
            self._keep(simulation, changes, note["source"])
            if note["kind"] == "attitude" and self.settings.point is not None:
                self._engaged = self._last.get(self.settings.point.engaged or "") == 1
                self._engaged_at = monotonic()
        self._answer(note, refused)
        return changes if refused is None else []

    def _keep(self, simulation: Session, changes: Sequence[Change], source: str) -> None:
        """Record changes; all of them, unless the run has no end."""
        if simulation.last == ENDLESS and len(self.commands) + len(changes) > _MOST_COMMANDS:
            self._commands_not_kept += len(changes)
            return
        self.commands += [[simulation.time, c.name, _plain(c.value), source] for c in changes]

    def _answer(self, note: dict[str, Any], refused: str | None) -> None:
        assert self._link is not None
        self._link.note({"what": "answer", "number": note["number"], "refused": refused})

    def _released(self, simulation: Session) -> list[Change]:
        """Give guidance the attitude back when the bridge, which looks after the timeout, is gone."""
        point = self.settings.point
        if not self._engaged or point is None or point.engaged is None:
            return []
        if monotonic() - self._engaged_at < self.settings.setpoint_timeout + 2.0:
            return []
        self._engaged = False
        self._last[point.engaged] = 0
        self.commands.append([simulation.time, point.engaged, 0, "timeout"])
        return [Change(simulation.k, point.engaged, 0)]


def _ending(error: BaseException | None) -> tuple[str, bool]:
    """How a run ended, in words, and whether it failed."""
    if error is None:
        return "Run ended", False
    return (f"Run failed: {error}", True) if isinstance(error, Exception) else ("Run interrupted", False)


def _columns(system: System, signals: Signals) -> list[tuple[str, int, int]]:
    """Where the values of each role are in a snapshot."""
    first: dict[str, tuple[int, int]] = {}
    n = 0
    for name in signals.variables:
        size = system.port(name)[1].size
        first[name] = (n, n + size)
        n += size
    named = [*signals.roles.items(), *((f"shown:{key}", name) for key, name in signals.shown.items())]
    return [(key, *first[name]) for key, name in named]


def _places(simulation: Simulation, signals: Signals) -> np.ndarray[Any, Any]:
    """Where the values of a snapshot are in a row."""
    first, n = {}, 0
    for name, port in simulation.ports.items():
        first[name] = range(n, n + port.size)
        n += port.size
    missing = [name for name in signals.variables if name not in first]
    if missing:
        raise AdcsError(f"the bridge shows {missing[0]}, which is not recorded: record it too")
    return np.array([i for name in signals.variables for i in first[name]], int)


def _shaped(system: System, name: str, flat: Any) -> Any:
    port = system.port(name)[1]
    if port.type == "Boolean":
        return np.reshape(np.asarray(flat) != 0, port.shape)[()]
    if not port.type.startswith("Float"):
        return np.reshape(np.asarray(flat, np.int64), port.shape)[()]
    return np.reshape(np.asarray(flat, float), port.shape)[()]


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def log_only(system: System, signals: Signals, settings: Settings, path: Path) -> Recorder:
    """Return a watcher that writes a telemetry log, without network and process."""
    return Recorder(
        system, signals, replace(settings, columns=_columns(system, signals), base=signals.base, tlog=str(path))
    )


class Recorder(Hook):
    """Writes what a ground station would have seen to a telemetry log; a watcher and a context manager."""

    def __init__(self, system: System, signals: Signals, settings: Settings) -> None:
        from hil_bridge.ground.log import Log

        self._log = Log(replace(settings, parameters=parameters(system)))
        self._signals = signals
        self._where: np.ndarray[Any, Any] | None = None

    def begin(self, simulation: Simulation, hooks: Sequence[Hook], watched: Watched) -> None:
        """Find what is logged in the rows of the run."""
        self._simulation = simulation
        self._where = _places(simulation, self._signals)

    def ahead(self, k: int) -> int:
        """Every point is logged."""
        return 1

    def after(self, point: int, time: float) -> None:
        """Log the point that was taken last."""
        assert self._where is not None
        self._log.point(Snapshot(point, time, self._simulation.row[self._where]))

    def report(self) -> dict[str, Any]:
        """Return what the manifest of the run is to have."""
        self._log.close(*_ending(sys.exc_info()[1]))
        return {"tlog": self._log.path, **({"tlog_incomplete": self._log.trouble} if self._log.trouble else {})}

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._log.close(*_ending(error))
