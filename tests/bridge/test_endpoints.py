"""Real sockets on loopback: dead, stalled and many clients cost the simulation nothing, nor each other."""

import hashlib
import socket
import struct
import time
from dataclasses import replace

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from adcs import AdcsError
from hil_bridge.ground import endpoints
from hil_bridge.ground.endpoints import Place

from .live import HEARTBEAT, Udp, bridge, until


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("udp:127.0.0.1:1", "expected udpout:HOST:PORT"),
        ("udpout:127.0.0.1", "expected udpout:HOST:PORT"),
        ("udpout:127.0.0.1:70000", "expected udpout:HOST:PORT"),
        ("udpout:127.0.0.1:0", "port 0"),
        ("tcpin:example.org:5760", "is not an IPv4 address"),
        ("udpin:0.0.0.0:14550", "add --remote"),
        ("udpout:192.168.1.7:14550", "add --remote"),
    ],
)
def test_refused_endpoints(text, message):
    with pytest.raises(AdcsError, match=message):
        Place.parse(text)


def test_endpoints_beyond_this_machine_want_a_word():
    assert str(Place.parse("udpin:0.0.0.0:14550", exposed=True)) == "udpin:0.0.0.0:14550"
    assert str(Place.parse("tcpin::5760")) == "tcpin:127.0.0.1:5760"


def test_a_port_that_is_taken_is_named(settings):
    with (
        bridge(settings, "udpin:127.0.0.1:0") as first,
        pytest.raises(AdcsError, match=r"udpin:127\.0\.0\.1:\d+: Address already in use; is another program there"),
    ):
        endpoints.open_endpoint(Place("udpin", *first.address()), 1, 1, None, (), 0.0)


def test_a_ground_station_gets_what_is_due_and_heartbeats_without_a_simulation(settings):
    station = Udp()
    with bridge(settings, f"udpout:127.0.0.1:{station.port}") as running:
        until(lambda: station.count("HEARTBEAT"))
        running.play(101, station)
        until(lambda: station.count("ATTITUDE") == 51)
        expected = {"ATTITUDE": 51, "ATTITUDE_QUATERNION": 51, "ATTITUDE_TARGET": 11, "SYSTEM_TIME": 2}
        until(lambda: {name: station.count(name) for name in expected} == expected)
        assert not any(m.get_type().startswith(("UNKNOWN", "BAD")) for m in station.heard)
        until(lambda: running.server.endpoints[0].report()["sent"] >= len(station.heard))
        assert running.server.endpoints[0].report()["not_sent"] == 0


def test_heartbeats_come_once_a_second_with_a_simulation_and_without(settings):
    """On the clock: 50 points a second for 3 s, then none; a partner may ask for others, or for none."""
    station, quiet = Udp(), Udp(254)
    with bridge(replace(settings, step=0.02), "udpin:127.0.0.1:0") as running:
        for each in (station, quiet):
            each.send(HEARTBEAT, running.address())
        until(lambda: len(running.server.endpoints[0].peers) == 2)
        quiet.send(mavlink.MAVLink_command_long_message(1, 1, 511, 0, 0, -1, 0, 0, 0, 0, 0), running.address())
        until(lambda: quiet.count("COMMAND_ACK"))
        silenced = quiet.count("HEARTBEAT")
        began, times, heard = time.monotonic(), [], 0
        while (now := time.monotonic() - began) < 6.0:
            if running.k * 0.02 < min(now, 3.0):
                running.point()
            if station.count("HEARTBEAT") > heard:
                heard = station.count("HEARTBEAT")
                times.append(now)
            time.sleep(0.002)
        assert len(times) in (6, 7)
        assert np.diff(times) == pytest.approx(1.0, abs=0.5)
        assert np.mean(np.diff(times)) == pytest.approx(1.0, abs=0.1)
        assert station.count("SYS_STATUS") in (3, 4)
        assert quiet.count("HEARTBEAT") == silenced


