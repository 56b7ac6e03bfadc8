"""Adaptive tracking with guaranteed bounds, recomputed from the paper's equations with NumPy and SciPy only.

Equation numbers are those of de Ruiter, Observer-Based Adaptive Spacecraft Attitude Control with Guaranteed Performance
Bounds. Other roads than the components' are taken: parameters come from evaluating the torque-free acceleration at
basis vectors, the regressors are whole matrices, the auxiliary acceleration differentiates Eq. (11) term by term, the
projection is the printed case distinction (with y for its last v). ``MUTANTS`` names deliberate mistakes.

Quaternions are scalar first, SI units throughout; the estimates are whole, not offsets from the nominal values.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from .observer_pd import Array, body_acceleration, error, kinematics, observer_rates, rotation, skew

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))  # the order of Eqs. (16) and (18)

MUTANTS = (
    "adaptation sign of theta",
    "adaptation sign of theta_p",
    "no adaptation",
    "v instead of y in the projection",
    "error attitude transposed",
    "error quaternion conjugated",
    "without - dw x C wd",
    "without q4 dw",
    "lambda instead of lambda / 2",
    "regressor of the rate error",
    "feedback of the rate error",
)

HATS = ("rate in the regressor", "auxiliary acceleration", "filtered rate error")
"""Terms of Eqs. (27)-(30) that carry a hat; each can be given its true value instead, to see that a test notices."""


def products(omega: Array) -> Array:
    """phi(omega), Eq. (16)."""
    return np.array([omega[i] * omega[j] for i, j in PAIRS])


def regressor(omega: Array) -> Array:
    """Phi(omega), (3, 18), Eq. (15)."""
    return np.asarray(np.kron(np.eye(3), products(omega)), np.float64)


def symmetric(theta_p: Array) -> Array:
    """P of [P11 P22 P33 P12 P13 P23]."""
    P = np.empty((3, 3))
    for k, (i, j) in enumerate(PAIRS):
        P[i, j] = P[j, i] = theta_p[k]
    return P


def torque_regressor(torque: Array) -> Array:
    """Psi(torque), (3, 6), Eq. (18): column k is what P of the k-th basis vector makes of the torque."""
    return np.column_stack([symmetric(e) @ torque for e in np.eye(6)])


def parameters(inertia: Array) -> tuple[Array, Array]:
    """theta (18) and theta_p (6) of an inertia: the quadratic form of Eq. (14) by polarisation."""
    P = np.linalg.inv(inertia)

    def acceleration(omega: Array) -> Array:
        return P @ np.cross(omega, inertia @ omega)

    e = np.eye(3)
    squares = [acceleration(e[i]) for i in range(3)]
    mixed = [acceleration(e[i] + e[j]) - squares[i] - squares[j] for i, j in PAIRS[3:]]
    return np.column_stack([*squares, *mixed]).ravel(), np.array([P[i, j] for i, j in PAIRS])


def level(offset: Array, eta: float, epsilon: float) -> float:
    """d(v), Eqs. (25), (26)."""
    return float((offset @ offset - eta**2) / (epsilon * eta**2))


def project(v: Array, centre: Array, y: Array, eta: float, epsilon: float, otherwise: Literal["y", "v"] = "y") -> Array:
    """Eqs. (23), (24); print has ``otherwise="v"``."""
    d, gradient = level(v - centre, eta, epsilon), 2 * (v - centre) / (epsilon * eta**2)
    if d > 0 and gradient @ y > 0:
        return y - d * gradient * (gradient @ y) / (gradient @ gradient)
    return y if otherwise == "y" else v


@dataclass(frozen=True)
class Gains:
    """The constants of the law; ``inertia`` is I*."""

    inertia: Array
    k: float
    lam: float
    gamma: float
    gamma_p: float
    dead_zone: float
    eta: float
    eta_p: float
    epsilon: float
    epsilon_p: float

    @classmethod
    def of(cls, p: Mapping[str, Any]) -> "Gains":
        """From the parameters of the component."""
        names = ("k", "lambda", "gamma", "gamma_p", "dead_zone", "eta", "eta_p", "epsilon", "epsilon_p")
        return cls(np.asarray(p["J_B"]), *(float(p[n]) for n in names))

    @cached_property
    def centre(self) -> tuple[Array, Array]:
        """theta*, theta_p*."""
        return parameters(self.inertia)


def law(
    g: Gains,
    q_hat: Array,
    omega_hat: Array,
    q_r: Array,
    omega_r: Array,
    omega_r_dot: Array,
    theta: Array,
    theta_p: Array,
    *,
    mutant: str | None = None,
    true: tuple[Array, Array] | None = None,
    without_hat: str | None = None,
) -> dict[str, Array]:
    """Eqs. (27)-(30): torque, errors as the law sees them, and the rates of the estimates.

    The term ``without_hat`` is taken at the ``true`` attitude and rate.
    """
    assert mutant is None or mutant in MUTANTS
    assert without_hat is None or without_hat in HATS
    C, q_e = error(q_hat, q_r)
    if mutant == "error attitude transposed":
        C = C.T
    if mutant == "error quaternion conjugated":
        q_e = q_e * [1, -1, -1, -1]
    wd = C @ omega_r
    dw = omega_hat - wd
    wt = dw + g.lam * q_e[1:]
    omega = omega_hat
    seen = {"q_e": q_e, "omega_e": dw, "filtered": wt}
    if true is not None and without_hat is not None:
        C_true, q_true = error(true[0], q_r)
        dw_true = true[1] - C_true @ omega_r
        if without_hat == "rate in the regressor":
            omega = true[1]
        elif without_hat == "auxiliary acceleration":
            C, q_e, dw, wd = C_true, q_true, dw_true, C_true @ omega_r
        else:
            wt = dw_true + g.lam * q_true[1:]
    # (30) is d/dt of C wd - lam q with C' = -S(dw) C and q' of the kinematics
    aux = C @ omega_r_dot
    if mutant != "without - dw x C wd":
        aux = aux - skew(dw) @ wd
    q_dot = kinematics(q_e, dw)[1:]
    if mutant == "without q4 dw":
        q_dot = q_dot - q_e[0] * dw / 2
    aux = aux - (2 if mutant == "lambda instead of lambda / 2" else 1) * g.lam * q_dot
    feedback = dw if mutant == "feedback of the rate error" else wt
    Phi = regressor(dw if mutant == "regressor of the rate error" else omega)
    wanted = aux - g.k * feedback + Phi @ theta
    torque = np.asarray(np.linalg.solve(symmetric(theta_p), wanted), np.float64)

    theta_dot, theta_p_dot = np.zeros(18), np.zeros(6)
    if np.linalg.norm(wt) > g.dead_zone and mutant != "no adaptation":
        y, y_p = -Phi.T @ wt, torque_regressor(torque).T @ wt
        if mutant == "adaptation sign of theta":
            y = -y
        if mutant == "adaptation sign of theta_p":
            y_p = -y_p
        otherwise: Literal["y", "v"] = "v" if mutant == "v instead of y in the projection" else "y"
        theta_dot = g.gamma * project(theta, g.centre[0], y, g.eta, g.epsilon, otherwise)
        theta_p_dot = g.gamma_p * project(theta_p, g.centre[1], y_p, g.eta_p, g.epsilon_p, otherwise)
    return {**seen, "torque": torque, "theta_dot": theta_dot, "theta_p_dot": theta_p_dot}


def sinusoids(
    t: float, bias: ArrayLike, amplitude: ArrayLike, frequency: ArrayLike, phase: ArrayLike
) -> tuple[Array, Array]:
    """bias + amplitude sin(frequency t + phase) per axis and its derivative, by the complex exponential."""
    wave = np.asarray(amplitude) * np.exp(1j * (np.asarray(frequency) * t + np.asarray(phase)))
    return np.asarray(bias) + wave.imag, np.asarray(frequency) * wave.real


def estimates(p: Mapping[str, Any], t: float, q: Array, omega: Array) -> dict[str, Array]:
    """Eqs. (7), (8) with the sinusoidal errors of the component: C(q_hat) = C(v) C(q) by SciPy's rotations."""
    root = np.sqrt(3)
    v = sinusoids(t, 0, p["attitude_bound"] / root * np.ones(3), p["attitude_frequency"], p["attitude_phase"])[0]
    v_omega = sinusoids(t, 0, p["rate_bound"] / root * np.ones(3), p["rate_frequency"], p["rate_phase"])[0]
    small = Rotation.from_rotvec(v / np.linalg.norm(v) * 2 * np.arcsin(np.linalg.norm(v)) if v.any() else v)
    turned = (rotation(q) * small).as_quat(scalar_first=True)  # SciPy turns vectors: the order is reversed
    q_v = small.as_quat(scalar_first=True)
    expected_scalar = q_v[0] * q[0] - q_v[1:] @ q[1:]
    sign = 1.0 if turned[0] * expected_scalar >= 0 else -1.0
    return {"q_EN": sign * turned, "omega_BN_B_est": omega + v_omega, "q_EB": q_v, "rate_error_B": v_omega}


