"""Attitude from unit vectors, with NumPy and SciPy only: the laws of chapter 4, QUEST's problem, and the closed loop.

Written from the dissertation, and by other roads than the components take: M tilde from products of skew matrices, as
in the derivation of (4.9); P by SciPy's Bartels-Stewart solver; Wahba's problem by SciPy's singular values; rotations
by ``scipy.spatial.transform``. Quaternions are scalar first, C_BN takes components in N to B; a row per vector.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import solve_continuous_lyapunov
from scipy.spatial.transform import Rotation

from .observer_pd import Array, body_acceleration, kinematics, rotation, skew


def seen(q: Array, x: Array) -> Array:
    """The directions x (n, 3), of any length, as unit vectors in the frame that q leads to."""
    return rotation(q).inv().apply(x / np.linalg.norm(x, axis=1, keepdims=True))


def omega_error(k: Array, y: Array, y_r: Array) -> Array:
    """Omega (4.7)."""
    return 0.5 * np.sum([k_j * skew(a) @ b for k_j, a, b in zip(k, y, y_r, strict=True)], axis=0)


def m_tilde(k: Array, y: Array, y_r: Array) -> Array:
    """M tilde, with Omega' = M tilde omega: -1/2 sum k S(y_r) S(y), second line of (4.9)."""
    return -0.5 * np.sum([k_j * skew(b) @ skew(a) for k_j, a, b in zip(k, y, y_r, strict=True)], axis=0)


def lyapunov_solution(a_m: Array, q: Array) -> Array:
    """P with Am^T P + P Am = -Q."""
    return solve_continuous_lyapunov(a_m.T, -q)


@dataclass(frozen=True)
class Gains:
    """Weights, gains and filter of the law; of Sec. 4.3 unless said otherwise."""

    k: Array = field(default_factory=lambda: np.ones(3))
    k_p: float = 0.03
    k_z: float = 0.6
    a_m: Array = field(default_factory=lambda: np.diag([-3.0, -10.0, -5.0]))
    b: Array = field(default_factory=lambda: np.eye(3))
    q: Array = field(default_factory=lambda: 10.5 * np.eye(3))

    @cached_property
    def p(self) -> Array:
        """P with Am^T P + P Am = -Q."""
        return lyapunov_solution(self.a_m, self.q)


def gyro_free(g: Gains, y: Array, y_r: Array, z: Array) -> tuple[Array, Array]:
    """Torque (4.25) and z' (4.26)."""
    omega = omega_error(g.k, y, y_r)
    z_dot = g.a_m @ z + g.b @ omega
    zeta = g.b.T @ g.p @ z_dot
    return -g.k_p * omega - g.k_z * m_tilde(g.k, y, y_r).T @ zeta, z_dot


def resting_filter(g: Gains, y: Array, y_r: Array) -> Array:
    """z with z' = 0 (remark 4.2.1)."""
    return -np.linalg.solve(g.a_m, g.b @ omega_error(g.k, y, y_r))


def quest(k: Array, y: Array, x: Array, q_near: Array) -> Array:
    """The quaternion that solves Wahba's problem, with the sign of ``q_near``."""
    fitted, _ = Rotation.align_vectors(y, x / np.linalg.norm(x, axis=1, keepdims=True), k)  # y = C x
    q = fitted.inv().as_quat(scalar_first=True)
    return q if q @ q_near >= 0 else -q


def observability(k: Array, y: Array, x: Array) -> float:
    """Product of the gaps between the largest and the other eigenvalues of Davenport's matrix, over 8 (sum k)^3."""
    profile = np.einsum("j,ja,jb->ab", k, y, x / np.linalg.norm(x, axis=1, keepdims=True))
    vector = 2 * omega_error(k, y, x / np.linalg.norm(x, axis=1, keepdims=True))
    davenport = np.block(
        [
            [np.array([[np.trace(profile)]]), vector[None]],
            [vector[:, None], profile + profile.T - np.trace(profile) * np.eye(3)],
        ]
    )
    values = np.linalg.eigvalsh(davenport)
    return float(np.prod(values[3] - values[:3]) / (8 * k.sum() ** 3))


def _diagonal(degrees: float) -> Array:
    return Rotation.from_rotvec(np.radians(degrees) * np.ones(3) / np.sqrt(3)).as_quat(scalar_first=True)


