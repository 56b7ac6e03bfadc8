"""The feasible gain region of Sec. IV: for which (a, b) do the conditions of the proof hold?

For given gains the conditions leave seven numbers free: c1, c2 of the Lyapunov function and xi_1 ... xi_5 in (0, 1). A
pair (a, b) belongs to the region if some choice of them satisfies all of

- Q1 > 0, with the margin Q2 = Q1 - diag(k1, k2, k3) > 0 (53), (65)-(68),
- V1 >= 0 (55),
- phi_2 > 2 sqrt(phi_1 phi_3) (79),
- phi_4 r_1^2 + phi_5 r_1 < phi_4 r_2^2 (86), with r_1 < r_2 the roots of N_4 (75),
- c1 V0(0) + J_M |dq_v(0)| |dw(0)| + (c3/J_m) V0(0)^2 < phi_4 r_2^2 (89).

`search` looks for the choice with the largest margin. That one is found shows that the gains belong to the region; that
none is found does not prove the contrary.

In (61) the term b mu_v |E(dq)^T sigma'| |dw| needs a bound on |E(dq)^T sigma'|, which is lost in print. `FILTER_BOUNDS`
names three; the verdict depends on it. Rigorous is 1 + mu_v: sigma is a low-pass of unit vectors, so |E^T sigma| <= 1,
and E(dq)^T dq^ is the vector part of the measurement error, at most mu_v.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from adcs.library.velocity_free.settings import (
    ACCELERATION_LIMIT,
    ERROR_BOUND,
    INERTIA,
    INERTIA_BOUND,
    RATE_BOUND,
    RATE_LIMIT,
    START_ATTITUDE,
    START_RATE,
    TORQUE_BOUND,
)
from fmus.errors import AdcsError

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

A_RANGE, B_RANGE = (0.01, 0.3), (0.01, 1.5)
FREE = 6  # c2, c1, xi_1 ... xi_4; xi_5 only has to be positive, and all conditions are strict
FILTER_BOUNDS = {"1": 1.0, "1 + mu_v": 1.0 + ERROR_BOUND, "2": 2.0}
CONDITIONS = ("Q1 > 0", "(79)", "(86)", "(89)")


@dataclass(frozen=True)
class Bounds:
    """What the conditions are made of. `inertia` (3, 3) [kg.m2]; rates of the reference [rad/s, rad/s2]; SI units."""

    rate: float = 0.0  # nu_omega
    acceleration: float = 0.0  # nu_omegaDot
    inertia: ArrayLike = INERTIA
    inertia_error: float = INERTIA_BOUND  # mu_J
    attitude_error: float = ERROR_BOUND  # mu_v
    error_rate: float = RATE_BOUND  # mu_omega
    torque: float = TORQUE_BOUND  # mu_d
    start_attitude: float = START_ATTITUDE  # |dq_v(0)|
    start_rate: float = START_RATE  # |dw(0)|
    filter_bound: float = FILTER_BOUNDS["1 + mu_v"]  # of |E(dq)^T sigma'|

    def __post_init__(self) -> None:
        """Refuse what no body and no sensor can have."""
        J = np.asarray(self.inertia, dtype=float)
        if J.shape != (3, 3) or not np.allclose(J, J.T) or np.linalg.eigvalsh(J)[0] <= 0:
            raise AdcsError("bounds: inertia is not a symmetric positive definite 3 x 3 matrix")
        for name, value in vars(self).items():
            if name != "inertia" and not (np.isfinite(value) and value >= 0):
                raise AdcsError(f"bounds: {name} = {value:g}: expected 0 or more")
        for name in ("attitude_error", "start_attitude"):
            if getattr(self, name) >= 1:
                raise AdcsError(
                    f"bounds: {name} = {getattr(self, name):g} bounds the vector part of a unit quaternion: "
                    "expected below 1"
                )


STABILISATION = Bounds()
TRACKING = Bounds(rate=RATE_LIMIT, acceleration=ACCELERATION_LIMIT)


class Margins(NamedTuple):
    """How far each condition is from failing: positive where it holds; and what the proof then promises."""

    definite: Array  # 1/k4, smallest eigenvalue of Q3 relative to the bound (72) of V0; V1 >= 0 by construction
    roots: Array  # phi_2 / (2 sqrt(phi_1 phi_3)) - 1
    nested: Array  # phi_4 r_2^2 / (phi_4 r_1^2 + phi_5 r_1) - 1
    start: Array  # phi_4 r_2^2 / bound of V(0) - 1
    residual: Array  # bound of V0 in the residual set (85): phi_4 V0^2 <= V <= phi_4 r_1^2 + phi_5 r_1 [N.m]

    def least(self) -> Array:
        """One number that rises on the way to the region: the first condition that fails, or the smallest margin."""
        inside = np.minimum(self.nested, self.start)
        below = np.where(self.roots > 0, inside, np.clip(self.roots, -1.9, 0.0))
        return np.where(self.definite > 0, below, -3.0 + np.tanh(self.definite))


@np.errstate(invalid="ignore", divide="ignore", over="ignore")
def margins(a: Array, b: Array, free: Array, bounds: Bounds) -> Margins:
    """The conditions at gains a, b (...) and free numbers (..., 6), which may take any real values.

    They are mapped so that V1 >= 0 (55), c2 mu_0 > J_M (54), c1 > c2/(2 J_m) and 0 < xi < 1 hold for all of them.
    """
    J = np.asarray(bounds.inertia, dtype=float)
    J_m, _, J_M = np.linalg.eigvalsh(J)
    J_bar = np.abs(np.linalg.eigvalsh(2 * J - np.trace(J) * np.eye(3))).max()  # (21)
    root = sqrt(J_M * (J_M - J_m))
    mu_v, mu_w, nu, nu_dot = bounds.attitude_error, bounds.error_rate, bounds.rate, bounds.acceleration
    mu_0 = sqrt(1 - mu_v**2)  # (29)
    mu_eta = (
        4 * root * nu**2 * mu_v**2 + 2 * J_M * (2 * nu**2 + nu_dot) * mu_v + (nu**2 + nu_dot) * bounds.inertia_error
    )

    c2 = J_M / mu_0 * (1 + np.exp(free[..., 0]))
    c1 = np.maximum(c2 / (2 * J_m), np.sqrt(J_M / (2 * a) + c2**2 / (J_m * b))) * (1 + np.exp(free[..., 1]))
    xi_1, xi_2, xi_3, xi_4 = np.moveaxis(1 / (1 + np.exp(-free[..., 2:])), -1, 0)

    gamma_1 = a * mu_v + mu_eta + bounds.torque  # (50)
    gamma_2 = c1 * gamma_1 + c2 * mu_w  # (51)
    gamma_3 = c1 * b * mu_w + c2 / J_m * gamma_1  # (52)
    inertia_factor = 0.5 + root / J_m
    c3 = (inertia_factor * c2) ** 2 / (2 * b * (c2 * mu_0 - J_M) * (1 - xi_1))  # (63)
    gamma_4 = 2 * c3 / J_m * (a * (1 - mu_0) + b * mu_v * bounds.filter_bound + gamma_1)  # (61)
    gamma_5 = 2 * c3 * b * mu_w / J_m  # (62)

    # Q1 (53), of which the parts 1 - xi are set aside as k1, k2, k3 (66)-(68)
    q_11, q_22, q_33 = a * mu_0, (c2 * mu_0 - J_M) * xi_1 / 2, (c1 - c2 / (2 * J_m)) * b
    q_12 = -(c1 * a * (1 - mu_0) + J_bar * nu) / 2
    q_13 = -(b / 2 + c2 * a / J_m) / 2
    q_23 = -(c1 * b * mu_v + c2 + c2 * J_bar * nu / J_m) / 2
    k_1, k_2, k_3 = q_11 * (1 - xi_2), q_22 * (1 - xi_3), q_33 * (1 - xi_4)
    q_11, q_22, q_33 = q_11 * xi_2, q_22 * xi_3, q_33 * xi_4

    # Q3 (71) is what is left after minimising over |dq_v|; 1/k4 its least eigenvalue in the metric of (72)
    s_22, s_23, s_33 = q_22 - q_12**2 / q_11, q_23 - q_12 * q_13 / q_11, q_33 - q_13**2 / q_11
    s_22, s_23, s_33 = s_22 / (J_M / 2), s_23 / np.sqrt(J_M / 2 * b / 2), s_33 / (b / 2)
    k_4 = (s_22 + s_33) / 2 - np.sqrt(((s_22 - s_33) / 2) ** 2 + s_23**2)  # its inverse, in fact

    phi_1 = (gamma_4**2 / k_2 + gamma_5**2 / k_3) / 4  # (76)
    phi_2 = k_4 - gamma_2 * gamma_4 / (2 * k_2) - gamma_3 * gamma_5 / (2 * k_3)  # (77)
    phi_3 = (gamma_1**2 / k_1 + gamma_2**2 / k_2 + gamma_3**2 / k_3) / 4 + 4 * a * k_4  # (78)
    spread = np.sqrt(np.maximum(phi_2**2 - 4 * phi_1 * phi_3, 0.0))
    r_1, r_2 = (phi_2 - spread) / (2 * phi_1), (phi_2 + spread) / (2 * phi_1)
    phi_4, phi_5 = c3 / J_m, 2 * c1  # (83), (84)
    reach = phi_4 * r_2**2
    V_0 = 2 * a * (1 - sqrt(1 - bounds.start_attitude**2)) + J_M / 2 * bounds.start_rate**2  # (88)
    start = c1 * V_0 + J_M * bounds.start_attitude * bounds.start_rate + phi_4 * V_0**2  # (87)
    residual = phi_4 * r_1**2 + phi_5 * r_1
    return Margins(
        k_4,
        phi_2 / (2 * np.sqrt(phi_1 * np.maximum(phi_3, 1e-300))) - 1,
        reach / residual - 1,
        reach / start - 1,
        np.sqrt(residual / phi_4),
    )


def search(
    a: ArrayLike, b: ArrayLike, bounds: Bounds, generations: int = 120, population: int = 40, seed: int = 1
) -> tuple[Array, Array]:
    """Largest margin found at each pair of gains (N,), and the free numbers that give it (N, 6).

    Differential evolution, side by side at all pairs.
    """
    a, b = np.atleast_1d(np.asarray(a, float)), np.atleast_1d(np.asarray(b, float))
    if a.shape != b.shape or a.ndim != 1:
        raise AdcsError(f"gains: a has shape {a.shape} and b {b.shape}: expected the same number of values")
    if not (np.isfinite(a).all() and np.isfinite(b).all() and (a > 0).all() and (b > 0).all()):
        raise AdcsError("gains: a and b must be positive")
    random = np.random.default_rng(seed)
    points = 2.0 * random.normal(size=(a.size, population, FREE))
    score = margins(a[:, None], b[:, None], points, bounds).least()
    rows = np.arange(a.size)
    for _ in range(generations):
        first, second = random.integers(0, population, (2, population))
        best = points[rows, score.argmax(axis=1)][:, None]
        pull, cross = random.random((a.size, population, 1)), random.random(points.shape) < 0.8
        moved = points + 0.6 * pull * (best - points) + 0.7 * (points[:, first] - points[:, second])
        trial = np.where(cross, moved, points)
        trial_score = margins(a[:, None], b[:, None], trial, bounds).least()
        better = trial_score > score  # never where it is not a number
        points, score = np.where(better[..., None], trial, points), np.where(better, trial_score, score)
    chosen = score.argmax(axis=1)
    return score[rows, chosen], points[rows, chosen]


@dataclass(frozen=True)
class Region:
    """The margin over a grid of gains: `a` (n,), `b` (m,), `margin` (m, n), positive inside."""

    a: Array
    b: Array
    margin: Array

    @property
    def inside(self) -> Flags:
        """Whether the conditions can be met, (m, n)."""
        return self.margin > 0

    @property
    def share(self) -> float:
        """Part of the grid that is inside."""
        return float(self.inside.mean())


def region(bounds: Bounds, points: int = 41, rounds: int = 40, seed: int = 1) -> Region:
    """The region over [.01, .3] x [.01, 1.5] on a grid of `points` by `points`.

    Searched on every sixth point; from there the choices spread over the grid, each pair of gains taking over what
    suits its neighbours and varying it.
    """
    a, b = np.linspace(*A_RANGE, points), np.linspace(*B_RANGE, points)
    A, B = np.meshgrid(a, b)
    coarse = np.linspace(0, points - 1, 2 + (points - 1) // 6).round().astype(int)
    _, found = search(A[np.ix_(coarse, coarse)].ravel(), B[np.ix_(coarse, coarse)].ravel(), bounds, seed=seed)
    nearest = np.abs(np.arange(points)[:, None] - coarse).argmin(axis=1)
    free = found.reshape(len(coarse), len(coarse), FREE)[np.ix_(nearest, nearest)]
    margin = margins(A, B, free, bounds).least()
    random = np.random.default_rng(seed)
    for turn in range(rounds):
        size = 0.5 * 0.9**turn
        for axis, shift in ((0, 1), (0, -1), (1, 1), (1, -1), (0, 0), (0, 0)):
            tried_free = np.roll(free, shift, axis) + size * random.normal(size=free.shape)
            tried = margins(A, B, tried_free, bounds).least()
            better = tried > margin
            margin, free = np.where(better, tried, margin), np.where(better[..., None], tried_free, free)
    return Region(a, b, margin)
