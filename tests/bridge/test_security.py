"""Strangers, noise, forged, replayed and tampered messages."""

import os
import random
import signal
import subprocess
import sys
from dataclasses import replace

import pytest
from pymavlink.dialects.v20 import common as mavlink

from adcs import AdcsError
from hil_bridge.ground.security import Bucket, Codec, Keyring
from hil_bridge.ground.settings import Pointing

from .ground import Ground, Station

KEY = bytes(range(32))
NOW = 1_800_000_000.0
HEARTBEAT = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)


class Sender:
    """A partner that signs by pymavlink itself, whose code is not the one under test."""

    def __init__(self, key=KEY, ahead=0.0, system=255, link=0):
        self.mav = mavlink.MAVLink(None, srcSystem=system, srcComponent=190)
        self.mav.signing.secret_key = key
        self.mav.signing.sign_outgoing = True
        self.mav.signing.link_id = link
        self.mav.signing.timestamp = int((NOW + ahead - 1420070400) * 1e5)

    def frame(self, message=HEARTBEAT):
        return message.pack(self.mav)


def codec(path=None, clock=lambda: NOW):
    return Codec(1, 1, Keyring(KEY, path, clock))


def taken(receiver, *frames):
    return [len(receiver.parsed(frame, True)[0]) for frame in frames]


def test_signed_messages_are_taken_and_unsigned_ones_are_not():
    receiver, sender = codec(), Sender()
    assert taken(receiver, sender.frame(), sender.frame(), HEARTBEAT.pack(mavlink.MAVLink(None, 255, 190))) == [1, 1, 0]
    plain = HEARTBEAT.pack(mavlink.MAVLink(None, 255, 190), force_mavlink1=True)
    assert taken(receiver, plain) == [0]


def test_forged_tampered_and_replayed_messages_are_not_taken():
    receiver, sender = codec(), Sender()
    frame = sender.frame()
    assert taken(receiver, Sender(key=bytes(32)).frame()) == [0]
    for place in range(len(frame)):
        broken = bytearray(frame)
        broken[place] ^= 1
        assert taken(receiver, bytes(broken)) == [0], place
    assert taken(receiver, frame, frame, sender.frame()) == [1, 0, 1]


def test_a_forged_time_in_the_future_does_not_lock_the_true_sender_out():
    """pymavlink remembers the time of a frame before it checks the signature."""
    receiver, sender = codec(), Sender()
    assert taken(receiver, Sender(key=bytes(32), ahead=3600).frame(), sender.frame()) == [0, 1]


@pytest.mark.parametrize(("ahead", "result"), [(-30, 1), (30, 1), (-90, 0), (90, 0), (3600, 0)])
def test_clocks_may_differ_by_a_minute(ahead, result):
    receiver = codec()
    assert taken(receiver, Sender(ahead=ahead).frame()) == [result]
    assert taken(receiver, Sender(system=254).frame()) == [1]  # and nobody else suffers


def test_a_restart_forgets_nothing(tmp_path):
    path = tmp_path / "key.times"
    first = codec(path)
    frame = Sender().frame()
    assert taken(first, frame) == [1]
    first.packed(HEARTBEAT)
    sent = first.keyring.now()
    first.keyring.save()
    again = codec(path)
    assert taken(again, frame) == [0]  # captured, and sent once more
    assert codec(path, clock=lambda: NOW - 5).keyring.now() > sent  # a clock that went back does not repeat times


