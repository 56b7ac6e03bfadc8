"""A bridge under attack on real sockets, beside a run that must not notice.

How much of it: `ADCS_FUZZ=1000000 python -m pytest tests/bridge/test_attacks.py tests/bridge/test_security.py -s` for a
long one; what was tried is printed.
"""

import os
import random
import socket
import struct
import time
import tracemalloc
from dataclasses import replace
from itertools import pairwise

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from adcs import run
from hil_bridge.ground.security import Codec
from hil_bridge.ground.settings import Pointing

from .ground import Station, values
from .live import HEARTBEAT, Udp, bridge, until
from .test_run import T5, flown

N = int(os.environ.get("ADCS_FUZZ", "6000"))
WILD = (float("nan"), float("inf"), -float("inf"), 3.4e38, -3.4e38, 1e-45, -0.0, 2.0**31, -1.0)


def packed(mav, message):
    data = message.pack(mav)
    mav.seq = (mav.seq + 1) % 256
    return data


def test_every_float_field_of_every_message_that_is_understood_takes_wild_numbers(settings, rng):
    """Each field alone, and all at once. Nothing raises, and what reaches the simulation is finite."""
    allowed = replace(settings, allow=["arm", "param", "attitude"], arm="a.b", point=Pointing("a.q", "a.rate", "a.on"))
    station = Station(allowed)
    station.show(values(rng))
    tried = 0
    for kind in mavlink.mavlink_map.values():
        if kind.msgname not in station.vehicle._handlers:
            continue
        sample = {name: _sample(kind, name) for name in kind.fieldnames}
        floats = [n for n, t in zip(kind.fieldnames, kind.fieldtypes, strict=True) if t in ("float", "double")]
        for value in WILD:
            for chosen in [*([n] for n in floats), floats]:
                for command in (400, 176, 511, 510, 512, 520) if "command" in sample else (0,):
                    fields = sample | {n: [value] * 4 if n == "q" else value for n in chosen}
                    fields |= {"command": command} if "command" in sample else {}
                    tried += 1
                    station.now += 0.1
                    station.send(kind(**{n: fields[n] for n in kind.fieldnames}))
    for _, _, changes, _ in station.asked:
        for _, value in changes:
            assert np.isfinite(value).all()
    print(f"\nwild numbers in float fields of accepted messages: {tried}")
    assert tried > 500


def _sample(kind, name):
    if name in ("target_system", "target_component"):
        return 1
    if name == "q":
        return [1.0, 0.0, 0.0, 0.0]
    if name == "param_id":
        return b"CTRL_K_P"
    if name == "param_type":
        return 9
    return [0] * 251 if name == "payload" else 0


