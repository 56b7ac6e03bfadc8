"""Where ground stations are: UDP to and from them, TCP. Nothing here waits; what cannot be sent now is dropped."""

from __future__ import annotations

import ipaddress
import os
import socket
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

from fmus.errors import AdcsError, Failed
from hil_bridge.ground.security import Bucket, Codec, Keyring

Kind = Literal["udpout", "udpin", "tcpin"]
Address = tuple[str, int]

DEFAULTS = ("udpout:127.0.0.1:14550", "udpout:127.0.0.1:14540")
MOST_PEERS = 16

_RATE, _BURST = 200.0, 400.0  # messages per second that a source may send
_FRAME = 280  # bytes of the longest message; so many more that are none count as one
_IDLE = 10.0  # s without a word, after which a source is forgotten
_STALLED = 5.0  # s in which a TCP partner takes nothing, after which it is left
_SEND_BUFFER = 1 << 16
_MOST_READ = 64  # datagrams of an endpoint, until others have their turn


@dataclass
class Counters:
    """What went through an endpoint."""

    sent: int = 0
    sent_bytes: int = 0
    not_sent: int = 0
    received: int = 0
    bad: int = 0
    limited: int = 0
    strangers: int = 0
    disconnected: int = 0


@dataclass(frozen=True)
class Place:
    """One endpoint as it was asked for: `udpout:127.0.0.1:14550`."""

    kind: Kind
    host: str
    port: int

    def __str__(self) -> str:
        return f"{self.kind}:{self.host}:{self.port}"

    @classmethod
    def parse(cls, text: str, exposed: bool = False) -> Place:
        """Read KIND:HOST:PORT; refuse an address beyond this machine unless it may be `exposed`."""
        kind, _, rest = text.partition(":")
        host, _, port = rest.rpartition(":")
        host = "127.0.0.1" if host in ("", "localhost") else host
        expected = "expected udpout:HOST:PORT, udpin:HOST:PORT or tcpin:HOST:PORT, as in udpout:127.0.0.1:14550"
        if kind not in ("udpout", "udpin", "tcpin") or not port.isdecimal() or int(port) > 65535:
            raise AdcsError(f"endpoint {text!r}: {expected}")
        try:
            address = ipaddress.IPv4Address(host)
        except ValueError:
            raise AdcsError(f"endpoint {text!r}: {host!r} is not an IPv4 address; {expected}") from None
        if kind == "udpout" and int(port) == 0:
            raise AdcsError(f"endpoint {text!r}: port 0 is no place to send to")
        if not address.is_loopback and not exposed:
            raise AdcsError(
                f"endpoint {text!r} reaches beyond this machine, and MAVLink lets anyone there in: "
                "add --remote, and --key to have messages signed"
            )
        return cls(kind, host, int(port))  # type: ignore[arg-type]


class Peer:
    """One partner: its codec, how often it may speak, and what it is sent.

    `stream`, `spoke` and `beat` (the times [s] of its last message and of the heartbeat before the next) are the
    vehicle's to use.
    """

    def __init__(self, name: str, codec: Codec, now: float, write: Callable[[bytes], bool]) -> None:
        self.name, self.codec, self.heard = name, codec, now
        self.bucket = Bucket(_RATE, _BURST)
        self.stream: Any = None
        self.spoke: float | None = None
        self.queue: deque[Any] = deque()
        self.beat = -1e9
        self._write = write
        self.lost = 0
        self.sent = 0

    def send(self, message: Any) -> bool:
        """Send a message whole, or not at all; whether it was sent."""
        done = self._write(self.codec.packed(message))
        self.sent += done
        self.lost += not done
        return done


