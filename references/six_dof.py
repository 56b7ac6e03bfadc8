"""Six-degree-of-freedom output feedback recomputed from the published equations with NumPy and SciPy only.

Equation numbers are those of Pan, Wong and Kapila. Everything is in the law's scaled units, time and mass too, where
the components convert at their ports; matrices are six by six and inverted numerically; the closed loop is the paper's
error dynamics (9), (10), (22), (23) in the body frame, not the motion of the body.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import block_diag

from . import velocity_free as orbit
from .observer_pd import Array, error, kinematics, rotation, skew

I3 = np.eye(3)


def T_of(q_e: Array) -> Array:
    """(29)."""
    return 0.5 * (q_e[0] * I3 + skew(q_e[1:]))


@dataclass(frozen=True)
class Law:
    """(29)-(48) at one point, in scaled units. Replaceable parts, to see what a wrong law would do."""

    m: float
    J: Array
    mu: float
    k: float
    k_0: float
    k_1: float
    inverse_of_T: Callable[[Array], Array] = lambda q: np.linalg.inv(T_of(q))
    force_sign: float = -1.0
    gradient_factor: float = 1.5
    omega_2_sign: float = 1.0
    filter_gamma: float = 1.0
    gyro_sign: float = -1.0
    damping: float = 2.0
    transposed: bool = True

    def gamma(self, q_e: Array) -> Array:
        return np.diag([self.k_0] * 3 + [self.k_1 / (1 - q_e[1:] @ q_e[1:]) ** 2] * 3)

    def omega_2(self, e_R: Array, q_e: Array, e_f: Array, w: Array) -> Array:
        turn = -self.inverse_of_T(q_e) @ (e_f[3:] + q_e[1:]) + w
        return np.concatenate([self.omega_2_sign * np.cross(turn, e_R), np.zeros(3)])

    def filter_rate(self, p: Array, e_R: Array, q_e: Array, w: Array) -> Array:
        """(34)."""
        r_0 = np.concatenate([e_R, q_e[1:]])
        e_f = p - self.k * r_0
        drive = self.k**2 * r_0 + self.filter_gamma * self.gamma(q_e) @ r_0
        return -(self.k + 1) * p + drive - self.k * self.omega_2(e_R, q_e, e_f, w)

    def control(self, R: Array, R_d: Array, q_e: Array, w: Array, w_dot: Array, e_f: Array) -> tuple[Array, Array]:
        """(48): force on the body, -f, and torque; R, R_d, w = C omega_d and w_dot = C omega_d' in B."""
        P = self.inverse_of_T(q_e)
        e_R = R_d - R
        r_0 = np.concatenate([e_R, q_e[1:]])
        size = np.linalg.norm(R)
        Z = R / size
        tensor = np.trace(self.J) * I3 + 2 * self.J - 5 * (Z @ self.J @ Z) * I3
        upper = self.m * self.mu * (R / size**3 - R_d / np.linalg.norm(R_d) ** 3)
        upper = upper + self.gradient_factor * self.mu / size**4 * tensor @ Z
        known = self.gyro_sign * np.cross(w, self.J @ w) - self.J @ w_dot
        known = known + 3 * self.mu / size**3 * np.cross(Z, self.J @ Z)
        N = np.concatenate([upper, P.T @ known])
        M = block_diag(self.m * I3, P.T @ self.J @ P)
        inner = (self.gamma(q_e) - np.eye(6)) @ r_0 - self.damping * e_f - self.omega_2(e_R, q_e, e_f, w)
        u = self.k * e_f - N - M @ inner - self.gamma(q_e) @ r_0
        return self.force_sign * u[:3], np.linalg.solve(P.T if self.transposed else P, u[3:])


def scales(p: Mapping[str, Any]) -> dict[str, float]:
    length, time, mass = (float(p[f"{n}_unit"]) for n in ("length", "time", "mass"))
    return {
        "length": length,
        "time": time,
        "mass": mass,
        "force": mass * length / time**2,
        "torque": mass * length**2 / time**2,
        "inertia": mass * length**2,
        "mu": length**3 / time**2,
    }


def law_of(p: Mapping[str, Any]) -> Law:
    s = scales(p)
    m, J, mu = (p.get("mass", 1.0), p.get("J_B", I3), p.get("mu", 1.0))
    k, k_0, k_1 = (float(p[n]) for n in ("k", "k_0", "k_1"))
    return Law(m / s["mass"], np.asarray(J) / s["inertia"], mu / s["mu"], k, k_0, k_1)


def filter_law(p: Mapping[str, Any]) -> tuple[Array, Array]:
    """e_f and p' per second."""
    s, law = scales(p), law_of(p)
    c, q_e = error(p["q_BN"], p["q_RN"])
    e_R = rotation(p["q_BN"]).inv().apply(p["r_RN_N"] - p["r_BN_N"]) / s["length"]
    state = np.concatenate([p["p_R"], p["p_eps"]])
    e_f = state - law.k * np.concatenate([e_R, q_e[1:]])
    return e_f, law.filter_rate(state, e_R, q_e, c @ p["omega_RN_R"] * s["time"]) / s["time"]


