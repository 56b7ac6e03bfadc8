"""The adaptive laws for unknown, variable inertia, and the bodies they are made for."""

from collections.abc import Callable

import numpy as np

from .. import adaptive as ref
from .. import observer_pd as reference
from ..adaptive import DIAGONAL, MASSES, Adaptation, errors, every_element
from ..law import Law, Point, Values, inertia, quaternion
from ..observer_pd import Array, rotation

Draw = Callable[[np.random.Generator], Point]


def tracking_point(rng: np.random.Generator) -> Point:
    return {
        "q_BN": quaternion(rng),
        "omega_BN_B": rng.normal(size=3),
        "q_RN": quaternion(rng),
        "omega_RN_R": rng.normal(size=3),
        "omegaDot_RN_R": rng.normal(size=3),
    }


def certainty_point(rng: np.random.Generator) -> Point:
    """Half of the points lie where the projection of theta_est may act; its start value does not."""
    theta = rng.normal(size=6)
    theta *= rng.uniform(40, 60) / np.linalg.norm(theta)
    bound = np.linalg.norm(theta) * rng.choice([0.9, 1.1])
    gains = {"beta": rng.uniform(1, 30), "k_v": rng.uniform(1, 30), "gamma_1": rng.uniform(0, 80)}
    projection = {"theta_bound": bound, "theta_margin": rng.uniform(0.6, 1) * bound}
    return {**tracking_point(rng), **gains, **projection, "theta_est": theta}


def estimate_point(rng: np.random.Generator, name: str, shape: tuple[int, ...], size: float) -> Point:
    estimate = rng.normal(size=shape) * size
    bound = np.linalg.norm(estimate) * rng.choice([0.9, 1.1])
    # rates of moderate size, so that differences resolve them
    projection = {"sigma_bound": bound, "sigma_margin": rng.uniform(0.6, 1) * bound}
    return {name: estimate, "gamma_2": rng.uniform(0, 8), **projection}


def appendage_motion(rng: np.random.Generator) -> Point:
    return {"position_B": rng.normal(size=(2, 3)), "velocity_B": rng.normal(size=(2, 3))}


def tracking_errors(p: Values) -> ref.Errors:
    return errors(p["q_BN"], p["omega_BN_B"], p["q_RN"], p["omega_RN_R"], p["omegaDot_RN_R"])


def certainty_equivalence(p: Values, name: str, basis: Array) -> tuple[Point, Point]:
    """Outputs and derivatives of a law whose estimate of J_1 is called `name`, in the given parametrisation."""
    e, omega = tracking_errors(p), p["omega_BN_B"]
    W = ref.w_1(e, omega)
    u = -p["beta"] * e.q_e[1:] - p["k_v"] * e.omega_e - W @ p["theta_est"]
    theta_law = Adaptation(p["gamma_1"], p["theta_bound"], p["theta_margin"])
    outputs = {"q_BR": e.q_e, "omega_BR_B": e.omega_e, "theta_est": p["theta_est"]}
    rates = {"theta_est": theta_law.rate(p["theta_est"], W.T @ e.s)}
    if name:
        sigma = np.ravel(p[name])
        if "position_B" in p:
            W = ref.w_2(e, omega, basis, ref.point_psi(p["position_B"]))
            W = W + ref.w_3(e, omega, basis, ref.point_psi_dot(p["position_B"], p["velocity_B"]))
        else:
            unit_rate = ref.w_3(e, omega, basis, np.eye(3))
            W = ref.w_2(e, omega, basis, p["torque_impulse"] * np.eye(3))
            norm = ref.implicit_norm(u - W @ sigma, unit_rate @ sigma)
            W = W + norm * unit_rate
            rates["torque_impulse"] = np.array(norm)
            outputs |= {"torque_impulse": p["torque_impulse"], "torque_norm": np.array(norm)}
            outputs["implementability"] = 1 - np.linalg.norm(unit_rate @ sigma)
        u = u - W @ sigma
        sigma_law = Adaptation(p["gamma_2"], p["sigma_bound"], p["sigma_margin"])
        rates[name] = sigma_law.rate(sigma, W.T @ e.s).reshape(np.shape(p[name]))
        outputs[name] = p[name]
    return {**outputs, "torque_B": u}, rates


def certainty_law(draw: Draw, name: str = "", basis: Array | None = None, start: Point | None = None) -> Law:
    used = np.zeros((0, 3, 3)) if basis is None else basis
    return Law(
        draw=draw,
        outputs=lambda p: certainty_equivalence(p, name, used)[0],
        rates=lambda p: certainty_equivalence(p, name, used)[1],
        smooth=slow("theta", "gamma_1") | (slow("sigma", "gamma_2") if name else {}) | (start or {}),
    )


def slow(estimate: str, gain: str) -> Point:
    """Adaptation without projection, by which the torque changes little in a second."""
    return {f"{estimate}_bound": np.array(1e6), f"{estimate}_margin": np.array(1e6), gain: np.array(0.02)}


def comparison(p: Values) -> dict[str, Array]:
    arguments = (p["theta_est"], p["omega_f"], np.reshape(p["W_f"], (3, 6)), p["gamma"], p["k_p"], p["k_w"])
    return ref.comparison_law(tracking_errors(p), p["omega_BN_B"], *arguments)


def body_rates(p: Values, J: Array, J_dot: Array, torque: Array) -> Point:
    omega = p["omega_BN_B"]
    right = -J_dot @ omega - reference.skew(omega) @ J @ omega + torque
    return {"q_BN": reference.kinematics(p["q_BN"], omega), "omega_BN_B": np.linalg.solve(J, right)}


