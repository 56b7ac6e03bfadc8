"""The velocity-free law, its filter, the orbit and what disturbs there."""

import numpy as np

from .. import velocity_free as ref
from ..law import Law, Point, Values, elementwise, inertia, quaternion
from ..observer_pd import Array, error, rotation


def orbit_point(rng: np.random.Generator) -> Point:
    e = rng.uniform(0, 0.6)
    return {
        "semi_major_axis": rng.uniform(7e6, 4e7) / (1 - e),
        "eccentricity": e,
        "inclination": rng.uniform(0, np.pi),
        "ascending_node": rng.uniform(-np.pi, np.pi),
        "argument_of_perigee": rng.uniform(-np.pi, np.pi),
        "mean_anomaly": rng.uniform(-np.pi, np.pi),
        "mu": 3.986e14 * rng.uniform(0.9, 1.1),
        "earth_radius": 6.371e6,
        "time": rng.uniform(0, 2e4),
    }


def orbit_outputs(p: Values) -> Point:
    r, v = ref.kepler(p)
    return {"r_ON_N": r, "v_ON_N": v, "altitude": np.linalg.norm(r) - p["earth_radius"]}


SCALES = {"r_ON_N": 1e7, "v_ON_N": 1e4, "altitude": 1e7}
"""Of quantities that cancel or pass through zero: what 1e-12 is relative to."""


def of_size(name: str, expected: Array, point: Values) -> Array:
    if name.startswith("der("):
        return elementwise(name, expected, point)
    return np.asarray(1e-12 * SCALES.get(name, max(1e-3, float(np.abs(expected).max()))))


LAWS = {
    "AttitudeErrorFilter": Law(
        rounding=of_size,
        draw=lambda rng: {"q_BN": quaternion(rng), "q_RN": quaternion(rng), "sigma_BR": rng.normal(size=4)},
        outputs=lambda p: {
            "sigma_BR": p["sigma_BR"],
            "sigmaDot_BR": error(p["q_BN"], p["q_RN"])[1] - p["sigma_BR"],
        },
        rates=lambda p: {"sigma_BR": ref.G(p["q_RN"]).T @ p["q_BN"] - p["sigma_BR"]},
    ),
    "VelocityFreeTracking": Law(
        rounding=of_size,
        draw=lambda rng: {
            "J_B": inertia(rng),
            "a": rng.uniform(0.1, 3),
            "b": rng.uniform(0.1, 3),
            "q_BN": quaternion(rng),
            "q_RN": quaternion(rng),
            "omega_RN_R": rng.normal(size=3),
            "omegaDot_RN_R": rng.normal(size=3),
            "sigmaDot_BR": rng.normal(size=4),
        },
        outputs=lambda p: {"torque_B": ref.torque(p), "q_BR": error(p["q_BN"], p["q_RN"])[1]},
    ),
    "EnvironmentTorque": Law(
        rounding=of_size,
        draw=lambda rng: {
            "J_B": inertia(rng),
            "mass": rng.uniform(1, 100),
            "drag_coefficient": rng.uniform(1, 3),
            "area": rng.uniform(0.01, 3),
            "density": rng.uniform(1e-13, 1e-9),
            "lever_arm_B": rng.normal(size=3),
            "mu": 3.986e14 * rng.uniform(0.9, 1.1),
            "earth_radius": 6.371e6,
            "j2": rng.uniform(1e-3, 2e-3),
            "q_BN": quaternion(rng),
            "r_BN_N": rotation(quaternion(rng)).apply([rng.uniform(6.6e6, 4e7), 0, 0]),
            "v_BN_N": rng.normal(size=3) * 5e3,
        },
        outputs=ref.environment,
    ),
    "KeplerOrbit": Law(rounding=of_size, draw=orbit_point, outputs=orbit_outputs),
}