KILLED = """
import os, signal, sys
from pathlib import Path
from hil_bridge.ground.security import Codec, Keyring
receiver = Codec(1, 1, Keyring(bytes(range(32)), Path(sys.argv[1]), lambda: 1_800_000_000.0))
print(len(receiver.parsed(bytes.fromhex(sys.argv[2]), True)[0]), receiver.keyring.now(), flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this platform has no SIGKILL")
def test_what_was_accepted_before_a_kill_9_is_not_accepted_after_it(tmp_path):
    path, sender = tmp_path / "key.times", Sender()
    frame = sender.frame()
    done = subprocess.run(
        [sys.executable, "-c", KILLED, str(path), frame.hex()], capture_output=True, text=True, check=False
    )
    accepted, sent = map(int, done.stdout.split())
    assert (done.returncode, accepted) == (-signal.SIGKILL, 1)
    again = codec(path)
    assert taken(again, frame, sender.frame()) == [0, 0]  # the sender has to wait for a second
    sender.mav.signing.timestamp += 100_001
    assert taken(again, sender.frame()) == [1]
    assert again.keyring.now() > sent


def test_without_a_file_that_can_be_written_nothing_is_accepted(tmp_path):
    folder = tmp_path / "gone"
    folder.mkdir()
    receiver, sender = codec(folder / "key.times"), Sender()
    assert taken(receiver, sender.frame()) == [1]
    (folder / "key.times").unlink()
    folder.rmdir()
    sender.mav.signing.timestamp += 200_000
    assert taken(receiver, sender.frame()) == [0]
    assert "No such file" in receiver.keyring.trouble
    with pytest.raises(AdcsError, match="cannot write the times of signed messages"):
        receiver.keyring.save()
    folder.mkdir()
    assert taken(receiver, sender.frame()) == [1]


def test_senders_are_not_remembered_without_end():
    receiver = codec()
    frames = [Sender(system=1 + i % 250, link=i // 250).frame() for i in range(300)]
    assert sum(taken(receiver, *frames)) == len(receiver.keyring.seen) == 256


def test_what_is_sent_is_signed_and_its_time_goes_on():
    sender = codec()
    receiver = mavlink.MAVLink(None, 255, 190)
    receiver.signing.secret_key = KEY
    receiver.signing.timestamp = int((NOW - 1420070400) * 1e5)
    for _ in range(5):
        (message,) = receiver.parse_buffer(sender.packed(HEARTBEAT))
        assert message.get_signed()


def test_keys_from_files(tmp_path):
    file = tmp_path / "key"
    file.write_text(KEY.hex() + "\n")
    assert Keyring.open(file).key == KEY
    file.write_text("a pass phrase\n")
    assert len(Keyring.open(file).key) == 32
    file.write_text("")
    with pytest.raises(AdcsError, match="is empty"):
        Keyring.open(file)
    file.write_bytes(b"\xff\xfe")
    with pytest.raises(AdcsError, match="is no text"):
        Keyring.open(file)
    with pytest.raises(AdcsError, match="cannot read the signing key"):
        Keyring.open(tmp_path / "none")
    (tmp_path / "times").write_text("{")
    with pytest.raises(AdcsError, match="does not hold the times"):
        Keyring(KEY, tmp_path / "times")


def test_the_rate_of_a_source_is_limited():
    bucket = Bucket(rate=10, burst=5)
    assert sum(bucket.take(0.0) for _ in range(20)) == 5
    assert sum(bucket.take(1.0) for _ in range(20)) == 5
    assert not all(bucket.take(2.0) for _ in range(6))


def test_a_broken_datagram_does_not_spoil_the_next():
    receiver = Codec(1, 1)
    good = HEARTBEAT.pack(mavlink.MAVLink(None, 255, 190))
    assert receiver.parsed(b"\xfd", True) == ([], 1)
    for _ in range(6):
        assert taken(receiver, good) == [1]
    assert taken(receiver, good[:-3], good) == [0, 1]


N_RANDOM = int(os.environ.get("ADCS_FUZZ", "6000"))


def test_noise_and_mutated_messages_do_no_harm(settings):
    """Whatever comes in, nothing raises, and the next valid request is answered. ADCS_FUZZ=1000000 for a long one."""
    rng = random.Random(1)
    station, ground = Station(settings), Ground()
    mav = mavlink.MAVLink(None, 255, 190)
    kinds = [
        mavlink.MAVLink_param_set_message(1, 1, b"CTRL_K_P", 2.0, 9),
        mavlink.MAVLink_command_long_message(1, 1, 511, 0, 30, 1e5, 0, 0, 0, 0, 0),
        mavlink.MAVLink_set_attitude_target_message(0, 1, 1, 7, [1, 0, 0, 0], 0, 0, 0, 0),
        mavlink.MAVLink_file_transfer_protocol_message(0, 1, 1, [0] * 251),
        mavlink.MAVLink_param_request_list_message(1, 1),
        mavlink.MAVLink_ping_message(1, 1, 0, 0),
        mavlink.MAVLink_statustext_message(1, b"hello", 0, 0),
    ]
    frames = [kind.pack(mav) for kind in kinds]
    for i in range(N_RANDOM):
        if i % 2:
            data = rng.randbytes(rng.choice((1, 2, 12, 60, 300)))
            data = bytes([rng.choice((0xFD, 0xFE))]) + data if i % 4 == 1 else data
        else:
            broken = bytearray(rng.choice(frames))
            for _ in range(rng.randint(1, 3)):
                broken[rng.randrange(len(broken))] = rng.randrange(256)
            data = bytes(broken)
        for message in station.ground.peer.codec.parsed(data, True)[0]:
            station.vehicle.handle(station.ground.peer, message, 0.0)
        station.ground.heard.clear()
        station.ground.peer.queue.clear()
    assert ground.heard == []
    station.now = 1e6
    station.send(mavlink.MAVLink_ping_message(3, 4, 0, 0))
    assert station.ground.last("PING").time_usec == 3


@pytest.mark.parametrize("allow", [[], ["arm", "param", "attitude"]])
def test_valid_messages_with_wild_contents_do_no_harm(settings, allow):
    """Checksums right, fields random: what a hostile ground station would send."""
    rng = random.Random(2)
    station = Station(replace(settings, allow=allow, arm="a.b", point=Pointing("a.q")))
    station.show([0.1] * 23)
    codec = mavlink.MAVLink(None, 255, 190)
    names = [m for m in mavlink.mavlink_map.values() if m.msgname in station.vehicle._handlers]
    handled = 0
    for _ in range(N_RANDOM // 2):
        kind = rng.choice(names)
        fields = kind.unpacker.unpack(rng.randbytes(kind.unpacker.size))
        payload = kind.unpacker.pack(*fields)
        frame = Raw(kind.id, kind.crc_extra, payload).pack(codec)
        for message in station.ground.peer.codec.parsed(frame, True)[0]:
            handled += 1
            for name in ("target_system", "target_component"):
                if hasattr(message, name):
                    setattr(message, name, 1)
            station.vehicle.handle(station.ground.peer, message, 0.0)
        station.ground.peer.queue.clear()
    assert handled == N_RANDOM // 2
    assert allow or station.asked == []


class Raw(mavlink.MAVLink_message):
    """A message of any payload."""

    def __init__(self, id_, crc_extra, payload):
        super().__init__(id_, "RAW")
        self._raw, self._crc_extra = payload, crc_extra

    def pack(self, mav, force_mavlink1=False):
        return self._pack(mav, self._crc_extra, self._raw)