def body_outputs(p: Values, J: Array) -> Point:
    momentum = rotation(p["q_BN"]).apply(J @ p["omega_BN_B"])
    return {"q_BN": p["q_BN"], "omega_BN_B": p["omega_BN_B"], "J_B": J, "H_N": momentum}


def loaded(p: Values) -> Array:
    return p["J_0_B"] + np.asarray(np.kron(p["mass"], np.eye(3)) @ ref.point_psi(p["position_B"]))


def loaded_rate(p: Values) -> Array:
    return np.asarray(np.kron(p["mass"], np.eye(3)) @ ref.point_psi_dot(p["position_B"], p["velocity_B"]))


def body_point(rng: np.random.Generator) -> Point:
    torques = {"torque_B": rng.normal(size=3), "torque_disturbance_B": rng.normal(size=3)}
    return {"q_BN": quaternion(rng), "omega_BN_B": rng.normal(size=3), **torques}


def fuel_point(rng: np.random.Generator) -> Point:
    """The tank is never quite empty, and J stays definite."""
    J_1 = 1e-3 * inertia(rng)
    fuel = rng.uniform(100, 200)
    J_0 = inertia(rng) + fuel * J_1
    return {**body_point(rng), "J_0_B": J_0, "J_1_B": J_1, "fuel": fuel, "torque_impulse": 0.9 * fuel * rng.uniform()}


def fuel_rates(p: Values) -> Point:
    norm = np.linalg.norm(p["torque_B"])
    J = p["J_0_B"] - p["torque_impulse"] * p["J_1_B"]
    torque = p["torque_B"] + p["torque_disturbance_B"]
    return {**body_rates(p, J, -norm * p["J_1_B"], torque), "torque_impulse": np.array(norm)}


def fuel_outputs(p: Values) -> Point:
    J = p["J_0_B"] - p["torque_impulse"] * p["J_1_B"]
    own = {"torque_impulse": p["torque_impulse"], "fuel_left": p["fuel"] - p["torque_impulse"]}
    return {**body_outputs(p, J), **own}


def paths_of(p: Values) -> ref.Appendage:
    return ref.Appendage(tuple(map(tuple, p["position_B_0"])), float(p["extension"]), float(p["frequency"]))


LAWS = {
    "AppendagePaths": Law(
        draw=lambda rng: {
            "position_B_0": rng.normal(size=(2, 3)),
            "extension": rng.uniform(0, 2),
            "frequency": rng.uniform(0, 1),
            "time": rng.uniform(0, 20),
        },
        outputs=lambda p: {
            "position_B": paths_of(p).positions(float(p["time"])),
            "velocity_B": paths_of(p).velocities(float(p["time"])),
        },
    ),
    "AppendageBody": Law(
        draw=lambda rng: {
            **body_point(rng),
            **appendage_motion(rng),
            "J_0_B": inertia(rng),
            "mass": rng.uniform(0, 3, 2),
        },
        outputs=lambda p: body_outputs(p, loaded(p)),
        rates=lambda p: body_rates(p, loaded(p), loaded_rate(p), p["torque_B"] + p["torque_disturbance_B"]),
    ),
    "FuelLossBody": Law(draw=fuel_point, outputs=fuel_outputs, rates=fuel_rates),
    "AdaptiveTracking": certainty_law(certainty_point),
    "AdaptiveAppendageTracking": certainty_law(
        lambda rng: {**certainty_point(rng), **appendage_motion(rng), **estimate_point(rng, "mass_est", (2,), 1)},
        "mass_est",
        MASSES,
    ),
    "AdaptiveAppendageTrackingFull": certainty_law(
        lambda rng: {**certainty_point(rng), **appendage_motion(rng), **estimate_point(rng, "J_1_est", (3, 6), 1)},
        "J_1_est",
        every_element(6),
    ),
    "AdaptiveFuelTracking": certainty_law(
        lambda rng: {
            **certainty_point(rng),
            **estimate_point(rng, "sigma_est", (3,), 0.05),
            "torque_impulse": rng.uniform(0, 20),
        },
        "sigma_est",
        DIAGONAL,
    ),
    "AdaptiveFuelTrackingFull": certainty_law(
        lambda rng: {
            **certainty_point(rng),
            **estimate_point(rng, "J_1_est", (3, 3), 0.03),
            "torque_impulse": rng.uniform(0, 20),
        },
        "J_1_est",
        every_element(3),
        {"J_1_est": np.diag([1e-3, 2e-3, 3e-3]) + 1e-4, "torque_impulse": np.array(1.0), "gamma_2": np.array(1e-6)},
    ),
    "NonCertaintyEquivalenceTracking": Law(
        draw=lambda rng: {
            **tracking_point(rng),
            "k_p": rng.uniform(0.1, 2),
            "k_w": rng.uniform(0.1, 2),
            "gamma": rng.uniform(0, 10),
            "theta_est": rng.normal(size=6) * 10,
            "omega_f": rng.normal(size=3),
            "W_f": rng.normal(size=(3, 6)),
        },
        outputs=lambda p: {
            "q_BR": comparison(p)["q_e"],
            "omega_BR_B": comparison(p)["omega_e"],
            "torque_B": comparison(p)["torque"],
            "theta_sum": comparison(p)["theta_sum"],
            **{name: p[name] for name in ("theta_est", "omega_f", "W_f")},
        },
        rates=lambda p: {
            "theta_est": comparison(p)["theta_dot"],
            "omega_f": comparison(p)["omega_f_dot"],
            "W_f": comparison(p)["W_f_dot"],
        },
    ),
}
