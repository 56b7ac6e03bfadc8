"""The TCP connection of a simulator to the one autopilot that flies in it."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import contextmanager
from ipaddress import ip_address
from select import select
from time import monotonic
from typing import Any

from fmus.errors import AdcsError
from hil_bridge.hil.framing import Frames

PORT = 4560
"""Where PX4 looks for its simulator."""

_MOST = 65536  # bytes at a time


class Link:
    """A connected autopilot. Every failure of the connection is an AdcsError that says what the autopilot did."""

    def __init__(self, connection: socket.socket, peer: str, timeout: float) -> None:
        """`timeout` is how long the autopilot may leave messages unread [s]."""
        self.peer, self.frames = peer, Frames()
        self._socket = connection
        self._pending: list[Any] = []
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.settimeout(timeout)

    def send(self, data: bytes) -> None:
        """Send all of it."""
        try:
            self._socket.sendall(data)
        except TimeoutError:
            raise AdcsError(f"the autopilot at {self.peer} no longer reads what it is sent") from None
        except OSError as error:
            raise self._lost(error) from None

    def greeted(self, deadline: float) -> None:
        """Wait for the HEARTBEAT that tells MAVLink from other protocols; keep what came with it."""
        early: list[Any] = []
        while not any(message.get_type() == "HEARTBEAT" for message in early):
            if monotonic() >= deadline:
                raise AdcsError(f"what connected from {self.peer} sent no MAVLink HEARTBEAT: it is no autopilot")
            early += self.receive(deadline)
        self._pending = early

    def receive(self, deadline: float) -> list[Any]:
        """Return the messages that are there, or the next before `deadline` (of time.monotonic); else none."""
        if self._pending:
            messages, self._pending = self._pending, []
            return messages
        while True:
            patience = max(0.0, deadline - monotonic())
            if not select([self._socket], [], [], patience)[0]:
                return []
            try:
                data = self._socket.recv(_MOST)
            except OSError as error:
                raise self._lost(error) from None
            if not data:
                raise self._lost(ConnectionResetError())
            if messages := self.frames.feed(data):
                return messages
            if patience == 0.0:
                return []

    def _lost(self, error: OSError) -> AdcsError:
        if isinstance(error, ConnectionResetError | BrokenPipeError):
            return AdcsError(f"the autopilot at {self.peer} closed the connection")
        return AdcsError(f"the connection to the autopilot at {self.peer} broke: {error.strerror or error}")


class Server:
    """Listens for an autopilot, on the loopback interface unless `remote`."""

    def __init__(self, host: str = "127.0.0.1", port: int = PORT, remote: bool = False) -> None:
        """Port 0 lets the system choose one."""
        try:
            loopback = ip_address(host).is_loopback
        except ValueError:
            raise AdcsError(f"host {host!r} is not an IP address: use 127.0.0.1") from None
        if not loopback and not remote:
            raise AdcsError(f"{host} can be reached from other machines, which MAVLink does not keep out: add --remote")
        if not 0 <= port <= 65535:
            raise AdcsError(f"port {port}: expected 0 to 65535")
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_STREAM)
        try:
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._socket.bind((host, port))
            self._socket.listen(1)
        except OSError as error:
            self._socket.close()
            raise AdcsError(
                f"cannot listen on {host}:{port}: {error.strerror or error}; choose another --port"
            ) from None
        self.host, self.port = host, int(self._socket.getsockname()[1])

    @contextmanager
    def autopilot(self, connect_timeout: float, timeout: float) -> Iterator[Link]:
        """Wait for an autopilot [s] and for its HEARTBEAT, then listen no more: there is room for one."""
        where = f"{self.host}:{self.port}"
        deadline = monotonic() + connect_timeout
        try:
            if not select([self._socket], [], [], connect_timeout)[0]:
                raise AdcsError(f"no autopilot connected to {where} within {connect_timeout:g} s")
            connection, address = self._socket.accept()
        finally:
            self._socket.close()
        with connection:
            link = Link(connection, f"{address[0]}:{address[1]}", timeout)
            link.greeted(deadline)
            yield link