def test_random_and_mutated_datagrams_on_a_socket(settings):
    """Sent to a bridge that is in the middle of a run; then a station is answered, and nothing has grown."""
    rng = random.Random(7)
    station = Udp()
    frames = [
        packed(station.mav, message)
        for message in (
            mavlink.MAVLink_param_set_message(1, 1, b"CTRL_K_P", 2.0, 9),
            mavlink.MAVLink_command_long_message(1, 1, 511, 0, 30, 1e5, 0, 0, 0, 0, 0),
            mavlink.MAVLink_set_attitude_target_message(0, 1, 1, 7, [1, 0, 0, 0], 0, 0, 0, 0),
            mavlink.MAVLink_file_transfer_protocol_message(0, 1, 1, [255] * 251),
        )
    ]
    with bridge(settings, "udpin:127.0.0.1:0") as running, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        for i in range(N // 4):
            data = bytearray(rng.choice(frames))
            data[rng.randrange(len(data))] = rng.randrange(256)
            noise = rng.randbytes(rng.choice((0, 1, 11, 280, 1500)))
            sock.sendto(bytes(data) if i % 2 else noise, running.address())
            if i % 40 == 0:
                running.point()
                time.sleep(0.001)
        sock.sendto(b"\xfd" * 65000, running.address())
        until(lambda: running.server.vehicle.state is not None)
        station.send(HEARTBEAT, running.address())
        until(lambda: station.count("STATUSTEXT") >= 3)  # the banner
        assert len(running.server.endpoints[0].peers) <= 2
    print(f"\nrandom and mutated datagrams: {N // 4}")


def test_valid_commands_from_many_endpoints_neither_stall_nor_change_a_run_that_allows_none():
    """Twelve stations at once, 200 messages each as fast as they go; the run is that without stations, to the bit."""
    sent = 0

    def work(pilot):
        nonlocal sent
        stations = [Udp(200 + i) for i in range(12)]
        for _ in range(200):
            for each in [*stations, pilot.station]:
                for message in (
                    mavlink.MAVLink_param_set_message(1, 1, b"CTRL_K_P", 9.0, 9),
                    mavlink.MAVLink_command_long_message(1, 1, 400, 0, 0, 0, 0, 0, 0, 0, 0),
                    mavlink.MAVLink_param_request_list_message(1, 1),
                    mavlink.MAVLink_set_attitude_target_message(0, 1, 1, 7, [0, 1, 0, 0], 0, 0, 0, 0),
                ):
                    each.send(message, pilot.vehicle)
                    sent += 1
            time.sleep(0.005)

    result, _, _ = flown(work, stop_time=20.0, speed=5.0, allow="")
    assert result.manifest["outcome"]["status"] == "complete"
    assert result.manifest["commands"] == []
    assert np.array_equal(result.data, run(T5.build(), stop_time=20.0, step=0.01).data)
    endpoint = result.manifest["mavlink"]["endpoints"][0]
    assert endpoint["limited"] + endpoint["strangers"] > sent / 2
    print(f"\nvalid commands from 13 endpoints: {sent}")


def test_a_flood_of_allowed_commands_does_not_stall_the_run():
    """Gains, arming and attitudes as fast as they go, all allowed: the run ends in its time, with as many records as
    points can have."""
    sent = 0

    def work(pilot):
        nonlocal sent
        began = time.monotonic()
        while time.monotonic() - began < 3.0:
            for i in range(20):
                pilot.send(mavlink.MAVLink_param_set_message(1, 1, b"CTRL_K_P", 1.0 + 0.01 * (sent % 50), 9))
                pilot.send(mavlink.MAVLink_command_long_message(1, 1, 400, 0, i % 2, 0, 0, 0, 0, 0, 0))
                rates = [1e-3 * (sent % 7), 0.0, 0.0]
                pilot.send(mavlink.MAVLink_set_attitude_target_message(0, 1, 1, 0, [1, 0, 0, 0], *rates, 0))
                sent += 3
            time.sleep(0.01)

    began = time.monotonic()
    result, _, _ = flown(work, stop_time=20.0, speed=4.0)
    assert result.manifest["outcome"]["status"] == "complete"
    assert len(result.manifest["commands"]) < 5 * len(result.time)
    took = time.monotonic() - began
    told = result.manifest["mavlink"]
    tried, tried_for, longest = (told[name] for name in ("trials", "trials_s", "longest_trial_s"))
    assert tried > 3
    assert tried_for <= 0.2 * took + 0.2 + longest  # a fifth of the time, what may be spent at once, and one under way
    print(f"\nallowed commands from one endpoint: {sent} in 3 s; {tried} trials took {tried_for:.2f} of {took:.1f} s")


def test_numbers_of_messages_and_times_go_round_and_back(settings):
    """Sequence numbers wrap, clocks of partners go back, snapshots of the simulation too: all is taken as it comes."""
    station = Udp()
    with bridge(settings, "udpin:127.0.0.1:0") as running:
        for i in range(600):
            stamp = 10**12 - i * 10**9
            clock = mavlink.MAVLink_system_time_message(abs(stamp), abs(stamp) % 2**32)
            station.send(packed(station.mav, clock), running.address())
            if i % 20 == 0:
                station.send(packed(station.mav, mavlink.MAVLink_timesync_message(0, stamp)), running.address())
                time.sleep(0.02)
        until(lambda: running.server.endpoints[0].counters.received > 300)
        until(lambda: station.count("TIMESYNC"))
        running.play(101, station)
        until(lambda: station.count("ATTITUDE") == 51)
        running.k = 0  # the simulation begins anew
        running.point()
        until(lambda: running.server.vehicle.state.k == 0)
        before = station.count("ATTITUDE")
        running.k = 1
        for _ in range(100):
            running.point()
            time.sleep(0.001)
        until(lambda: station.count("ATTITUDE") - before >= 49)
        sequence = [m.get_seq() for m in station.heard]
        assert all((b - a) % 256 == 1 for a, b in pairwise(sequence))


def test_half_open_and_talkative_tcp_connections(settings):
    """Places taken and left, streams of garbage, frames that never end: others are served, and memory is bounded."""
    station = Udp()
    with bridge(settings, "tcpin:127.0.0.1:0", f"udpout:127.0.0.1:{station.port}") as running:
        address = running.address()
        for _ in range(100):  # come and gone without a word, half of them with a reset
            with socket.create_connection(address) as sock:
                if _ % 2:
                    sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        silent = [socket.create_connection(address) for _ in range(10)]
        with socket.create_connection(address) as sock:
            sock.settimeout(5.0)
            for _ in range(50):
                sock.sendall(b"\xfd\xff\x00" + os.urandom(4000))
                running.point()
        running.play(101, station)
        until(lambda: station.count("ATTITUDE") >= 51)
        until(lambda: len(running.server.endpoints[0].peers) == 10)
        for sock in silent:
            sock.close()
        until(lambda: not running.server.endpoints[0].peers)


def test_a_stream_whose_last_frame_is_never_complete_is_not_kept():
    codec, good = Codec(1, 1), HEARTBEAT.pack(mavlink.MAVLink(None, 255, 190))
    found = 0
    data = b""
    for _ in range(3000):  # each piece ends in the middle of a frame
        data = good[11:] + good * 5 + good[:11] if found else good[:11]
        found += max(1, len(codec.parsed(data, False)[0]))
        assert len(codec.buf) < 10_000
    assert found > 3000 * 5


def test_what_a_stranger_says_is_not_remembered_without_end(settings, rng):
    """Unknown parameters with names that never repeat, and changes that nobody answers."""
    open_ = replace(settings, allow=["param", "attitude", "arm"], point=Pointing("a.q"), arm="a.b")
    station = Station(open_)
    station.show(values(rng))

    def flood(n):
        for i in range(n):
            station.send(mavlink.MAVLink_param_set_message(1, 1, b"X%d" % (random.random() * 1e12), 1.0, 9))
            station.send(mavlink.MAVLink_param_set_message(1, 1, b"CTRL_K_P", 1.0 + i % 5, 9))
            station.asked.clear()
            station.ground.heard.clear()
            station.now += 1e-4

    flood(1000)
    tracemalloc.start()
    try:
        flood(200)
        before = tracemalloc.get_traced_memory()[0]
        flood(2000)
        assert tracemalloc.get_traced_memory()[0] - before < 100_000
    finally:
        tracemalloc.stop()
    assert len(station.vehicle._pending) == 100
    assert len(station.vehicle._last_warning) <= 64
    station.vehicle.tick(station.now + 31.0)  # nobody answered: the present value is told, and there is room again
    assert not station.vehicle._pending
    station.vehicle.flush(station.ground.peer)
    assert station.ground.last("PARAM_VALUE").param_value == 1.5
