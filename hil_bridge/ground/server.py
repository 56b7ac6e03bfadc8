"""The bridge itself: takes snapshots, feeds endpoints and log, hears ground stations. One loop, one thread."""

from __future__ import annotations

import select
from collections.abc import Iterator
from contextlib import suppress
from math import inf
from pathlib import Path
from time import monotonic
from typing import Any

from fmus.errors import AdcsError
from hil_bridge.ground.endpoints import Endpoint, Peer, Place, open_endpoint
from hil_bridge.ground.events import Event, Limits, Watch
from hil_bridge.ground.link import Link
from hil_bridge.ground.log import Logbook
from hil_bridge.ground.security import Keyring
from hil_bridge.ground.settings import COMPONENT_ID, SYSTEM_ID, Settings, Snapshot
from hil_bridge.ground.vehicle import Changes, Vehicle

_LOOK = 0.02  # s
_GRACE = 0.5  # s, for the last word of a simulation
_BACKLOG = 64  # snapshots; of more the oldest are left out


class Server:
    """A bridge with its endpoints open."""

    def __init__(self, settings: Settings, link: Link) -> None:
        """Raises AdcsError when an endpoint or a file cannot be had."""
        self.settings, self.link = settings, link
        self.vehicle = Vehicle(settings, self._request)
        state = Path(settings.key_state) if settings.key_state else None
        self.keyring = None if settings.key is None else Keyring.open(Path(settings.key), state)
        self.endpoints: list[Endpoint] = []
        self._log: Logbook | None = None
        self._log_trouble = ""
        self._stopped = False
        self._last_chance = inf
        self._left_out = 0
        self._busy, self._began = 0.0, monotonic()
        self._watch = Watch(Limits(saturated=settings.wheel_limit))
        try:
            for text in settings.endpoints:
                place = Place.parse(text, settings.exposed)
                allowed = settings.peers
                self.endpoints.append(open_endpoint(place, SYSTEM_ID, COMPONENT_ID, self.keyring, allowed, monotonic()))
            if self.keyring is not None:
                self.keyring.save()  # if that is not possible, it is said now
            if settings.tlog is not None:
                self._log = Logbook(Path(settings.tlog), self.vehicle)
        except BaseException:
            self.close()
            raise

    def serve(self) -> None:
        """Go on until the simulation says that it has ended, or `stop`."""
        self._say([*self.vehicle.text("Run started")])
        warned = False
        try:
            while not self._stopped and monotonic() < self._last_chance:
                sockets = [self.link.socket, *(s for e in self.endpoints for s in e.sockets)]
                readable, _, _ = select.select(sockets, [], [], _LOOK)
                now = monotonic()
                for endpoint in self.endpoints:
                    endpoint.tend(now)
                self._hear(readable, now)
                self._follow()
                self._say(self.vehicle.tick(now))
                for peer in self._peers():
                    self.vehicle.beat(peer, now)
                    self.vehicle.flush(peer)
                if self.keyring is not None and self.keyring.trouble and not warned:
                    warned = True
                    self._say(self.vehicle.text(f"Signed messages are refused: {self.keyring.trouble}"))
                self._busy += monotonic() - now
            if not self._stopped:
                self._say(self.vehicle.end("Run broken off: the simulation is gone", failed=True))
        finally:
            self.close()

    def stop(self) -> None:
        """Let `serve` end."""
        self._stopped = True

    def stop_soon(self) -> None:
        """Let `serve` end unless the simulation says by itself that it has."""
        self._last_chance = monotonic() + _GRACE

    def close(self) -> None:
        """Close endpoints and log; may be called twice."""
        for peer in self._peers():
            while peer.queue:
                self.vehicle.flush(peer)
        for endpoint in self.endpoints:
            endpoint.close()
        if self._log is not None:
            self._log.close()
            self._log_trouble = self._log.trouble
            self._log = None
        if self.keyring is not None:
            with suppress(AdcsError):  # what was written ahead holds
                self.keyring.save()

    def report(self) -> dict[str, Any]:
        """Counters of all endpoints, and how many points came too fast."""
        return {
            "endpoints": [endpoint.report() for endpoint in self.endpoints],
            "points_left_out": self._left_out,
            "busy": self._load(),
            **({"tlog_incomplete": self._log_trouble} if self._log_trouble else {}),
        }

    def _load(self) -> float:
        return self._busy / max(monotonic() - self._began, 1e-3)

    def _hear(self, readable: list[Any], now: float) -> None:
        for endpoint in self.endpoints:
            for sock in endpoint.sockets:
                if sock not in readable:
                    continue
                for peer, message in endpoint.receive(sock, now):
                    if peer.stream is None:
                        self.vehicle.greet(peer)
                    if self._log is not None:
                        self._log.heard(message)
                    self.vehicle.handle(peer, message, now)

    def _follow(self) -> None:
        """Take what the simulation sent."""
        points: list[Snapshot] = []
        for item in self.link.received():
            if isinstance(item, Snapshot):
                points.append(item)
            elif item["what"] == "answer":
                self._say(self.vehicle.answered(item["number"], item["refused"]))
            elif item["what"] == "end":
                self._take(points)
                points = []
                self._say(self.vehicle.end(item["text"], item["failed"]))
                self._stopped = True
        self._take(points)

    def _take(self, points: list[Snapshot]) -> None:
        self._left_out += max(0, len(points) - _BACKLOG)
        for point in points[-_BACKLOG:]:
            state = self.vehicle.scene.at(point)
            self.vehicle.show(state, self._load())
            now = state.since_start / self.settings.speed
            for peer in self._peers():
                self.vehicle.stream(peer, now)
            if self._log is not None:
                self._log.point()
            for event in self._watch.seen(state):
                self._event(event)

    def _event(self, event: Event) -> None:
        self._say(self.vehicle.text(event.text, event.severity))

    def _say(self, messages: list[Any]) -> None:
        self._to_all(messages)
        if self._log is not None:
            self._log.say(messages)

    def _to_all(self, messages: list[Any]) -> None:
        for peer in self._peers():
            for message in messages:
                peer.send(message)

    def _peers(self) -> Iterator[Peer]:
        for endpoint in self.endpoints:
            for peer in list(endpoint.peers.values()):
                if peer.stream is None:
                    self.vehicle.greet(peer)
                yield peer

    def _request(self, number: int, kind: str, changes: Changes, source: str) -> None:
        self.link.note({"what": "change", "number": number, "kind": kind, "changes": changes, "source": source})
