"""Attitude errors of recorded trajectories, for whole arrays at once.

Quaternions are scalar first, shape (..., 4); `C(q)` maps inertial to body components; `q_BR` is the attitude of B
relative to R, `C(q_BR) = C(q_BN) C(q_RN)^T`. This is post-processing: nothing here is integrated.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def direction_cosines(q: ArrayLike) -> Array:
    """`C(q) = (q0^2 - |qv|^2) I + 2 qv qv^T - 2 q0 S(qv)`, shape (..., 3, 3)."""
    q = np.asarray(q, dtype=float)
    scalar, vector = q[..., :1, None], q[..., 1:]
    square = np.sum(vector**2, axis=-1)[..., None, None]
    outer = vector[..., :, None] * vector[..., None, :]
    matrix: Array = (scalar**2 - square) * np.eye(3) + 2 * outer - 2 * scalar * skew(vector)
    return matrix


def skew(v: ArrayLike) -> Array:
    """`S(v)` with `S(v) w = v x w`, shape (..., 3, 3)."""
    return -np.cross(np.asarray(v, dtype=float)[..., None, :], np.eye(3))


def relative_quaternion(q_BN: ArrayLike, q_RN: ArrayLike) -> Array:
    """`q_BR` (..., 4) from `q_BN` and `q_RN`: attitude of B relative to R, without change of sign."""
    b, r = np.asarray(q_BN, dtype=float), np.asarray(q_RN, dtype=float)
    scalar = np.sum(b * r, axis=-1, keepdims=True)
    vector = r[..., :1] * b[..., 1:] - b[..., :1] * r[..., 1:] + np.cross(b[..., 1:], r[..., 1:])
    return np.concatenate([scalar, vector], axis=-1)


def rotate(q: ArrayLike, v: ArrayLike) -> Array:
    """`C(q) v` for each sample, shape (..., 3)."""
    turned: Array = np.einsum("...ij,...j->...i", direction_cosines(q), np.asarray(v, dtype=float))
    return turned


def rate_error(omega_BN_B: ArrayLike, q_BR: ArrayLike, omega_RN_R: ArrayLike) -> Array:
    """`omega_BR_B = omega_BN_B - C(q_BR) omega_RN_R` [rad/s], in B, shape (..., 3)."""
    return np.asarray(omega_BN_B, dtype=float) - rotate(q_BR, omega_RN_R)


def norm(v: ArrayLike) -> Array:
    """Euclidean norm along the last axis."""
    return np.asarray(np.linalg.norm(np.asarray(v, dtype=float), axis=-1), dtype=float)


def rms(v: ArrayLike) -> float:
    """Root of the mean square of all values."""
    return float(np.sqrt(np.mean(np.square(np.asarray(v, dtype=float)))))


def settling_time(time: ArrayLike, values: ArrayLike, threshold: float) -> float:
    """First recorded time from which on `values` (N,) stay at or below `threshold` to the end; NaN if they do not."""
    time, values = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
    above = np.flatnonzero(~(values <= threshold))  # a NaN counts as above
    if not above.size:
        return float(time[0])
    return float(time[above[-1] + 1]) if above[-1] + 1 < len(time) else float("nan")
