"""From where the gyro-free law is sure to converge: the level of Theorem 4.2.3, and the one that holds.

The theorem asks for V(0) < kp sum k, Eq. (4.27). That is not sufficient. With `M0 = sum k_j y_rj y_rj^T`, turn the
body by 180 degrees from the attitude wanted about an eigenvector e of M0 with the eigenvalue l: `ME = (2 e e^T - I) M0`
is symmetric, so Omega = 0; with omega = 0 and z' = 0 there is no torque, and the body stays. There
V = kp (sum k - l) < kp sum k. The proof rules out only that all vectors are reversed at once, which no turn can do.

V cannot grow, and all the attitudes with Omega = 0 but the one wanted are those three (or families of them, where
eigenvalues coincide), so below the lowest of them, `kp (sum k - l_max)`, the proof goes through.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from adcs.library.attitude import direction_cosines
from adcs.library.thakur.gyro_free.settings import DIRECTIONS, INERTIA, K_P, Q_RN, WEIGHTS, Start
from fmus.errors import AdcsError

Rows = Sequence[Sequence[float]]


def printed_level(k_p: float = K_P, weights: Sequence[float] = WEIGHTS) -> float:
    """The right side of Eq. (4.27), kp sum k [N.m]: not sufficient."""
    return k_p * sum(weights)


def sufficient_level(k_p: float = K_P, directions: Rows = DIRECTIONS, weights: Sequence[float] = WEIGHTS) -> float:
    """The level of V(0) [N.m] below which the law converges: `kp (sum k - l_max(M0))`.

    `directions` are those that the sensor sees, (n, 3), in any frame and of any length; `weights` (n,) are the
    k_j >= 0; `k_p` [N.m] is the attitude gain. Raises AdcsError for directions that do not tell the attitude: there
    it is zero.
    """
    x, k = _unit(directions), np.asarray(weights, dtype=float)
    if k.shape != (len(x),) or not np.all(k >= 0):
        raise AdcsError(f"weights {list(weights)}: expected a number >= 0 for each of the {len(x)} directions")
    level = float(k_p * (k.sum() - np.linalg.eigvalsh(np.einsum("j,ja,jb->ab", k, x, x))[-1]))
    if not level > 1e-6 * k_p * k.sum():
        raise AdcsError("directions of positive weight are collinear: give at least two that are not")
    return level


def start_value(
    start: Start | None = None,
    k_p: float = K_P,
    directions: Rows = DIRECTIONS,
    weights: Sequence[float] = WEIGHTS,
    inertia: Rows = INERTIA,
    q_RN: Sequence[float] = Q_RN,
) -> float:
    """V(0) [N.m] of Eq. (4.28) with the filter at rest, to be compared with `sufficient_level`."""
    start = start or Start()
    x, omega = _unit(directions), np.asarray(start.omega_BN_B)
    y, y_r = x @ direction_cosines(start.q_BN).T, x @ direction_cosines(q_RN).T
    apart = 1 - np.sum(y * y_r, axis=1)
    return float(0.5 * omega @ np.asarray(inertia) @ omega + 0.5 * k_p * np.asarray(weights) @ apart)


def resting_attitudes(
    directions: Rows = DIRECTIONS, weights: Sequence[float] = WEIGHTS, q_RN: Sequence[float] = Q_RN
) -> list[tuple[float, tuple[float, ...]]]:
    """The eigenvalues of M0 in ascending order, each with the attitude q_BN, 180 degrees off, at which u = 0."""
    x = _unit(directions)
    values, vectors = np.linalg.eigh(np.einsum("j,ja,jb->ab", np.asarray(weights, dtype=float), x, x))
    r0, r = float(q_RN[0]), np.asarray(q_RN[1:], dtype=float)
    # q_BN = q_BR q_RN with q_BR = (0, e), the axis e in N being the same in R: C_RN e = e' is turned with the vectors
    attitudes = []
    for e in vectors.T:
        a = direction_cosines(q_RN) @ e
        q = np.concatenate([[-a @ r], r0 * a + np.cross(r, a)])
        attitudes.append(tuple((q / np.linalg.norm(q)).tolist()))
    return list(zip(values.tolist(), attitudes, strict=True))


def _unit(directions: Rows) -> NDArray[np.float64]:
    x = np.asarray(directions, dtype=float)
    lengths = np.linalg.norm(x, axis=-1, keepdims=True)
    if x.ndim != 2 or x.shape[-1] != 3 or not np.all(lengths > 0):
        raise AdcsError("directions: expected rows of three numbers, none of them [0, 0, 0]")
    unit: NDArray[np.float64] = x / lengths
    return unit
