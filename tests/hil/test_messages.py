"""Every field that an autopilot is told, against recomputations of its own; and the numbers that do not fit."""

from dataclasses import replace
from datetime import UTC, datetime
from math import atan2, cos, degrees, hypot, pi, radians, sin, sqrt

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink
from scipy.spatial.transform import Rotation

from adcs import AdcsError, System
from adcs.library.hardware.systems import hil_spacecraft
from hil_bridge.frames import Earth, Geodetic, Place
from hil_bridge.hil.field import MagneticField
from hil_bridge.hil.messages import Messages, Moment, frame
from hil_bridge.hil.wiring import Wiring

WIRING = Wiring.find(hil_spacecraft())
EPOCH = datetime(2026, 1, 1)
STILL = np.array([1.0, 0.0, 0.0, 0.0])


def received(data: bytes) -> mavlink.MAVLink_message:
    (message,) = mavlink.MAVLink(None).parse_buffer(data)
    return message


def unit(q: np.ndarray) -> np.ndarray:
    return q / np.linalg.norm(q)


def moment(rng: np.random.Generator, name: str = "ned") -> Moment:
    """Some point of some orbit."""
    r_N = unit(rng.normal(size=3)) * rng.uniform(6.6e6, 8.0e6)
    v_N = np.cross(rng.normal(size=3), r_N) * 1e-3
    place = Earth(EPOCH).place(rng.uniform(0, 1e5), r_N, v_N)
    values = {
        WIRING.attitude: unit(rng.normal(size=4)),
        WIRING.rate: rng.normal(size=3) * 0.1,
        WIRING.gyro: rng.normal(size=3) * 0.1,
        WIRING.accelerometer: rng.normal(size=3) * 0.1,
        WIRING.magnetometer: rng.normal(size=3) * 3e-5,
        WIRING.star_tracker: unit(rng.normal(size=4)),
        WIRING.position: r_N,
        WIRING.velocity: v_N,
    }
    return Moment(1_004_000, values, place, frame(name, place, r_N, v_N))


def single(x: float) -> float:
    return float(np.float32(x))


def test_sensors() -> None:
    for seed in range(5):
        now = moment(np.random.default_rng(seed))
        heard = received(Messages(WIRING).sensors(now))
        assert (heard.time_usec, heard.id, heard.fields_updated) == (1_004_000, 0, 0b111111111)
        assert [heard.xgyro, heard.ygyro, heard.zgyro] == list(map(single, now.values[WIRING.gyro]))
        assert [heard.xacc, heard.yacc, heard.zacc] == list(map(single, now.values[WIRING.accelerometer]))
        gauss = 1e4 * now.values[WIRING.magnetometer]
        np.testing.assert_allclose([heard.xmag, heard.ymag, heard.zmag], gauss, rtol=1e-6)


def test_sensors_that_are_not_there_are_not_said_to_be_updated() -> None:
    wiring = Wiring("p.q_BN", "p.omega_BN_B", "g.omega_BN_B_meas", "p.torque_B")
    values = {"g.omega_BN_B_meas": np.array([0.1, 0.2, 0.3])}
    heard = received(Messages(wiring).sensors(Moment(1, values, None, STILL)))
    assert heard.fields_updated == 0b000111000
    assert heard.xmag == heard.xacc == heard.abs_pressure == 0.0


@pytest.mark.parametrize("name", ["ned", "lvlh", "eci"])
def test_attitudes_turn_from_body_to_the_frame(name: str) -> None:
    """A vector fixed in the body, taken to the frame by the quaternion of the message and by SciPy."""
    for seed in range(10):
        now = moment(np.random.default_rng(seed), name)
        assert now.place is not None
        r_N, v_N = now.values[WIRING.position], now.values[WIRING.velocity]
        down = -r_N / np.linalg.norm(r_N)
        if name == "eci":
            axes = np.eye(3)
        elif name == "lvlh":
            across = unit(np.cross(v_N, r_N))
            axes = np.array([np.cross(across, down), across, down])
        else:
            axes = now.place.C_FN  # of hil_bridge.frames, which has tests of its own
            assert degrees(np.arccos(axes[2] @ down)) < 0.2, "down is down"
        x_B = np.array([0.3, -0.5, 0.8])
        for variable, heard in (
            (WIRING.attitude, received(Messages(WIRING).truth(now)).attitude_quaternion),
            (WIRING.star_tracker, received(Messages(WIRING).star_tracker(now)).q),
        ):
            x_N = Rotation.from_quat(now.values[variable], scalar_first=True).apply(x_B)
            np.testing.assert_allclose(Rotation.from_quat(heard, scalar_first=True).apply(x_B), axes @ x_N, atol=1e-6)


def test_truth() -> None:
    now = moment(np.random.default_rng(1))
    assert now.place is not None
    heard = received(Messages(WIRING).truth(now))
    assert [heard.rollspeed, heard.pitchspeed, heard.yawspeed] == list(map(single, now.values[WIRING.rate]))
    where = now.place.geodetic
    assert abs(heard.lat - 1e7 * degrees(where.latitude)) <= 0.5
    assert abs(heard.lon - 1e7 * degrees(where.longitude)) <= 0.5
    assert abs(heard.alt - 1e3 * where.height) <= 0.5
    assert (heard.xacc, heard.yacc, heard.zacc) == (0, 0, 0), "free fall, whatever the accelerometer measures"