def control_law(p: Mapping[str, Any]) -> dict[str, Array]:
    s, law = scales(p), law_of(p)
    turn = rotation(p["q_BN"]).inv()
    c, q_e = error(p["q_BN"], p["q_RN"])
    R, R_d = turn.apply(p["r_BN_N"]) / s["length"], turn.apply(p["r_RN_N"]) / s["length"]
    w, w_dot = c @ p["omega_RN_R"] * s["time"], c @ p["omegaDot_RN_R"] * s["time"] ** 2
    force, torque = law.control(R, R_d, q_e, w, w_dot, np.concatenate([p["e_f_R"], p["e_f_eps"]]))
    return {
        "force_B": force * s["force"],
        "torque_B": torque * s["torque"],
        "r_RB_B": turn.apply(p["r_RN_N"] - p["r_BN_N"]),
        "q_BR": q_e,
    }


def plant_rates(p: Mapping[str, Any]) -> dict[str, Array]:
    """(1), (13); and with them f_d and tau_g."""
    turn, mu = rotation(p["q_BN"]), float(p["mu"])
    r = turn.inv().apply(p["r_BN_N"])
    size = np.linalg.norm(r)
    Z, J = r / size, p["J_B"]
    f_d = -1.5 * mu / size**4 * ((np.trace(J) * I3 + 2 * J) @ Z - 5 * (Z @ J @ Z) * Z)
    tau_g = 3 * mu / size**3 * skew(Z) @ J @ Z
    pull = -mu / size**3 * p["r_BN_N"]
    moment = p["torque_B"] + tau_g - skew(p["omega_BN_B"]) @ J @ p["omega_BN_B"]
    return {
        "r_BN_N": p["v_BN_N"],
        "v_BN_N": pull + turn.apply(f_d + p["force_B"]) / p["mass"],
        "q_BN": kinematics(p["q_BN"], p["omega_BN_B"]),
        "omega_BN_B": np.linalg.solve(J, moment),
        "f_d": f_d,
        "tau_g": tau_g,
    }


def point_mass_wrench(mu: float, R: Array, points: Array, masses: Array) -> tuple[Array, Array]:
    """Force and torque of gravity on point masses at ``points`` from their centre of mass at R: nothing expanded."""
    places = R + points
    forces = -mu * masses[:, None] * places / np.linalg.norm(places, axis=1)[:, None] ** 3
    return forces.sum(axis=0), np.cross(points, forces).sum(axis=0)


UNITS = {"length_unit": 1.0, "time_unit": 20.0, "mass_unit": 20.0}
BODY = {
    "mass": 100.0,
    "J_B": np.array([[22, 0.8, -0.5], [0.8, 18, 0.6], [-0.5, 0.6, 15]]),
    "mu": 398.6004418e12,
    "k": 3.0,
    "k_0": 2.0,
    "k_1": 1.5,
}
ORBIT = {
    "semi_major_axis": 7e6,
    "eccentricity": 0.02,
    "inclination": np.deg2rad(51.6),
    "ascending_node": 0.0,
    "argument_of_perigee": 0.0,
    "mean_anomaly": 0.0,
    "mu": 398.6004418e12,
}
S = scales(UNITS)


def reference_rate(t: float) -> tuple[Array, Array]:
    """omega_d and its derivative in SI units."""
    nu, phase, size = np.array([0.02, 0.03, 0.025]), np.array([0, 1, 2.0]), np.array([0.004, 0.003, 0.005])
    return np.array([0, -0.0011, 0]) + size * np.sin(nu * t + phase), size * nu * np.cos(nu * t + phase)


