"""A bridge on a real run: what is commanded arrives at a communication point and is recorded; nothing stops the run."""

import hashlib
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

import adcs
from adcs import AdcsError, Hook, ModelExchange, RunInterrupted, Save, rerun, run
from adcs.catalogue import SYSTEMS
from adcs.cli.ground_tools import attached
from adcs.cli.options import GroundTools
from hil_bridge.ground.attach import Bridge
from hil_bridge.ground.commands import make_commandable
from hil_bridge.ground.mapping import ROLES, find
from hil_bridge.ground.parameters import parameters
from hil_bridge.ground.settings import Settings
from hil_bridge.ground.trial import Trial
from orchestration.running.hooks.changes import Changes

from .live import HEARTBEAT, Over, Udp, until

T5 = SYSTEMS["full-state-pd"]


class Pilot(Thread):
    """A ground station with something to do while a run goes on."""

    def __init__(self, work):
        super().__init__(daemon=True)
        self.station = Udp()
        self.work = work
        self.error = None
        self.start()

    def run(self):
        try:
            self.vehicle = until(self._vehicle)
            self.work(self)
        except BaseException as error:
            self.error = error

    def _vehicle(self):
        try:
            data, address = self.station.socket.recvfrom(65535)
        except OSError:
            return None
        self.station.heard += self.station.mav.parse_buffer(data) or []
        return address

    def send(self, message):
        self.station.send(message, self.vehicle)

    def result_of(self, command, *p):
        n = self.station.count("COMMAND_ACK")
        self.send(mavlink.MAVLink_command_long_message(1, 1, command, 0, *p, *[0.0] * (7 - len(p))))
        until(lambda: self.station.count("COMMAND_ACK") > n)
        return [m for m in self.station.heard if m.get_type() == "COMMAND_ACK"][-1].result

    def parameter(self, id_, value):
        """Set it, and return the value that is confirmed."""
        n = self.station.count("PARAM_VALUE")
        self.send(mavlink.MAVLink_param_set_message(1, 1, id_.encode(), value, 9))
        until(lambda: self.station.count("PARAM_VALUE") > n)
        return [m for m in self.station.heard if m.get_type() == "PARAM_VALUE"][-1].param_value

    def texts(self):
        return [m.text for m in self.station.listen() if m.get_type() == "STATUSTEXT"]


def flown(work, stop_time=20.0, speed=10.0, allow="arm,param,attitude", entry=T5, **more):
    pilot = Pilot(work)
    system = entry.build()
    options = GroundTools(to=(f"udpout:127.0.0.1:{pilot.station.port}",), allow=allow, **more)
    with attached(system, options, step=0.01, speed=speed) as watcher:
        watchers = [watcher, Over(pilot)] if stop_time > 1000 else [watcher]
        try:
            result = run(system, stop_time=stop_time, step=0.01, hooks=[adcs.pace(speed), *watchers])
        except RunInterrupted as error:
            result = error.result
    pilot.join(5.0)
    if pilot.error is not None:
        raise pilot.error
    return result, pilot, watcher


def assert_short_way(result, row, target):
    """The law is given the target, with the sign that is nearest to the attitude it sees."""
    q_SN = result["commanded_reference.q_SN"][row]
    assert np.allclose(q_SN * np.sign(q_SN @ target), target, rtol=0, atol=1e-7)
    assert q_SN @ result["tracker.q_BN_meas"][row] > 0