class Endpoint:
    """Sockets and partners of one place. `peers` are those to be talked to."""

    def __init__(self, place: Place, codec: Callable[[], Codec], allowed: Sequence[str]) -> None:
        self.place, self.counters = place, Counters()
        self._codec, self._allowed = codec, frozenset(allowed)
        self.peers: dict[Address, Peer] = {}

    @property
    def sockets(self) -> list[socket.socket]:
        """All that may become readable."""
        raise NotImplementedError

    def receive(self, sock: socket.socket, now: float) -> Iterator[tuple[Peer, Any]]:
        """Yield what came in, message by message, with its sender."""
        raise NotImplementedError

    def tend(self, now: float) -> None:
        """Forget who left, and send what had to wait."""

    def close(self) -> None:
        """Close all sockets."""
        for sock in self.sockets:
            sock.close()

    def report(self) -> dict[str, Any]:
        """Place, partners and counters."""
        return {"endpoint": str(self.place), "partners": len(self.peers), **asdict(self.counters)}

    def _may_come(self, address: Address) -> bool:
        return not self._allowed or address[0] in self._allowed

    def _sent(self, size: int) -> bool:
        self.counters.sent += 1
        self.counters.sent_bytes += size
        return True

    def _dropped(self) -> bool:
        self.counters.not_sent += 1
        return False

    def _messages(self, peer: Peer, data: bytes, whole: bool, now: float) -> Iterator[tuple[Peer, Any]]:
        paid = max(1, len(data) // _FRAME)
        if not peer.bucket.take(now, paid):  # before it costs anything
            self.counters.limited += 1
            return
        good, bad = peer.codec.parsed(data, whole)
        self.counters.bad += bad
        for n, message in enumerate(good):
            if n >= paid and not peer.bucket.take(now):
                self.counters.limited += 1
                continue
            peer.heard = now
            self.counters.received += 1
            yield peer, message


class _Udp(Endpoint):
    def __init__(self, place: Place, codec: Callable[[], Codec], allowed: Sequence[str], local: Address) -> None:
        super().__init__(place, codec, allowed)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)  # unconnected: a dead port makes no errors
        try:
            self._socket.bind(local)
        except OSError as error:
            self._socket.close()
            raise Failed(f"{place}: {error.strerror}; is another program there?") from None
        self._socket.setblocking(False)

    @property
    def sockets(self) -> list[socket.socket]:
        return [self._socket]

    def _peer(self, address: Address, now: float) -> Peer:
        name = f"{self.place.kind} {address[0]}:{address[1]}"
        return Peer(name, self._codec(), now, lambda data: self._write(data, address))

    def _write(self, data: bytes, address: Address) -> bool:
        try:
            self._socket.sendto(data, address)
        except OSError:  # a full buffer, or no way there now
            return self._dropped()
        return self._sent(len(data))

    def receive(self, sock: socket.socket, now: float) -> Iterator[tuple[Peer, Any]]:
        for _ in range(_MOST_READ):
            try:
                data, address = self._socket.recvfrom(65535)
            except OSError:
                return
            yield from self._from(data, address, now)

    def _from(self, data: bytes, address: Address, now: float) -> Iterator[tuple[Peer, Any]]:
        raise NotImplementedError


class UdpOut(_Udp):
    """Sends to one address from the start, and hears nobody else."""

    def __init__(self, place: Place, codec: Callable[[], Codec], allowed: Sequence[str], now: float) -> None:
        local = "127.0.0.1" if ipaddress.IPv4Address(place.host).is_loopback else "0.0.0.0"
        super().__init__(place, codec, allowed, (local, 0))
        self._only = (place.host, place.port)
        self.peers[self._only] = self._peer(self._only, now)

    def _from(self, data: bytes, address: Address, now: float) -> Iterator[tuple[Peer, Any]]:
        if address != self._only:
            self.counters.strangers += 1
            return
        yield from self._messages(self.peers[address], data, True, now)


