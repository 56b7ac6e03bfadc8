"""The thesis' closed loops recomputed with NumPy, many runs side by side, from its equations and not from the C++ code.

Where a sign or a transposition could be wrong, another road than the printed formula is taken: the error and the
direction cosines come from quaternions; the Jacobians of the error from kinematics, since sigma_e is the attitude of R
relative to B: sigma_e' = N(sigma_e) (omega_RO_R - C(sigma_e) omega_BO_B); the plant is integrated in MRP, and its
disturbances come from the angular momentum. Equation numbers are those of the thesis.

Arrays have one row per run; vectors are (R, 3), matrices (R, 3, 3). SI units. All numbers of the thesis that a loop
needs are written here again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[Any]
DEG = np.pi / 180
J = np.diag([37 / 12, 37 / 12, 25 / 12])
K_1 = np.array([-1.0, 1.0, 0.5])


def dot(a: Array, b: Array) -> Array:
    return np.asarray(np.sum(a * b, axis=-1, keepdims=True))


def times(matrix: Array, v: Array) -> Array:
    return np.asarray(np.einsum("...ij,...j->...i", matrix, v))


def quaternion(sigma: Array) -> Array:
    """Scalar first (3.18)."""
    square = dot(sigma, sigma)
    return np.concatenate([1 - square, 2 * sigma], axis=-1) / (1 + square)


def mrp(q: Array) -> Array:
    """Within 180 degrees (3.8), (3.12)."""
    q = np.where(q[..., :1] < 0, -q, q)
    return q[..., 1:] / (1 + q[..., :1])


def difference(sigma: Array, sigma_r: Array) -> Array:
    """sigma_r (x) (-sigma): C(q_RB) = C(q_RO) C(q_BO)^T, by Hamilton's product of conj(q_BO) and q_RO."""
    b, r = quaternion(sigma), quaternion(sigma_r)
    scalar = dot(b, r)
    vector = b[..., :1] * r[..., 1:] - r[..., :1] * b[..., 1:] - np.cross(b[..., 1:], r[..., 1:])
    return mrp(np.concatenate([scalar, vector], axis=-1))


def columns(sigma: Array) -> tuple[Array, Array]:
    """c_2 and c_3: the second and third axis of O, seen in B."""
    q = quaternion(sigma)
    _, second, third = np.eye(3)
    return turned(q, second), turned(q, third)


def turned(q: Array, v: Array) -> Array:
    """C(q) v."""
    scalar, vector = q[..., :1], q[..., 1:]
    v = np.broadcast_to(v, vector.shape)
    t = 2 * np.cross(vector, v)
    return v - scalar * t + np.cross(vector, t)


def rate_of(sigma: Array, omega: Array) -> Array:
    """N(sigma) omega (3.21), without the matrix."""
    return 0.25 * ((1 - dot(sigma, sigma)) * omega + 2 * np.cross(sigma, omega) + 2 * sigma * dot(sigma, omega))


def inverse_rate(sigma: Array, sigma_dot: Array) -> Array:
    """N(sigma)^-1 sigma_dot = 16 N^T sigma_dot / (1 + |sigma|^2)^2."""
    square = dot(sigma, sigma)
    transposed = (1 - square) * sigma_dot - 2 * np.cross(sigma, sigma_dot) + 2 * sigma * dot(sigma, sigma_dot)
    return 4 * transposed / (1 + square) ** 2


def w_times(error: Array, omega: Array) -> Array:
    """W omega = -N(sigma_e) C(sigma_e) omega."""
    return -rate_of(error, turned(quaternion(error), omega))


def w_transposed(error: Array, v: Array) -> Array:
    """W^T v = -C(sigma_e)^T N(sigma_e)^T v, and N^T v is N of the opposite turn."""
    q = quaternion(error)
    back = np.concatenate([q[..., :1], -q[..., 1:]], axis=-1)
    return -turned(back, rate_of(-error, v))


def w_inverse(error: Array, v: Array) -> Array:
    """W^-1 v = -C(sigma_e)^T N(sigma_e)^-1 v."""
    q = quaternion(error)
    back = np.concatenate([q[..., :1], -q[..., 1:]], axis=-1)
    return -turned(back, inverse_rate(error, v))


def gravity(n: Array, c_3: Array, inertia: Array) -> Array:
    return 3 * n**2 * np.cross(c_3, times(inertia, c_3))


def shortened(x: Array, limit: float) -> Array:
    """(C.8)."""
    size = np.linalg.norm(x, axis=-1, keepdims=True)
    return np.where(size > limit, x * limit / np.where(size > 0, size, 1), x)


def projected(estimate: Array, rate: Array, limit: float, delta: float) -> Array:
    """(C.16)."""
    excess, along = dot(estimate, estimate) - limit**2, dot(estimate, rate)
    acts = (excess > 0) & (along > 0)
    square = np.where(acts, dot(estimate, estimate), 1.0)
    return np.where(acts, rate - excess / (delta * square) * along * estimate, rate)


