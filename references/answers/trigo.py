"""Plant, guidance, disturbances and sampled laws of the loops in MRP."""

import itertools
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from .. import trigo as ref
from ..law import Law, Point, Sampled, Values, definite, inertia, of_the_whole, quaternion
from ..observer_pd import Array, body_acceleration, kinematics, rate_along, rotation

PERIOD = 0.25


def mrp(rng: np.random.Generator, largest: float = 0.55) -> Array:
    """Each component within its bound, and |sigma| < 1."""
    return rng.uniform(-largest, largest, 3)


def orbit_axes(q_BO: Array) -> Array:
    """C_BO, by SciPy, which turns vectors where the thesis turns frames."""
    return rotation(q_BO).as_matrix().T


def gravity(n: float, c_3: Array, j: Array) -> Array:
    return 3 * n**2 * np.cross(c_3, j @ c_3)


def body(p: Values) -> dict[str, Array]:
    c = orbit_axes(p["q_BO"])
    omega, n = p["omega_BN_B"], p["orbital_rate"]
    torque = p["torque_B"] + p["torque_disturbance_B"] + gravity(n, c[:, 2], p["J_B"])
    return {
        "relative": omega - c @ np.array([0.0, -n, 0.0]),
        "acceleration": body_acceleration(p["J_B"], omega, torque),
        "c_3": c[:, 2],
    }


def body_outputs(p: Values) -> Point:
    found, omega, j_0 = body(p), p["omega_BN_B"], p["J0_B"]
    momentum_rate = j_0 @ found["acceleration"] + np.cross(omega, j_0 @ omega)
    known = gravity(p["orbital_rate"], found["c_3"], j_0) + p["torque_B"]
    return {
        "q_BO": p["q_BO"],
        "omega_BN_B": omega,
        "workload": p["workload"],
        "sigma_BO": rotation(p["q_BO"]).as_mrp(),
        "omega_BO_B": found["relative"],
        "torque_unmodelled_B": momentum_rate - known,
    }


def body_rates(p: Values) -> Point:
    found = body(p)
    return {
        "q_BO": kinematics(p["q_BO"], found["relative"]),
        "omega_BN_B": found["acceleration"],
        "workload": np.abs(p["omega_BN_B"] * p["torque_B"]).sum(),
    }


def profile(p: Values) -> Point:
    """The low-pass by the numerical solution of its differential equation."""
    t, angle, tau = float(p["time"]), float(p["angle"]), float(p["time_constant"])
    start, rate = float(p["slew_start"]), float(p["slew_rate"])

    def wanted(at: float) -> float:
        return float(np.clip(rate * (at - start), 0, angle))

    knots = sorted({x for x in (start, start + angle / rate) if 0 < x < t} | {0.0, t})
    theta = 0.0
    if start < 0:  # what has passed before t = 0
        knots = sorted({x for x in (start, start + angle / rate) if x < t} | {t})
    for a, b in itertools.pairwise(knots):
        flow = solve_ivp(
            lambda at, y: [(wanted(at) - y[0]) / tau], (a, b), [theta], "DOP853", rtol=1e-13, atol=1e-14, max_step=tau
        )
        theta = float(flow.y[0, -1])
    slope = (wanted(t) - theta) / tau
    if t >= p["scan_start"]:
        w = 2 * np.pi / float(p["scan_period"])
        theta = angle * np.cos(w * (t - p["scan_start"]))
        slope = -w * angle * np.sin(w * (t - p["scan_start"]))
    turn = Rotation.from_rotvec(theta * p["axis"] / np.linalg.norm(p["axis"]))
    omega = slope * p["axis"] / np.linalg.norm(p["axis"])
    sigma = turn.as_mrp()
    return {"theta": np.array(theta), "sigma_RO": sigma, "sigmaDot_RO": ref.rate_of(sigma, omega)}


