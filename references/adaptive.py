"""Adaptive attitude tracking with unknown, variable inertia (ch. 3), recomputed with NumPy and SciPy only.

Equation numbers are those of the dissertation. The regressors are not written down but found: column k of W is what the
right-hand sides of (3.16)-(3.18) and (3.56) give for the k-th basis matrix of the parametrisation, so parameters and
gradient cannot be mixed up in the same way as in the components. The projection is written case by case as in (3.27),
the time derivative of the appendage's inertia comes from the complex step, |u| from the roots of (3.38), and the error
phi from the acceleration of the error itself.

Quaternions are scalar first; SI units throughout.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from .observer_pd import Array, Reference, error, kinematics, skew

PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
SYMMETRIC = np.array([[[float((i, j) in ((a, b), (b, a))) for j in range(3)] for i in range(3)] for a, b in PAIRS])
"""Basis of J_0 = sum theta_k SYMMETRIC[k]."""
MASSES = np.array([np.hstack([-np.eye(3), np.zeros((3, 3))]), np.hstack([np.zeros((3, 3)), -np.eye(3)])])
"""J_1 = sum m_k MASSES[k], sec. 3.4.1."""
DIAGONAL = np.array([np.diag(e) for e in np.eye(3)])


def every_element(columns: int) -> Array:
    """Basis of all 3 x `columns` matrices, row by row: the full parametrisation."""
    return np.eye(3 * columns).reshape(-1, 3, columns)


def combined(basis: Array, parameters: Array) -> Array:
    return np.tensordot(parameters, basis, axes=1)


@dataclass(frozen=True)
class Errors:
    """Tracking errors and what (3.14) makes of them."""

    q_e: Array
    omega_e: Array
    phi: Array
    a: Array
    s: Array
    q_dot: Array


def errors(
    q: Array,
    omega: Array,
    q_r: Array,
    omega_r: Array,
    omega_r_dot: Array,
    phi_sign: float = 1.0,
    frame: Callable[[Array, Array], Array] = lambda c_e, _: c_e,
) -> Errors:
    """phi is minus the derivative of C(q_e) omega_r with Cdot_e = -S(omega_e) C_e, by the product rule. Two mistakes
    can be made: `phi_sign` = -1, and a `frame` of C(q_e) and q_r that takes the place of C(q_e)."""
    c_e, q_e = error(q, q_r)
    c = frame(c_e, q_r)
    omega_e = omega - c @ omega_r
    phi = phi_sign * skew(omega_e) @ c @ omega_r - c @ omega_r_dot
    q_dot = kinematics(q_e, omega_e)[1:]
    return Errors(q_e, omega_e, phi, q_dot + phi, omega_e + q_e[1:], q_dot)


def w_1(e: Errors, omega: Array) -> Array:
    """(3.16), 3 x 6."""
    return np.column_stack([J @ e.a - skew(omega) @ J @ omega for J in SYMMETRIC])


def w_2(e: Errors, omega: Array, basis: Array, psi: Array) -> Array:
    """(3.17) for J_1 = sum sigma_k basis[k]."""
    return np.column_stack([-J @ psi @ e.a + skew(omega) @ J @ psi @ omega for J in basis])


def w_3(e: Errors, omega: Array, basis: Array, psi_dot: Array) -> Array:
    """(3.18)."""
    return np.column_stack([J @ psi_dot @ (omega - (e.omega_e + e.q_e[1:]) / 2) for J in basis])


def projection(estimate: Array, gradient: Array, gain: float, bound: float, margin: float) -> Array:
    """(3.27), (3.31) with epsilon = bound^2, delta = margin^2."""
    square, outward = estimate @ estimate, gradient @ estimate
    if square < bound**2 or outward <= 0:
        return gain * gradient
    return gain * (gradient - (square - bound**2) * outward / (margin**2 * square) * estimate)


def implicit_norm(tau: Array, v: Array) -> float:
    """|u| of u = tau - |u| v: the root of (3.38) that is not negative. It is the only one where |v| < 1; elsewhere,
    where a solver's trial step may end, the smaller one."""
    roots = np.roots([1 - v @ v, 2 * tau @ v, -tau @ tau])
    return float(min(r.real for r in roots if r.real >= 0))


def point_psi(positions: Array) -> Array:
    """[M_1; M_2] of (3.9), 6 x 3; complex positions allowed."""
    return np.vstack([(r @ r) * np.eye(3) - np.outer(r, r) for r in positions])


