"""An autopilot of its own, for tests: a program that knows nothing of the simulator but MAVLink.

It connects to a simulator as PX4 does, takes the rate from HIL_SENSOR, the attitude from HIL_STATE_QUATERNION or from
the star tracker (ODOMETRY), and holds an attitude by a PD law written with rotation matrices.
"""

import argparse
import socket
import sys
import time
from math import sqrt
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

ARMED = mavlink.MAV_MODE_FLAG_SAFETY_ARMED
LOCKSTEP = 1


def rotation_matrix(w: float, x: float, y: float, z: float) -> np.ndarray:
    """From body to reference, by Rodrigues' formula."""
    sine = sqrt(x * x + y * y + z * z)
    if sine == 0.0:
        return np.eye(3)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) / sine
    cosine = (w * w - sine * sine) / (w * w + sine * sine)
    return np.eye(3) + 2 * w * sine / (w * w + sine * sine) * k + (1 - cosine) * k @ k


def half_angle_error(held: np.ndarray, now: np.ndarray) -> np.ndarray:
    """Axis times sin(angle/2) of the turn from the held attitude to that of now, in the body frame."""
    turn = held.T @ now
    twice = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])  # 2 sin(angle) axis
    return twice / (2 * sqrt(max(1.0 + np.trace(turn), 1e-9)))


class Autopilot:
    def __init__(self, options: argparse.Namespace) -> None:
        self.options = options
        self.held = rotation_matrix(*options.attitude)
        self.link = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self.link.robust_parsing = True
        self.link_out = mavlink.MAVLink(self, srcSystem=1, srcComponent=1)
        self.attitude = np.eye(3)
        self.socket = self.connected()
        self.answers = 0

    def connected(self) -> socket.socket:
        for _ in range(200):
            try:
                connection = socket.create_connection(("127.0.0.1", self.options.port))
            except OSError:
                time.sleep(0.05)
                continue
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return connection
        sys.exit("autopilot: no simulator")

    def write(self, data: bytes) -> None:
        self.socket.sendall(data)

    def run(self) -> None:
        if not self.options.silent:
            self.link_out.heartbeat_send(0, 12, 0, 0, 0)
        while data := self.socket.recv(65536):
            for message in self.link.parse_buffer(data) or []:
                self.handle(message)

    def handle(self, message: Any) -> None:
        kind = message.get_type()
        source = "ODOMETRY" if self.options.star_tracker else "HIL_STATE_QUATERNION"
        if kind == source:
            self.attitude = rotation_matrix(*(message.q if kind == "ODOMETRY" else message.attitude_quaternion))
        elif kind == "HIL_SENSOR":
            self.answer(message)

    def answer(self, sensors: Any) -> None:
        options = self.options
        if options.stop_after is not None and self.answers >= options.stop_after:
            return
        self.answers += 1
        if self.answers <= options.boot:
            return
        rate = np.array([sensors.xgyro, sensors.ygyro, sensors.zgyro])
        torque = -options.k_p * half_angle_error(self.held, self.attitude) - options.k_v * rate
        controls = [*(torque / options.max_torque).tolist(), *[float("nan")] * 13]
        time_usec = sensors.time_usec
        if options.noise:
            self.write(noise(self.answers))
        if options.stale:
            self.link_out.hil_actuator_controls_send(max(0, time_usec - 4000), [1.0] * 16, ARMED, LOCKSTEP)
        self.link_out.hil_actuator_controls_send(time_usec, controls, 0 if options.disarmed else ARMED, LOCKSTEP)


def noise(k: int) -> bytes:
    """Bytes that are no message: random ones, beginnings of long frames, a frame with a wrong bit and one cut short."""
    rng = np.random.default_rng(k)
    cut = mavlink.MAVLink_hil_actuator_controls_message(1, [0.5] * 16, ARMED, 1).pack(mavlink.MAVLink(None))
    flipped = bytearray(cut)
    flipped[rng.integers(len(cut))] ^= 1 << int(rng.integers(8))
    beginnings = b"\xfd\xff\x00" + rng.bytes(3) + b"\xfe"
    return rng.bytes(rng.integers(0, 40)) + beginnings + bytes(flipped) + bytes(cut[: rng.integers(1, len(cut))])


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--port", type=int, required=True)
    parser.add_argument("--attitude", type=float, nargs=4, default=[1.0, 0.0, 0.0, 0.0])
    parser.add_argument("--k-p", type=float, default=1.5)
    parser.add_argument("--k-v", type=float, default=5.0)
    parser.add_argument("--max-torque", type=float, default=1.0)
    parser.add_argument("--star-tracker", action="store_true", help="take the attitude from ODOMETRY")
    parser.add_argument("--boot", type=int, default=0, help="leave so many sensor messages unanswered at first")
    parser.add_argument("--stop-after", type=int, help="answer so many sensor messages, then no more")
    parser.add_argument("--disarmed", action="store_true")
    parser.add_argument("--silent", action="store_true", help="send no HEARTBEAT")
    parser.add_argument("--noise", action="store_true", help="send garbage between the messages")
    parser.add_argument("--stale", action="store_true", help="answer the sensors before, too")
    Autopilot(parser.parse_args()).run()


if __name__ == "__main__":
    main()
