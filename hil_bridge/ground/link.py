"""Between a simulation and its bridge: datagrams on loopback that neither side waits for.

The bridge may be slow, hang or be killed, and the simulation goes on. Datagrams carry a secret of the run.
"""

from __future__ import annotations

import json
import secrets
import socket
import struct
from collections.abc import Iterator
from typing import Any

import numpy as np

from hil_bridge.ground.settings import Snapshot

_HEAD = struct.Struct("<qd")
_BUFFER = 1 << 20
_TOKEN = 16
Note = dict[str, Any]


class Link:
    """One side of it. `address` and `token` are what the other side needs."""

    def __init__(self, token: bytes | None = None, other: int | None = None) -> None:
        """`other` is the port of the other side, if it is there already."""
        self.token = secrets.token_bytes(_TOKEN) if token is None else token
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
        self.socket.setblocking(False)
        self.port: int = self.socket.getsockname()[1]
        self._other = None if other is None else ("127.0.0.1", other)
        self.lost = 0
        if self._other is not None:
            self.note({"what": "hello"})

    def snapshot(self, snapshot: Snapshot) -> None:
        """Send the values of a point."""
        values = np.asarray(snapshot.values, np.float64).tobytes()
        self._send(b"S" + _HEAD.pack(snapshot.k, snapshot.t) + values)

    def note(self, note: Note) -> None:
        """Send anything else."""
        self._send(b"N" + json.dumps(note).encode())

    def received(self) -> Iterator[Snapshot | Note]:
        """Yield what has come."""
        while True:
            try:
                data, address = self.socket.recvfrom(65535)
            except OSError:
                return
            if data[:_TOKEN] != self.token:
                continue
            self._other = address
            kind, body = data[_TOKEN : _TOKEN + 1], data[_TOKEN + 1 :]
            if kind == b"S":
                k, t = _HEAD.unpack_from(body)
                yield Snapshot(k, t, np.frombuffer(body, np.float64, offset=_HEAD.size))  # type: ignore[arg-type]
            else:
                yield json.loads(body)

    def close(self) -> None:
        """Close the socket."""
        self.socket.close()

    def _send(self, data: bytes) -> None:
        if self._other is None:
            self.lost += 1
            return
        try:
            self.socket.sendto(self.token + data, self._other)
        except OSError:
            self.lost += 1
