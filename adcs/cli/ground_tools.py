"""From words on the command line to a bridge: which variables, where to, what is allowed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from adcs.cli.options import GroundTools
from fmus.errors import AdcsError
from orchestration.system import System

if TYPE_CHECKING:
    from hil_bridge.ground.attach import Bridge, Recorder


def attached(
    system: System, tools: GroundTools, *, step: float, start: float = 0.0, speed: float = 1.0, network: bool = True
) -> Bridge | Recorder:
    """Return what takes part in a run of the system, which is rewired for the commands that are allowed.

    Without `network` it only writes the log.
    """
    from hil_bridge.ground.attach import Bridge, log_only  # here, for the dialect of MAVLink takes long to load
    from hil_bridge.ground.commands import make_commandable
    from hil_bridge.ground.endpoints import DEFAULTS
    from hil_bridge.ground.mapping import find
    from hil_bridge.ground.security import Keyring
    from hil_bridge.ground.settings import ALLOWED, Settings

    allow = [word for word in tools.allow.split(",") if word]
    for word in allow:
        if word not in ALLOWED:
            raise AdcsError(f"--allow {word}: expected some of {', '.join(ALLOWED)}, separated by commas")
    if tools.key is not None:
        Keyring.open(tools.key)  # which another process reads, and is refused now
    if tools.tlog is not None and tools.tlog.is_file():
        raise AdcsError(f"--tlog {tools.tlog} is there already: give another name")
    signals = find(system, tools.map, tools.show)
    settings = Settings(
        system=system.name,
        columns=(),
        step=step,
        start=start,
        speed=speed,
        frame=tools.frame,
        epoch=tools.epoch.isoformat(),
        position=_position(tools.position),
        allow=allow,
        endpoints=list(tools.to or DEFAULTS),
        exposed=tools.remote,
        peers=list(tools.peer),
        key=None if tools.key is None else str(tools.key),
        key_state=None if tools.key is None else f"{tools.key}.times",
        tlog=None if tools.tlog is None else str(tools.tlog),
        wheel_limit=tools.wheel_limit,
        rates=dict(_rate(text) for text in tools.rate),
    )
    if not network:
        if tools.tlog is None:
            raise AdcsError("no network and no log: nothing to do")
        return log_only(system, signals, settings, tools.tlog)
    commandable, signals = make_commandable(system, signals, allow)
    return Bridge(system, signals, settings, commandable)


def _position(text: str) -> tuple[float, float, float]:
    words = text.replace("km", "e3").split(",")
    try:
        latitude, longitude, height = (float(word) for word in words)
    except ValueError:
        raise AdcsError(f"--position {text}: expected LATITUDE,LONGITUDE,HEIGHT, as in 52.1,4.3,500km") from None
    if not (abs(latitude) <= 90 and abs(longitude) <= 180 and abs(height) < 1e9):
        raise AdcsError(f"--position {text}: latitude within 90 deg, longitude within 180 deg, height in m or km")
    return latitude, longitude, height


def _rate(text: str) -> tuple[str, float]:
    name, _, rate = text.partition("=")
    try:
        return name.strip().upper(), float(rate)
    except ValueError:
        raise AdcsError(f"--rate {text}: expected MESSAGE=HZ, as in ATTITUDE_QUATERNION=250") from None