def point_psi_dot(positions: Array, velocities: Array) -> Array:
    """Its time derivative by the complex step."""
    return np.asarray(point_psi(positions + 1e-30j * velocities).imag / 1e-30)


def w_c(e: Errors, omega: Array, k_p: float, k_w: float) -> Array:
    """(3.56), 3 x 6."""
    b = e.phi + k_w * e.omega_e + k_p * e.q_dot + (k_p + k_w) * k_p * e.q_e[1:]
    return np.column_stack([-skew(omega) @ J @ omega + J @ b for J in SYMMETRIC])


@dataclass(frozen=True)
class Adaptation:
    """Gains and projection of an estimate; without a bound there is no projection."""

    gain: float
    bound: float = 1e6
    margin: float = 1e6

    def rate(self, estimate: Array, gradient: Array) -> Array:
        return projection(estimate, gradient, self.gain, self.bound, self.margin)


def turned(reference: Reference, angle: float) -> Array:
    """q_R from q_R(0) = 1 after the integral of r reached `angle`; continuous through 180 degrees."""
    axis = np.array(reference.axis)
    half = np.linalg.norm(axis) * angle / 2
    return np.array([np.cos(half), *(np.sin(half) * axis / np.linalg.norm(axis))])


# --- inertia models: J(t, psi), Jdot, and Psi, Psidot as the controllers know them ------------------------------------


@dataclass(frozen=True)
class Appendage:
    """(3.59)-(3.60)."""

    retracted: tuple[tuple[float, ...], ...] = ((0.5, 0.0, 0.0), (0.0, 0.8, 0.0))
    extension: float = 1.0
    frequency: float = 0.1

    def positions(self, t: float | complex) -> Array:
        return np.asarray(self.retracted) * (1 + self.extension * np.sin(self.frequency * t) ** 2)

    def velocities(self, t: float) -> Array:
        return np.asarray(self.positions(t + 1e-30j).imag / 1e-30)


