"""What a bridge costs: microseconds for a message, and 250 points a second for 16 ground stations at full rate.

python -m benchmarks.mavlink [--seconds 10] [--fifo]
"""

from __future__ import annotations

import argparse
import os
import socket
from threading import Thread
from time import perf_counter, process_time

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from adcs import Session
from adcs.catalogue import SYSTEMS
from adcs.cli.ground_tools import attached
from adcs.cli.options import GroundTools
from hil_bridge.ground.security import Codec
from hil_bridge.ground.settings import Settings, Snapshot
from hil_bridge.ground.state import Scene
from hil_bridge.ground.telemetry import Report
from orchestration.grid import Grid
from orchestration.process.watch import Unwatched
from orchestration.running.hooks.pace import Clock

_STATIONS, _RATE = 16, 250.0


def message_costs(n: int = 2000) -> dict[str, float]:
    """Microseconds from a snapshot to the bytes of an ATTITUDE_QUATERNION, once more for another, and to parse it."""
    columns = [("attitude", 0, 4), ("rate", 4, 7), ("position", 7, 10), ("velocity", 10, 13)]
    scene = Scene(Settings("benchmark", columns, 0.004))
    values = np.array([1.0, 0, 0, 0, 0.1, 0.2, 0.3, 7e6, 0, 0, 0, 5e3, 5e3])
    id_ = mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION
    codec, other, parser = Codec(1, 1), Codec(1, 1), Codec(255, 1)

    def first() -> bytes:
        (message,) = Report(scene.at(Snapshot(0, 1.0, values)), True, False).messages(id_)  # type: ignore[arg-type]
        return codec.packed(message)

    frame = first()
    (again,) = Report(scene.at(Snapshot(0, 1.0, values)), True, False).messages(id_)  # type: ignore[arg-type]
    work = {
        "from snapshot to bytes, with an orbit": first,
        "packed for a further partner": lambda: other.packed(again),
        "parsed": lambda: parser.parsed(frame, True),
    }
    costs = {}
    for name, piece in work.items():
        began = perf_counter()
        for _ in range(n):
            piece()
        costs[name] = 1e6 * (perf_counter() - began) / n
    return costs


def crowd(seconds: float) -> dict[str, float]:
    """Run full-state-pd at 250 Hz with 16 partners, each of which gets every attitude."""
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(_STATIONS)]
    counts = [0] * _STATIONS
    quaternion = mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION

    def listen(i: int) -> None:
        while data := sockets[i].recv(4096):
            counts[i] += int.from_bytes(data[7:10], "little") == quaternion

    for sock in sockets:
        sock.bind(("127.0.0.1", 0))
    threads = [Thread(target=listen, args=(i,), daemon=True) for i in range(_STATIONS)]
    for thread in threads:
        thread.start()
    places = [f"udpout:127.0.0.1:{s.getsockname()[1]}" for s in sockets]
    options = GroundTools(to=tuple(places), rate=(f"ATTITUDE_QUATERNION={_RATE}", f"ATTITUDE={_RATE}"))
    system = SYSTEMS["full-state-pd"].build()
    step = 1 / _RATE
    watcher = attached(system, options, step=step)
    pace = Clock(Grid(0.0, step, 0))
    spent = 0.0
    with Session(system, step=step, steps=round(seconds * _RATE)) as simulation, watcher:
        watcher.begin(simulation, (), Unwatched())
        pace.start(0)
        for _ in range(round(seconds * _RATE)):
            pace.wait(simulation.k)
            began = process_time()
            point, time = simulation.k, simulation.time
            simulation.propagate()
            simulation.move_on()
            watcher.after(point, time)
            watcher.changes(point + 1)
            spent += process_time() - began
        report = watcher.report()
    late = pace.report()
    for sock in sockets:
        sock.close()
    bridge = report["mavlink"]
    return {
        "points": late["points"],
        "late in the median [ms]": 1e3 * late["late_median_s"],
        "late at 99 % [ms]": 1e3 * late["late_99_percent_s"],
        "late at most [ms]": 1e3 * late["late_most_s"],
        "simulation's CPU time per point [us]": 1e6 * spent / late["points"],
        "bridge busy [%]": 100 * bridge["busy"],
        "points left out": bridge["points_left_out"],
        "messages sent": sum(e["sent"] for e in bridge["endpoints"]),
        "messages not sent": sum(e["not_sent"] for e in bridge["endpoints"]),
        "attitudes that came to the slowest of 16": min(counts),
    }


def main() -> None:
    """Print all of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--fifo", action="store_true", help="with SCHED_FIFO")
    arguments = parser.parse_args()
    for name, cost in message_costs().items():
        print(f"{name}: {cost:.1f} us")
    if arguments.fifo:
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(10))
    for name, value in crowd(arguments.seconds).items():
        print(f"{name}: {value:.4g}")


if __name__ == "__main__":
    main()
