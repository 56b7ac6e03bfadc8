"""An autopilot that dies, hangs, is late, never comes, or is none: one clear line, and what was recorded is kept."""

import json
import signal
import socket
import struct
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Thread
from time import monotonic, sleep

import numpy as np
import pytest
from flights import autopilot, connected, flown, prepared
from pymavlink.dialects.v20 import common as mavlink

from adcs import AdcsError, RunFailed, RunInterrupted
from adcs.cli.app import app
from adcs.library.hardware.systems import PERIOD
from hil_bridge.hil.flying import fly
from hil_bridge.hil.link import Server
from tests.invoking import invoke

ANSWER = mavlink.MAVLink_hil_actuator_controls_message
ARMED = mavlink.MAV_MODE_FLAG_SAFETY_ARMED


class Hand:
    """An autopilot by hand, in this process: what it says before the simulator listens waits in the socket."""

    def __init__(self, server: Server, *early: mavlink.MAVLink_message) -> None:
        self.socket = socket.create_connection((server.host, server.port))
        self.codec = mavlink.MAVLink(None)
        self.heard: list[mavlink.MAVLink_message] = []
        for message in (*early, mavlink.MAVLink_heartbeat_message(0, 12, 0, 0, 0, 3)):
            self.say(message)

    @contextmanager
    def answering(self, reply: Callable[[int], None]) -> Iterator[None]:
        """Call `reply` with k for the sensors of each point; until the simulator closes the connection."""

        def listen() -> None:
            with suppress(OSError):
                while data := self.socket.recv(1 << 20):
                    for message in self.codec.parse_buffer(data) or []:
                        self.heard.append(message)
                        if message.get_type() == "HIL_SENSOR":
                            reply(round((message.time_usec - 1_000_000) / (1e6 * PERIOD)))

        thread = Thread(target=listen)
        thread.start()
        try:
            yield
        finally:
            self.socket.shutdown(socket.SHUT_RDWR)
            thread.join()

    def say(self, message: mavlink.MAVLink_message) -> None:
        self.socket.sendall(message.pack(self.codec))

    def answer(self, k: int, torque: float = 0.0) -> None:
        """The controls for point k, whose time it knows beforehand."""
        controls = [torque, *[float("nan")] * 15]
        self.say(ANSWER(1_000_000 + round(1e6 * PERIOD * k), controls, ARMED, 1))


def test_kill_9_in_the_middle_of_a_flight() -> None:
    with connected() as (link, process):
        system, flight = prepared(link)

        def kill(part: float) -> None:
            if part > 0.2 and process.poll() is None:
                process.send_signal(signal.SIGKILL)
                process.wait()

        with pytest.raises(RunFailed) as failed:
            fly(system, flight, stop_time=2.0, step=PERIOD, progress=kill)
    text, result = str(failed.value), failed.value.result
    assert "\n" not in text
    assert text.startswith(f"the autopilot at {link.peer} closed the connection")
    assert text.endswith(("101 rows are kept", "102 rows are kept"))
    assert len(result.time) in (101, 102)
    whole = flown(stop_time=0.5)
    np.testing.assert_array_equal(result.data, whole.data[: len(result.data)])
    assert result.manifest["outcome"]["status"] == "failed"


def test_a_connection_that_is_reset_is_a_closed_one() -> None:
    server = Server(port=0)
    hand = Hand(server)
    with server.autopilot(5.0, 5.0) as link:
        system, flight = prepared(link)
        hand.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        hand.socket.close()
        with pytest.raises(
            RunFailed, match=r"the autopilot at 127\.0\.0\.1:\d+ closed the connection; 0 rows are kept"
        ):
            fly(system, flight, stop_time=1.0, step=PERIOD)


def test_an_autopilot_that_stops_answering_is_given_up() -> None:
    with connected("--stop-after", "50") as (link, _):
        system, flight = prepared(link, timeout=2.5)
        began = monotonic()
        with pytest.raises(RunFailed, match=r"did not answer the sensors of t = 0.2 s within 2.5 s; 50 rows are kept$"):
            fly(system, flight, stop_time=2.0, step=PERIOD)
        assert monotonic() - began > 2.5


