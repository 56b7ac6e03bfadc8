"""A vehicle without simulation and network, and a ground station that hears it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pymavlink.dialects.v20 import common as mavlink
from scipy.spatial.transform import Rotation

from hil_bridge.ground.endpoints import Peer
from hil_bridge.ground.parameters import Parameter
from hil_bridge.ground.security import Codec
from hil_bridge.ground.settings import Settings, Snapshot
from hil_bridge.ground.vehicle import Vehicle


def matrix(q_BF: ArrayLike) -> NDArray[np.float64]:
    """C_BF, by SciPy, whose rotation of q_BF goes from body to reference."""
    turned: NDArray[np.float64] = Rotation.from_quat(q_BF, scalar_first=True).inv().as_matrix()
    return turned


class Ground:
    """A ground station's end of a wire, decoded independently; `peer` is the vehicle's end of it."""

    def __init__(self, system: int = 255) -> None:
        self._codec = mavlink.MAVLink(None, srcSystem=system, srcComponent=190)
        self._codec.robust_parsing = True
        self.heard: list[Any] = []
        self.peer = Peer("test", Codec(1, 1), 0.0, self._take)

    def _take(self, data: bytes) -> bool:
        self.heard += self._codec.parse_buffer(data) or []
        return True

    def of(self, name: str) -> list[Any]:
        return [m for m in self.heard if m.get_type() == name]

    def last(self, name: str) -> Any:
        return self.of(name)[-1]

    @property
    def texts(self) -> list[str]:
        return [m.text for m in self.of("STATUSTEXT")]

    def sent(self, message: Any) -> Any:
        """The message as it arrives: packed and parsed."""
        return self.peer.codec.parsed(message.pack(self._codec), True)[0][0]


ROLES = {"attitude": 4, "rate": 3, "true_attitude": 4, "true_rate": 3, "reference": 4, "reference_rate": 3, "torque": 3}
ORBIT = {**ROLES, "position": 3, "velocity": 3}


def columns(roles: dict[str, int]) -> list[tuple[str, int, int]]:
    found, n = [], 0
    for role, size in roles.items():
        found.append((role, n, n + size))
        n += size
    return found


def parameter(id_: str, variable: str, index: int = 0, element: str = "", value: float = 1.5, **more: Any) -> Parameter:
    given = {"unit": "N.m", "description": "", "low": 0.0, "high": 10.0, "whole": False, **more}
    return Parameter(id_, variable, index, element or variable, value=value, **given)


class Station:
    """A vehicle with one ground station, and what it asked of the simulation."""

    def __init__(self, settings: Settings) -> None:
        self.asked: list[tuple[int, str, list[Any], str]] = []
        self.vehicle = Vehicle(settings, lambda *request: self.asked.append(request))
        self.ground = Ground()
        self.vehicle.greet(self.ground.peer)
        self.now = 100.0

    def show(self, values: dict[str, Any] | list[float], t: float = 0.0, k: int = 0) -> None:
        flat = list(values) if isinstance(values, list) else [float(x) for v in values.values() for x in np.ravel(v)]
        self.vehicle.show(self.vehicle.scene.at(Snapshot(k, t, flat)))

    def send(self, message: Any) -> None:
        self.vehicle.handle(self.ground.peer, self.ground.sent(message), self.now)
        while self.ground.peer.queue:
            self.vehicle.flush(self.ground.peer)

    def command(self, command: int, *p: float) -> int:
        """Send COMMAND_LONG; return the result that is acknowledged."""
        self.send(mavlink.MAVLink_command_long_message(1, 1, command, 0, *p, *[0.0] * (7 - len(p))))
        ack = self.ground.last("COMMAND_ACK")
        assert ack.command == command
        return int(ack.result)

    def ask_for(self, id_: int) -> Any:
        assert self.command(mavlink.MAV_CMD_REQUEST_MESSAGE, id_) == mavlink.MAV_RESULT_ACCEPTED
        return self.ground.last(str(mavlink.mavlink_map[id_].msgname))


def values(rng: np.random.Generator, orbit: bool = False) -> dict[str, Any]:
    """Values of each role, quaternions of unit length."""
    drawn: dict[str, Any] = {role: rng.normal(size=size) for role, size in ROLES.items()}
    for role in ("attitude", "true_attitude", "reference"):
        drawn[role] /= np.linalg.norm(drawn[role])
    if orbit:
        drawn |= {"position": np.array([6.8e6, 1e5, -2e5]), "velocity": np.array([100.0, 5400.0, 5300.0])}
    return drawn


def orbiting(settings: Settings, **changes: Any) -> Settings:
    return replace(settings, columns=columns(ORBIT), **changes)