def fal(e: Array, alpha: float, delta: float) -> Array:
    """(8.42)."""
    return np.where(np.abs(e) > delta, np.abs(e) ** alpha * np.sign(e), e / delta ** (1 - alpha))


@dataclass(frozen=True)
class Mode:
    """One run. `mutant` names a deliberate mistake."""

    controller: str
    scenario: str
    slew_start: float = 20.62
    lag: int = 1
    by_difference: bool = True
    acceleration_limit: float = 0.10 * DEG
    held: bool = True
    parallel_axis: bool = True
    mirror: tuple[float, float, float] = (0.05, 0.05, 0.005)
    inertia_twice: bool = True
    torque_delay: int = 1
    update_first: int = 1
    n: float = 1.073e-3
    mutant: str = ""


@dataclass
class Batch:
    """All `modes` at once, controlled every `period` s, with plant steps of 0.01 s."""

    modes: Sequence[Mode]
    period: float = 0.1
    scan_start: float = 500.0
    gain: dict[str, float] = field(default_factory=lambda: {"tf": 15.0, "ii": 50.0, "neso": 5.0})
    torque_limit: float = 0.05 * float(np.sqrt(4 / 3))
    from_first_command: bool = False  # the start of the runs at 5 Hz

    def __post_init__(self) -> None:
        modes = self.modes
        tilt = Rotation.from_euler("ZYX", [10, 10, 10], degrees=True).as_matrix().T  # 3-2-1: turns frames
        self.inertia_0 = np.array([tilt @ J @ tilt.T if m.scenario == "mismatch" else J for m in modes])
        self.inverse_0 = np.linalg.inv(self.inertia_0)
        self.n = np.array([[m.n] for m in modes])
        self.damping = np.array([[0.0 if m.controller == "bs" else 1.0] for m in modes])
        # The part's spin: inertia that its spin is multiplied with, for wheel and mirror.
        beta = 19.471 * DEG
        self.axis = np.array([np.cos(beta), 0.0, np.sin(beta)])
        self.swing_axis = Rotation.from_euler("ZYX", [45, 45, 0], degrees=True).apply([0.0, 0.0, 1.0])

    def rows(self, **of: object) -> list[int]:
        return [i for i, m in enumerate(self.modes) if all(getattr(m, k) == v for k, v in of.items())]

    def wheel_momentum(self, mode: Mode) -> Array:
        r = np.array([0.043, 0.0, 0.014])
        spin = 0.055**2 / 2 * self.axis
        if mode.parallel_axis:
            spin = spin + 1.0 * np.cross(r, np.cross(self.axis, r))
        return spin * 4200 * 2 * np.pi / 60

    def mirror_torque(self, mode: Mode, t: float, row: int, sigma: Array, omega: Array, torque: Array) -> Array:
        """From the balance of angular momentum, solved for what a body of inertia J_0 would need besides."""
        length, width, height = mode.mirror
        own = 0.03 / 12 * np.diag([height**2 + width**2, length**2 + height**2, length**2 + width**2])
        frame = Rotation.from_euler("ZYX", [45, 45, 0], degrees=True)
        q, swing = 2 * np.pi / 15, 45 * DEG
        angle, speed, change = (
            swing * np.sin(q * t),
            swing * q * np.cos(q * t),
            -swing * q**2 * np.sin(q * t),
        )

        def in_body(at: float) -> Array:
            turn = (frame * Rotation.from_rotvec([0.0, 0.0, at])).as_matrix()
            return np.asarray(turn @ own @ turn.T)

        a = self.swing_axis
        j_b, j_b0 = in_body(angle), in_body(45 * DEG)
        step = 1e-20  # complex step of the inertia's rate: only the turn about the axis depends on time
        c, s = np.cos(angle + 1j * step), np.sin(angle + 1j * step)
        turn = frame.as_matrix() @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        j_dot = np.imag(turn @ own @ turn.T) / step * speed
        r = np.array([0.30, 0.20, 0.20])
        spin = j_b @ a + (0.03 * np.cross(r, np.cross(a, r)) if mode.parallel_axis else 0.0)
        j_0 = self.inertia_0[row]
        j = j_0 + j_b - j_b0
        n = self.n[row]
        c_3 = columns(sigma)[1]
        w = omega
        momentum_rate = torque + 3 * n**2 * np.cross(c_3, j @ c_3)
        momentum_rate = momentum_rate - np.cross(w, j @ w) - np.cross(w, spin * speed)
        momentum_rate = momentum_rate - j_dot @ (w + a * speed) - spin * change
        acceleration = np.linalg.solve(j, momentum_rate)
        return np.asarray(j_0 @ acceleration + np.cross(w, j_0 @ w) - 3 * n**2 * np.cross(c_3, j_0 @ c_3) - torque)

    def mismatch_torque(self, row: int, sigma: Array, omega: Array, torque: Array) -> Array:
        """What a body of the known inertia lacks to be accelerated like the true one."""
        c_3, n, j_0 = columns(sigma)[1], self.n[row], self.inertia_0[row]

        def acceleration(inertia: Array, more: Array) -> Array:
            moment = 3 * n**2 * np.cross(c_3, inertia @ c_3) - np.cross(omega, inertia @ omega) + torque + more
            return np.asarray(np.linalg.solve(inertia, moment))

        return np.asarray(j_0 @ (acceleration(J, np.zeros(3)) - acceleration(j_0, np.zeros(3))))

    def disturbance(self, t: float, sigma: Array, omega: Array, torque: Array, mask: Sequence[int]) -> Array:
        """For the runs `mask`; a mismatch that is not held is in the plant itself."""
        total = np.zeros_like(omega)
        for i in mask:
            mode = self.modes[i]
            if mode.scenario == "wheel":
                total[i] = np.cross(self.wheel_momentum(mode), omega[i])
            elif mode.scenario == "mirror":
                total[i] = self.mirror_torque(mode, t, i, sigma[i], omega[i], torque[i])
            elif mode.scenario == "mismatch" and mode.held:
                total[i] = self.mismatch_torque(i, sigma[i], omega[i], torque[i])
        return total

    def reference(self, mode: Mode, k: int, state: dict[str, float]) -> tuple[Array, Array]:
        """(D.6), (9.8): sigma_r and its rate."""
        dt, direction = self.period, K_1 / np.linalg.norm(K_1)
        t = (k - mode.lag) * dt
        u = min(max(0.3 * DEG * (t - mode.slew_start), 0.0), 30 * DEG)
        weight = dt / (30 + dt)
        state["theta"] = state.get("theta", 0.0) + weight * (u - state.get("theta", 0.0))
        theta, slope = state["theta"], (u - state["theta"]) / 30
        if t > self.scan_start - 1e-7:
            phase = 2 * np.pi * (t - self.scan_start) / 300
            theta, slope = 30 * DEG * np.cos(phase), -30 * DEG * 2 * np.pi / 300 * np.sin(phase)
        size = np.tan(theta / 4)
        rate = (1 + size**2) * slope / 4
        if mode.by_difference:
            rate = (size - state.get("size", 0.0)) / dt if k else 0.0
        state["size"] = float(size)
        return size * direction, rate * direction

    def run(self, stop: float) -> dict[str, Array]:
        """Signals at the control instants, (K + 1, R, ...)."""
        modes, dt, h = self.modes, self.period, 0.01
        runs, steps, inner = len(modes), round(stop / self.period), round(self.period / 0.01)
        zero = np.zeros((runs, 3))
        sigma, omega = zero.copy(), zero.copy()
        if self.from_first_command:
            omega = omega - self.n * np.array([0.0, 1.0, 0.0])
        x_c, chi_1, chi_2, chi_2_dot, torque = zero.copy(), zero.copy(), zero.copy(), zero.copy(), zero.copy()
        state, omega_hat, before = zero.copy(), omega.copy(), zero.copy()
        reference_states: list[dict[str, float]] = [{} for _ in modes]
        work = np.zeros((runs, 1))
        tf, ii, neso = (self.rows(controller=c) for c in ("tf", "ii", "neso"))
        held, free = self.rows(held=True), self.rows(held=False)
        first = np.array([[m.update_first == 1] for m in modes])
        delayed = np.array([[m.torque_delay == 1] for m in modes])
        twice = np.array([[[m.inertia_twice]] for m in modes])
        acceleration_limits = np.array([[m.acceleration_limit] for m in modes])
        beta_2 = self.gain["neso"] * np.where(twice, self.inertia_0 @ self.inertia_0, self.inertia_0)
        sign = np.array([[-1.0 if m.mutant == "chi sign" else 1.0] for m in modes])
        true = np.array([j if m.held else J for m, j in zip(modes, self.inertia_0, strict=True)])
        inverse = np.linalg.inv(true)
        stored: dict[str, list[Array]] = {}

        def keep(**values: Array) -> None:
            for name, value in values.items():
                stored.setdefault(name, []).append(value.copy())

        def flow(s: Array, w: Array, u: Array, d: Array) -> tuple[Array, Array]:
            c_2, c_3 = columns(s)
            w_dot = u + d + gravity(self.n, c_3, true) - np.cross(w, times(true, w))
            return rate_of(s, w + self.n * c_2), times(inverse, w_dot)

        for k in range(steps + 1):
            t = k * dt
            pairs = [self.reference(m, k, s) for m, s in zip(modes, reference_states, strict=True)]
            sigma_r, sigma_r_dot = (np.array(x) for x in zip(*pairs, strict=True))
            z_1 = difference(sigma, sigma_r)
            c_2, c_3 = columns(sigma)
            forward = rate_of(z_1, inverse_rate(sigma_r, sigma_r_dot))
            raw = -self.n * c_2 - w_inverse(z_1, forward + 0.1 * z_1) - chi_2
            if k == 0 and self.from_first_command:
                x_c = raw.copy()
            wanted = (shortened(raw, DEG) - x_c) / dt
            size = np.linalg.norm(wanted, axis=-1, keepdims=True)
            x_c_dot = wanted * np.minimum(1.0, acceleration_limits / np.where(size > 0, size, 1.0))
            x_c = x_c + dt * x_c_dot
            z_2 = omega - x_c
            z_1_bar, z_2_bar = z_1 - sign * chi_1, z_2 - sign * chi_2
            v = x_c_dot - z_2 - self.damping * z_2_bar - w_transposed(z_1, z_1_bar)

            estimate = zero.copy()
            step = zero.copy()
            if tf:
                step[tf] = dt * projected(state, self.gain["tf"] * z_2_bar, 0.1, 0.001)[tf]
            if ii:
                bracket = v + chi_2 + chi_2_dot
                step[ii] = -dt * self.gain["ii"] * times(self.inverse_0, bracket)[ii]
                if k == 0:
                    state[ii] = -self.gain["ii"] * times(self.inverse_0, omega)[ii]
            ahead = np.where(first & (k > 0), step, 0.0)
            state = state + ahead
            estimate[tf] = state[tf]
            estimate[ii] = (state + self.gain["ii"] * times(self.inverse_0, omega))[ii]
            state = state + np.where(first, 0.0, step)
            estimate[neso] = state[neso]

            gyroscopic, gradient = np.cross(omega, times(self.inertia_0, omega)), gravity(self.n, c_3, self.inertia_0)
            torque_raw = gyroscopic - gradient + times(self.inertia_0, v) - estimate
            change = (shortened(torque_raw, self.torque_limit) - torque) / dt
            torque = torque + dt * shortened(change, 6.0)
            if neso:
                acting = np.where(delayed, before, torque)
                e = omega_hat - omega
                known = times(self.inverse_0, gradient - gyroscopic + acting + state)
                margin = 0.02 * DEG**2
                hat_dot = projected(omega_hat, known - fal(e, 0.2, 0.1), 2 * DEG, margin)
                xi_dot = projected(state, -times(beta_2, fal(e, 0.4, 0.3)), 0.1, 0.001)
                innovation = -e
                omega_hat = omega_hat + dt * hat_dot
                state[neso] = (state + dt * xi_dot)[neso]
                keep(innovation=innovation)
            before = torque.copy()
            d = self.disturbance(t, sigma, omega, torque, held)
            now = d + self.disturbance(t, sigma, omega, torque, free)
            omega_dot = flow(sigma, omega, torque, now)[1]
            unmodelled = times(self.inertia_0, omega_dot) + gyroscopic - gradient - torque
            keep(
                sigma=sigma, omega=omega, sigma_r=sigma_r, z_1=z_1, z_2=z_2, torque=torque, x_c=x_c,
                estimate=estimate, work=work, unmodelled=unmodelled,
            )  # fmt: skip
            chi_1 = chi_1 + dt * (-0.1 * chi_1 + w_times(z_1, x_c - raw))
            chi_2_dot = -chi_2 + times(self.inverse_0, torque - torque_raw)
            chi_2 = chi_2 + dt * chi_2_dot
            if k == steps:
                break
            for j in range(inner):
                if free:  # exchanged with the plant at each of its steps
                    now = d + self.disturbance(t + j * h, sigma, omega, torque, free)
                elif j == 0:
                    now = d
                s_1, w_1 = flow(sigma, omega, torque, now)
                s_2, w_2 = flow(sigma + h / 2 * s_1, omega + h / 2 * w_1, torque, now)
                s_3, w_3 = flow(sigma + h / 2 * s_2, omega + h / 2 * w_2, torque, now)
                s_4, w_4 = flow(sigma + h * s_3, omega + h * w_3, torque, now)
                stages = (omega, omega + h / 2 * w_1, omega + h / 2 * w_2, omega + h * w_3)
                power = [np.abs(w * torque).sum(axis=-1, keepdims=True) for w in stages]
                work = work + h / 6 * (power[0] + 2 * power[1] + 2 * power[2] + power[3])
                sigma = sigma + h / 6 * (s_1 + 2 * s_2 + 2 * s_3 + s_4)
                omega = omega + h / 6 * (w_1 + 2 * w_2 + 2 * w_3 + w_4)
        return {name: np.array(rows) for name, rows in stored.items()}
