"""Flights for the tests: a server in this process, an autopilot in one of its own."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from adcs import Result, System
from adcs.library.hardware.systems import PERIOD, hil_spacecraft
from hil_bridge.hil.actuators import Actuators
from hil_bridge.hil.flying import fly
from hil_bridge.hil.link import Link, Server
from hil_bridge.hil.lockstep import Flight, Terms
from hil_bridge.hil.wiring import Wiring

AUTOPILOT = Path(__file__).parent / "autopilot.py"
EXACT = {
    "imu.gyro_noise": 0.0,
    "imu.gyro_bias": (0.0, 0.0, 0.0),
    "tracker.half_angle": 0.0,
}
"""Start values of sensors without errors."""


@contextmanager
def autopilot(port: int, *options: str) -> Iterator[subprocess.Popen[bytes]]:
    """The test's autopilot as a process; it ends with the block, and with the simulator's connection."""
    command = [sys.executable, str(AUTOPILOT), "--port", str(port), *options]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            yield process
        finally:
            process.kill()


@contextmanager
def connected(*options: str, timeout: float = 20.0) -> Iterator[tuple[Link, subprocess.Popen[bytes]]]:
    """An autopilot that has connected and said so."""
    server = Server(port=0)
    with autopilot(server.port, *options) as process, server.autopilot(60.0, timeout) as link:
        yield link, process


def prepared(link: Link, system: System | None = None, **terms: Any) -> tuple[System, Flight]:
    """A flight of the spacecraft, in lockstep from the first point on."""
    system = system or hil_spacecraft()
    wanted = Terms(**{"frame": "eci", "timeout": 20.0, "warm_up": 0.0, **terms})
    return system, Flight(system, link, Wiring.find(system), Actuators.by_axis((1.0,)), wanted)


def flown(
    *options: str,
    stop_time: float = 2.0,
    step: float = PERIOD,
    changes: dict[str, Any] | None = None,
    fmi_version: Any = "2.0",
    **terms: Any,
) -> Result:
    """Fly to the end."""
    with connected(*options) as (link, _):
        system, flight = prepared(link, **terms)
        for name, value in (changes or {}).items():
            system.set(name, value)
        return fly(system, flight, stop_time=stop_time, step=step, fmi_version=fmi_version)
