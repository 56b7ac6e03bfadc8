"""Messages out of a stream: whole, in pieces, damaged, and among bytes that are none."""

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from hil_bridge.hil.framing import Frames


def frames(n: int, version_1: bool = False) -> list[bytes]:
    """So many different answers, packed; by MAVLink 2 unless version 1 is asked for."""
    codec = mavlink.MAVLink(None, srcSystem=7)
    made = []
    for k in range(n):
        message = mavlink.MAVLink_hil_actuator_controls_message(4000 * k, [k / n] * 16, 128, 1)
        made.append(bytes(message.pack(codec, force_mavlink1=version_1)))
        codec.seq = (codec.seq + 1) % 256
    return made


def times(found: list[mavlink.MAVLink_message]) -> list[int]:
    return [message.time_usec for message in found]


@pytest.mark.parametrize("version_1", [False, True])
@pytest.mark.parametrize("size", [1, 2, 3, 17, 1000])
def test_pieces_of_any_size(size: int, version_1: bool) -> None:
    stream = b"".join(frames(20, version_1))
    reader = Frames()
    found = [m for i in range(0, len(stream), size) for m in reader.feed(stream[i : i + size])]
    assert times(found) == [4000 * k for k in range(20)]
    assert (reader.messages, reader.garbage) == (20, 0)


def test_signed_frames_are_read() -> None:
    codec = mavlink.MAVLink(None)
    codec.signing.secret_key = bytes(32)
    codec.signing.sign_outgoing = True
    signed = bytes(mavlink.MAVLink_hil_actuator_controls_message(4000, [0.0] * 16, 128, 1).pack(codec))
    assert times(Frames().feed(signed + frames(2)[0])) == [4000, 0]


@pytest.mark.parametrize(
    "beginning",
    [b"\xfd", b"\xfe", b"\xfd\xff", b"\xfd\xff\x01", b"\xfe\xff\x00\x00", b"\xfd\x09\x00\x00\x00\x01\x01\x4d\x5d\x0e"],
    ids=["2", "1", "2-long", "2-long-signed", "1-long", "unknown-id"],
)
def test_what_looks_like_a_beginning_swallows_nothing(beginning: bytes) -> None:
    """pymavlink's own parser would wait for up to 280 bytes here, and an autopilot in lockstep sends no more."""
    (good,) = frames(1)
    reader = Frames()
    assert len(reader.feed(beginning + good)) == 1
    assert reader.garbage == len(beginning)


@pytest.mark.parametrize("cut", range(1, 40, 3))
def test_a_frame_cut_short_does_not_take_the_next_with_it(cut: int) -> None:
    first, second, third = frames(3)
    reader = Frames()
    assert times(reader.feed(first[:-cut])) == []
    assert times(reader.feed(second)) == [4000]
    assert times(reader.feed(third)) == [8000]


def test_every_single_bit_flipped_is_seen() -> None:
    """A flipped bit costs its own message and no other, and never makes another message of it."""
    good = frames(3)
    for byte in range(len(good[1])):
        for bit in range(8):
            damaged = bytearray(good[1])
            damaged[byte] ^= 1 << bit
            found = times(Frames().feed(good[0] + bytes(damaged) + good[2]))
            assert found == [0, 8000], (byte, bit)


def test_a_million_random_bytes_hide_no_message() -> None:
    """Random bytes, half of them likely beginnings of frames, with messages in between."""
    rng = np.random.default_rng(4)
    good = frames(200)
    stream = b""
    for frame in good:
        noise = rng.integers(0, 256, 5000).astype(np.uint8)
        noise[rng.random(5000) < 0.02] = 0xFD
        stream += noise.tobytes() + frame
    reader = Frames()
    found = [m for i in range(0, len(stream), 4096) for m in reader.feed(stream[i : i + 4096])]
    answers = [m.time_usec for m in found if m.get_type() == "HIL_ACTUATOR_CONTROLS"]
    assert answers == [4000 * k for k in range(200)]
    assert reader.garbage + sum(map(len, good)) <= len(stream)


def test_no_more_than_a_frame_is_kept() -> None:
    reader = Frames()
    for _ in range(100):
        reader.feed(b"\xfd" * 1000)
    assert len(reader._rest) < 310
