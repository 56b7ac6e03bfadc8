"""Laws and attitude from unit vectors."""

import numpy as np

from .. import gyro_free as ref
from ..law import Law, Point, Values, definite, quaternion
from ..observer_pd import Array


def hurwitz(rng: np.random.Generator) -> Array:
    """A matrix in no particular basis with all eigenvalues left of -0.2."""
    a = rng.normal(size=(3, 3))
    shifted: Array = a - (np.linalg.eigvals(a).real.max() + rng.uniform(0.2, 2)) * np.eye(3)
    return shifted


def vectors(rng: np.random.Generator) -> Point:
    """Three directions in N, weights, and unit vectors that are not quite what any attitude shows."""
    y = rng.normal(size=(3, 3))
    return {
        "directions_N": rng.normal(size=(3, 3)),
        "weights": rng.uniform(0.1, 2, 3),
        "directions_B": y / np.linalg.norm(y, axis=1, keepdims=True),
    }


def gains(p: Values) -> ref.Gains:
    return ref.Gains(p["weights"], p["k_p"], p["k_z"], p["A_m"], p["B"], p["Q"])


def gyro_free(p: Values, law: ref.Control = ref.gyro_free) -> Point:
    y_r, z = ref.seen(p["q_RN"], p["directions_N"]), p["z_0"] + p["z_moved"]
    torque, z_dot = law(gains(p), p["directions_B"], y_r, z)
    omega = ref.omega_error(p["weights"], p["directions_B"], y_r)
    return {"z_moved": p["z_moved"], "torque_B": torque, "Omega_B": omega, "z": z, "zDot": z_dot}


def vector_pd(p: Values) -> Point:
    omega = ref.omega_error(p["weights"], p["directions_B"], ref.seen(p["q_RN"], p["directions_N"]))
    return {"torque_B": -p["k_p"] * omega - p["k_w"] * p["omega_BN_B"], "Omega_B": omega}


def measured(rng: np.random.Generator) -> Point:
    """Vectors seen at a random attitude, each off by a few degrees, and that attitude as the sign to take."""
    point, q = vectors(rng), quaternion(rng)
    y = ref.seen(q, point["directions_N"]) + rng.normal(scale=0.05, size=(3, 3))
    return {**point, "directions_B": y / np.linalg.norm(y, axis=1, keepdims=True), "q_BN_first": q}


LAWS = {
    "GyroFreeStabilization": Law(
        draw=lambda rng: {
            **vectors(rng),
            "q_RN": quaternion(rng),
            "k_p": rng.uniform(0.1, 3),
            "k_z": rng.uniform(0.1, 3),
            "A_m": hurwitz(rng),
            "B": rng.normal(size=(3, 3)),
            "Q": definite(rng),
            "filter_at_rest": np.array(0),
            "z_0": rng.normal(size=3),
            "z_moved": rng.normal(size=3),
        },
        outputs=gyro_free,
        rates=lambda p: {"z_moved": gyro_free(p)["zDot"]},
        revealing={"filter_at_rest": 1},
    ),
    "VectorPd": Law(
        draw=lambda rng: {
            **vectors(rng),
            "q_RN": quaternion(rng),
            "k_p": rng.uniform(0.1, 3),
            "k_w": rng.uniform(0.1, 3),
            "omega_BN_B": rng.normal(size=3),
        },
        outputs=vector_pd,
    ),
    "Quest": Law(
        draw=measured,
        outputs=lambda p: {
            "q_BN_est": ref.quest(p["weights"], p["directions_B"], p["directions_N"], p["q_BN_first"]),
            "observability": np.array(ref.observability(p["weights"], p["directions_B"], p["directions_N"])),
        },
    ),
}
