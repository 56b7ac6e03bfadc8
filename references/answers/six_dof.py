"""Body, filter, law and actuator in six degrees of freedom."""

import numpy as np

from .. import six_dof as ref
from .. import velocity_free as orbit
from ..law import Law, Point, Values, inertia, of_the_whole, quaternion
from ..observer_pd import Array, rotation


def place(rng: np.random.Generator) -> Array:
    return rotation(quaternion(rng)).apply([rng.uniform(6.6e6, 1e7), 0, 0])


def error_point(rng: np.random.Generator) -> Point:
    """Positions a few metres apart, attitudes whose difference is anything up to 170 degrees."""
    r, q_RN = place(rng), quaternion(rng)
    axis = rng.normal(size=3)
    half = rng.uniform(0, np.deg2rad(85))
    error = np.append(np.cos(half), np.sin(half) * axis / np.linalg.norm(axis))
    units = {"length_unit": rng.uniform(0.5, 5), "time_unit": rng.uniform(1, 50), "mass_unit": rng.uniform(1, 50)}
    gains = {"k": rng.uniform(2, 5), "k_0": rng.uniform(1, 5), "k_1": rng.uniform(1.1, 5)}
    motion = {"r_RN_N": r + 10 * rng.normal(size=3), "q_RN": q_RN, "omega_RN_R": 0.01 * rng.normal(size=3)}
    return {**units, **gains, **motion, "r_BN_N": r, "q_BN": orbit.G(q_RN) @ error}


def filter_point(rng: np.random.Generator) -> Point:
    p_eps = rng.normal(size=3)
    return error_point(rng) | {"p_R": 30 * rng.normal(size=3), "p_eps": p_eps / np.linalg.norm(p_eps)}


def control_point(rng: np.random.Generator) -> Point:
    body = {"mass": rng.uniform(10, 200), "J_B": inertia(rng), "mu": 3.986e14 * rng.uniform(0.9, 1.1)}
    signals = {"e_f_R": 10 * rng.normal(size=3), "e_f_eps": rng.normal(size=3)}
    return error_point(rng) | body | signals | {"omegaDot_RN_R": 1e-3 * rng.normal(size=3)}


def filter_outputs(p: Values) -> Point:
    e_f, _ = ref.filter_law(p)
    return {"p_R": p["p_R"], "p_eps": p["p_eps"], "e_f_R": e_f[:3], "e_f_eps": e_f[3:]}


def plant_outputs(p: Values) -> Point:
    rates = ref.plant_rates(p)
    states = {n: p[n] for n in ("r_BN_N", "v_BN_N", "q_BN", "omega_BN_B")}
    forces = {"gravity_gradient_force_B": rates["f_d"], "gravity_gradient_torque_B": rates["tau_g"]}
    return {**states, **forces, "altitude": np.linalg.norm(p["r_BN_N"]) - p["earth_radius"]}


def actuated(p: Values) -> Point:
    limited = {
        name: np.clip(p[f"{name}_command_B"], -(p[limit] or np.inf), p[limit] or np.inf)
        for name, limit in (("force", "max_force"), ("torque", "max_torque"))
    }
    spent = {"impulse": p["impulse"], "angular_impulse": p["angular_impulse"]}
    return {"force_B": limited["force"], "torque_B": limited["torque"], **spent}


# Positions are differences of numbers of 7e6 m, of which double precision resolves 1e-9 m: 1e-12 is relative to what
# goes into a result. For e_R and all that is proportional to it these are the positions themselves.
ROUNDING_OF_POSITIONS = 1e-16 * 7e6


def of_the_body(name: str, expected: Array, point: Values) -> Array:
    return np.asarray(1e-12 * float(np.abs(expected).max()))


def steepness(point: Values) -> float:
    """Of P, and of Gamma with its k_1, towards 180 degrees."""
    half = 0.5 * float(np.linalg.norm(point["q_BN"] - point["q_RN"]))
    return 1 / max(1e-2, 1 - half**2) ** 2


def of_the_filter(name: str, expected: Array, point: Values) -> Array:
    """1e-12 of the size of a result, and what the rounding of positions becomes in it."""
    gains = (1 + float(point["k"])) ** 2 + float(point["k_0"])
    positions = 4 * gains * ROUNDING_OF_POSITIONS / float(point["length_unit"])
    return (of_the_whole(name, expected, point) + positions) * steepness(point)


def of_the_law(name: str, expected: Array, point: Values) -> Array:
    s = ref.scales(point)
    gains = (1 + float(point["k"])) ** 2 + float(point["k_0"])
    masses = 1 + float(point["mass"]) / s["mass"]
    positions = 8 * gains * masses * ROUNDING_OF_POSITIONS / s["length"] * s["force"]
    return (of_the_whole(name, expected, point) + positions) * steepness(point)


POSITIONS = {"r_BN_N": 100.0, "r_RN_N": 100.0}


LAWS = {
    "SixDofBody": Law(
        rounding=of_the_body,
        draw=lambda rng: {
            "mass": rng.uniform(10, 200),
            "J_B": inertia(rng),
            "mu": 3.986e14 * rng.uniform(0.9, 1.1),
            "earth_radius": 6.371e6,
            "r_BN_N": place(rng),
            "v_BN_N": 5e3 * rng.normal(size=3),
            "q_BN": quaternion(rng),
            "omega_BN_B": rng.normal(size=3),
            "force_B": rng.normal(size=3),
            "torque_B": rng.normal(size=3),
        },
        outputs=plant_outputs,
        rates=lambda p: {
            n: v for n, v in ref.plant_rates(p).items() if n in ("r_BN_N", "v_BN_N", "q_BN", "omega_BN_B")
        },
    ),
    "PoseErrorFilter": Law(
        rounding=of_the_filter,
        lengths=POSITIONS,
        draw=filter_point,
        outputs=filter_outputs,
        rates=lambda p: {"p_R": ref.filter_law(p)[1][:3], "p_eps": ref.filter_law(p)[1][3:]},
    ),
    "SixDofOutputFeedback": Law(draw=control_point, outputs=ref.control_law, rounding=of_the_law, lengths=POSITIONS),
    "ForceTorqueActuator": Law(
        rounding=of_the_whole,
        lengths={"max_force": 0.0, "max_torque": 0.0},
        draw=lambda rng: {
            "max_force": rng.choice([0.0, 0.5, 1.0]),
            "max_torque": rng.choice([0.0, 0.5, 1.0]),
            "force_command_B": rng.normal(size=3),
            "torque_command_B": rng.normal(size=3),
            "impulse": rng.uniform(),
            "angular_impulse": rng.uniform(),
        },
        outputs=actuated,
        rates=lambda p: {
            "impulse": np.linalg.norm(actuated(p)["force_B"]),
            "angular_impulse": np.linalg.norm(actuated(p)["torque_B"]),
        },
    ),
}