def swinging(p: Values) -> Point:
    """A body J_0 with a part in it, by the balance of the angular momentum of the whole."""
    q, t = 2 * np.pi / p["swing_period"], p["time"]
    frame = Rotation.from_euler("ZYX", [p["euler"][2], p["euler"][1], p["euler"][0]])

    def part(angle: float) -> Array:
        turn = (frame * Rotation.from_rotvec([0, 0, angle])).as_matrix()
        return np.asarray(turn @ np.diag(p["J_A"]) @ turn.T)

    angle = p["amplitude"] * np.sin(q * t)
    speed, change_ = p["amplitude"] * q * np.cos(q * t), -(q**2) * angle
    a = frame.as_matrix()[:, 2]
    j_dot = rate_along(lambda _, x: part(float(x[0])), 0.0, np.array([angle]), np.array([1.0]), h=2e-3) * speed
    j_0, w, n = p["J0_B"], p["omega_BN_B"], p["orbital_rate"]
    j = j_0 + part(angle) - part(float(p["angle_0"]))
    spin = part(angle) @ a + p["J_offset_B"] @ a
    c_3 = Rotation.from_mrp(p["sigma_BO"]).as_matrix().T[:, 2]
    moment = p["torque_control_B"] + gravity(n, c_3, j) - np.cross(w, j @ w + spin * speed)
    acceleration = np.linalg.solve(j, moment - j_dot @ (w + a * speed) - spin * change_)
    torque = j_0 @ acceleration + np.cross(w, j_0 @ w) - gravity(n, c_3, j_0) - p["torque_control_B"]
    return {"torque_B": torque, "angle": np.array(angle)}


def mismatched(p: Values) -> Point:
    c_3 = Rotation.from_mrp(p["sigma_BO"]).as_matrix().T[:, 2]

    def acceleration(j: Array) -> Array:
        return body_acceleration(j, p["omega_BN_B"], p["torque_control_B"] + gravity(p["orbital_rate"], c_3, j))

    return {"torque_B": p["J0_B"] @ (acceleration(p["J_B"]) - acceleration(p["J0_B"]))}


def spinning(p: Values) -> Point:
    a = p["axis"] / np.linalg.norm(p["axis"])
    total = p["inertia"] * np.eye(3) + p["J_offset_B"]
    momentum = total @ a * (p["speed"] + p["acceleration"] * p["time"])
    return {"H_B": momentum, "torque_B": np.cross(momentum, p["omega_BN_B"]) - total @ a * p["acceleration"]}


def symmetric(rng: np.random.Generator) -> Array:
    x = rng.normal(size=(3, 3))
    return x + x.T


LAWS = {
    "OrbitingBody": Law(
        rounding=of_the_whole,
        draw=lambda rng: {
            "J_B": inertia(rng),
            "J0_B": inertia(rng),
            "orbital_rate": rng.uniform(0, 0.5),
            "q_BO": quaternion(rng),
            "omega_BN_B": rng.normal(size=3),
            "workload": rng.uniform(0, 1),
            "torque_B": rng.normal(size=3),
            "torque_disturbance_B": rng.normal(size=3),
        },
        outputs=body_outputs,
        rates=body_rates,
    ),
    "ScanningReference": Law(
        rounding=of_the_whole,
        draw=lambda rng: {
            "axis": rng.normal(size=3),
            "angle": rng.uniform(0.1, 3.0),
            "slew_rate": rng.uniform(0.05, 1),
            "slew_start": rng.uniform(-2, 4),
            "time_constant": rng.uniform(0.5, 4),
            "scan_start": 12.0,
            "scan_period": rng.uniform(1, 9),
            "time": rng.uniform(0, 20),
        },
        outputs=profile,
    ),
    "SpinningWheel": Law(
        rounding=of_the_whole,
        draw=lambda rng: {
            "omega_BN_B": rng.normal(size=3),
            "axis": rng.normal(size=3),
            "inertia": rng.uniform(0.1, 1),
            "speed": rng.normal(),
            "acceleration": rng.normal(),
            "J_offset_B": symmetric(rng),
            "time": rng.uniform(0, 5),
        },
        outputs=spinning,
    ),
    "OscillatingPayload": Law(
        rounding=of_the_whole,
        draw=lambda rng: {
            "sigma_BO": mrp(rng),
            "omega_BN_B": rng.normal(size=3),
            "torque_control_B": rng.normal(size=3),
            "J0_B": inertia(rng),
            "J_A": rng.uniform(0.1, 1, 3),
            "euler": rng.uniform(-1, 1, 3),
            "amplitude": rng.uniform(0.2, 1),
            "swing_period": rng.uniform(5, 20),
            "angle_0": rng.normal(),
            "J_offset_B": symmetric(rng),
            "orbital_rate": rng.uniform(0, 0.5),
            "time": rng.uniform(0, 20),
        },
        outputs=swinging,
    ),
    "InertiaMismatch": Law(
        rounding=of_the_whole,
        draw=lambda rng: {
            "sigma_BO": mrp(rng),
            "omega_BN_B": rng.normal(size=3),
            "torque_control_B": rng.normal(size=3),
            "J_B": inertia(rng),
            "J0_B": inertia(rng),
            "orbital_rate": rng.uniform(0, 0.5),
        },
        outputs=mismatched,
    ),
}