@dataclass(frozen=True)
class AdaptiveLoop:
    """Plant and adaptive law as one ODE. The state is [q, omega, angle of R, torque impulse, theta_hat, sigma_hat].

    `kind` is "rigid", "appendage" or "fuel"; `basis` the parametrisation of J_1 in the law. Mistakes that can be made:
    `phi_sign` and `adapt_sign` flip phi's first term and the adaptation, `frame` takes the place of C(q_e) in the law,
    `rate_term` = 0 drops -J' omega from the plant.
    """

    kind: str
    basis: Array
    theta_law: Adaptation
    sigma_law: Adaptation
    J_0: Array = field(default_factory=lambda: np.array([[20, 1.2, 0.9], [1.2, 17, 1.4], [0.9, 1.4, 15]]))
    J_1: Array = field(default_factory=lambda: np.zeros((3, 3)))
    theta_0: tuple[float, ...] = (21.1, 1.9, 1.4, 17.8, 2.9, 15.5)
    beta: float = 20.0
    k_v: float = 24.5
    q: tuple[float, ...] = (float(np.sqrt(1 - 3 * 0.1826**2)), 0.1826, 0.1826, 0.1826)
    omega: tuple[float, ...] = (0.001, 0.001, 0.002)
    reference: Reference = field(
        default_factory=lambda: Reference(amplitude=0.3, frequency=0.3, q_0=(1.0, 0.0, 0.0, 0.0))
    )
    paths: Appendage = field(default_factory=Appendage)
    phi_sign: float = 1.0
    frame: Callable[[Array, Array], Array] = lambda c_e, _: c_e
    adapt_sign: float = 1.0
    rate_term: float = 1.0

    @cached_property
    def start(self) -> Array:
        return np.concatenate([self.q, self.omega, [0.0, 0.0], self.theta_0, np.zeros(len(self.basis))])

    @cached_property
    def theta(self) -> Array:
        """The true parameters of J_0."""
        return np.array([self.J_0[pair] for pair in PAIRS])

    @cached_property
    def sigma(self) -> Array:
        """The true parameters of J_1 in the law's parametrisation."""
        if not len(self.basis):
            return np.zeros(0)
        columns = self.basis.reshape(len(self.basis), -1).T
        return np.linalg.lstsq(columns, self.J_1.ravel(), rcond=None)[0]

    def errors(self, t: float, x: Array, *mistakes: Any) -> Errors:
        q_r = turned(self.reference, x[7])
        return errors(x[:4], x[4:7], q_r, self.reference.omega(t), self.reference.omega_dot(t), *mistakes)

    def psi(self, t: float, impulse: float) -> Array:
        return point_psi(self.paths.positions(t)) if self.kind == "appendage" else impulse * np.eye(3)

    def law(self, t: float, x: Array) -> dict[str, Array]:
        """Torque, rates of the estimates, and the signals they are made of."""
        omega, impulse, theta, sigma = x[4:7], x[8], x[9:15], x[15:]
        e = self.errors(t, x, self.phi_sign, self.frame)
        W = w_1(e, omega)
        u = -self.beta * e.q_e[1:] - self.k_v * e.omega_e - W @ theta
        y = {"Phi": W.T @ e.s, "Gamma": np.zeros(0)}
        if self.kind != "rigid":
            variable = w_2(e, omega, self.basis, self.psi(t, impulse))
            if self.kind == "fuel":
                unit_rate = w_3(e, omega, self.basis, np.eye(3))
                size = implicit_norm(u - variable @ sigma, unit_rate @ sigma)
                variable = variable + size * unit_rate
            else:
                psi_dot = point_psi_dot(self.paths.positions(t), self.paths.velocities(t))
                variable = variable + w_3(e, omega, self.basis, psi_dot)
            u = u - variable @ sigma
            y["Gamma"] = variable.T @ e.s
        y["torque"] = u
        y["theta_dot"] = self.adapt_sign * self.theta_law.rate(theta, y["Phi"])
        y["sigma_dot"] = self.adapt_sign * self.sigma_law.rate(sigma, y["Gamma"]) if len(sigma) else np.zeros(0)
        return y

    def inertia(self, t: float, impulse: float) -> Array:
        return self.J_0 if self.kind == "rigid" else np.asarray(self.J_0 - self.J_1 @ self.psi(t, impulse))

    def rates(self, t: float, x: Array) -> Array:
        y = self.law(t, x)
        u, omega, impulse = y["torque"], x[4:7], x[8]
        J, J_dot = self.inertia(t, impulse), np.zeros((3, 3))
        if self.kind == "appendage":
            J_dot = -self.J_1 @ point_psi_dot(self.paths.positions(t), self.paths.velocities(t))
        elif self.kind == "fuel":
            J_dot = -np.linalg.norm(u) * self.J_1
        acceleration = np.linalg.solve(J, -self.rate_term * J_dot @ omega - skew(omega) @ J @ omega + u)
        angle_rate = self.reference.rate(t).real
        return np.concatenate(
            [
                kinematics(x[:4], omega),
                acceleration,
                [angle_rate, np.linalg.norm(u) if self.kind == "fuel" else 0.0],
                y["theta_dot"],
                y["sigma_dot"],
            ]
        )

    def lyapunov(self, t: float, x: Array) -> float:
        """(3.24)."""
        e = self.errors(t, x)
        value = e.s @ self.inertia(t, x[8]) @ e.s / 2
        value += (self.beta + self.k_v) * (e.q_e[1:] @ e.q_e[1:] + (e.q_e[0] - 1) ** 2)
        value += np.sum((x[9:15] - self.theta) ** 2) / (2 * self.theta_law.gain) if self.theta_law.gain else 0.0
        if len(x) > 15 and self.sigma_law.gain:
            value += np.sum((x[15:] - self.sigma) ** 2) / (2 * self.sigma_law.gain)
        return float(value)

    def lyapunov_rate(self, t: float, x: Array) -> tuple[float, float]:
        """-k_v |omega_e|^2 - beta |q_ev|^2, and what the projection adds to it, (3.32)."""
        y, e = self.law(t, x), self.errors(t, x)
        plain = -self.k_v * e.omega_e @ e.omega_e - self.beta * e.q_e[1:] @ e.q_e[1:]
        extra = 0.0
        for estimate, true, gradient, law in (
            (x[9:15], self.theta, y["Phi"], self.theta_law),
            (x[15:], self.sigma, y["Gamma"], self.sigma_law),
        ):
            square, outward = estimate @ estimate, gradient @ estimate
            if square >= law.bound**2 and outward > 0:
                part = (square - law.bound**2) * outward / (law.margin**2 * square)
                extra -= part * (estimate - true) @ estimate
        return float(plain), float(extra)


