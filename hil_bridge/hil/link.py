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

_MOST = 16384  # bytes at a time
_MOST_WAITING = 8  # connections that have not said yet what they are
_MOST_EARLY = 1000  # messages that are kept of what comes before the first point


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

    def fileno(self) -> int:
        """The socket's number, to be waited for."""
        return self._socket.fileno()

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()

    def greets(self) -> bool:
        """Whether the HEARTBEAT has come that tells MAVLink from other protocols; what came with it is kept.

        To be called when there is something to read; does not wait.
        """
        self._pending, early = [], self._pending
        messages = self.receive(0.0)
        self._pending = [*early, *messages][-_MOST_EARLY:]
        return any(message.get_type() == "HEARTBEAT" for message in messages)

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
            self._socket.listen(_MOST_WAITING)
            self._socket.setblocking(False)
        except OSError as error:
            self._socket.close()
            raise AdcsError(
                f"cannot listen on {host}:{port}: {error.strerror or error}; choose another --port"
            ) from None
        self.host, self.port = host, int(self._socket.getsockname()[1])

    @contextmanager
    def autopilot(self, connect_timeout: float, timeout: float) -> Iterator[Link]:
        """Wait for an autopilot [s], the first that sends a HEARTBEAT, then listen no more: there is room for one."""
        deadline = monotonic() + connect_timeout
        waiting: list[Link] = []
        try:
            link = self._first_to_greet(waiting, deadline, connect_timeout, timeout)
        finally:
            self._socket.close()
            for each in waiting:
                each.close()
        try:
            yield link
        finally:
            link.close()

    def _first_to_greet(self, waiting: list[Link], deadline: float, connect_timeout: float, timeout: float) -> Link:
        """Return the first of those who connect that sends a HEARTBEAT; who says nothing holds up nobody."""
        last = ""
        while (patience := deadline - monotonic()) > 0:
            readable = select([self._socket.fileno(), *(link.fileno() for link in waiting)], [], [], patience)[0]
            for link in [link for link in waiting if link.fileno() in readable]:
                last = link.peer
                try:
                    greets = link.greets()
                except AdcsError:  # it left again
                    waiting.remove(link)
                    link.close()
                    continue
                if greets:
                    waiting.remove(link)
                    return link
            if self._socket.fileno() in readable:
                try:
                    connection, address = self._socket.accept()
                except OSError:  # it left before it was let in
                    continue
                waiting.append(Link(connection, f"{address[0]}:{address[1]}", timeout))
                if len(waiting) > _MOST_WAITING:
                    waiting.pop(0).close()
        if waiting or last:
            peer = waiting[-1].peer if waiting else last
            raise AdcsError(f"what connected from {peer} sent no MAVLink HEARTBEAT: it is no autopilot")
        raise AdcsError(f"no autopilot connected to {self.host}:{self.port} within {connect_timeout:g} s")
