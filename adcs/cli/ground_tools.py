"""From words on the command line to a bridge: which variables, where to, what is allowed."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

from fmus.errors import AdcsError
from hil_bridge.frames import FrameName
from hil_bridge.ground.attach import Bridge, Recorder, log_only
from hil_bridge.ground.commands import make_commandable
from hil_bridge.ground.endpoints import DEFAULTS
from hil_bridge.ground.mapping import find
from hil_bridge.ground.settings import ALLOWED, Settings
from orchestration.system import System


@dataclass(frozen=True)
class Options:
    """What can be chosen; see `adcs bridge --help`."""

    endpoints: Sequence[str] = ()
    allow: str = ""
    frame: FrameName = "ned"
    epoch: str = "2026-01-01T00:00:00"
    position: str = "0,0,500km"
    maps: Sequence[str] = ()
    shows: Sequence[str] = ()
    rates: Sequence[str] = ()
    expose: bool = False
    peers: Sequence[str] = ()
    key: Path | None = None
    tlog: Path | None = None
    wheel_limit: float | None = None
    network: bool = True


def attached(
    system: System, options: Options, *, step: float, start: float = 0.0, speed: float = 1.0
) -> AbstractContextManager[Bridge | Recorder]:
    """Return what takes part in a run of the system, which is rewired for the commands that are allowed."""
    allow = [word for word in options.allow.split(",") if word]
    for word in allow:
        if word not in ALLOWED:
            raise AdcsError(f"--allow {word}: expected some of {', '.join(ALLOWED)}, separated by commas")
    signals = find(system, options.maps, options.shows)
    settings = Settings(
        system=system.name,
        columns=(),
        step=step,
        start=start,
        speed=speed,
        frame=options.frame,
        epoch=options.epoch,
        position=_position(options.position),
        allow=allow,
        endpoints=list(options.endpoints or DEFAULTS),
        exposed=options.expose,
        peers=list(options.peers),
        key=None if options.key is None else str(options.key),
        key_state=None if options.key is None else f"{options.key}.times",
        tlog=None if options.tlog is None else str(options.tlog),
        wheel_limit=options.wheel_limit,
        rates=dict(_rate(text) for text in options.rates),
    )
    if not options.network:
        if options.tlog is None:
            raise AdcsError("no network and no log: nothing to do")
        return log_only(system, signals, settings, options.tlog)
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