def rows(*vectors: Array) -> tuple[Array, ...]:
    return tuple(np.atleast_2d(v) for v in vectors)


def backstepping(p: Values, memory: dict[str, Any], u: Values) -> Point:
    dt, n, j_0 = p["period"], np.array([[p["orbital_rate"]]]), p["J0_B"]
    sigma, omega, sigma_r, sigma_r_dot, estimate = rows(
        u["sigma_BO"], u["omega_BN_B"], u["sigma_RO"], u["sigmaDot_RO"], u["torque_disturbance_B_est"]
    )
    c = {k: p[k][None] for k in ("c_1", "c_2", "K", "J0_B")}
    chi_1, chi_2, chi_2_dot = (memory.get(k, np.zeros((1, 3))) for k in ("chi_1", "chi_2", "chi_2_dot"))
    z_1 = ref.difference(sigma, sigma_r)
    c_2, c_3 = ref.columns(sigma)
    forward = ref.rate_of(z_1, ref.inverse_rate(sigma_r, sigma_r_dot))
    raw = -n * c_2 - ref.w_inverse(z_1, forward + ref.times(c["c_1"], z_1)) - chi_2
    before = memory.get("x_c", raw if p["start_at_command"] else np.zeros((1, 3)))
    x_dot = ref.shortened((ref.shortened(raw, p["rate_limit"]) - before) / dt, p["acceleration_limit"])
    x_c = before + dt * x_dot
    z_2 = omega - x_c
    z_1_bar, z_2_bar = z_1 - chi_1, z_2 - chi_2
    v = x_dot - ref.times(c["c_2"], z_2) - ref.times(c["K"], z_2_bar) - ref.w_transposed(z_1, z_1_bar)
    expected = v + ref.times(c["c_2"], chi_2) + chi_2_dot
    gyroscopic = np.cross(omega, ref.times(c["J0_B"], omega))
    torque_raw = gyroscopic - ref.gravity(n, c_3, c["J0_B"]) + ref.times(c["J0_B"], v) - estimate
    torque = memory.get("torque", np.zeros((1, 3)))
    wanted = (ref.shortened(torque_raw, p["torque_limit"]) - torque) / dt
    torque = torque + dt * ref.shortened(wanted, p["torque_rate_limit"])
    chi_2_dot = -ref.times(c["c_2"], chi_2) + np.linalg.solve(j_0, (torque - torque_raw)[0])
    memory["chi_1"] = chi_1 + dt * (-ref.times(c["c_1"], chi_1) + ref.w_times(z_1, x_c - raw))
    memory["chi_2"], memory["chi_2_dot"] = chi_2 + dt * chi_2_dot, chi_2_dot
    memory["x_c"], memory["torque"] = x_c, torque
    found = {
        "torque_B": torque,
        "torque_raw_B": torque_raw,
        "omega_c_B": x_c,
        "omega_c_raw_B": raw,
        "omegaDot_c_B": x_dot,
        "sigma_RB": z_1,
        "z_2_B": z_2,
        "z_1_bar_B": z_1_bar,
        "z_2_bar_B": z_2_bar,
        "acceleration_expected_B": expected,
    }
    return {name: value[0] for name, value in found.items()}


def tuning(p: Values, memory: dict[str, Any], u: Values) -> Point:
    state = memory.get("state", np.zeros(3))
    step = p["period"] * ref.projected(state, p["G"] @ u["z_2_bar_B"], p["limit"], p["margin"] * p["limit"] ** 2)
    if p["update_first"]:
        used = state + step if "state" in memory else state
        memory["state"] = used
    else:
        used = state
        memory["state"] = state + step
    return {"torque_disturbance_B_est": used}


def invariance(p: Values, memory: dict[str, Any], u: Values) -> Point:
    gain = p["gamma"] * np.linalg.inv(p["J0_B"])
    beta = gain @ u["omega_BN_B"]
    state = memory.get("state", -beta)
    step = -p["period"] * gain @ u["acceleration_expected_B"]
    if p["update_first"]:
        state = state + step if "state" in memory else state
        memory["state"] = state
        return {"torque_disturbance_B_est": state + beta}
    memory["state"] = state + step
    return {"torque_disturbance_B_est": state + beta}


