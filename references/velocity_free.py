"""Velocity-free attitude tracking recomputed from the published equations with NumPy and SciPy only.

Equation numbers are those of the paper. Roads other than the components' are taken: rotations by
``scipy.spatial.transform``, E(q) and G(q) as matrices, the oblateness force as the gradient of its potential by complex
step, Kepler's equation by a bracketing root finder and the true anomaly.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from .observer_pd import Array, body_acceleration, error, kinematics, rotation, skew


def E(q: Array) -> Array:
    """(8), (9): [-q_v^T; q_v^x + q_0 I]."""
    return np.vstack([-q[1:], skew(q[1:]) + q[0] * np.eye(3)])


def G(q: Array) -> Array:
    """(4): [q | E(q)]."""
    return np.column_stack([q, E(q)])


def torque(p: Mapping[str, Any]) -> Array:
    """(32) with the dot on sigma, (90)."""
    c, dq = error(p["q_BN"], p["q_RN"])
    w = c @ p["omega_RN_R"]
    eta = skew(w) @ p["J_B"] @ w + p["J_B"] @ c @ p["omegaDot_RN_R"]
    return -p["a"] * dq[1:] - p["b"] / 2 * E(dq).T @ p["sigmaDot_BR"] + eta


def kepler(p: Mapping[str, Any]) -> tuple[Array, Array]:
    """Position and velocity from the elements at p["time"]."""
    a, e, mu = (float(p[n]) for n in ("semi_major_axis", "eccentricity", "mu"))
    mean = float(p["mean_anomaly"]) + np.sqrt(mu / a**3) * float(p["time"])
    eccentric = brentq(lambda x: x - e * np.sin(x) - mean, mean - 2, mean + 2, xtol=1e-15, rtol=1e-15)
    nu = 2 * np.arctan2(np.sqrt(1 + e) * np.sin(eccentric / 2), np.sqrt(1 - e) * np.cos(eccentric / 2))
    parameter = a * (1 - e**2)
    in_plane = parameter / (1 + e * np.cos(nu)) * np.array([np.cos(nu), np.sin(nu), 0])
    speed = np.sqrt(mu / parameter) * np.array([-np.sin(nu), e + np.cos(nu), 0])
    angles = [float(p[n]) for n in ("ascending_node", "inclination", "argument_of_perigee")]
    turn = Rotation.from_euler("ZXZ", angles)
    return turn.apply(in_plane), turn.apply(speed)


def oblateness_acceleration(mu: float, radius: float, j2: float, r: Array) -> Array:
    """-grad of mu J_2 R^2 / (2 r^3) (3 z^2 / r^2 - 1)."""

    def potential(x: Any) -> Any:
        square = np.sum(x * x)
        return mu * j2 * radius**2 / (2 * square**1.5) * (3 * x[2] * x[2] / square - 1)

    steps = 1e-20 * np.eye(3)
    return -np.array([potential(r + 1j * h).imag / 1e-20 for h in steps])


def environment(p: Mapping[str, Any]) -> dict[str, Array]:
    """(92), with the oblateness force from its potential and the mass."""
    turn = rotation(p["q_BN"]).inv()
    r, v, arm = p["r_BN_N"], p["v_BN_N"], p["lever_arm_B"]
    up = turn.apply(r / np.linalg.norm(r))
    gradient = 3 * p["mu"] / np.linalg.norm(r) ** 3 * skew(up) @ p["J_B"] @ up
    drag = -p["density"] / 2 * p["drag_coefficient"] * p["area"] * np.linalg.norm(v) * v
    pull = p["mass"] * oblateness_acceleration(p["mu"], p["earth_radius"], p["j2"], r)
    parts = {
        "gravity_gradient_B": gradient,
        "drag_B": np.cross(arm, turn.apply(drag)),
        "oblateness_B": np.cross(arm, turn.apply(pull)),
    }
    height = np.linalg.norm(r) - p["earth_radius"]
    return {**parts, "torque_B": sum(parts.values()), "altitude": height}


INERTIA = np.array([[0.0465, -0.0007, 0.0004], [-0.0007, 0.0486, -0.0021], [0.0004, -0.0021, 0.0482]])


@dataclass(frozen=True)
class Loop:
    """The ideal closed loop (23) with (31); state [q, omega, q_r, sigma].

    ``control`` and ``filtered`` can be replaced, to see what a wrong law would do.
    """

    tracking: bool
    a: float = 0.2
    b: float = 0.8
    inertia: Array = field(default_factory=lambda: INERTIA)
    control: Callable[[Mapping[str, Any]], Array] = torque
    filtered: Callable[[Array, Array], Array] = lambda sigma, dq: dq - sigma

    @property
    def start(self) -> Array:
        q = np.array([np.sqrt(0.9925), 0.05, 0.05, 0.05])
        return np.concatenate([q, [-0.09, 0.03, -0.03], np.eye(4)[0], q])

    def reference(self, t: float) -> tuple[Array, Array]:
        size = 0.05 * self.tracking
        return size * np.sin(0.5 * t) * np.ones(3), 0.5 * size * np.cos(0.5 * t) * np.ones(3)

    def signals(self, t: float, x: Array) -> dict[str, Array]:
        q, omega, q_r, sigma = x[:4], x[4:7], x[7:11], x[11:15]
        omega_r, omega_r_dot = self.reference(t)
        c, dq = error(q, q_r)
        rate = self.filtered(sigma, dq)
        point: dict[str, Any] = {"q_BN": q, "q_RN": q_r, "omega_RN_R": omega_r, "omegaDot_RN_R": omega_r_dot}
        point |= {"J_B": self.inertia, "a": self.a, "b": self.b, "sigmaDot_BR": rate, "sigma_BR": sigma}
        return {**point, "dq": dq, "dw": omega - c @ omega_r, "torque_B": self.control(point)}

    def rates(self, t: float, x: Array) -> Array:
        return self._rates(x, self.signals(t, x))

    def _rates(self, x: Array, y: dict[str, Array]) -> Array:
        return np.concatenate(
            [
                kinematics(x[:4], x[4:7]),
                body_acceleration(INERTIA, x[4:7], y["torque_B"]),
                kinematics(x[7:11], y["omega_RN_R"]),
                y["sigmaDot_BR"],
            ]
        )

    def lyapunov(self, t: float, x: Array) -> float:
        """V_0 (30), with the dot on sigma."""
        y = self.signals(t, x)
        dq, dw, ds = y["dq"], y["dw"], y["sigmaDot_BR"]
        attitude = self.a * (dq[1:] @ dq[1:] + (dq[0] - 1) ** 2)
        return float(attitude + dw @ INERTIA @ dw / 2 + self.b / 2 * ds @ ds)

    def lyapunov_rate(self, t: float, x: Array) -> float:
        """-b |sigmaDot|^2."""
        ds = self.signals(t, x)["sigmaDot_BR"]
        return float(-self.b * ds @ ds)

    def run(self, times: Array) -> Array:
        """States on the grid ``times``, and last the integral of ``lyapunov_rate``, shape (N, 16)."""

        def flow(t: float, z: Array) -> Array:
            y = self.signals(t, z[:15])
            return np.append(self._rates(z[:15], y), -self.b * y["sigmaDot_BR"] @ y["sigmaDot_BR"])

        start = np.append(self.start, 0.0)
        solution = solve_ivp(flow, times[[0, -1]], start, "DOP853", times, rtol=1e-12, atol=1e-13)
        rows: Array = solution.y.T
        return rows


# --- the bounds of Sec. IV --------------------------------------------------------------------------------------------


def feed_forward_error(J: Array, J_hat: Array, c_tilde: Array, w: Array, w_dot: Array) -> Array:
    """eta^ - eta of (32) and (22) for a body rate w and acceleration w_dot of the reference, in B."""
    w_hat = c_tilde @ w
    eta_hat = skew(w_hat) @ J_hat @ w_hat + J_hat @ c_tilde @ w_dot
    return eta_hat - skew(w) @ J @ w - J @ w_dot


@dataclass(frozen=True)
class Errors:
    """A point of the uncertain error dynamics (23), (26): states, reference, and what is uncertain."""

    dq: Array
    dw: Array
    sigma: Array
    tilde: Array  # dq~
    tilde_rate: Array  # omega~
    w_r: Array
    w_r_dot: Array
    disturbance: Array
    J: Array
    J_hat: Array
    a: float
    b: float

    def split(self, x: Array) -> tuple[Array, Array, Array, Array]:
        return x[:4], x[4:7], x[7:11], x[11:15]

    @property
    def x(self) -> Array:
        return np.concatenate([self.dq, self.dw, self.sigma, self.tilde])

    def filter_rate(self, x: Array) -> Array:
        dq, _, sigma, tilde = self.split(x)
        return G(dq) @ tilde - sigma

    def rates(self, x: Array) -> Array:
        dq, dw, _, tilde = self.split(x)
        c, c_tilde = rotation(dq).as_matrix().T, rotation(tilde).as_matrix().T
        measured = G(dq) @ tilde
        w, w_hat = c @ self.w_r, c_tilde @ c @ self.w_r
        eta = skew(w) @ self.J @ w + self.J @ c @ self.w_r_dot
        eta_hat = skew(w_hat) @ self.J_hat @ w_hat + self.J_hat @ c_tilde @ c @ self.w_r_dot
        u = -self.a * measured[1:] - self.b / 2 * E(measured).T @ self.filter_rate(x) + eta_hat
        J_bar = 2 * self.J - np.trace(self.J) * np.eye(3)
        moment = -skew(dw) @ (self.J @ dw + J_bar @ w) + u - eta + self.disturbance
        dw_dot = np.linalg.solve(self.J, moment)
        return np.concatenate([E(dq) @ dw / 2, dw_dot, self.filter_rate(x), E(tilde) @ self.tilde_rate / 2])

    def V_0(self, x: Array) -> float:
        """(30)."""
        dq, dw, _, _ = self.split(x)
        ds = self.filter_rate(x)
        attitude = self.a * (dq[1:] @ dq[1:] + (dq[0] - 1) ** 2)
        return float(attitude + dw @ self.J @ dw / 2 + self.b / 2 * ds @ ds)

    def V(self, x: Array, c1: float, c2: float, c3: float) -> float:
        """(36), (37)."""
        dq, dw, _, _ = self.split(x)
        first = c1 * self.V_0(x) + dq[1:] @ self.J @ dw - 2 * c2 * (E(dq) @ dw / 2) @ self.filter_rate(x)
        return float(first + c3 / np.linalg.eigvalsh(self.J)[0] * self.V_0(x) ** 2)


class Conditions:
    """(40)-(89) for one choice of the free numbers, one scalar after the other."""

    def __init__(self, a: float, b: float, c1: float, c2: float, xi: Array, p: Mapping[str, float], J: Array) -> None:
        low, _, high = np.linalg.eigvalsh(J)
        tension = np.abs(2 * np.linalg.eigvalsh(J) - np.trace(J)).max()
        nu, nud, mv, mw, md = p["nu"], p["nu_dot"], p["mu_v"], p["mu_w"], p["mu_d"]
        m0 = np.sqrt(1 - mv**2)
        root = np.sqrt(high * (high - low))
        self.mu_eta = 4 * root * nu**2 * mv**2 + 2 * high * (2 * nu**2 + nud) * mv + (nu**2 + nud) * p["mu_J"]
        self.g1 = a * mv + self.mu_eta + md
        self.g2 = c1 * self.g1 + c2 * mw
        self.g3 = c1 * b * mw + c2 / low * self.g1
        self.c1, self.c2 = c1, c2
        self.factor = 0.5 + root / low
        self.slack = (c2 * m0 - high) * (1 - xi[0])
        self.c3 = self.factor**2 * c2**2 / (2 * b * self.slack)
        self.b = b
        self.g4 = 2 * self.c3 / low * (a * (1 - m0) + b * mv * p["filter"] + self.g1)
        self.g5 = 2 * self.c3 / low * b * mw
        upper = np.zeros((3, 3))
        upper[0, 1] = -(c1 * a * (1 - m0) + tension * nu) / 2
        upper[0, 2] = -(b / 2 + c2 * a / low) / 2
        upper[1, 2] = -(c1 * b * mv + c2 + c2 * tension * nu / low) / 2
        diagonal = np.array([a * m0, (c2 * m0 - high) * xi[0] / 2, (c1 - c2 / (2 * low)) * b])
        self.Q = np.diag(diagonal) + upper + upper.T
        k = diagonal * (1 - xi[1:])
        Q2 = self.Q - np.diag(k)
        Q3 = Q2[1:, 1:] - np.outer(Q2[1:, 0], Q2[0, 1:]) / Q2[0, 0]
        scale = np.diag(1 / np.sqrt([high / 2, b / 2]))
        self.inverse_k4 = np.linalg.eigvalsh(scale @ Q3 @ scale)[0]
        phi1 = (self.g4**2 / k[1] + self.g5**2 / k[2]) / 4
        phi2 = self.inverse_k4 - self.g2 * self.g4 / (2 * k[1]) - self.g3 * self.g5 / (2 * k[2])
        phi3 = (self.g1**2 / k[0] + self.g2**2 / k[1] + self.g3**2 / k[2]) / 4 + 4 * a * self.inverse_k4
        self.roots = np.sort(np.roots([phi1, -phi2, phi3]))  # of N_4 (75)
        self.gain4, self.gain5 = self.c3 / low, 2 * c1
        V0 = 2 * a * (1 - np.sqrt(1 - p["start_attitude"] ** 2)) + high / 2 * p["start_rate"] ** 2
        self.V_start = c1 * V0 + high * p["start_attitude"] * p["start_rate"] + self.c3 / low * V0**2

    def bound(self, z: Array, V_0: float) -> float:
        """The right-hand side of (60)."""
        n3 = self.c3 * self.b * z[2] ** 2 - self.factor * self.c2 * z[2] + self.slack / 2
        linear = np.array([self.g1, self.g2 + self.g4 * V_0, self.g3 + self.g5 * V_0])
        return float(-z @ self.Q @ z + linear @ z - n3 * z[1] ** 2)