@dataclass(frozen=True)
class Loop:
    """The error dynamics in scaled units, state z = [e_R, e_V, q_e, omega, p, q_d]; ``law`` may be a wrong one."""

    law: Law = field(default_factory=lambda: law_of({**UNITS, **BODY}))

    @property
    def start(self) -> Array:
        axis = np.array([1, 2, -1]) / np.sqrt(6)
        q_e = np.append(np.cos(np.pi / 8), np.sin(np.pi / 8) * axis)
        c = rotation(q_e).as_matrix().T
        omega = (np.array([0.01, -0.008, 0.006]) - c @ reference_rate(0.0)[0]) * S["time"]
        e_R, e_V = c @ [-20, 15, -10], c @ [-0.05, -0.02, 0.03] * S["time"]
        return np.concatenate([e_R, e_V, q_e, omega, self.law.k * e_R, self.law.k * q_e[1:], np.eye(4)[0]])

    def surroundings(self, tau: float, z: Array) -> dict[str, Array]:
        """What the laws need of the reference, in B and in scaled units, at the scaled time tau."""
        omega_d, omega_d_dot = reference_rate(tau * S["time"])
        c = rotation(z[6:10]).as_matrix().T
        R_d_N, _ = orbit.kepler(ORBIT | {"time": tau * S["time"]})
        R_d = c @ rotation(z[19:23]).inv().apply(R_d_N)
        scaled = (c @ omega_d * S["time"], c @ omega_d_dot * S["time"] ** 2)
        return {"w": scaled[0], "w_dot": scaled[1], "R_d": R_d, "R": R_d - z[:3], "omega_d": omega_d * S["time"]}

    def rates(self, tau: float, z: Array, right: Law | None = None) -> Array:
        """The body obeys the right equations of motion whatever the law thinks."""
        body, law = right or self.law, self.law
        e_R, e_V, q_e, omega, p, q_d = np.split(z, [3, 6, 10, 13, 19])
        s = self.surroundings(tau, z)
        w, w_dot, R, R_d = s["w"], s["w_dot"], s["R"], s["R_d"]
        e_f = p - law.k * np.concatenate([e_R, q_e[1:]])
        force, torque = law.control(R, R_d, q_e, w, w_dot, e_f)
        omega_b = omega + w
        size = np.linalg.norm(R)
        tensor = np.trace(body.J) * I3 + 2 * body.J - 5 * (R @ body.J @ R) / size**2 * I3
        e_V_dot = -np.cross(omega_b, e_V) - body.mu * R_d / np.linalg.norm(R_d) ** 3 + body.mu * R / size**3
        e_V_dot = e_V_dot + 1.5 * body.mu / (body.m * size**5) * tensor @ R - force / body.m  # (10), f = -force
        gravity = 3 * body.mu / size**5 * np.cross(R, body.J @ R)
        moment = -np.cross(omega_b, body.J @ omega_b) + body.J @ (np.cross(omega, w) - w_dot) + gravity + torque  # (22)
        return np.concatenate(
            [
                e_V - np.cross(omega_b, e_R),  # (9)
                e_V_dot,
                kinematics(q_e, omega),
                np.linalg.solve(body.J, moment),
                law.filter_rate(p, e_R, q_e, w),
                kinematics(q_d, s["omega_d"]),
            ]
        )

    def auxiliary(self, z: Array) -> tuple[Array, Array]:
        """e_f (33) and eta (35)."""
        e_R, e_V, q_e, omega, p = np.split(z[:19], [3, 6, 10, 13])
        r_0 = np.concatenate([e_R, q_e[1:]])
        e_f = p - self.law.k * r_0
        return e_f, np.concatenate([e_V, T_of(q_e) @ omega]) + e_f + r_0

    def lyapunov(self, z: Array) -> float:
        """(50)."""
        e_f, eta = self.auxiliary(z)
        eps, law = z[7:10], self.law
        y = np.concatenate([eta[:3], np.linalg.solve(T_of(z[6:10]), eta[3:])])
        potential = law.k_0 * z[:3] @ z[:3] + e_f @ e_f + law.k_1 * eps @ eps / (1 - eps @ eps)
        return float(potential + y @ block_diag(law.m * I3, law.J) @ y) / 2

    def lyapunov_rate(self, tau: float, z: Array) -> float:
        """(54) with (25), (46), (47): chi_1 and chi_2 as printed."""
        law = self.law
        e_R, e_V, q_e, omega = np.split(z[:13], [3, 6, 10])
        e_f, eta = self.auxiliary(z)
        eps, J, w = q_e[1:], law.J, self.surroundings(tau, z)["w"]
        T = T_of(q_e)
        P = np.linalg.inv(T)
        q_dot = kinematics(q_e, omega)
        T_dot = T_of(q_dot)  # T is linear in the quaternion
        coriolis = P.T @ J @ P @ T_dot @ P + P.T @ skew(J @ P @ q_dot[1:]) @ P
        tau_un = (skew(J @ w) - skew(w) @ J - J @ skew(w)) @ omega
        chi = np.concatenate([-law.m * np.cross(omega + w, e_V), P.T @ tau_un - coriolis @ (e_f[3:] + eps)])
        chi_1 = np.concatenate([chi[:3], T.T @ chi[3:]])
        M = block_diag(law.m * I3, P.T @ J @ P)
        chi_2 = (law.k * e_f + (law.k - 1) * M @ eta) @ np.vstack([skew(P @ eta[3:]), np.zeros((3, 3))])
        y = np.concatenate([eta[:3], P @ eta[3:]])
        M_hat = block_diag(law.m * I3, J)
        decay = law.k_0 * e_R @ e_R + e_f @ e_f + law.k_1 * eps @ eps / (1 - eps @ eps) ** 2
        return float(-decay - (law.k - 1) * y @ M_hat @ y + y @ chi_1 + e_R @ chi_2)

    def run(self, times: Array) -> Array:
        """z on the grid of scaled times, shape (N, 23)."""
        solution = solve_ivp(self.rates, times[[0, -1]], self.start, "DOP853", times, rtol=1e-11, atol=1e-10)
        rows: Array = solution.y.T
        return rows
