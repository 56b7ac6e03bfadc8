"""`python -m benchmarks.lockstep`: points per second of a spacecraft in lockstep with an autopilot over TCP."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Annotated

import cyclopts
from cyclopts import Parameter
from cyclopts.validators import Number
from pymavlink.dialects.v20 import common as mavlink
from rich.console import Console
from rich.progress import track
from rich.table import Table

from adcs import AdcsError
from adcs.library.hardware.systems import PERIOD, hil_spacecraft
from hil_bridge.hil.actuators import Actuators
from hil_bridge.hil.flying import fly
from hil_bridge.hil.link import Server
from hil_bridge.hil.lockstep import Flight, Terms
from hil_bridge.hil.wiring import Wiring


@dataclass(frozen=True)
class Round:
    """Time [s] of one point: real, and of this process; and until the answer was there, in the median."""

    wall: float
    cpu: float
    answer: float


def measure_round(points: int) -> Round:
    """Fly so many points with an autopilot that answers at once, in a process of its own."""
    system = hil_spacecraft()
    server = Server(port=0)
    command = [sys.executable, "-m", "benchmarks.lockstep", "--answer", str(server.port)]
    with subprocess.Popen(command) as process:
        with server.autopilot(60.0, 20.0) as link:
            terms = Terms(warm_up=0.0, timeout=20.0)
            flight = Flight(system, link, Wiring.find(system), Actuators.by_axis((1.0,)), terms)
            manifest = fly(system, flight, stop_time=(points - 1) * PERIOD, step=PERIOD).manifest
        process.wait()
    timing = manifest["timing"]
    answer = manifest["hardware_in_the_loop"]["answer_median_s"]
    return Round(timing["wall_s"] / points, timing["cpu_s"] / points, answer)


def answer(port: int) -> None:
    """Be the autopilot: answer every HIL_SENSOR with no torque."""
    codec = mavlink.MAVLink(None)
    with socket.create_connection(("127.0.0.1", port)) as line:
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        line.sendall(mavlink.MAVLink_heartbeat_message(0, 0, 0, 0, 0, 3).pack(codec))
        while data := line.recv(65536):
            for message in codec.parse_buffer(data) or []:
                if message.get_type() == "HIL_SENSOR":
                    controls = [0.0] * 16
                    reply = mavlink.MAVLink_hil_actuator_controls_message(message.time_usec, controls, 128, 1)
                    line.sendall(reply.pack(codec))


def main(
    rounds: Annotated[int, Parameter(validator=Number(gte=1), help="Rounds, of which medians are taken.")] = 5,
    points: Annotated[int, Parameter(validator=Number(gte=10), help="Points of each round.")] = 5000,
    output: Annotated[Path, Parameter(help="Folder for the results.")] = Path("results/benchmarks"),
    answer_port: Annotated[int | None, Parameter(name="--answer", show=False)] = None,
) -> None:
    """Time the exchange of sensors and controls, point by point."""
    if answer_port is not None:
        return answer(answer_port)
    console = Console()
    try:
        measured = [measure_round(points) for _ in track(range(rounds), "measuring", console=console, transient=True)]
    except AdcsError as error:
        Console(stderr=True).print(f"[red]error:[/red] {error}")
        raise SystemExit(1) from error
    wall, cpu, trip = (median(getattr(r, name) for r in measured) for name in ("wall", "cpu", "answer"))
    table = Table(title=f"Lockstep over TCP, {points} points, medians of {rounds} rounds")
    for column in ("points per s", "of real time at 250 Hz", "µs per point", "of it CPU time here", "until the answer"):
        table.add_column(column, justify="right")
    cells = (f"{1 / wall:.0f}", f"{PERIOD / wall:.1f}", f"{1e6 * wall:.0f}", f"{1e6 * cpu:.0f}", f"{1e6 * trip:.0f}")
    table.add_row(*cells)
    console.print(table)
    output.mkdir(parents=True, exist_ok=True)
    content = {"points_per_s": 1 / wall, "points": points, "rounds": [asdict(r) for r in measured]}
    (output / "lockstep.json").write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    return None


if __name__ == "__main__":
    cyclopts.run(main)
