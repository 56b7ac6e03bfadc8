"""What a ground station reads is what the simulation has, in float32 and in the frame asked for; nothing overflows."""

from dataclasses import replace
from math import degrees, inf, nan, pi

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink
from scipy.spatial.transform import Rotation

from adcs import AdcsError
from hil_bridge.frames import Earth, lvlh
from hil_bridge.ground.events import Limits, Watch
from hil_bridge.ground.settings import Snapshot
from hil_bridge.ground.telemetry import MESSAGES
from hil_bridge.wire import clamped, milliseconds, texts

from .ground import Ground, Station, columns, orbiting, values


def rotation(q):
    return Rotation.from_quat(q, scalar_first=True)


def closeness(found, expected):
    """Angle between two attitudes [rad]."""
    return (found * expected.inv()).magnitude()


def test_attitude_is_that_of_the_simulation(station, rng):
    drawn = values(rng)
    station.show(drawn, t=12.345)
    quaternion = station.ask_for(mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION)
    assert quaternion.time_boot_ms == 12345
    q = [quaternion.q1, quaternion.q2, quaternion.q3, quaternion.q4]
    assert np.allclose(q, drawn["attitude"] * np.sign(drawn["attitude"][0]), rtol=0, atol=6e-8)
    rates = [quaternion.rollspeed, quaternion.pitchspeed, quaternion.yawspeed]
    assert np.allclose(rates, drawn["rate"], rtol=6e-8)
    euler = station.ask_for(mavlink.MAVLINK_MSG_ID_ATTITUDE)
    found = Rotation.from_euler("ZYX", [euler.yaw, euler.pitch, euler.roll])
    assert closeness(found, rotation(drawn["attitude"])) < 1e-6
    target = station.ask_for(mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET)
    assert closeness(rotation(target.q), rotation(drawn["reference"])) < 1e-6
    assert target.body_pitch_rate == pytest.approx(drawn["reference_rate"][1], rel=6e-8)
    truth = station.ask_for(mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION)
    assert closeness(rotation(truth.attitude_quaternion), rotation(drawn["true_attitude"])) < 1e-6
    torque = station.ask_for(mavlink.MAVLINK_MSG_ID_ACTUATOR_OUTPUT_STATUS)
    assert np.allclose(torque.actuator[:3], drawn["torque"], rtol=6e-8)


@pytest.mark.parametrize("frame", ["ned", "lvlh", "eci"])
def test_attitude_in_each_frame(settings, rng, frame):
    """By rotation matrices: C_BF = C_BN C_FN^T."""
    station = Station(orbiting(settings, frame=frame))
    drawn = values(rng, orbit=True)
    station.show(drawn, t=100.0)
    place = Earth(station.vehicle.settings.start_of_time).place(100.0, drawn["position"], drawn["velocity"])
    C_FN = {"ned": place.C_FN, "lvlh": lvlh(drawn["position"], drawn["velocity"]), "eci": np.eye(3)}[frame]
    message = station.ask_for(mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION)
    found = rotation([message.q1, message.q2, message.q3, message.q4]).as_matrix()  # body to F
    expected = C_FN @ rotation(drawn["attitude"]).as_matrix()
    assert np.abs(found - expected).max() < 5e-7
    inertial = station.ask_for(mavlink.MAVLINK_MSG_ID_DEBUG_FLOAT_ARRAY)
    assert inertial.name == "q_RN"  # the last of three


def test_place_over_the_earth(settings, rng):
    station = Station(orbiting(settings))
    drawn = values(rng, orbit=True)
    station.show(drawn, t=3600.0)
    place = Earth(station.vehicle.settings.start_of_time).place(3600.0, drawn["position"], drawn["velocity"])
    message = station.ask_for(mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT)
    assert message.lat == round(1e7 * degrees(place.geodetic.latitude))
    assert message.lon == round(1e7 * degrees(place.geodetic.longitude))
    assert message.alt == round(1e3 * place.geodetic.height)
    assert (message.vx, message.vy) == tuple(32767 * np.sign(place.velocity_ned[:2]))  # 7.6 km/s in 327 m/s
    local = station.ask_for(mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED)
    assert np.allclose([local.vx, local.vy, local.vz], place.velocity_ned, rtol=1e-7, atol=1e-4)
    gps = station.ask_for(mavlink.MAVLINK_MSG_ID_GPS_RAW_INT)
    assert gps.vel == 65535
    course = np.degrees(np.arctan2(place.velocity_ned[1], place.velocity_ned[0])) % 360
    assert gps.cog == round(100 * course)