def test_commands_arrive_are_recorded_and_can_be_repeated():
    """Gain, disarm and arm, an attitude; a gain that the law refuses. The record alone gives the same run again."""
    seen = {}

    def work(pilot):
        pilot.send(HEARTBEAT)
        seen["gain"] = pilot.parameter("CTRL_K_P", 2.5)
        seen["refused"] = pilot.parameter("CTRL_K_P", 0.0)  # the law wants it above 0, which FMI cannot say
        seen["off"] = pilot.result_of(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0)
        n = pilot.station.count("ATTITUDE")
        until(lambda: pilot.station.count("ATTITUDE") > n + 3)  # points without torque
        seen["on"] = pilot.result_of(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
        for _ in range(3):
            pilot.send(mavlink.MAVLink_set_attitude_target_message(0, 1, 1, 7, [0.8, 0.6, 0, 0], 0, 0, 0, 0))
        until(lambda: "Attitude target taken" in pilot.texts())

    result, pilot, _ = flown(work)
    assert (seen["gain"], seen["refused"], seen["off"], seen["on"]) == (2.5, 2.5, 0, 0)
    commands = result.manifest["commands"]
    assert [c[1:3] for c in commands[:3]] == [
        ["controller.k_p", 2.5],
        ["torque_switch.enabled", 0],
        ["torque_switch.enabled", 1],
    ]
    assert {c[3] for c in commands} == {f"udpout 127.0.0.1:{pilot.station.port}", "attitude target timed out"}
    assert ["commanded_reference.engaged", 1] in [c[1:3] for c in commands]
    off, on = (c[0] for c in commands[1:3])
    silent = (result.time > off - 1e-9) & (result.time < on - 1e-9)
    assert silent.any()
    assert np.array_equal(~result["torque_switch.torque_applied_B"].any(axis=1), silent)
    engaged = next(c[0] for c in commands if c[1:3] == ["commanded_reference.engaged", 1])
    row = round(engaged / 0.01)
    assert_short_way(result, row, [0.8, 0.6, 0, 0])
    assert np.array_equal(result["commanded_reference.q_SN"][row - 1], result["guidance.q_RN"][row - 1])
    assert "controller.k_p = 2.5 N.m" in pilot.texts()
    assert any("k_p" in text and "refused" in text for text in pilot.texts())

    repeated = rerun(result.manifest)
    assert np.array_equal(repeated.result.data, result.data)
    assert repeated.differences == ()
    again = T5.build()
    make_commandable(again, find(again), ["arm", "param", "attitude"])
    changes = [(t, name, value) for t, name, value, _ in commands]
    by_hooks = run(again, stop_time=20.0, step=0.01, hooks=[Changes(changes)], save=Save(list(result.ports)))
    assert np.array_equal(by_hooks.data, result.data)


def test_being_commandable_changes_nothing():
    plain, prepared = T5.build(), T5.build()
    make_commandable(prepared, find(prepared), ["arm", "attitude"])
    one = run(plain, stop_time=5.0, step=0.01)
    other = run(prepared, stop_time=5.0, step=0.01, save=Save(list(one.ports)))
    assert np.array_equal(one.data, other.data)


def test_a_slew_ends_at_the_commanded_attitude_and_its_timeout_gives_it_back():
    """Targets go on until the attitude is there, then there is silence; 40 times real time."""
    target = np.array([0.8, 0.6, 0, 0])
    message = mavlink.MAVLink_set_attitude_target_message(0, 1, 1, 7, target.tolist(), 0, 0, 0, 0)

    def there(pilot):
        pilot.send(message)
        seen = [m for m in pilot.station.listen() if m.get_type() == "ATTITUDE_QUATERNION"]
        settled = seen[-50:]
        pilot.station.heard = settled
        return len(settled) == 50 and all(abs(np.dot([m.q1, m.q2, m.q3, m.q4], target)) > 0.99999 for m in settled)

    def work(pilot):
        until(lambda: there(pilot))
        until(lambda: any("timed out" in text for text in pilot.texts()))

    result, _, _ = flown(work, stop_time=4000.0, speed=40.0, allow="attitude")
    engaged = [c for c in result.manifest["commands"] if c[1] == "commanded_reference.engaged"]
    assert [c[2] for c in engaged] == [1, 0]
    before, after = (round(engaged[1][0] / 0.01) + i for i in (-1, 0))
    assert abs(result["plant.q_BN"][before] @ target) > 0.99999  # half a degree
    assert_short_way(result, before, target)
    assert np.array_equal(result["commanded_reference.q_SN"][after:], result["guidance.q_RN"][after:])


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this platform has no SIGKILL")
def test_the_run_goes_on_when_the_bridge_is_killed():
    station = Udp()
    system = T5.build()
    options = GroundTools(to=(f"udpout:127.0.0.1:{station.port}",))
    with attached(system, options, step=0.01, speed=10.0) as watcher:

        class Kill(Hook):
            def after(self, point, time):
                if point == 299:
                    os.kill(watcher.pid, signal.SIGKILL)

        result = run(system, stop_time=10.0, step=0.01, hooks=[adcs.pace(10.0), Kill(), watcher])
    plain = run(T5.build(), stop_time=10.0, step=0.01)
    assert np.array_equal(result.data, plain.data)
    assert result.manifest["outcome"]["status"] == "complete"


def ended(pilot):
    """Text and state of the vehicle's last words."""
    heard = pilot.station.listen()
    beat = [m for m in heard if m.get_type() == "HEARTBEAT"][-1]
    return [m.text for m in heard if m.get_type() == "STATUSTEXT"][-1], beat.system_status, beat.base_mode & 128


def test_the_last_words_say_how_it_ended():
    _, pilot, _ = flown(lambda pilot: None, stop_time=3.0)
    assert ended(pilot) == ("Run ended", mavlink.MAV_STATE_POWEROFF, 0)
    _, pilot, _ = flown(lambda pilot: None, stop_time=4000.0)  # broken off by the test, as by Ctrl-C
    assert ended(pilot) == ("Run interrupted", mavlink.MAV_STATE_POWEROFF, 0)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this platform has no SIGKILL")
def test_a_simulation_that_is_killed_is_missed():
    station = Udp()
    code = "from adcs.cli.app import main; main()"
    command = [sys.executable, "-c", code, "bridge", "full-state-pd", "--to", f"udpout:127.0.0.1:{station.port}"]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as process:
        until(lambda: station.count("ATTITUDE") > 5)
        process.kill()
    until(lambda: any(m.text.startswith("Run broken off") for m in station.listen() if m.get_type() == "STATUSTEXT"))
    last = until(
        lambda: [
            m
            for m in station.listen()
            if m.get_type() == "HEARTBEAT" and m.system_status == mavlink.MAV_STATE_EMERGENCY
        ]
    )
    assert not last[-1].base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this platform has no SIGKILL")
def test_a_bridge_that_is_killed_accepts_nothing_again(tmp_path):
    """A signed message that was answered is captured, the bridge killed with -9 and started again."""
    key = tmp_path / "key"
    key.write_text("a pass phrase")
    friend = Udp()
    friend.mav.signing.secret_key = hashlib.sha256(b"a pass phrase").digest()
    friend.mav.signing.sign_outgoing = True
    friend.mav.signing.timestamp = int((time.time() - 1420070400) * 1e5)
    captured = mavlink.MAVLink_ping_message(1, 1, 0, 0).pack(friend.mav)
    heard = []
    for _ in range(2):
        with attached(T5.build(), GroundTools(to=("udpin:127.0.0.1:0",), key=key), step=0.01) as watcher:
            _, host, port = watcher.endpoints[0].split(":")
            address = (host, int(port))
            if not heard:
                friend.send(captured, address)
                until(lambda: friend.count("PING") == 1)
                heard = friend.heard
                os.kill(watcher.pid, signal.SIGKILL)
                continue
            for _ in range(3):
                friend.send(captured, address)
            friend.mav.signing.timestamp += 150_000
            friend.send(mavlink.MAVLink_ping_message(2, 2, 0, 0), address)
            until(lambda: friend.count("PING") == 2)
            assert [m.seq for m in friend.heard if m.get_type() == "PING"] == [1, 2]
            report = watcher.report()["mavlink"]
    assert (report["endpoints"][0]["received"], report["endpoints"][0]["bad"]) == (1, 3)


def test_a_ground_station_sees_the_values_of_the_run():
    result, pilot, _ = flown(
        lambda pilot: until(lambda: pilot.station.count("ATTITUDE_QUATERNION") > 40), stop_time=10.0
    )
    found = [m for m in pilot.station.listen() if m.get_type() == "ATTITUDE_QUATERNION"]
    assert len(found) > 40
    for m in found:
        row = m.time_boot_ms // 10
        q = result["tracker.q_BN_meas"][row]
        assert np.allclose([m.q1, m.q2, m.q3, m.q4], q * np.sign(q[0]), rtol=0, atol=6e-8)
        assert np.allclose([m.rollspeed, m.pitchspeed, m.yawspeed], result["plant.omega_BN_B"][row], rtol=6e-8)
    assert "Run started" in pilot.texts() or pilot.station.count("STATUSTEXT")
    assert "Run ended" in pilot.texts()


def test_every_system_has_something_to_show():
    for name, entry in SYSTEMS.items():
        system = entry.build()
        signals = find(system)
        assert {"attitude", "rate", "torque"} <= set(signals.roles) or name == "observer-inertia-error", name
        ids = [p.id for p in parameters(system)]
        assert len(ids) == len(set(ids)) and max(map(len, ids)) <= 16, name
        assert all(id_.isascii() for id_ in ids)


def test_what_is_shown_is_found_by_name():
    roles = find(SYSTEMS["observer-pd"].build()).roles
    assert roles["attitude"] == "tracker.q_BN_meas"
    assert roles["rate"] == "observer.omega_BN_B_est"
    assert roles["true_attitude"] == "plant.q_BN"
    assert roles["reference"] == "guidance.q_RN"
    assert roles["torque"] == "controller.torque_B"
    assert find(SYSTEMS["six-dof"].build()).roles["position"] == "plant.r_BN_N"
    assert find(SYSTEMS["six-dof"].build()).base == "N"
    trigo = find(SYSTEMS["trigo-bs"].build())
    assert (trigo.roles["attitude"], trigo.base) == ("sensor.sigma_BO_meas", "O")


def test_what_is_shown_is_changed_by_declaration(tmp_path):
    system = SYSTEMS["observer-pd"].build()
    file = tmp_path / "map.toml"
    file.write_text('[roles]\nattitude = "plant.q_BN"\ntorque = ""\n[shown]\nenergy = "plant.kinetic_energy"\n')
    signals = find(system, [str(file), "rate=plant.omega_BN_B"], ["plant.H_N"])
    assert signals.roles["attitude"] == "plant.q_BN"
    assert signals.roles["rate"] == "plant.omega_BN_B"
    assert "torque" not in signals.roles
    assert signals.shown == {"energy": "plant.kinetic_energy", "H_N": "plant.H_N"}


def test_the_map_of_the_page_fits_the_system_of_the_page(tmp_path):
    page = (Path(__file__).parents[2] / "docs/mavlink.md").read_text()
    (text,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    file = tmp_path / "shown.toml"
    file.write_text(text)
    signals = find(SYSTEMS["observer-pd"].build(), [str(file), "rate=plant.omega_BN_B"], ["plant.H_N"])
    assert signals.roles["attitude"] == "plant.q_BN" and signals.roles["rate"] == "plant.omega_BN_B"
    assert signals.shown == {"energy": "plant.kinetic_energy", "H_N": "plant.H_N"}


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ("attitude=plant.omega_BN_B", "--map attitude=plant.omega_BN_B: expected an output with 4 or 3 elements in 1"),
        ("colour=plant.q_BN", "there is no 'colour', choose one of attitude, rate"),
        ("attitude=plant.q_NB", "has no variable 'q_NB': did you mean q_BN"),
        ("nothing.toml", "expected ROLE=COMPONENT.VARIABLE or a TOML file"),
        ("position=plant.H_N", "expected an output with 3 elements in m"),
    ],
)
def test_refused_maps(wanted, message):
    with pytest.raises(AdcsError) as error:
        find(SYSTEMS["observer-pd"].build(), [wanted])
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"allow": "fly"}, "--allow fly: expected some of arm, param, attitude"),
        ({"position": "91,0,0"}, "latitude within 90 deg"),
        ({"position": "here"}, "expected LATITUDE,LONGITUDE,HEIGHT"),
        ({"rate": ["ATTITUDE=fast"]}, "expected MESSAGE=HZ"),
        ({"rate": ["SCALED_IMU=5"]}, "the bridge has no such message"),
        ({"to": ["udpin:0.0.0.0:14550"]}, "add --remote"),
        ({"frame": "lvlh"}, "no orbit"),
    ],
)
def test_refused_options(options, message):
    system = T5.build()
    given = {"to": ["udpout:127.0.0.1:9"], **options}
    with pytest.raises(AdcsError) as error, attached(system, GroundTools(**given), step=0.01):
        pass
    assert message in str(error.value)