@dataclass(frozen=True)
class ComparisonLoop:
    """(3.53)-(3.56) on a rigid body. The state is [q, omega, angle of R, theta_hat, omega_f, W_f by rows].

    `second_sign` = -1 is the printed sign of (3.53).
    """

    gamma: float = 100.0
    k_p: float = 0.5
    k_w: float = 0.5
    J_0: Array = field(default_factory=lambda: np.array([[20, 1.2, 0.9], [1.2, 17, 1.4], [0.9, 1.4, 15]]))
    theta_0: tuple[float, ...] = (21.1, 1.9, 1.4, 17.8, 2.9, 15.5)
    q: tuple[float, ...] = (float(np.sqrt(1 - 3 * 0.1826**2)), 0.1826, 0.1826, 0.1826)
    omega: tuple[float, ...] = (0.001, 0.001, 0.002)
    reference: Reference = field(
        default_factory=lambda: Reference(amplitude=0.3, frequency=0.3, q_0=(1.0, 0.0, 0.0, 0.0))
    )
    second_sign: float = 1.0
    adapt_sign: float = 1.0
    phi_sign: float = 1.0

    @cached_property
    def start(self) -> Array:
        return np.concatenate([self.q, self.omega, [0.0], self.theta_0, np.zeros(3 + 18)])

    def law(self, t: float, x: Array) -> dict[str, Array]:
        q, omega, theta, omega_f, W_f = x[:4], x[4:7], x[8:14], x[14:17], x[17:35].reshape(3, 6)
        q_r = turned(self.reference, x[7])
        e = errors(q, omega, q_r, self.reference.omega(t), self.reference.omega_dot(t), self.phi_sign)
        return comparison_law(
            e, omega, theta, omega_f, W_f, self.gamma, self.k_p, self.k_w, self.second_sign, self.adapt_sign
        )

    def rates(self, t: float, x: Array) -> Array:
        y, omega = self.law(t, x), x[4:7]
        acceleration = np.linalg.solve(self.J_0, -skew(omega) @ self.J_0 @ omega + y["torque"])
        parts = [kinematics(x[:4], omega), acceleration, [self.reference.rate(t).real]]
        return np.concatenate([*parts, y["theta_dot"], y["omega_f_dot"], y["W_f_dot"].ravel()])

    def manifold(self, t: float, x: Array) -> Array:
        """eta = omega_f' + k_w omega_f + k_p q_ev + J^-1 W_f z, which only fades: eta' = -alpha eta."""
        y, omega_f, W_f = self.law(t, x), x[14:17], x[17:35].reshape(3, 6)
        z = y["theta_sum"] - np.array([self.J_0[pair] for pair in PAIRS])
        return np.asarray(
            y["omega_f_dot"] + self.k_w * omega_f + self.k_p * y["q_e"][1:] + np.linalg.solve(self.J_0, W_f @ z)
        )


def comparison_law(
    e: Errors,
    omega: Array,
    theta: Array,
    omega_f: Array,
    W_f: Array,
    gamma: float,
    k_p: float,
    k_w: float,
    second_sign: float = 1.0,
    adapt_sign: float = 1.0,
) -> dict[str, Array]:
    """(3.53)-(3.55)."""
    W, alpha, q_ev = w_c(e, omega, k_p, k_w), k_p + k_w, e.q_e[1:]
    beta_c = gamma * W_f.T @ omega_f
    theta_dot = gamma * W_f.T @ ((alpha + k_w) * omega_f + k_p * q_ev) - gamma * W.T @ omega_f
    return {
        "q_e": e.q_e,
        "omega_e": e.omega_e,
        "theta_sum": theta + beta_c,
        "torque": -W @ (theta + beta_c) + second_sign * gamma * W_f @ W_f.T @ (k_p * (omega_f - q_ev) - e.omega_e),
        "theta_dot": adapt_sign * theta_dot,
        "omega_f_dot": -alpha * omega_f + e.omega_e,
        "W_f_dot": -alpha * W_f + W,
    }


def solve(
    rates: Callable[[float, Array], Array], start: Array, times: Sequence[float] | Array, rtol: float = 1e-12
) -> Array:
    """The state at each of the times, (N, n), by DOP853."""
    grid = np.asarray(times, dtype=float)
    solution = solve_ivp(rates, (grid[0], grid[-1]), start, "DOP853", grid, rtol=rtol, atol=1e-13)
    if not solution.success:
        raise RuntimeError(solution.message)
    return np.asarray(solution.y.T)
