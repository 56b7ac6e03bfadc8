"""A ground station that sends back the attitude it was shown turns nothing; a target is reached the short way."""

from dataclasses import replace

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from adcs.catalogue import SYSTEMS
from hil_bridge import frames
from hil_bridge.ground.settings import Pointing

from .ground import ROLES, Station, columns, matrix, orbiting, values
from .live import until
from .test_run import flown

POINT = Pointing("command.q_CN", "command.omega_CN_C", "command.engaged")
SINGLE = 3e-7  # of a float32 quaternion, multiplied twice

ATTITUDES = [
    [1.0, 0.0, 0.0, 0.0],
    [-1.0, 0.0, 0.0, 0.0],
    [0.6, 0.0, 0.8, 0.0],
    [-0.6, 0.0, 0.8, 0.0],
    [1e-9, 0.6, 0.8, 0.0],  # half a revolution away, on either side
    [-1e-9, 0.6, 0.8, 0.0],
    [-1e-9, -0.6, -0.8, 0.0],
    [0.0, 0.0, 0.0, -1.0],
    *np.random.default_rng(3).normal(size=(20, 4)).tolist(),
]


def target(q):
    return mavlink.MAVLink_set_attitude_target_message(0, 1, 1, 7, list(map(float, q)), 0.0, 0.0, 0.0, 0.0)


def commanded(station):
    return np.array(dict(station.asked[-1][2])["command.q_CN"])


def error(q_BN, q_CN):
    """q_BC (4,), the error that a law turns by: all four numbers, since a law tells q from -q."""
    return frames.multiply(q_BN, frames.conjugate(q_CN))


@pytest.mark.parametrize("frame", [None, "ned", "lvlh", "eci"])
@pytest.mark.parametrize("shown", ["ATTITUDE_QUATERNION", "HIL_STATE_QUATERNION"])
def test_what_was_shown_and_is_sent_back_commands_no_rotation(settings, rng, frame, shown):
    open_ = replace(settings, allow=["attitude"], point=POINT)
    station = Station(open_ if frame is None else orbiting(open_, frame=frame))
    for q in ATTITUDES:
        q_BN = frames.unit(q)
        drawn = values(rng, orbit=frame is not None) | {"attitude": q_BN, "true_attitude": q_BN}
        station.show(drawn, t=50.0)
        heard = station.ask_for(getattr(mavlink, f"MAVLINK_MSG_ID_{shown}"))
        sent_back = heard.attitude_quaternion if shown[0] == "H" else [heard.q1, heard.q2, heard.q3, heard.q4]
        assert sent_back[0] >= 0
        for sign in (1.0, -1.0):  # both are the same attitude
            station.send(target(sign * np.array(sent_back)))
            assert np.abs(error(q_BN, commanded(station)) - [1.0, 0.0, 0.0, 0.0]).max() < SINGLE


def test_the_target_is_the_nearer_of_two(settings, rng):
    station = Station(replace(settings, allow=["attitude"], point=POINT))
    for _ in range(50):
        drawn = values(rng)
        station.show(drawn)
        station.now += 10.0
        station.vehicle.tick(station.now)  # the target before has timed out
        q_CN = frames.unit(rng.normal(size=4))
        station.send(target(q_CN))
        assert error(drawn["attitude"], commanded(station))[0] >= 0  # at most half a revolution
        assert np.abs(matrix(commanded(station)) - matrix(q_CN)).max() < 3e-6


def test_noise_half_a_revolution_away_does_not_toss_the_sign(settings, rng):
    """The body must leave the neighbourhood of half a revolution first; then the short way is the other one."""
    station = Station(replace(settings, allow=["attitude"], point=POINT))
    drawn = values(rng)
    told = []
    for angle in [*rng.normal(np.pi, 0.02, size=40), np.pi + 0.3]:
        q_BN = [np.cos(angle / 2), np.sin(angle / 2), 0.0, 0.0]
        station.show(drawn | {"attitude": np.array(q_BN)})
        station.send(target([1.0, 0.0, 0.0, 0.0]))
        told.append(commanded(station)[0])
    assert len(set(told[:-1])) == 1
    assert told[-1] == -1.0  # cos(angle/2) < 0


def test_without_an_estimate_the_true_attitude_decides_and_without_both_nothing(settings, rng):
    roles = {k: n for k, n in ROLES.items() if k != "attitude"}
    station = Station(replace(settings, columns=columns(roles), allow=["attitude"], point=POINT))
    drawn = {k: v for k, v in values(rng).items() if k != "attitude"} | {"true_attitude": np.array([-1.0, 0, 0, 0])}
    station.show(drawn)
    station.send(target([1.0, 0.0, 0.0, 0.0]))
    assert commanded(station)[0] == -1.0
    station = Station(replace(settings, columns=[("rate", 0, 3)], allow=["attitude"], point=POINT))
    station.show([0.0, 0.0, 0.0])
    station.send(target([-0.6, 0.8, 0.0, 0.0]))
    assert commanded(station) == pytest.approx([-0.6, 0.8, 0.0, 0.0], abs=1e-7)


def test_a_run_in_which_what_is_shown_is_sent_back():
    """A body at rest, with q_0 < 0: at the first point of the command the law's error is no rotation, with its sign."""

    class Still:
        def build(self):
            system = SYSTEMS["full-state-pd"].build()
            system.set("plant.q_BN", [-0.5, 0.5, 0.5, 0.5])
            system.set("plant.omega_BN_B", [0.0, 0.0, 0.0])
            system.set("tracker.half_angle", 0.0)
            return system

    def work(pilot):
        pilot.result_of(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0)
        until(lambda: pilot.station.count("ATTITUDE_QUATERNION") > 3)
        for _ in range(3):
            shown = [m for m in pilot.station.listen() if m.get_type() == "ATTITUDE_QUATERNION"][-1]
            pilot.send(target([shown.q1, shown.q2, shown.q3, shown.q4]))
        until(lambda: "Attitude target taken" in pilot.texts())

    result, _, _ = flown(work, stop_time=6.0, speed=2.0, entry=Still())
    commands = result.manifest["commands"]
    engaged = next(c[0] for c in commands if c[1:3] == ["commanded_reference.engaged", 1])
    row = round(engaged / 0.01)
    assert result["plant.q_BN"][row][0] < 0
    assert result["controller.q_BR"][row][0] > 0.99  # not 1: the body drifts while the message is on its way
