"""What a bridge is told once, at its start; plain data, since it may run in a process of its own."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from datetime import datetime
from typing import Any

from hil_bridge.frames import FrameName
from hil_bridge.ground.parameters import Parameter

ALLOWED = ("arm", "param", "attitude")
"""What a ground station may be let to do."""

SYSTEM_ID = 1
COMPONENT_ID = 1  # MAV_COMP_ID_AUTOPILOT1


@dataclass(frozen=True)
class Pointing:
    """The variables that take a commanded attitude relative to N, its rate, and whether it counts; if there are any."""

    attitude: str
    rate: str | None = None
    engaged: str | None = None


@dataclass(frozen=True)
class Settings:
    """All of it.

    `columns` are (key, first, last) of the values in a snapshot, where the key is a role or `shown:NAME`; `step` and
    `start` are in s, `speed` in simulated seconds per second; attitudes are relative to `base`; `position` is latitude
    and longitude [deg] and height [m] of a system without orbit. `arm` is the variable that closes the control loop;
    `wheel_limit` is in rad/s, `setpoint_timeout` in s on the clock. `notes` are said to each new ground station.
    """

    system: str
    columns: Sequence[tuple[str, int, int]]
    step: float
    start: float = 0.0
    speed: float = 1.0
    base: str = "N"
    frame: FrameName = "ned"
    epoch: str = "2026-01-01T00:00:00"
    position: tuple[float, float, float] = (0.0, 0.0, 500e3)
    parameters: Sequence[Parameter] = ()
    allow: Sequence[str] = ()
    arm: str | None = None
    point: Pointing | None = None
    wheel_limit: float | None = None
    setpoint_timeout: float = 1.0
    endpoints: Sequence[str] = ()
    exposed: bool = False
    peers: Sequence[str] = ()
    key: str | None = None
    key_state: str | None = None
    tlog: str | None = None
    notes: Sequence[str] = ()
    rates: dict[str, float] = field(default_factory=dict)

    @property
    def start_of_time(self) -> datetime:
        """The epoch."""
        return datetime.fromisoformat(self.epoch)

    def dumped(self) -> str:
        """All of it as JSON in one line."""
        return json.dumps(asdict(self))

    @classmethod
    def loaded(cls, text: str) -> Settings:
        """Read what `dumped` wrote."""
        content: dict[str, Any] = json.loads(text)
        content["parameters"] = [Parameter(**each) for each in content["parameters"]]
        content["columns"] = [(key, first, last) for key, first, last in content["columns"]]
        content["point"] = None if content["point"] is None else Pointing(**content["point"])
        content["position"] = tuple(content["position"])
        return cls(**content)


@dataclass(frozen=True)
class Snapshot:
    """The values of one communication point."""

    k: int
    t: float  # s
    values: Sequence[float]
