"""Telemetry logs: read back by pymavlink, cut off, replayed."""

import subprocess
import sys
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

from adcs import AdcsError, run
from adcs.catalogue import SYSTEMS
from adcs.cli.ground_tools import attached
from adcs.cli.options import GroundTools
from hil_bridge.ground.endpoints import Place
from hil_bridge.ground.replay import replay
from hil_bridge.ground.tlog import TlogWriter, read, sender

from .live import Udp

ENTRY = SYSTEMS["six-dof"]


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    """A run with an orbit, logged without network: the result, and the log's path."""
    path = tmp_path_factory.mktemp("tlog") / "flight.tlog"
    system = ENTRY.build()
    with attached(system, GroundTools(tlog=path), step=0.1, network=False) as watcher:
        result = run(system, stop_time=60.0, step=0.1, hooks=[watcher])
    return result, path


def messages(path, *kinds):
    log = mavutil.mavlink_connection(str(path), dialect="common")
    found = []
    while (message := log.recv_match(type=list(kinds) or None)) is not None:
        found.append(message)
    log.close()
    return found


def test_a_log_is_what_pymavlink_reads(flight):
    result, path = flight
    found = messages(path)
    assert not any(m.get_type() == "BAD_DATA" for m in found)
    attitudes = [m for m in found if m.get_type() == "ATTITUDE_QUATERNION"]
    assert [m.time_boot_ms for m in attitudes] == [round(1e3 * t) for t in result.time]
    assert [m._timestamp for m in attitudes] == pytest.approx(1767225600 + result.time, abs=1e-6)
    texts = [m.text for m in found if m.get_type() == "STATUSTEXT"]
    assert "Run started" in texts and texts[-1] == "Run ended"
    assert len([m for m in found if m.get_type() == "PARAM_VALUE"]) == found_parameters(found)


def found_parameters(found):
    return next(m.param_count for m in found if m.get_type() == "PARAM_VALUE")


def test_the_ground_track_moves_as_the_orbit_does(flight):
    result, path = flight
    track = messages(path, "GLOBAL_POSITION_INT")
    assert len(track) == 301
    radius = np.linalg.norm(result["plant.r_BN_N"], axis=1)
    for m in track[::50]:
        row = round(m.time_boot_ms / 100)
        assert m.alt * 1e-3 == pytest.approx(radius[row] - 6378e3, abs=25e3)  # the ellipsoid's flattening


def test_mavlogdump_reads_it(flight):
    _, path = flight
    done = subprocess.run(
        [sys.executable, "-m", "pymavlink.tools.mavlogdump", "--types", "STATUSTEXT", str(path)],
        capture_output=True,
        text=True,
        check=False,
    )
    if "No module named" in done.stderr:
        pytest.skip("this pymavlink has no mavlogdump module")
    assert "Run ended" in done.stdout


def test_times_never_go_back_and_a_cut_frame_ends_the_log(tmp_path):
    path = tmp_path / "x" / "a.tlog"
    frame = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3).pack(mavlink.MAVLink(None, 7, 8))
    with TlogWriter(path) as log:
        for t in (5.0, 4.0, 6.0):
            log.write(t, frame)
    assert [t for t, _ in read(path)] == [5.0, 5.0, 6.0]
    assert sender(next(read(path))[1]) == (7, 8)
    path.write_bytes(path.read_bytes()[:-4])
    assert len(list(read(path))) == 2


@pytest.mark.parametrize("content", [b"hello, this is not a log at all", b"\0" * 40])
def test_what_is_no_log_is_named(tmp_path, content):
    path = tmp_path / "a.tlog"
    path.write_bytes(content)
    with pytest.raises(AdcsError, match="is no telemetry log"):
        list(read(path))
    with pytest.raises(AdcsError, match="cannot read"):
        list(read(tmp_path / "none.tlog"))


def test_a_log_is_replayed_frame_by_frame(flight):
    _, path = flight
    station = Udp()
    done = []
    place = Place("udpout", "127.0.0.1", station.port)
    thread = Thread(target=lambda: done.append(replay(path, [place], speed=40.0)), daemon=True)
    thread.start()
    expected = [frame for _, frame in read(path)]
    while thread.is_alive():
        station.listen()
    heard = [bytes(m.get_msgbuf()) for m in station.listen()]
    rest = iter(expected)
    assert all(frame in rest for frame in heard)  # in order; the kernel may drop some of a busy machine
    assert len(heard) > 0.9 * len(expected)
    assert done[0]["frames"] == len(expected)


def test_a_replay_wants_frames_and_a_speed(tmp_path, flight):
    empty = tmp_path / "a.tlog"
    empty.write_bytes(b"")
    place = [Place("udpout", "127.0.0.1", 9)]
    with pytest.raises(AdcsError, match="has no frames of a vehicle"):
        replay(empty, place)
    with pytest.raises(AdcsError, match="speed = 0"):
        replay(flight[1], place, speed=0.0)


def test_target_acquired_is_said_once(tmp_path):
    path = tmp_path / "a.tlog"
    system = SYSTEMS["full-state-pd"].build()
    with attached(system, GroundTools(tlog=path), step=0.01, network=False) as watcher:
        result = run(system, stop_time=80.0, step=0.01, hooks=[watcher])
    texts = [m.text for m in messages(path, "STATUSTEXT")]
    acquired = [text for text in texts if text.startswith("Target acquired")]
    error = 2 * np.arccos(np.clip(np.abs(result["controller.q_BR"][:, 0]), 0, 1))
    first = result.time[np.flatnonzero(error < 0.0035)[0]]
    assert acquired[0].startswith(f"Target acquired at t = {first:.6g} s")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this platform has no /dev/full")
@pytest.mark.parametrize("network", [False, True])
def test_a_full_disk_ends_the_log_and_not_the_run(capfd, network):
    system = SYSTEMS["full-state-pd"].build()
    options = GroundTools(to=("udpout:127.0.0.1:9",), tlog=Path("/dev/full"))
    with attached(system, options, step=0.01, network=network) as watcher:
        result = run(system, stop_time=20.0, step=0.01, hooks=[watcher])
    assert result.manifest["outcome"]["status"] == "complete"
    assert np.array_equal(result.data, run(SYSTEMS["full-state-pd"].build(), stop_time=20.0, step=0.01).data)
    said = capfd.readouterr().err.splitlines()
    assert said == ["adcs: the telemetry log ends here, the run goes on: /dev/full: No space left on device"]
    account = result.manifest["mavlink"] if network else result.manifest
    assert account["tlog_incomplete"] == "/dev/full: No space left on device"


def test_the_last_heartbeat_of_a_log_is_off(flight):
    _, path = flight
    beats = messages(path, "HEARTBEAT")
    assert beats[-1].system_status == mavlink.MAV_STATE_POWEROFF
    assert {m.system_status for m in beats[:-1]} == {mavlink.MAV_STATE_ACTIVE}