def test_answers_for_another_time_are_not_taken_for_this() -> None:
    server = Server(port=0)
    hand = Hand(server)
    with server.autopilot(5.0, 5.0) as link:
        system, flight = prepared(link, timeout=2.0)

        def reply(k: int) -> None:
            if k < 2:
                hand.answer(k - 1, 1.0)  # late
                hand.answer(k, 0.25 * k)
                hand.answer(k, 0.75)  # the first counts
            else:
                hand.answer(k + 1, 1.0)  # ahead

        with hand.answering(reply), pytest.raises(RunFailed) as failed:
            fly(system, flight, stop_time=2.0, step=PERIOD)
    assert "t = 0.008 s within 2 s (" in str(failed.value)
    assert " late, 1 ahead of time); 2 rows are kept" in str(failed.value)
    np.testing.assert_array_equal(failed.value.result["actuator.torque_B"][:, 0], [0.0, 0.25])


def test_messages_in_pieces_of_one_byte() -> None:
    server = Server(port=0)
    hand = Hand(server)
    with server.autopilot(5.0, 5.0) as link:
        system, flight = prepared(link)
        hand.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

        def reply(k: int) -> None:
            whole = ANSWER(1_000_000 + 4000 * k, [0.1 * k] * 16, ARMED, 1).pack(hand.codec)
            for i in range(len(whole)):
                hand.socket.sendall(whole[i : i + 1])

        with hand.answering(reply):
            result = fly(system, flight, stop_time=2 * PERIOD, step=PERIOD)
    np.testing.assert_allclose(result["actuator.torque_B"], np.outer([0.0, 0.1, 0.2], np.ones(3)), rtol=1e-7)


def test_no_autopilot_comes() -> None:
    server = Server(port=0)
    with pytest.raises(AdcsError, match=rf"^no autopilot connected to 127.0.0.1:{server.port} within 0.1 s$"):
        server.autopilot(0.1, 1.0).__enter__()


def test_what_is_no_autopilot_is_sent_away() -> None:
    server = Server(port=0)
    stranger = socket.create_connection((server.host, server.port))
    stranger.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")
    with pytest.raises(AdcsError, match="sent no MAVLink HEARTBEAT: it is no autopilot"):
        server.autopilot(0.3, 1.0).__enter__()


def test_there_is_room_for_one() -> None:
    server = Server(port=0)
    hand = Hand(server)
    with server.autopilot(5.0, 5.0), pytest.raises(ConnectionRefusedError):
        Hand(server)
    hand.socket.close()


def test_a_port_in_use_and_an_address_for_others_are_refused() -> None:
    server = Server(port=0)
    with pytest.raises(AdcsError, match=rf"cannot listen on 127.0.0.1:{server.port}: .*choose another --port"):
        Server(port=server.port)
    with pytest.raises(AdcsError, match=r"0\.0\.0\.0 can be reached from other machines.*--remote"):
        Server("0.0.0.0", 0)
    with pytest.raises(AdcsError, match="'localhost' is not an IP address"):
        Server("localhost", 0)


def test_an_autopilot_that_does_not_read_does_not_hold_up_forever() -> None:
    """Time goes on without lockstep; the socket fills, and the flight ends with a line."""
    server = Server(port=0)
    hand = Hand(server)
    with server.autopilot(5.0, 0.3) as link:
        system, flight = prepared(link, lockstep=False, speed=1e6, warm_up=60.0)
        with pytest.raises(RunFailed, match=r"no longer reads what it is sent; [0-9]{3,5} rows are kept"):
            fly(system, flight, stop_time=400.0, step=PERIOD)
    hand.socket.close()


def test_a_flood_of_random_bytes_ends_with_the_timeout() -> None:
    server = Server(port=0)
    hand = Hand(server)
    with server.autopilot(5.0, 5.0) as link:
        system, flight = prepared(link, timeout=0.5)
        hand.socket.setblocking(False)
        rng = np.random.default_rng(5)
        try:
            while True:
                hand.socket.send(rng.bytes(65536))
        except BlockingIOError:
            pass
        with pytest.raises(RunFailed, match=r"did not answer the sensors of t = 0 s within 0.5 s; 0 rows are kept"):
            fly(system, flight, stop_time=1.0, step=PERIOD)
        assert flight.report()["garbage_bytes"] > 65536