def test_two_ground_stations_have_rates_of_their_own(settings):
    slow, fast = Udp(), Udp(254)
    with bridge(settings, "udpin:127.0.0.1:0") as running:
        for each in (slow, fast):
            each.send(HEARTBEAT, running.address())
        until(lambda: len(running.server.endpoints[0].peers) == 2)
        slow.send(mavlink.MAVLink_request_data_stream_message(1, 1, 0, 4, 1), running.address())
        interval = mavlink.MAVLink_command_long_message(1, 1, 511, 0, 30, 1e4, 0, 0, 0, 0, 0)
        fast.send(interval, running.address())
        until(lambda: fast.count("COMMAND_ACK"))
        until(lambda: any(p.stream.interval(30) == 0.25 for p in running.server.endpoints[0].peers.values()))
        running.play(101, slow, fast)
        until(lambda: fast.count("ATTITUDE") == 101)
        assert slow.count("ATTITUDE") == 5


def test_a_dead_port_makes_no_errors_and_costs_others_nothing(settings):
    station = Udp()
    dead = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    dead.bind(("127.0.0.1", 0))
    port = dead.getsockname()[1]
    dead.close()
    with bridge(settings, f"udpout:127.0.0.1:{port}", f"udpout:127.0.0.1:{station.port}") as running:
        running.play(101, station)
        until(lambda: station.count("ATTITUDE") == 51)


