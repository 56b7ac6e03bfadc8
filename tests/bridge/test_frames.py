"""Frames against other formulations: SciPy's rotations, Bowring's latitude, geometry, rates by differences."""

from datetime import UTC, datetime
from math import cos, degrees, pi, radians, sin

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hil_bridge import frames
from hil_bridge.frames import Earth, Geodetic

from .ground import matrix

A, F = 6378137.0, 1 / 298.257223563  # WGS 84


def quaternions(n=50, seed=1):
    rng = np.random.default_rng(seed)
    q = rng.normal(size=(n, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def body_to_frame(q):
    """MAVLink's and SciPy's reading: the rotation from body to reference."""
    return Rotation.from_quat(q, scalar_first=True)


def test_quaternions_of_matrices_and_products():
    for q, p in zip(quaternions(), quaternions(seed=2), strict=True):
        found = frames.quaternion(matrix(q))
        assert np.allclose(found, q * np.sign(q[0]), rtol=0, atol=1e-14)
        assert np.allclose(matrix(frames.multiply(q, p)), matrix(q) @ matrix(p), rtol=0, atol=1e-14)
        assert np.allclose(frames.multiply(q, frames.conjugate(q)), [1, 0, 0, 0], rtol=0, atol=1e-15)


@pytest.mark.parametrize("axis", range(3))
def test_half_turns_have_quaternions(axis):
    expected = np.insert(np.zeros(3), axis, 1.0)
    assert np.array_equal(np.abs(frames.quaternion(matrix([0.0, *expected[:3]]))), [0.0, *expected[:3]])


def test_euler_angles_turn_about_z_then_y_then_x():
    for q in quaternions():
        yaw, pitch, roll = body_to_frame(q).as_euler("ZYX")
        assert np.allclose(frames.euler(q), [roll, pitch, yaw], rtol=0, atol=1e-12)


@pytest.mark.parametrize("pitch", [pi / 2, -pi / 2])
def test_straight_up_and_down_have_euler_angles_too(pitch):
    q = Rotation.from_euler("ZYX", [0.4, pitch, 0.1]).as_quat(scalar_first=True)
    roll, found, yaw = frames.euler(q)
    again = Rotation.from_euler("ZYX", [yaw, found, roll])
    assert found == pitch
    assert (again * body_to_frame(q).inv()).magnitude() < 1e-7


def test_rodrigues_parameters():
    for q in quaternions():
        sigma = body_to_frame(q).as_mrp()
        found = frames.from_mrp(sigma)
        assert min(np.abs(found - q).max(), np.abs(found + q).max()) < 1e-14


def test_the_angle_of_a_rotation():
    for q in quaternions():
        assert frames.rotation_angle(q) == pytest.approx(body_to_frame(q).magnitude(), abs=1e-14)


def test_geodetic_places_go_there_and_back():
    rng = np.random.default_rng(3)
    for _ in range(50):
        place = Geodetic(rng.uniform(-1.57, 1.57), rng.uniform(-3.1, 3.1), rng.uniform(-100, 4e7))
        r = frames.position_of(place)
        e2 = F * (2 - F)
        n = A / np.sqrt(1 - e2 * sin(place.latitude) ** 2)
        expected = (n + place.height) * cos(place.latitude)
        assert np.allclose(r[:2], [expected * cos(place.longitude), expected * sin(place.longitude)], rtol=1e-14)
        assert r[2] == pytest.approx((n * (1 - e2) + place.height) * sin(place.latitude), rel=1e-13)
        again = frames.geodetic_of(r)
        assert again.latitude == pytest.approx(place.latitude, abs=1e-10)  # one step of Fukushima: < 1 mm
        assert again.longitude == pytest.approx(place.longitude, abs=1e-12)
        assert again.height == pytest.approx(place.height, abs=1e-6)


def test_north_east_and_down_are_where_they_should_be():
    """Down is against the change of position with height; north and east are its changes with latitude, longitude."""
    for latitude, longitude in ((0.3, -2.0), (-1.2, 3.0), (0.0, 0.0), (1.5, 1.0)):
        C = frames.ned(latitude, longitude)
        assert np.allclose(C @ C.T, np.eye(3), rtol=0, atol=1e-15)
        assert np.linalg.det(C) == pytest.approx(1.0)

        def r(dlat=0.0, dlon=0.0, h=0.0, latitude=latitude, longitude=longitude):
            return frames.position_of(Geodetic(latitude + dlat, longitude + dlon, h))

        for row, step in ((0, r(dlat=1e-6) - r(dlat=-1e-6)), (1, r(dlon=1e-6) - r(dlon=-1e-6)), (2, r() - r(h=1.0))):
            assert np.allclose(C[row], step / np.linalg.norm(step), rtol=0, atol=2e-9)


def test_the_orbit_frame():
    r, v = np.array([7e6, 0, 0]), np.array([100.0, 7500.0, 0])
    C = frames.lvlh(r, v)
    assert np.allclose(C @ C.T, np.eye(3), rtol=0, atol=1e-15)
    assert np.allclose(C @ r, [0, 0, -7e6])  # z to the Earth
    assert (C @ v)[0] > 7000  # x along the track
    assert np.allclose(C @ np.cross(r, v), [0, -5.25e10, 0])  # y against the normal


def test_the_earth_turns_and_the_pole_hardly_moves():
    earth = Earth(datetime(2026, 1, 1, tzinfo=UTC))
    C = earth.C_EN(0.0)
    assert np.allclose(C @ C.T, np.eye(3), rtol=0, atol=1e-14)
    assert degrees(np.arccos(C[2, 2])) < 0.2  # 26 years of precession, 20 arc seconds a year
    later = earth.C_EN(100.0) @ C.T
    angle = np.arctan2(later[0, 1], later[0, 0])
    assert angle == pytest.approx(100 * frames.EARTH_RATE, rel=2e-6)  # stellar against sidereal day
    day = earth.C_EN(86164.0905) @ C.T  # a sidereal day later
    assert np.abs(day - np.eye(3)).max() < 1e-4


def test_greenwich_is_where_the_almanac_has_it():
    """Mean sidereal time at 2026-01-01 0 h UT1, 6 h 42 min 20 s by the formula of 1982: its independent polynomial."""
    earth = Earth(datetime(2026, 1, 1, tzinfo=UTC))
    days = (datetime(2026, 1, 1, tzinfo=UTC) - datetime(2000, 1, 1, 12, tzinfo=UTC)).total_seconds() / 86400
    T = days / 36525
    gmst = (24110.54841 + 8640184.812866 * T + 0.093104 * T**2 - 6.2e-6 * T**3) % 86400 / 86400 * 2 * pi
    x = earth.C_EN(0.0).T @ [1.0, 0.0, 0.0]  # Greenwich meridian in the celestial frame of J2000
    precession = radians(4612.156534 / 3600) * T  # in right ascension, to the equinox of date
    assert (np.arctan2(x[1], x[0]) + precession) % (2 * pi) == pytest.approx(gmst, abs=radians(0.01))


def test_velocity_over_the_ground_by_differences():
    earth = Earth(datetime(2026, 3, 1, 7, 30))
    r, v = np.array([6.8e6, 1e5, -3e5]), np.array([300.0, 5300.0, 5300.0])
    place = earth.place(10.0, r, v)
    dt = 1e-3
    before, after = (earth.C_EN(10.0 + s * dt) @ (r + s * dt * v) for s in (-1, 1))
    expected = frames.ned(place.geodetic.latitude, place.geodetic.longitude) @ ((after - before) / (2 * dt))
    assert np.allclose(place.velocity_ned, expected, rtol=0, atol=2e-4)
    assert np.allclose(place.C_FN @ place.C_FN.T, np.eye(3), rtol=0, atol=1e-14)


def test_a_geostationary_satellite_stands_still():
    earth = Earth(datetime(2026, 1, 1))
    w, radius = frames.EARTH_RATE, 42164172.0
    C = earth.C_EN(0.0)
    r_N = C.T @ [radius, 0, 0]
    v_N = C.T @ [0, w * radius, 0]
    place = earth.place(0.0, r_N, v_N)
    assert np.abs(place.velocity_ned).max() < 1e-6
    assert abs(place.geodetic.latitude) < 1e-12
    assert place.geodetic.height == pytest.approx(radius - A)


def test_unix_time():
    assert Earth(datetime(1970, 1, 2)).unix_time(0.25) == 86400.25