@dataclass(frozen=True)
class Loop:
    """The closed loop of a set-up: plain numbers, as ``values`` of the system's components by name.

    ``source`` says where the controller's attitude and rate come from: the plant, the bounded errors or the observer.
    The state is [q, omega, q_R, theta, theta_p], followed by [q_hat, omega_hat] of the observer.
    """

    values: Mapping[str, Mapping[str, Any]]
    source: Literal["exact", "errors", "observer"] = "exact"
    mutant: str | None = None
    gains: Gains = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "gains", Gains.of(self.values["controller"]))

    @cached_property
    def inertia(self) -> Array:
        return np.asarray(self.values["plant"]["J_B"], float)

    @cached_property
    def truth(self) -> tuple[Array, Array]:
        """theta, theta_p of the true inertia."""
        return parameters(self.inertia)

    @cached_property
    def start(self) -> Array:
        v = self.values
        parts = [v["plant"]["q_BN"], v["plant"]["omega_BN_B"], v["guidance"]["q_RN"], *self.gains.centre]
        if self.source == "observer":
            parts += [v["observer"]["q_EN"], v["observer"]["omega_EN_E"]]
        return np.concatenate([np.asarray(p, float) for p in parts])

    def signals(self, t: float, x: Array) -> dict[str, Array]:
        q, omega, q_r, theta, theta_p = x[:4], x[4:7], x[7:11], x[11:29], x[29:35]
        guidance = self.values["guidance"]
        omega_r, omega_r_dot = sinusoids(
            t, *(guidance[f"rate_{n}"] for n in ("bias", "amplitude", "frequency", "phase"))
        )
        q_est, omega_est = q, omega
        y: dict[str, Array] = {}
        if self.source == "errors":
            seen = estimates(self.values["estimate"], t, q, omega)
            q_est, omega_est = seen["q_EN"], seen["omega_BN_B_est"]
        elif self.source == "observer":
            omega_est = error(q, x[35:39])[0] @ x[39:42]
        control = law(self.gains, q_est, omega_est, q_r, omega_r, omega_r_dot, theta, theta_p, mutant=self.mutant)
        C, q_e = error(q, q_r)
        y |= {"q": q, "omega": omega, "q_r": q_r, "omega_r": omega_r, "theta": theta, "theta_p": theta_p}
        y |= {"q_est": q_est, "omega_est": omega_est, "omega_r_dot": omega_r_dot}
        y |= {"true_q_e": q_e, "true_omega_e": omega - C @ omega_r}
        return y | control

    def disturbance(self, t: float) -> Array:
        p = self.values.get("disturbance")
        if p is None:
            return np.zeros(3)
        return sinusoids(t, *(p[f"torque_{n}"] for n in ("bias", "amplitude", "frequency", "phase")))[0]

    def rates(self, t: float, x: Array) -> Array:
        y = self.signals(t, x)
        parts = [
            kinematics(y["q"], y["omega"]),
            body_acceleration(self.inertia, y["omega"], y["torque"] + self.disturbance(t)),
            kinematics(y["q_r"], y["omega_r"]),
            y["theta_dot"],
            y["theta_p_dot"],
        ]
        if self.source == "observer":
            o = self.values["observer"]
            parts += observer_rates(
                np.asarray(o["J_B"]), o["lambda"], o["gamma"], y["q"], y["torque"], x[35:39], x[39:42]
            )
        return np.concatenate(parts)

    def lyapunov(self, y: Mapping[str, Array]) -> float:
        """V, Eq. (49), of the signals."""
        g = self.gains
        d, d_p = y["theta"] - self.truth[0], y["theta_p"] - self.truth[1]
        return float(y["filtered"] @ y["filtered"] / 2 + d @ d / (2 * g.gamma) + d_p @ d_p / (2 * g.gamma_p))

    def run(self, times: Array, rtol: float = 1e-12, atol: float = 1e-14) -> dict[str, Array]:
        """Integrate with DOP853: signals on the grid, the state ``x``, ``lyapunov`` and ``spent``, k times the integral
        of |filtered|^2."""
        n = self.start.size

        def flow(t: float, z: Array) -> Array:
            wt = self.signals(t, z[:n])["filtered"]
            return np.append(self.rates(t, z[:n]), self.gains.k * wt @ wt)

        solution = solve_ivp(
            flow, (times[0], times[-1]), np.append(self.start, 0.0), "DOP853", times, rtol=rtol, atol=atol
        )
        if not solution.success:
            raise RuntimeError(solution.message)
        x = solution.y[:n].T
        rows = [self.signals(t, row) for t, row in zip(times, x, strict=True)]
        signals = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        lyapunov = np.array([self.lyapunov(row) for row in rows])
        return {**signals, "time": times, "x": x, "lyapunov": lyapunov, "spent": solution.y[n]}