class UdpIn(_Udp):
    """Waits for ground stations, and talks to those who said something valid."""

    def __init__(self, place: Place, codec: Callable[[], Codec], allowed: Sequence[str]) -> None:
        super().__init__(place, codec, allowed, (place.host, place.port))
        self.place = Place(place.kind, place.host, self._socket.getsockname()[1])
        self._newcomers = Bucket(_RATE, _BURST)

    def _from(self, data: bytes, address: Address, now: float) -> Iterator[tuple[Peer, Any]]:
        known = address in self.peers
        if not known and (not self._may_come(address) or len(self.peers) >= MOST_PEERS):
            self.counters.strangers += 1
            return
        if not known and not self._newcomers.take(now):
            self.counters.limited += 1
            return
        peer = self.peers[address] if known else self._peer(address, now)
        for found in self._messages(peer, data, True, now):
            self.peers[address] = peer
            yield found

    def tend(self, now: float) -> None:
        """Forget who is silent."""
        for address in [a for a, peer in self.peers.items() if now - peer.heard > _IDLE]:
            del self.peers[address]


@dataclass
class _Connection:
    socket: socket.socket
    rest: bytes = b""  # of a message that was sent in part
    stuck: float | None = None  # since when it takes nothing


class TcpIn(Endpoint):
    """Waits for connections."""

    def __init__(self, place: Place, codec: Callable[[], Codec], allowed: Sequence[str]) -> None:
        super().__init__(place, codec, allowed)
        self._listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        if os.name == "posix":  # elsewhere it would let another program take the port
            self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            self._listener.bind((place.host, place.port))
        except OSError as error:
            self._listener.close()
            raise Failed(f"{place}: {error.strerror}; is another program there?") from None
        self._listener.listen(MOST_PEERS)
        self._listener.setblocking(False)
        self.place = Place(place.kind, place.host, self._listener.getsockname()[1])
        self._connections: dict[Address, _Connection] = {}
        self._now = 0.0

    @property
    def sockets(self) -> list[socket.socket]:
        """The listening socket and all connections."""
        return [self._listener, *(c.socket for c in self._connections.values())]

    def receive(self, sock: socket.socket, now: float) -> Iterator[tuple[Peer, Any]]:
        """Take a new connection, or what came in by one."""
        if sock is self._listener:
            self._accept(now)
            return
        address = next((a for a, c in self._connections.items() if c.socket is sock), None)
        if address is None:
            return
        try:
            data = sock.recv(1 << 14)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._leave(address)
            return
        yield from self._messages(self.peers[address], data, False, now)

    def tend(self, now: float) -> None:
        """Send the rest of messages that were cut, and leave who takes nothing."""
        self._now = now
        for address, connection in list(self._connections.items()):
            if connection.rest:
                self._flush(connection)
            if connection.stuck is not None and now - connection.stuck > _STALLED:
                self.counters.disconnected += 1
                self._leave(address)

    def _accept(self, now: float) -> None:
        try:
            sock, address = self._listener.accept()
        except OSError:
            return
        if len(self.peers) >= MOST_PEERS or not self._may_come(address):
            self.counters.strangers += 1
            sock.close()
            return
        sock.setblocking(False)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection = _Connection(sock)
        self._connections[address] = connection
        name = f"tcp {address[0]}:{address[1]}"
        self.peers[address] = Peer(name, self._codec(), now, lambda data: self._write(data, connection))

    def _write(self, data: bytes, connection: _Connection) -> bool:
        if connection.rest:
            return self._dropped()
        connection.rest = data
        self._flush(connection)
        if len(connection.rest) == len(data):  # nothing of it went: drop it whole
            connection.rest = b""
            return self._dropped()
        return self._sent(len(data))

    def _flush(self, connection: _Connection) -> None:
        try:
            n = connection.socket.send(connection.rest)
        except OSError:
            n = 0
        connection.rest = connection.rest[n:]
        if not n and connection.stuck is None:
            connection.stuck = self._now
        elif n:
            connection.stuck = None

    def _leave(self, address: Address) -> None:
        self._connections.pop(address).socket.close()
        del self.peers[address]


def open_endpoint(
    place: Place, system: int, component: int, keyring: Keyring | None, allowed: Sequence[str], now: float
) -> Endpoint:
    """Open the sockets of a place; AdcsError if another program has them."""

    def codec() -> Codec:
        return Codec(system, component, keyring)

    if place.kind == "udpout":
        return UdpOut(place, codec, allowed, now)
    return UdpIn(place, codec, allowed) if place.kind == "udpin" else TcpIn(place, codec, allowed)
