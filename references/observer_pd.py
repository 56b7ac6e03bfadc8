"""Observer-based attitude tracking without a gyro, recomputed from the published equations with NumPy and SciPy only.

Equation numbers are those of the dissertation: rigid body (2.12)-(2.13), PD (5.1) and (5.27), observer (5.11)-(5.12).
Wherever a sign or a transposition could be wrong, another road than the printed formula is taken, so that a mistake
cannot be shared with the components: rotations are composed and turned into matrices by ``scipy.spatial.transform``,
rdot comes from the complex step, the reference attitude from its differential equation.

Quaternions are scalar first; ``C_BN`` takes components in N to components in B; SI units throughout.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

Array = NDArray[Any]


def skew(v: Array) -> Array:
    """S(v), with S(v) w = v x w."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def rotation(q: Array) -> Rotation:
    """The rotation whose matrix is C(q)^T: SciPy turns vectors, the dissertation turns frames."""
    return Rotation.from_quat(q, scalar_first=True)


def error(q: Array, q_other: Array) -> tuple[Array, Array]:
    """C(q) C(q_other)^T (5.5) and its quaternion, continuous through 180 degrees: the scalar part is q . q_other."""
    turned = rotation(q_other).inv() * rotation(q)
    q_e = turned.as_quat(scalar_first=True)
    return turned.as_matrix().T, q_e if q_e[0] * (q @ q_other) >= 0 else -q_e


def kinematics(q: Array, omega: Array) -> Array:
    """qdot = 1/2 E(q) omega, with E = [-q_v^T; q_0 I + S(q_v)]."""
    return 0.5 * np.vstack([-q[1:], q[0] * np.eye(3) + skew(q[1:])]) @ omega


@dataclass(frozen=True)
class Reference:
    """omega_R = r(t) axis, from q_R(0); r [rad/s] is the profile of sec. 5.4."""

    amplitude: float = 0.1
    frequency: float = 1.0
    decay: float = 0.01
    ramp: float = 0.08 * np.pi
    wobble: float = 0.006
    axis: tuple[float, ...] = (1.0, 1.0, 1.0)
    q_0: tuple[float, ...] = (float(np.sqrt(1 - 3 * 0.1826**2)), 0.1826, 0.1826, 0.1826)

    def rate(self, t: float | complex) -> complex:
        fade = np.exp(-self.decay * t**2)
        swing = self.amplitude * np.cos(self.frequency * t) * (1 - fade)
        return swing + (self.ramp + self.wobble * np.sin(self.frequency * t)) * t * fade

    def omega(self, t: float) -> Array:
        return self.rate(t).real * np.array(self.axis)

    def omega_dot(self, t: float) -> Array:
        """By complex step: exact to rounding, without a second formula."""
        return self.rate(t + 1e-30j).imag / 1e-30 * np.array(self.axis)

    def attitude(self, angle: float) -> Array:
        """q_R after the integral of r reached ``angle``: the exponential of the kinematics about the fixed axis."""
        generator = np.column_stack([kinematics(e, np.array(self.axis)) for e in np.eye(4)])
        return expm(generator * angle) @ np.array(self.q_0)


def body_acceleration(inertia: Array, omega: Array, torque: Array) -> Array:
    """J omegadot = -S(omega) J omega + u."""
    return np.linalg.solve(inertia, torque - skew(omega) @ inertia @ omega)


def pd_torque(
    inertia: Array, k_p: float, k_v: float, q: Array, omega: Array, q_r: Array, omega_r: Array, omega_r_dot: Array
) -> Array:
    """(5.1); with the observer's estimate for omega it is (5.27)."""
    c_e, q_e = error(q, q_r)
    omega_r_b = c_e @ omega_r
    return (
        -k_p * q_e[1:] - k_v * (omega - omega_r_b) + inertia @ c_e @ omega_r_dot + skew(omega_r_b) @ inertia @ omega_r_b
    )


def observer_rates(
    inertia: Array, lam: float, gamma: float, q: Array, torque: Array, q_hat: Array, omega_hat: Array
) -> tuple[Array, Array]:
    """Derivatives of q_hat (5.11) and omega_hat (5.12)."""
    c_t, q_t = error(q, q_hat)
    q_tv, omega_b = q_t[1:], c_t @ omega_hat
    moment = gamma * q_tv - skew(omega_b) @ inertia @ omega_b + torque - lam * inertia @ skew(q_tv) @ omega_b
    return kinematics(q_hat, omega_hat + lam * c_t.T @ q_tv), c_t.T @ np.linalg.solve(inertia, moment)


def control_lyapunov(inertia: Array, k_p: float, q_e: Array, omega_e: Array) -> float:
    """V_c (5.2)."""
    return float(k_p * ((1 - q_e[0]) ** 2 + q_e[1:] @ q_e[1:]) + 0.5 * omega_e @ inertia @ omega_e)


def observer_lyapunov(inertia: Array, gamma: float, q_t: Array, omega_t: Array) -> float:
    """V_o (5.19)."""
    return float(gamma * (q_t[1:] @ q_t[1:] + (q_t[0] - 1) ** 2) + 0.5 * omega_t @ inertia @ omega_t)


