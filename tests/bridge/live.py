"""A bridge in a thread of the test, with a simulation that the test plays, and ground stations on real sockets."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from threading import Thread
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from adcs import Hook
from hil_bridge.ground.endpoints import TcpIn, UdpIn
from hil_bridge.ground.link import Link
from hil_bridge.ground.server import Server
from hil_bridge.ground.settings import Settings, Snapshot

PATIENCE = 30.0  # s: far longer than anything takes, on a busy machine too


def until(condition: Callable[[], Any], patience: float = PATIENCE) -> Any:
    """Wait for something to become true, and return it."""
    end = time.monotonic() + patience
    while not (found := condition()):
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.001)
    return found


class Bridge:
    """The simulation's side."""

    def __init__(self, settings: Settings) -> None:
        self.link = Link()
        self.server = Server(settings, Link(self.link.token, self.link.port))
        until(lambda: list(self.link.received()))  # hello
        self._thread = Thread(target=self.server.serve, daemon=True)
        self._thread.start()
        self.k = 0
        self.n = settings.columns[-1][2]
        self.step = settings.step

    def point(self, values: list[float] | None = None) -> float:
        """Send a point; return how long that took [s]."""
        began = time.perf_counter()
        self.link.snapshot(Snapshot(self.k, self.k * self.step, values or [0.5] * self.n))
        self.k += 1
        return time.perf_counter() - began

    def play(self, n: int, *stations: Udp) -> None:
        """Send n points, not faster than the bridge takes them, while stations listen."""
        for _ in range(n):
            self.point()
            k = self.k - 1
            until(lambda k=k: self.server.vehicle.state is not None and self.server.vehicle.state.k >= k - 8)
            for station in stations:
                station.listen()

    def address(self, i: int = 0) -> tuple[str, int]:
        place = self.server.endpoints[i].place
        return place.host, place.port

    def end(self) -> None:
        self.server.stop()
        self._thread.join(PATIENCE)
        self.link.close()
        self.server.link.close()


@contextmanager
def bridge(settings: Settings, *endpoints: str, **changes: Any) -> Iterator[Bridge]:
    found = Bridge(replace(settings, endpoints=list(endpoints), **changes))
    try:
        yield found
    finally:
        found.end()


class Udp:
    """A ground station on UDP; bound to a port of its own."""

    def __init__(self, system: int = 255) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.setblocking(False)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self.port = self.socket.getsockname()[1]
        self.mav = mavlink.MAVLink(None, srcSystem=system, srcComponent=190)
        self.mav.robust_parsing = True
        self.heard: list[Any] = []

    def __del__(self) -> None:
        self.socket.close()

    def send(self, message: Any, to: tuple[str, int]) -> None:
        self.socket.sendto(message if isinstance(message, bytes) else message.pack(self.mav), to)

    def listen(self) -> list[Any]:
        while True:
            try:
                data = self.socket.recv(65535)
            except OSError:
                return self.heard
            self.heard += self.mav.parse_buffer(data) or []

    def count(self, name: str) -> int:
        return sum(m.get_type() == name for m in self.listen())


class Over(Hook):
    """Ends a run when a thread is done."""

    def __init__(self, thread):
        self.thread = thread

    def after(self, point, time):
        if not self.thread.is_alive():
            raise KeyboardInterrupt


HEARTBEAT = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)

__all__ = ["HEARTBEAT", "Bridge", "Over", "TcpIn", "Udp", "UdpIn", "bridge", "until"]
