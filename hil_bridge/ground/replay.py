"""A telemetry log sent again, frame by frame, at the pace at which it was written or another."""

from __future__ import annotations

import select
from collections.abc import Callable, Sequence
from math import isfinite
from pathlib import Path
from time import monotonic
from typing import Any

from fmus.errors import AdcsError
from hil_bridge.ground.endpoints import Endpoint, Place, open_endpoint
from hil_bridge.ground.settings import COMPONENT_ID, SYSTEM_ID
from hil_bridge.ground.tlog import read, sender

_LOOK = 0.02  # s
_GROUND = 250  # systems from here on are ground stations: what they said is not said again


class _Raw:
    """A frame as it was recorded, in the place of a message."""

    def __init__(self, frame: bytes) -> None:
        self._frame = frame

    def pack(self, codec: Any) -> bytes:
        """Return it."""
        return self._frame


def replay(
    path: Path,
    places: Sequence[Place],
    speed: float = 1.0,
    peers: Sequence[str] = (),
    wait: float = 0.0,
    progress: Callable[[float], None] = lambda fraction: None,
) -> dict[str, Any]:
    """Send the frames of the vehicle in a log, `speed` times as fast; return the counters.

    With `wait` [s] nothing is sent before a ground station has come, or that time is over.
    """
    if not (isfinite(speed) and speed > 0):
        raise AdcsError(f"speed = {speed}: expected a positive number, 1 for the pace of the log")
    frames = [(time, frame) for time, frame in read(path) if sender(frame)[0] < _GROUND]
    if not frames:
        raise AdcsError(f"{path} has no frames of a vehicle")
    endpoints: list[Endpoint] = []
    try:
        for place in places:
            endpoint = open_endpoint(place, SYSTEM_ID, COMPONENT_ID, None, peers, monotonic())
            endpoints.append(endpoint)  # one by one, so that what is open is closed when another fails
        until = monotonic() + wait
        while monotonic() < until and not any(e.peers for e in endpoints):
            _listen(endpoints, _LOOK)
        origin = monotonic()
        first, last = frames[0][0], frames[-1][0]
        for time, frame in frames:
            while (early := origin + (time - first) / speed - monotonic()) > 0:
                _listen(endpoints, min(early, _LOOK))
            for endpoint in endpoints:
                for peer in list(endpoint.peers.values()):
                    peer.send(_Raw(frame))
            progress((time - first) / max(last - first, 1e-9))
        _listen(endpoints, 0.0)
        return {"frames": len(frames), "seconds": last - first, "endpoints": [e.report() for e in endpoints]}
    finally:
        for endpoint in endpoints:
            endpoint.close()


def _listen(endpoints: Sequence[Endpoint], timeout: float) -> None:
    """Let partners come and go; what they say is not answered."""
    sockets = [s for endpoint in endpoints for s in endpoint.sockets]
    readable, _, _ = select.select(sockets, [], [], timeout)
    now = monotonic()
    for endpoint in endpoints:
        endpoint.tend(now)
        for sock in endpoint.sockets:
            if sock in readable:
                for _ in endpoint.receive(sock, now):
                    pass