def test_without_orbit_the_place_is_declared(settings, rng):
    station = Station(replace(settings, position=(52.0, 4.5, 400e3)))
    station.show(values(rng))
    message = station.ask_for(mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT)
    assert (message.lat, message.lon, message.alt, message.vx) == (520000000, 45000000, 400000000, 0)
    assert "No orbit: N is shown as NED at 52, 4.5 deg, 400 km" in "".join(
        m.text
        for m in station.vehicle.banner()  # long texts come in pieces
    )
    with pytest.raises(AdcsError, match="no orbit"):
        Station(replace(settings, frame="lvlh"))


def test_every_message_survives_any_number(settings):
    """Nothing raises, and integers stay at their limits, whatever the simulation comes up with."""
    station = Station(orbiting(settings))
    n = columns({"all": sum(last - first for _, first, last in station.vehicle.settings.columns)})[0][2]
    for extreme in (0.0, 1e300, -1e300, 1e38, 3.5e38, nan, inf, -inf, 1e-320):
        for t in (0.0, 1e6, 4.3e6, 3e9):
            station.show([extreme] * n, t=t)
            for id_ in MESSAGES:
                for message in station.vehicle.report.messages(id_):
                    data = message.pack(mavlink.MAVLink(None))
                    assert Ground().peer.codec.parsed(data, True)[1] == 0


def test_numbers_that_are_none_are_not_shown_as_attitude(station, rng):
    drawn = values(rng) | {"attitude": np.array([nan, 0, 0, 0])}
    station.show(drawn)
    assert station.command(mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION) == 3


@pytest.mark.parametrize(
    ("value", "bits", "expected"),
    [
        (7.6e5, 16, 32767),
        (-7.6e5, 16, -32767),
        (4.2e10, 32, 2147483647),
        (nan, 16, 0),
        (inf, 32, 2147483647),
        (-inf, 32, -2147483647),
        (-0.6, 16, -1),
    ],
)
def test_clamping(value, bits, expected):
    assert clamped(value, bits) == expected


def test_time_since_start_wraps_after_49_days():
    assert milliseconds(4294967.295) == 2**32 - 1
    assert milliseconds(4294967.296) == 0
    assert milliseconds(4294967.296 + 0.5) == 500


def test_long_texts_come_in_pieces(station):
    text = "x" * 49 + "ä" + "y" * 60
    messages = station.vehicle.text(text)
    assert [m.chunk_seq for m in messages] == [0, 1, 2]
    assert len({m.id for m in messages}) == 1 and messages[0].id > 0
    assert b"".join(texts(text)).decode() == text


def test_heartbeat_is_an_orbiter_of_no_known_make(station):
    message = station.vehicle.heartbeat()
    assert (message.type, message.autopilot) == (45, 0)
    assert message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED


def test_wheels(settings):
    station = Station(replace(settings, columns=columns({"wheel_speed": 4})))
    station.show([pi, -2 * pi, 0.0, 1e6])
    found = [m.frequency for m in station.vehicle.report.messages(mavlink.MAVLINK_MSG_ID_RAW_RPM)]
    assert np.allclose(found, [30.0, -60.0, 0.0, 1e6 * 30 / pi])


def test_events_are_told_once(settings):
    station = Station(replace(settings, columns=columns({"attitude_error": 4, "wheel_speed": 2})))
    watch = Watch(Limits(saturated=100.0))

    def said(angle, *speeds, t=0.0):
        values = [np.cos(angle / 2), np.sin(angle / 2), 0.0, 0.0, *speeds]
        return [event.text for event in watch.seen(station.vehicle.scene.at(Snapshot(0, t, values)))]

    assert said(0.1, 0.0, 0.0) == []
    assert said(0.003, 0.0, 0.0, t=2.5) == ["Target acquired at t = 2.5 s, error 0.172 deg"]
    assert said(0.01, 0.0, 0.0) == []
    assert said(0.04, 0.0, -100.0, t=3.0) == [
        "Target lost at t = 3 s, error 2.29 deg",
        "Wheel 2 saturated at t = 3 s",
    ]
    assert said(0.04, 0.0, -99.0) == []
    assert said(0.04, 0.0, -90.0) == []
    assert said(0.04, 0.0, 101.0, t=4.0) == ["Wheel 2 saturated at t = 4 s"]
    assert said(0.04, nan, 0.0, t=5.0) == ["wheel_speed is not a number from t = 5 s"]
    assert said(0.04, nan, 0.0, t=6.0) == []