def test_the_true_specific_force_is_what_the_accelerometer_is_fed() -> None:
    """A constant, an output, or neither; never the measurement with its bias and noise."""
    now = moment(np.random.default_rng(1))
    system = hil_spacecraft()
    system.set("imu.specific_force_B", (0.98, -1.96, 4.9))
    pushed = received(Messages(Wiring.find(system)).truth(now))
    assert (pushed.xacc, pushed.yacc, pushed.zacc) == (100, -200, 500)  # mG, to the nearest
    wiring = replace(WIRING, specific_force="a.specific_force_B")
    felt = now.values | {"a.specific_force_B": np.array([-9.80665, 0.0, 1.0])}
    heard = received(Messages(wiring).truth(replace(now, values=felt)))
    assert (heard.xacc, heard.yacc, heard.zacc) == (-1000, 0, 102)
    assert "a.specific_force_B" in wiring.outputs


def test_signs_of_quaternions_do_not_jump() -> None:
    """The body turns on through 180 deg, and the frame's quaternion changes its sign: what is told changes smoothly."""
    messages, before = Messages(WIRING), None
    values = moment(np.random.default_rng(2)).values
    for angle in np.linspace(0.0, 4 * pi, 200):
        q_BN = np.array([cos(angle / 2), sin(angle / 2), 0.0, 0.0])
        sign = -1.0 if int(angle * 10) % 2 else 1.0  # both are the same attitude
        now = Moment(1, values | {WIRING.attitude: q_BN, WIRING.star_tracker: sign * q_BN}, None, sign * STILL)
        told = np.array([received(messages.truth(now)).attitude_quaternion, received(messages.star_tracker(now)).q])
        assert before is None or np.abs(told - before).max() < 0.04
        assert before is not None or (told[:, 0] > 0).all()
        before = told


def test_gps_agrees_with_geometry() -> None:
    """From latitude, longitude and height back to the position, by the ellipsoid's equations."""
    for seed in range(5):
        now = moment(np.random.default_rng(seed))
        assert now.place is not None
        heard = received(Messages(WIRING).gps(now))
        a, f = 6378137.0, 1 / 298.257223563
        e2 = f * (2 - f)
        lat, lon, height = radians(heard.lat * 1e-7), radians(heard.lon * 1e-7), heard.alt * 1e-3
        n = a / sqrt(1 - e2 * sin(lat) ** 2)
        r_E = [
            (n + height) * cos(lat) * cos(lon),
            (n + height) * cos(lat) * sin(lon),
            (n * (1 - e2) + height) * sin(lat),
        ]
        assert np.linalg.norm(r_E) == pytest.approx(np.linalg.norm(now.values[WIRING.position]), abs=0.05)
        north, east, _ = now.place.velocity_ned
        assert heard.vel == 65535, "orbital speed does not fit, so it is unknown"
        assert (heard.cog / 100 - degrees(atan2(east, north))) % 360 == pytest.approx(0, abs=0.006) or (
            (heard.cog / 100 - degrees(atan2(east, north))) % 360 > 359.99
        )
        assert hypot(north, east) > 655.35
        assert heard.fix_type == 3


def test_numbers_that_do_not_fit_are_clamped() -> None:
    high = Place(Geodetic(pi / 2, pi, 3e6), np.array([7600.0, -7600.0, 10.0]), np.eye(3))
    now = Moment(2**40, moment(np.random.default_rng(0)).values, high, STILL)
    pushed = replace(WIRING, constant_force=(1e6, -1e6, 0.0))
    truth, gps = received(Messages(pushed).truth(now)), received(Messages(WIRING).gps(now))
    assert (truth.xacc, truth.yacc) == (32767, -32767)
    assert truth.alt == gps.alt == 2**31 - 1
    assert (truth.vx, truth.vy, truth.vz) == (gps.vn, gps.ve, gps.vd) == (32767, -32767, 1000)
    assert (truth.lat, truth.lon, truth.time_usec) == (900_000_000, 1_800_000_000, 2**40)


def test_slow_ground_speeds_are_said() -> None:
    slow = Place(Geodetic(0.1, 0.2, 100.0), np.array([3.0, 4.0, -1.0]), np.eye(3))
    heard = received(Messages(WIRING).gps(Moment(1, moment(np.random.default_rng(0)).values, slow, STILL)))
    assert (heard.vel, heard.vn, heard.ve, heard.vd, heard.cog) == (500, 300, 400, -100, 5313)


def test_sequence_numbers_run_on() -> None:
    messages, now = Messages(WIRING), moment(np.random.default_rng(0))
    heard = [received(messages.sensors(now)).get_seq() for _ in range(300)]
    assert heard == [k % 256 for k in range(300)]


# --- the magnetic field -----------------------------------------------------------------------------------------------

