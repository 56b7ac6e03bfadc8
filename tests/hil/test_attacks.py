"""A simulator's port under attack: strangers, half-open connections, floods, wild numbers, clocks that go back.

How much of it: `ADCS_FUZZ=1000000 python -m pytest tests/hil/test_attacks.py -s` for a long one.
"""

import os
import random
import socket
import struct
import tracemalloc
from threading import Thread
from time import monotonic, sleep

import numpy as np
import pytest
from flights import prepared
from pymavlink.dialects.v20 import common as mavlink
from test_failures import ANSWER, ARMED, Hand

from adcs import AdcsError, RunFailed
from adcs.library.hardware.systems import PERIOD
from hil_bridge.hil.actuators import Actuators
from hil_bridge.hil.flying import fly
from hil_bridge.hil.framing import Frames
from hil_bridge.hil.link import Server

N = int(os.environ.get("ADCS_FUZZ", "6000"))


def test_strangers_and_half_open_connections_do_not_take_the_autopilots_place() -> None:
    """A browser, one that says nothing, one that comes and goes, one that is reset; then the autopilot comes."""
    server = Server(port=0)
    strangers = [socket.create_connection((server.host, server.port)) for _ in range(5)]
    strangers[0].sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")
    strangers[1].close()
    strangers[2].setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    strangers[2].close()
    strangers[3].sendall(os.urandom(100_000))
    hand: list[Hand] = []

    def come() -> None:
        sleep(0.5)
        hand.append(Hand(server))

    thread = Thread(target=come)
    thread.start()
    with server.autopilot(20.0, 5.0) as link:
        thread.join()
        assert link.peer == "{}:{}".format(*hand[0].socket.getsockname())
        system, flight = prepared(link)
        with hand[0].answering(hand[0].answer):
            result = fly(system, flight, stop_time=5 * PERIOD, step=PERIOD)
    assert len(result.time) == 6
    strangers[4].settimeout(5.0)
    assert strangers[4].recv(1) == b"", "sent away"
    for sock in strangers:
        sock.close()


def test_a_crowd_of_strangers_is_sent_away_in_time() -> None:
    server = Server(port=0)
    crowd = [socket.socket() for _ in range(30)]
    for sock in crowd:
        sock.setblocking(False)
        sock.connect_ex((server.host, server.port))
    began = monotonic()
    with pytest.raises(AdcsError, match=r"sent no MAVLink HEARTBEAT: it is no autopilot"):
        server.autopilot(1.0, 1.0).__enter__()
    assert monotonic() - began < 5.0
    for sock in crowd:
        sock.close()


def test_a_flood_before_the_heartbeat_is_not_kept() -> None:
    """Valid messages, but no HEARTBEAT: they are dropped at the deadline, and memory is bounded meanwhile."""
    server = Server(port=0)
    sock = socket.create_connection((server.host, server.port))
    codec = mavlink.MAVLink(None)
    piece = mavlink.MAVLink_system_time_message(1, 1).pack(codec) * 500
    stop = monotonic() + 1.5

    def flood() -> None:
        sock.settimeout(0.2)
        while monotonic() < stop:
            try:
                sock.sendall(piece)
            except OSError:
                return

    thread = Thread(target=flood)
    thread.start()
    tracemalloc.start()
    try:
        with pytest.raises(AdcsError, match="sent no MAVLink HEARTBEAT"):
            server.autopilot(1.5, 1.0).__enter__()
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()
        thread.join()
        sock.close()


@pytest.mark.parametrize("filler", [b"\xfd", b"\xfe", b"\xfd\xff\x00", b"\xfe\x00"])
def test_bytes_that_look_like_beginnings_do_not_hold_up(filler: bytes) -> None:
    """The worst there is: every byte may begin a frame. What is kept is less than a frame."""
    frames, good = Frames(), ANSWER(5, [0.5] * 16, ARMED, 1).pack(mavlink.MAVLink(None))
    began = monotonic()
    assert frames.feed((filler * 16384)[:16384]) == []
    assert monotonic() - began < 5.0
    assert len(frames._rest) < 300
    found = frames.feed(good * 20 + b"\0" * 600)
    assert [m.time_usec for m in found] == [5] * 20