def extended(p: Values, memory: dict[str, Any], u: Values) -> Point:
    omega, dt = u["omega_BN_B"], p["period"]
    hat = np.asarray(memory.get("hat", omega))
    xi = memory.get("xi", np.zeros(3))
    torque = memory.get("torque", np.zeros(3)) if p["torque_delay"] else u["torque_B"]
    c_3 = Rotation.from_mrp(u["sigma_BO"]).as_matrix().T[:, 2]
    e = hat - omega
    moment = gravity(p["orbital_rate"], c_3, p["J0_B"]) + torque + xi
    acceleration = body_acceleration(p["J0_B"], omega, moment)
    hat_dot = acceleration - p["beta_1"] @ ref.fal(e, p["alpha_1"], p["delta_1"])
    xi_dot = -p["beta_2"] @ ref.fal(e, p["alpha_2"], p["delta_2"])
    limits = [(p[f"{x}_limit"], p[f"{x}_margin"] * p[f"{x}_limit"] ** 2) for x in ("rate", "torque")]
    memory["hat"] = hat + dt * ref.projected(hat, hat_dot, *limits[0])
    memory["xi"] = xi + dt * ref.projected(xi, xi_dot, *limits[1])
    memory["torque"] = u["torque_B"]
    return {"torque_disturbance_B_est": xi, "omega_BN_B_est": hat, "innovation_B": -e}


SAMPLED = {
    "BacksteppingControl": Sampled(
        step=backstepping,
        draw=lambda rng: {
            "J0_B": inertia(rng),
            "c_1": definite(rng),
            "c_2": definite(rng),
            "K": definite(rng),
            "orbital_rate": rng.uniform(0, 0.5),
            "rate_limit": rng.uniform(1, 20),
            "acceleration_limit": rng.uniform(5, 50),
            "torque_limit": rng.uniform(20, 2000),
            "torque_rate_limit": rng.uniform(100, 10000),
            "period": np.array(PERIOD),
            "start_at_command": rng.integers(2),
        },
        inputs=lambda rng: {
            "sigma_BO": mrp(rng),
            "sigma_RO": mrp(rng),
            "sigmaDot_RO": rng.normal(size=3),
            "omega_BN_B": rng.normal(size=3),
            "torque_disturbance_B_est": rng.normal(size=3),
        },
    ),
    "TuningFunctionObserver": Sampled(
        step=tuning,
        revealing={"update_first": 1},
        draw=lambda rng: {
            "G": definite(rng),
            "limit": rng.uniform(0.2, 2),
            "margin": rng.uniform(0.1, 1),
            "period": np.array(PERIOD),
            "update_first": rng.integers(2),
        },
        inputs=lambda rng: {"z_2_bar_B": rng.normal(size=3)},
    ),
    "ImmersionInvarianceObserver": Sampled(
        step=invariance,
        revealing={"update_first": 1},
        draw=lambda rng: {
            "J0_B": inertia(rng),
            "gamma": rng.uniform(1, 50),
            "period": np.array(PERIOD),
            "update_first": rng.integers(2),
        },
        inputs=lambda rng: {"omega_BN_B": rng.normal(size=3), "acceleration_expected_B": rng.normal(size=3)},
    ),
    "NonlinearExtendedStateObserver": Sampled(
        step=extended,
        draw=lambda rng: {
            "J0_B": inertia(rng),
            "beta_1": definite(rng),
            "beta_2": definite(rng),
            "alpha_1": rng.uniform(0.1, 1),
            "alpha_2": rng.uniform(0.1, 1),
            "delta_1": rng.uniform(0.1, 1),
            "delta_2": rng.uniform(0.1, 1),
            "orbital_rate": rng.uniform(0, 0.5),
            "rate_limit": rng.uniform(0.5, 3),
            "rate_margin": rng.uniform(0.1, 1),
            "torque_limit": rng.uniform(0.5, 3),
            "torque_margin": rng.uniform(0.1, 1),
            "period": np.array(PERIOD),
            "torque_delay": rng.integers(2),
        },
        inputs=lambda rng: {
            "sigma_BO": mrp(rng),
            "omega_BN_B": rng.normal(size=3),
            "torque_B": rng.normal(size=3),
        },
    ),
}