@dataclass(frozen=True)
class Settings:
    """Sec. 4.3."""

    inertia: Array = field(default_factory=lambda: np.diag([0.29, 0.29, 0.5]))
    x: Array = field(default_factory=lambda: np.array([[0, 0, 1], [1, 0, 0], [1, 1, 0]]) / [[1], [1], [np.sqrt(2)]])
    q_r: Array = field(default_factory=lambda: _diagonal(87.7))
    q: Array = field(default_factory=lambda: _diagonal(120.0))
    omega: Array = field(default_factory=lambda: np.full(3, -0.02))
    gains: Gains = field(default_factory=Gains)
    k_w: float = 0.06

    @property
    def y_r(self) -> Array:
        return seen(self.q_r, self.x)


Control = Callable[[Gains, Array, Array, Array], tuple[Array, Array]]


@dataclass(frozen=True)
class Loop:
    """The closed loop; ``control`` and ``see`` may be replaced, to see what a wrong law would do. State [q, omega, z].

    With ``full_state`` the law is u = -kp Omega - kw omega, and there is no z.
    """

    full_state: bool = False
    settings: Settings = field(default_factory=Settings)
    control: Control = gyro_free
    see: Callable[[Array, Array], Array] = seen

    @property
    def start(self) -> Array:
        s = self.settings
        z = [] if self.full_state else [resting_filter(s.gains, seen(s.q, s.x), s.y_r)]
        return np.concatenate([s.q, s.omega, *z])

    def torque(self, x: Array) -> tuple[Array, Array]:
        """Torque and z' (empty without filter) at the state x."""
        s, g = self.settings, self.settings.gains
        y = self.see(x[:4], s.x)
        if self.full_state:
            return -g.k_p * omega_error(g.k, y, s.y_r) - s.k_w * x[4:7], np.empty(0)
        return self.control(g, y, s.y_r, x[7:])

    def rates(self, _: float, x: Array) -> Array:
        torque, z_dot = self.torque(x)
        turn = body_acceleration(self.settings.inertia, x[4:7], torque)
        return np.concatenate([kinematics(x[:4], x[4:7]), turn, z_dot])

    def lyapunov(self, x: Array) -> float:
        """V (4.28); without filter its first two terms."""
        s, g = self.settings, self.settings.gains
        y = seen(x[:4], s.x)
        value = 0.5 * x[4:7] @ s.inertia @ x[4:7] + 0.5 * g.k_p * np.sum(g.k * (1 - np.sum(y * s.y_r, axis=1)))
        if not self.full_state:
            z_dot = g.a_m @ x[7:] + g.b @ omega_error(g.k, y, s.y_r)
            value += 0.5 * g.k_z * z_dot @ g.p @ z_dot
        return float(value)

    def lyapunov_rate(self, x: Array) -> float:
        """What the proof says of V': -1/2 kz z'^T Q z', or -kw |omega|^2."""
        s, g = self.settings, self.settings.gains
        if self.full_state:
            return float(-s.k_w * x[4:7] @ x[4:7])
        z_dot = g.a_m @ x[7:] + g.b @ omega_error(g.k, seen(x[:4], s.x), s.y_r)
        return float(-0.5 * g.k_z * z_dot @ g.q @ z_dot)

    def run(self, times: Array) -> Array:
        """The states (len(times), n) by DOP853."""
        solution = solve_ivp(self.rates, (times[0], times[-1]), self.start, "DOP853", times, rtol=1e-12, atol=1e-14)
        if not solution.success:
            raise RuntimeError(solution.message)
        return solution.y.T


def resting_attitudes(s: Settings) -> list[tuple[float, Array]]:
    """The attitudes turned by 180 degrees from q_r about the eigenvectors of M0, at which Omega vanishes, each with its
    eigenvalue, in ascending order."""
    values, vectors = np.linalg.eigh(np.einsum("j,ja,jb->ab", s.gains.k, s.y_r, s.y_r))
    turned = [rotation(s.q_r) * Rotation.from_rotvec(np.pi * e) for e in vectors.T]
    return [(float(v), r.as_quat(scalar_first=True)) for v, r in zip(values, turned, strict=True)]