def test_ctrl_c_keeps_what_was_recorded() -> None:
    with connected() as (link, _):
        system, flight = prepared(link)

        def interrupt(part: float) -> None:
            if part > 0.5:
                raise KeyboardInterrupt

        with pytest.raises(RunInterrupted) as stopped:
            fly(system, flight, stop_time=0.4, step=PERIOD, progress=interrupt)
    assert len(stopped.value.result.time) == 51


def test_an_autopilot_that_boots_is_not_waited_for() -> None:
    """It leaves 30 messages unanswered, and time goes on without torque; with its first answer, lockstep begins."""
    with connected("--boot", "30") as (link, _):
        system, flight = prepared(link, warm_up=60.0)
        result = fly(system, flight, stop_time=3.0, step=PERIOD)
    account = result.manifest["hardware_in_the_loop"]
    assert account["locked_at_s"] >= 30 * PERIOD
    first = round(account["locked_at_s"] / PERIOD)
    assert account["points_not_waited_for"] == first
    assert account["points_answered"] == 751 - first
    assert not result["actuator.torque_B"][:first].any()
    assert result["actuator.torque_B"][first:].all()


def test_one_that_never_wakes_up_is_given_up() -> None:
    server = Server(port=0)
    hand = Hand(server)
    with server.autopilot(5.0, 5.0) as link:
        system, flight = prepared(link, warm_up=0.1, speed=10.0, timeout=1.0)
        with pytest.raises(RunFailed, match=r"did not answer within the 0.1 s of its warm-up; 25 rows are kept"):
            fly(system, flight, stop_time=1.0, step=PERIOD)
    hand.socket.close()


def test_without_lockstep_time_goes_on_and_the_last_controls_count() -> None:
    server = Server(port=0)
    hand = Hand(server)
    with server.autopilot(5.0, 5.0) as link:
        system, flight = prepared(link, lockstep=False, speed=2.0)
        hand.answer(0, 0.25)
        hand.answer(17, 0.5)
        began = monotonic()
        result = fly(system, flight, stop_time=0.2, step=PERIOD)
        assert monotonic() - began >= 0.1, "twice real time, and no faster"
    np.testing.assert_array_equal(result["actuator.torque_B"][:, 0], np.full(51, 0.5))
    assert result.manifest["hardware_in_the_loop"]["points_not_waited_for"] == 50


def test_without_lockstep_silence_ends_the_flight() -> None:
    server = Server(port=0)
    hand = Hand(server)
    with server.autopilot(5.0, 5.0) as link:
        system, flight = prepared(link, lockstep=False, speed=1.0, timeout=0.1)
        hand.answer(0, 0.25)
        with pytest.raises(RunFailed, match=r"has sent no controls for [\d.]+ s, at t = [\d.]+ s; \d+ rows are kept"):
            fly(system, flight, stop_time=5.0, step=PERIOD)
    hand.socket.close()


def test_requests_are_answered_and_the_interval_of_the_truth_is_kept() -> None:
    """PX4 asks for HIL_STATE_QUATERNION every 5 ms; here it is 12 ms, and something that nobody offers."""
    command = mavlink.MAV_CMD_SET_MESSAGE_INTERVAL
    wanted = (mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION, mavlink.MAVLINK_MSG_ID_ATTITUDE)
    server = Server(port=0)
    hand = Hand(
        server, *(mavlink.MAVLink_command_long_message(1, 1, command, 0, i, 12e3, 0, 0, 0, 0, 0) for i in wanted)
    )
    with server.autopilot(5.0, 5.0) as link:
        system, flight = prepared(link)
        with hand.answering(hand.answer):
            fly(system, flight, stop_time=10 * PERIOD, step=PERIOD)
    heard = hand.heard
    acknowledged = [m.result for m in heard if m.get_type() == "COMMAND_ACK"]
    assert acknowledged == [mavlink.MAV_RESULT_ACCEPTED, mavlink.MAV_RESULT_UNSUPPORTED]
    truth = [m.time_usec for m in heard if m.get_type() == "HIL_STATE_QUATERNION"]
    assert truth == [1_000_000, *range(1_012_000, 1_041_000, 12_000)]
    assert [m.time_usec for m in heard if m.get_type() == "HIL_SENSOR"] == [1_000_000 + 4000 * k for k in range(11)]