# The test values published with WMM2025: year, height [km], latitude, longitude [deg]; X, Y, Z [nT].
PUBLISHED = [
    (2025.0, 0, 80, 0, 6521.6, 145.9, 54791.5),
    (2025.0, 0, 0, 120, 39677.8, -109.6, -10580.2),
    (2025.0, 100, -80, 240, 5907.6, 14780.3, -49540.7),
    (2027.5, 0, 80, 0, 6500.8, 294.5, 54869.4),
]


@pytest.mark.parametrize(("year", "height", "latitude", "longitude", "x", "y", "z"), PUBLISHED)
def test_field_of_the_world_magnetic_model(
    year: float, height: float, latitude: float, longitude: float, x: float, y: float, z: float
) -> None:
    epoch = datetime(2025, 1, 1, tzinfo=UTC) if year == 2025.0 else datetime(2027, 7, 2, 12, tzinfo=UTC)
    turn = Rotation.random(random_state=3).as_matrix()  # of NED relative to N
    place = Place(Geodetic(radians(latitude), radians(longitude), 1e3 * height), np.zeros(3), turn)
    field_N = MagneticField(Earth(epoch)).at(0.0, place)
    np.testing.assert_allclose(turn @ field_N * 1e9, [x, y, z], atol=0.06)


def dipole_angles(turned: bool) -> np.ndarray:
    """Angles in degrees at 50 places in orbit between the field and a dipole tilted as in 2025."""
    g = 1e-9 * np.array([-1410.3, 4545.5, -29350.0])  # Gauss coefficients g11, h11, g10
    earth = Earth(EPOCH)
    field = MagneticField(earth)
    rng = np.random.default_rng(2)
    angles = []
    for t in rng.uniform(0, 86400, 50):
        r_N = unit(rng.normal(size=3)) * 7e6
        C_NE = earth.C_EN(t).T
        along = unit(r_N)
        axis = C_NE @ g if not turned else C_NE.T @ g
        dipole_N = (6371.2e3 / 7e6) ** 3 * (3 * (axis @ along) * along - axis)
        seen = field.at(t, earth.place(t, r_N, np.zeros(3)))
        assert turned or 0.5 < np.linalg.norm(seen) / np.linalg.norm(dipole_N) < 1.5
        angles.append(degrees(np.arccos(unit(seen) @ unit(dipole_N))))
    return np.array(angles)


def test_field_in_orbit_is_near_that_of_a_dipole() -> None:
    """The rest of the field turns it by 8 degrees on average; the Earth turned backwards would turn it by more."""
    right, wrong = dipole_angles(False), dipole_angles(True)
    assert right.mean() < 10
    assert right.max() < 40
    assert wrong.mean() > 1.5 * right.mean()


@pytest.mark.filterwarnings("ignore:ERFA function")
def test_an_epoch_without_a_model_is_refused() -> None:
    with pytest.raises(AdcsError, match="epoch 2031-01-01: the magnetic field model WMM2025 holds from 2025 to 2029"):
        MagneticField(Earth(datetime(2031, 1, 1)))


# --- which variables --------------------------------------------------------------------------------------------------


def test_the_variables_of_the_spacecraft() -> None:
    assert (
        Wiring(
            attitude="plant.q_BN",
            rate="plant.omega_BN_B",
            gyro="imu.omega_BN_B_meas",
            torque="actuator.torque_command_B",
            accelerometer="imu.specific_force_B_meas",
            magnetometer="magnetometer.magnetic_field_B_meas",
            magnetic_field="magnetometer.magnetic_field_N",
            position="orbit.r_ON_N",
            velocity="orbit.v_ON_N",
            star_tracker="tracker.q_BN_meas",
        )
        == WIRING
    )


def bare(gyro: bool = True, fed: bool = False) -> System:
    system = System("bare")
    system.add("body", "RigidBody", {"torque_disturbance_B": [0, 0, 0]})
    if gyro:
        system.add("gyro", "InertialMeasurementUnit")
        system.connect("body.omega_BN_B", "gyro.omega_BN_B")
    if fed:
        system.connect("body.H_N", "body.torque_B", factor=1.0)
    return system


@pytest.mark.parametrize(
    ("system", "torque", "message"),
    [
        (bare(gyro=False), None, "no output is called omega_BN_B_meas .*InertialMeasurementUnit.*hil-spacecraft can"),
        (bare(fed=True), None, "there is no free input torque_command_B or torque_B; nothing feeds body.torque_dist"),
        (
            bare(),
            "body.torque",
            "--torque body.torque: expected an input of 3 values that nothing feeds; nothing feeds",
        ),
    ],
)
def test_systems_that_cannot_be_flown(system: System, torque: str | None, message: str) -> None:
    with pytest.raises(AdcsError, match=message):
        Wiring.find(system, torque)


def test_any_free_input_may_take_the_torque() -> None:
    assert Wiring.find(bare(), "body.torque_disturbance_B").torque == "body.torque_disturbance_B"
    assert Wiring.find(bare()).torque == "body.torque_B"
