"""`adcs replay`: a telemetry log, for ground tools to watch again."""

from __future__ import annotations

import signal
import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from adcs.cli.command import Speed, Time, command
from adcs.cli.options import Endpoints
from hil_bridge.ground.endpoints import DEFAULTS, Place
from hil_bridge.ground.replay import replay as replay_log

app = command(
    "replay",
    "adcs replay flight.tlog",
    "adcs replay flight.tlog --real-time 4 --to tcpin:127.0.0.1:5760 --wait 1min",
)


@app.default
def replay(
    file: Annotated[Path, Parameter(help="A telemetry log (.tlog).")],
    /,
    endpoints: Endpoints = Endpoints(),
    *,
    real_time: Speed = 1.0,
    wait: Time = 0.0,
) -> None:
    """Send a telemetry log to ground tools again.

    Args:
        real_time: Keep the pace at which it was written, SPEED times as fast.
        wait: Wait for a ground tool to come, so long at most.
    """
    places = [Place.parse(text, endpoints.remote) for text in endpoints.to or DEFAULTS]
    console = Console(stderr=True)
    try:
        report = replay_log(file, places, real_time, endpoints.peer, wait)
    except KeyboardInterrupt:
        print("adcs: interrupted", file=sys.stderr)
        sys.exit(128 + signal.SIGINT)
    console.print(f"{report['frames']} frames of {report['seconds']:g} s sent to {', '.join(map(str, places))}")
