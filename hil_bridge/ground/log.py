"""A vehicle's telemetry log: what a ground station that only listens would have written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hil_bridge.ground.events import Limits, Watch
from hil_bridge.ground.security import Codec
from hil_bridge.ground.settings import COMPONENT_ID, SYSTEM_ID, Settings, Snapshot
from hil_bridge.ground.streams import Streams
from hil_bridge.ground.tlog import TlogWriter
from hil_bridge.ground.vehicle import Vehicle, message_rates


class Logbook:
    """A vehicle's log: a partner that only listens. Its time is that of the simulation."""

    def __init__(self, path: Path, vehicle: Vehicle) -> None:
        self._vehicle, self._writer = vehicle, TlogWriter(path)
        self._streams = Streams(message_rates(vehicle.settings))
        self._codec = Codec(SYSTEM_ID, COMPONENT_ID)
        self._flushed = 0.0

    def point(self) -> None:
        """Write what is due at the present state."""
        state, report = self._vehicle.state, self._vehicle.report
        assert state is not None and report is not None
        for id_ in self._streams.due(state.since_start):
            self.say(report.messages(id_))
        if state.since_start - self._flushed >= 1.0:
            self._flushed = state.since_start
            self._writer.flush()

    def say(self, messages: list[Any]) -> None:
        """Write messages of the vehicle."""
        for message in messages:
            self._writer.write(self._now, self._codec.packed(message))

    def heard(self, message: Any) -> None:
        """Write a message of a ground station."""
        self._writer.write(self._now, bytes(message.get_msgbuf()))

    @property
    def _now(self) -> float:
        state = self._vehicle.state
        return self._vehicle.scene.earth.unix_time(self._vehicle.settings.start if state is None else state.t)

    @property
    def trouble(self) -> str:
        """Why the log ends before the run, if it does."""
        return self._writer.trouble

    def close(self) -> int:
        """Close the file; return how many frames were written."""
        self._writer.close()
        return self._writer.frames


class Log:
    """A log without a bridge."""

    def __init__(self, settings: Settings) -> None:
        assert settings.tlog is not None
        self.path = settings.tlog
        self._open = True
        self._vehicle = Vehicle(settings, lambda number, kind, changes, source: None)
        self._watch = Watch(Limits(saturated=settings.wheel_limit))
        self._book = Logbook(Path(settings.tlog), self._vehicle)
        self._book.say([*self._vehicle.banner(), *self._vehicle.all_parameters(), *self._vehicle.text("Run started")])

    def point(self, snapshot: Snapshot) -> None:
        """Log a point of the run."""
        state = self._vehicle.scene.at(snapshot)
        self._vehicle.show(state)
        self._book.point()
        for event in self._watch.seen(state):
            self._book.say(self._vehicle.text(event.text, event.severity))

    @property
    def trouble(self) -> str:
        """Why the log ends before the run, if it does."""
        return self._book.trouble

    def close(self, text: str, failed: bool = False) -> None:
        """Write how it ended, and close the file; may be called twice."""
        if self._open:
            self._open = False
            self._book.say(self._vehicle.end(text, failed))
            self._book.close()