def test_random_and_mutated_streams() -> None:
    """Between them whole messages, which are all found."""
    rng = random.Random(11)
    codec = mavlink.MAVLink(None)
    frames, found, sent = Frames(), 0, 0
    for _ in range(N // 10):
        whole = ANSWER(7, [rng.uniform(-1, 1)] * 16, ARMED, 1).pack(codec)
        broken = bytearray(whole)
        broken[rng.randrange(len(broken))] ^= 1 << rng.randrange(8)
        pieces = [rng.randbytes(rng.randrange(40)), bytes(broken), whole[: rng.randrange(len(whole))]]
        rng.shuffle(pieces)
        data = b"".join(pieces) + b"\0" * 300 + whole
        sent += 1
        cut = rng.randrange(len(data))
        found += sum(
            m.get_type() == "HIL_ACTUATOR_CONTROLS" for m in [*frames.feed(data[:cut]), *frames.feed(data[cut:])]
        )
        assert len(frames._rest) < 300
    assert found >= sent
    print(f"\nrandom and mutated streams to the simulator: {3 * sent} pieces, {found} messages found")


def test_wild_numbers_in_every_field_of_the_controls_leave_a_finite_torque() -> None:
    rng = random.Random(5)
    effect = Actuators.by_axis((0.2, 0.2, 0.1))
    wild = [float("nan"), float("inf"), float("-inf"), 3.4e38, -3.4e38, 1e-45, -0.0]
    for _ in range(N // 10):
        controls = [rng.choice([*wild, rng.uniform(-2, 2)]) for _ in range(16)]
        message = ANSWER(rng.randrange(2**64), controls, ARMED, rng.randrange(2**64))
        torque = effect.torque(message)
        assert (np.abs(torque) <= [0.2, 0.2, 0.1]).all()


def test_clocks_that_go_back_and_requests_without_end_do_not_end_a_flight() -> None:
    """With each answer: two of other times, a sequence number anywhere, twenty requests with wild numbers."""
    server = Server(port=0)
    hand = Hand(server)
    rng = random.Random(3)
    wild = (float("nan"), float("inf"), -1.0, 0.0, 1e38, -1e38, 4000.0)

    def reply(k: int) -> None:
        hand.codec.seq = rng.randrange(256)
        for _ in range(20):
            p = [rng.choice((*wild, 115.0)) for _ in range(7)]
            command = rng.choice((mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, rng.randrange(65536)))
            hand.say(mavlink.MAVLink_command_long_message(1, 1, command, 0, *p))
        hand.say(ANSWER(0, [1.0] * 16, ARMED, 1))
        hand.say(ANSWER(2**64 - 1, [1.0] * 16, ARMED, 1))
        hand.answer(k, 0.25)

    with server.autopilot(5.0, 5.0) as link:
        system, flight = prepared(link)
        with hand.answering(reply):
            result = fly(system, flight, stop_time=100 * PERIOD, step=PERIOD)
    assert np.array_equal(result["actuator.torque_B"][:, 0], np.full(101, 0.25))
    account = result.manifest["hardware_in_the_loop"]
    assert (account["answers_late"], account["answers_ahead"]) == (101, 101)
    assert sum(m.get_type() == "COMMAND_ACK" for m in hand.heard) >= 20 * 99


def test_requests_that_nobody_waits_for_are_not_kept_without_end() -> None:
    """A flood of requests instead of an answer: the flight ends with its line, the replies kept are few."""
    server = Server(port=0)
    hand = Hand(server)
    request = mavlink.MAVLink_command_long_message(1, 1, 511, 0, 115, 4000, 0, 0, 0, 0, 0).pack(hand.codec) * 200

    def flood() -> None:
        hand.socket.settimeout(0.5)
        try:
            while True:
                hand.socket.sendall(request)
        except OSError:
            return

    with server.autopilot(5.0, 5.0) as link:
        system, flight = prepared(link, timeout=1.0)
        thread = Thread(target=flood)
        thread.start()
        with pytest.raises(RunFailed, match=r"did not answer the sensors of t = 0 s within 1 s; 0 rows are kept"):
            fly(system, flight, stop_time=1.0, step=PERIOD)
        assert len(flight._replies) <= 100
    thread.join()