@dataclass(frozen=True)
class Settings:
    """Sec. 5.4; q_hat(0) = q(0)."""

    inertia: Array = field(default_factory=lambda: np.array([[10, 1.2, 0.5], [1.2, 19, 1.5], [0.5, 1.5, 25]]))
    q: tuple[float, ...] = (float(np.sqrt(1 - 3 * 0.1**2)), -0.1, 0.1, -0.1)
    omega: tuple[float, ...] = (0.005, 0.006, 0.004)
    omega_hat: tuple[float, ...] = (-0.03, 0.01, -0.02)
    k_p: float = 1.5
    k_v: float = 5.0
    lam: float = 1.0
    gamma: float = 3.0
    reference: Reference = field(default_factory=Reference)


@dataclass(frozen=True)
class Loop:
    """A closed loop. ``control`` and ``observe`` may be replaced, to see what a wrong law would do.

    The state is [q, omega, q_R], followed by [q_hat, omega_hat] where there is an observer.
    """

    with_observer: bool
    settings: Settings = field(default_factory=Settings)
    control: Callable[..., Array] = pd_torque
    observe: Callable[..., tuple[Array, Array]] = observer_rates

    @cached_property
    def start(self) -> Array:
        s = self.settings
        estimates = [s.q, s.omega_hat] if self.with_observer else []
        return np.concatenate([s.q, s.omega, s.reference.q_0, *estimates])

    def signals(self, t: float, x: Array) -> dict[str, Array]:
        """Every signal of the loop at (t, x)."""
        s = self.settings
        q, omega, q_r = x[:4], x[4:7], x[7:11]
        omega_r, omega_r_dot = s.reference.omega(t), s.reference.omega_dot(t)
        c_e, q_e = error(q, q_r)
        y = {"q": q, "omega": omega, "q_e": q_e, "omega_e": omega - c_e @ omega_r}
        y |= {"q_r": q_r, "omega_r": omega_r, "omega_r_dot": omega_r_dot}
        y |= {"omega_est": omega, "omega_t": np.zeros(3)}
        if self.with_observer:
            q_hat, omega_hat = x[11:15], x[15:18]
            c_t, q_t = error(q, q_hat)
            estimate = c_t @ omega_hat
            y |= {"q_hat": q_hat, "omega_hat": omega_hat, "q_t": q_t}
            y |= {"omega_est": estimate, "omega_t": omega - estimate}
        y["torque"] = self.control(s.inertia, s.k_p, s.k_v, q, y["omega_est"], q_r, omega_r, omega_r_dot)
        return y

    def rates(self, t: float, x: Array) -> Array:
        return self._rates(self.signals(t, x))

    def _rates(self, y: dict[str, Array]) -> Array:
        s = self.settings
        parts = [
            kinematics(y["q"], y["omega"]),
            body_acceleration(s.inertia, y["omega"], y["torque"]),
            kinematics(y["q_r"], y["omega_r"]),
        ]
        if self.with_observer:
            parts += self.observe(s.inertia, s.lam, s.gamma, y["q"], y["torque"], y["q_hat"], y["omega_hat"])
        return np.concatenate(parts)

    def lyapunov(self, t: float, x: Array) -> Array:
        """[V_c, V_o]; V_o is absent without observer."""
        s, y = self.settings, self.signals(t, x)
        values = [control_lyapunov(s.inertia, s.k_p, y["q_e"], y["omega_e"])]
        if self.with_observer:
            values.append(observer_lyapunov(s.inertia, s.gamma, y["q_t"], y["omega_t"]))
        return np.array(values)

    def lyapunov_rates(self, y: dict[str, Array]) -> Array:
        """What the proofs say of the signals y: V_c' = -k_v |omega_e|^2 + k_v omega_e . omega_t (5.3, 5.31) and
        V_o' = -gamma lam |q_tv|^2 (5.22)."""
        s = self.settings
        values = [-s.k_v * y["omega_e"] @ (y["omega_e"] - y["omega_t"])]
        if self.with_observer:
            values.append(-s.gamma * s.lam * y["q_t"][1:] @ y["q_t"][1:])
        return np.array(values)

    def run(self, times: Array, rtol: float = 1e-13, atol: float = 1e-14) -> dict[str, Array]:
        """Integrate with DOP853; every signal on the grid ``times`` (row by row), the state ``x``, and the integrals of
        ``lyapunov_rates`` as ``lyapunov_integrals``, carried along as extra states."""
        n = self.start.size

        def flow(t: float, z: Array) -> Array:
            y = self.signals(t, z[:n])
            return np.concatenate([self._rates(y), self.lyapunov_rates(y)])

        solution = solve_ivp(
            flow,
            (times[0], times[-1]),
            np.concatenate([self.start, np.zeros(1 + self.with_observer)]),
            method="DOP853",
            t_eval=times,
            rtol=rtol,
            atol=atol,
        )
        if not solution.success:
            raise RuntimeError(solution.message)
        x = solution.y[:n].T
        rows = [self.signals(t, row) for t, row in zip(times, x, strict=True)]
        signals = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        return {**signals, "time": times, "x": x, "lyapunov_integrals": solution.y[n:].T}


def rate_along(function: Callable[[float, Array], Array], t: float, x: Array, x_dot: Array, h: float = 2e-3) -> Array:
    """d/dt of function(t, x) along x_dot: central differences of sixth order, error about 1e-12 for unit-size rates."""
    weights = {1: 3 / 4, 2: -3 / 20, 3: 1 / 60}
    steps = [
        w / h * (function(t + k * h, x + k * h * x_dot) - function(t - k * h, x - k * h * x_dot))
        for k, w in weights.items()
    ]
    return np.sum(steps, axis=0)