def test_the_command_line(tmp_path: Path) -> None:
    """As a user does it: the command in one shell, the autopilot in another, kill -9."""
    command = [sys.executable, "-c", "from adcs.cli.app import main; main()", "hil", "hil-spacecraft"]
    options = ["--port", "0", "--stop", "30", "--frame", "eci", "--out", str(tmp_path), "--no-report"]
    with subprocess.Popen([*command, *options], stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        waiting = process.stderr.readline()
        assert waiting.startswith("waiting for an autopilot on 127.0.0.1:")
        with autopilot(int(waiting.rpartition(":")[2])) as pilot:
            assert "connected" in process.stderr.readline()
            sleep(1.0)
            pilot.kill()
            _, errors = process.communicate(timeout=60)
    assert process.returncode == 1
    (line,) = [line for line in errors.splitlines() if line.startswith("adcs: ")]
    rows = int(line.split()[-4])
    assert "autopilot at 127.0.0.1:" in line
    assert line.endswith(f"; {rows} rows are kept")
    assert "Traceback" not in errors
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    assert manifest["outcome"]["rows"] == rows
    assert manifest["settings"]["hil"]["frame"] == "eci"
    assert manifest["hardware_in_the_loop"]["points_answered"] == rows
    assert len((tmp_path / "result.csv").read_text().splitlines()) == rows + 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["observer-pd"], "observer-pd cannot be flown: no output is called omega_BN_B_meas"),
        (["hil-spacecraft", "--port", "70000"], "port 70000: expected 0 to 65535"),
        (["hil-spacecraft", "--host", "0.0.0.0"], "add --remote"),
        (["hil-spacecraft", "--answer-timeout", "0"], "timeout = 0.0: expected a positive number"),
        (["hil-spacecraft", "--warm-up", "-1"], "warm-up = -1.0: expected a number from 0"),
        (["hil-spacecraft", "--max-torque", "a"], "--max-torque a: expected one number or three"),
        (["hil-spacecraft", "--stop", "0.0015"], "is not a whole number of steps of 0.004 s"),
        (["hil-spacecraft", "--set", "imu.period=0"], "noise is drawn per sample, give a period"),
        (["hil-spacecraft", "--set", "imu.gyro_noise"], "--set imu.gyro_noise: expected COMPONENT.VARIABLE=VALUE"),
        (["hil-spacecraft", "--port", "0", "--wait", "100ms"], "no autopilot connected to 127.0.0.1:"),
    ],
)
def test_refusals_of_the_command_line(
    arguments: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    refused = invoke(app, ["hil", *arguments])
    assert isinstance(refused.exception, AdcsError)
    assert message in str(refused.exception)
    assert "\n" not in str(refused.exception)


def test_numbers_that_no_message_holds_end_in_a_line() -> None:
    """A rate beyond float32 is told as the largest there is; when the body gives up, so does the flight."""
    server = Server(port=0)
    hand = Hand(server)
    with server.autopilot(5.0, 5.0) as link:
        system, flight = prepared(link)
        system.set("plant.omega_BN_B", (1e100, 1e100, 0.0))
        with hand.answering(hand.answer), pytest.raises(RunFailed, match="rows are kept") as failed:
            fly(system, flight, stop_time=1.0, step=PERIOD)
        assert "\n" not in str(failed.value)
    sensors = next(message for message in hand.heard if message.get_type() == "HIL_SENSOR")
    assert sensors.xgyro == pytest.approx(np.finfo(np.float32).max)