def test_a_value_is_tried_on_a_copy():
    trial = Trial(T5.build(), 0.01)
    assert trial.refused("controller.k_p", 2.0) is None
    assert "k_p" in (trial.refused("controller.k_p", 0.0) or "")
    assert trial.refused("plant.J_B", np.diag([1.0, 2.0, 2.5])) is None
    assert trial.refused("plant.J_B", np.diag([1.0, 2.0, -2.5])) is not None
    assert trial.refused("plant.J_B", np.diag([1.0, 2.0, 2.0])) is None


def test_a_watcher_may_not_be_given_to_model_exchange():
    system = T5.build()
    bridge = Bridge(system, find(system), Settings("x", (), 0.01))
    with pytest.raises(AdcsError, match=r"^mavlink: only co-simulation has it"):
        run(system, stop_time=1.0, step=0.01, method=ModelExchange(), hooks=[bridge])


def test_settings_cross_to_another_process():
    settings = Settings(
        "x", [("attitude", 0, 4)], 0.01, parameters=parameters(T5.build())[:3], position=(1.0, 2.0, 3.0)
    )
    again = Settings.loaded(settings.dumped())
    assert again.dumped() == settings.dumped()
    assert again.parameters == settings.parameters and again.columns == settings.columns


def test_roles_have_units_that_exist():
    assert {role.unit for role in ROLES.values()} <= {"1", "rad/s", "N.m", "m", "m/s", "N.m.s"}