def test_a_stalled_tcp_client_is_left_and_others_go_on(settings, monkeypatch):
    monkeypatch.setattr(endpoints, "_STALLED", 0.3)
    station = Udp()
    stalled = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    stalled.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
    with bridge(settings, "tcpin:127.0.0.1:0", f"udpout:127.0.0.1:{station.port}") as running:
        stalled.connect(running.address())
        until(lambda: running.server.endpoints[0].peers)
        for peer in running.server.endpoints[0].peers.values():
            until(lambda peer=peer: peer.stream)
            peer.stream.set(mavlink.MAVLINK_MSG_ID_DEBUG_FLOAT_ARRAY, 0.001)
        end = time.monotonic() + 5.0
        while running.server.endpoints[0].counters.disconnected == 0 and time.monotonic() < end:
            running.point()
            station.listen()
            time.sleep(0.0005)
        counters = running.server.endpoints[0].counters
        assert counters.disconnected == 1
        assert counters.not_sent > 0  # whole messages were dropped
        until(lambda: station.count("ATTITUDE") == (running.k + 1) // 2)
        assert running.server._left_out == 0
    stalled.close()


def test_what_a_tcp_client_gets_is_whole_however_slowly_it_reads(settings):
    client = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
    with bridge(settings, "tcpin:127.0.0.1:0") as running:
        client.connect(running.address())
        client.settimeout(0.2)
        until(lambda: running.server.endpoints[0].peers)
        mav = mavlink.MAVLink(None)
        mav.robust_parsing = True
        heard = []
        for _ in range(600):
            for _ in range(5):
                running.point()
            time.sleep(0.0005)
            if running.k % 50 == 0:
                heard += mav.parse_buffer(client.recv(1000)) or []
        time.sleep(0.05)
        while True:
            try:
                data = client.recv(65535)
            except TimeoutError:
                break
            if not data:
                break
            heard += mav.parse_buffer(data) or []
        assert len(heard) > 100
        assert not any(m.get_type() == "BAD_DATA" for m in heard)
    client.close()


def test_a_thousand_sources_have_sixteen_places_and_only_if_they_speak_mavlink(settings):
    with bridge(settings, "udpin:127.0.0.1:0") as running:
        station = Udp()
        station.send(HEARTBEAT, running.address())
        endpoint = running.server.endpoints[0]
        until(lambda: len(endpoint.peers) == 1)
        for i in range(1000):
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
                noise = i % 2
                sock.sendto(b"\xfdnonsense" if noise else HEARTBEAT.pack(station.mav), running.address())
            if i % 20 == 0:
                time.sleep(0.002)
        until(lambda: endpoint.counters.strangers + endpoint.counters.limited > 800)
        assert len(endpoint.peers) == endpoints.MOST_PEERS
        before = station.count("ATTITUDE")
        running.play(21, station)
        until(lambda: station.count("ATTITUDE") - before == 11)


def test_only_the_listed_addresses_are_heard(settings):
    with bridge(settings, "udpin:127.0.0.1:0", peers=["127.0.0.2"]) as running:
        station = Udp()
        station.send(HEARTBEAT, running.address())
        endpoint = running.server.endpoints[0]
        until(lambda: endpoint.counters.strangers == 1)
        assert not endpoint.peers
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
            sock.bind(("127.0.0.2", 0))
            sock.sendto(HEARTBEAT.pack(station.mav), running.address())
        until(lambda: len(endpoint.peers) == 1)


def test_nobody_else_may_answer_for_the_ground_station(settings):
    station, stranger = Udp(), Udp()
    with bridge(settings, f"udpout:127.0.0.1:{station.port}") as running:
        until(lambda: station.count("HEARTBEAT"))
        sock = running.server.endpoints[0].sockets[0]
        stranger.send(HEARTBEAT, sock.getsockname())
        until(lambda: running.server.endpoints[0].counters.strangers == 1)
        station.send(HEARTBEAT, sock.getsockname())
        until(lambda: running.server.endpoints[0].counters.received == 1)
        assert stranger.listen() == []


def test_a_flood_is_cut_off_before_it_is_parsed(settings):
    with bridge(settings, "udpin:127.0.0.1:0") as running:
        station = Udp()
        station.send(HEARTBEAT, running.address())
        endpoint = running.server.endpoints[0]
        until(lambda: endpoint.counters.received == 1)
        for i in range(3000):
            station.send(HEARTBEAT, running.address())
            if i % 50 == 0:
                time.sleep(0.001)
        until(lambda: endpoint.counters.received + endpoint.counters.limited > 2000)
        assert endpoint.counters.limited > 1000


def test_a_link_takes_nothing_without_its_secret(settings):
    station = Udp()
    with bridge(settings, f"udpout:127.0.0.1:{station.port}") as running:
        for data in (b"N" + b"0" * 20, b"", b"x" * 16 + b'N{"what": "end", "text": ""}'):
            station.send(data, ("127.0.0.1", running.server.link.port))
        running.point()
        until(lambda: station.count("ATTITUDE") == 1)
        assert not running.server._stopped


def test_a_tcp_client_that_is_killed_is_forgotten(settings):
    """Closed with a reset, as the kernel does for a process that dies with unread data."""
    client = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    station = Udp()
    with bridge(settings, "tcpin:127.0.0.1:0", f"udpout:127.0.0.1:{station.port}") as running:
        client.connect(running.address())
        until(lambda: running.server.endpoints[0].peers)
        running.play(11, station)
        client.close()
        until(lambda: not running.server.endpoints[0].peers)
        running.play(90, station)
        until(lambda: station.count("ATTITUDE") == 51)
        with socket.create_connection(running.address()):  # and may come again
            until(lambda: running.server.endpoints[0].peers)


def test_with_a_key_only_those_who_have_it_are_answered(settings, tmp_path):
    """A restart, with a frame captured before it, included."""
    key = tmp_path / "key"
    key.write_text("a pass phrase")
    secret = hashlib.sha256(b"a pass phrase").digest()
    friend, stranger = Udp(), Udp()
    friend.mav.signing.secret_key, friend.mav.signing.sign_outgoing = secret, True
    friend.mav.signing.timestamp = int((time.time() - 1420070400) * 1e5)
    captured = mavlink.MAVLink_ping_message(1, 1, 0, 0).pack(friend.mav)
    options = {"key": str(key), "key_state": f"{key}.times"}
    with bridge(settings, "udpin:127.0.0.1:0", **options) as running:
        stranger.send(HEARTBEAT, running.address())
        friend.send(captured, running.address())
        until(lambda: friend.count("PING"))  # signed by the bridge, and checked by pymavlink
        assert [m.get_signed() for m in friend.heard] == [True] * len(friend.heard)
        assert len(running.server.endpoints[0].peers) == 1
        assert running.server.endpoints[0].counters.bad == 1
    with bridge(settings, "udpin:127.0.0.1:0", **options) as running:
        stranger.send(captured, running.address())
        until(lambda: running.server.endpoints[0].counters.bad == 1)
        assert not running.server.endpoints[0].peers
        friend.send(mavlink.MAVLink_ping_message(2, 2, 0, 0), running.address())
        until(lambda: friend.count("PING") == 2)
    assert stranger.listen() == []
