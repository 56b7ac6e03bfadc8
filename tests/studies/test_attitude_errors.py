"""Against SciPy's rotations, an independent implementation (scalar last, active)."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from adcs.library import attitude

RANDOM = np.random.default_rng(7)


def quaternions(count: int = 20) -> np.ndarray:
    q = RANDOM.normal(size=(count, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def scipy_rotation(q: np.ndarray) -> Rotation:
    """The rotation whose inverse maps inertial to body components."""
    return Rotation.from_quat(q[..., [1, 2, 3, 0]])


def test_direction_cosines_map_inertial_to_body() -> None:
    q = quaternions()
    expected = scipy_rotation(q).inv().as_matrix()
    np.testing.assert_allclose(attitude.direction_cosines(q), expected, atol=1e-14)


def test_a_turn_about_z_brings_x_to_minus_y() -> None:
    """B turned by +90 deg about z: what is along x of N is along -y of B."""
    q = np.array([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    np.testing.assert_allclose(attitude.rotate(q, [1.0, 0.0, 0.0]), [0, -1, 0], atol=1e-15)


def test_relative_quaternion() -> None:
    q_BN, q_RN = quaternions(), quaternions()
    q_BR = attitude.relative_quaternion(q_BN, q_RN)
    expected = (scipy_rotation(q_RN).inv() * scipy_rotation(q_BN)).as_quat()[:, [3, 0, 1, 2]]
    sign = np.sign(np.sum(expected * q_BR, axis=1, keepdims=True))
    np.testing.assert_allclose(q_BR, sign * expected, atol=1e-14)
    product = attitude.direction_cosines(q_BN) @ attitude.direction_cosines(q_RN).transpose(0, 2, 1)
    np.testing.assert_allclose(attitude.direction_cosines(q_BR), product, atol=1e-14)


def test_relative_quaternion_keeps_its_sign() -> None:
    q = quaternions(1)[0]
    np.testing.assert_allclose(attitude.relative_quaternion(q, q), [1, 0, 0, 0], atol=1e-15)
    np.testing.assert_allclose(attitude.relative_quaternion(-q, q), [-1, 0, 0, 0], atol=1e-15)


def test_skew() -> None:
    v, w = RANDOM.normal(size=(2, 5, 3))
    np.testing.assert_allclose(np.einsum("nij,nj->ni", attitude.skew(v), w), np.cross(v, w), atol=1e-15)


def test_rate_error_is_the_rate_of_the_relative_attitude() -> None:
    """qBR' = 1/2 E(qBR) omega_BR, by central differences of two attitudes turning at constant rates."""
    q_BN, q_RN = quaternions(2)
    omega_B, omega_R = np.array([0.3, -0.2, 0.5]), np.array([-0.1, 0.4, 0.2])
    h = 1e-5

    def turned(q: np.ndarray, omega: np.ndarray, time: float) -> np.ndarray:
        last = (scipy_rotation(q) * Rotation.from_rotvec(omega * time)).as_quat()[[3, 0, 1, 2]]
        return last * np.sign(last @ q)

    def relative(time: float) -> np.ndarray:
        return attitude.relative_quaternion(turned(q_BN, omega_B, time), turned(q_RN, omega_R, time))

    rate = (relative(h) - relative(-h)) / (2 * h)
    q = relative(0.0)
    omega = attitude.rate_error(omega_B, q, omega_R)
    expected = 0.5 * np.concatenate([[-q[1:] @ omega], q[0] * omega + np.cross(q[1:], omega)])
    np.testing.assert_allclose(rate, expected, atol=1e-9)


def test_norm_and_rms() -> None:
    np.testing.assert_allclose(attitude.norm([[3.0, 4.0, 0.0], [0.0, 0.0, 2.0]]), [5, 2])
    assert attitude.rms([3.0, 4.0]) == pytest.approx(np.sqrt(12.5))


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([3, 2, 1, 0.5], 2.0),  # at the threshold counts as below
        ([3, 0.5, 2, 0.5], 3.0),  # the last crossing counts
        ([0.1, 0.2, 0.3, 0.4], 0.0),
        ([3, 2, 1, 2], np.nan),
        ([3, np.nan, 0.5, 0.5], 2.0),
        ([0.5, 0.5, 0.5, np.nan], np.nan),
    ],
)
def test_settling_time(values: list[float], expected: float) -> None:
    np.testing.assert_equal(attitude.settling_time([0.0, 1.0, 2.0, 3.0], values, 1.0), expected)
