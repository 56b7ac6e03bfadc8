"""Sensors that draw: what they make of the numbers, which `noise` writes anew."""

import numpy as np
from scipy.spatial.transform import Rotation

from ..gyro_free import seen
from ..law import Law, Point, Sampled, Values, quaternion
from ..noise import directions, normal, uniform
from ..observer_pd import Array, kinematics, rotation

PERIOD = 0.05


def tilted(e: Array, a: Array, angle: float) -> Array:
    """The direction e turned by `angle` towards d = a x e, that is about e x d."""
    axis = np.cross(e, np.cross(a, e))
    return Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).apply(e)


def angle_of(versine: float) -> float:
    return float(2 * np.arcsin(np.sqrt(versine / 2)))


def draw_number(p: Values, period: str) -> int:
    return int(np.floor(float(p["time"]) / float(p[period])))


def star_tracker(p: Values) -> Point:
    """Sec. 5.4.2: the eigenaxis tilted within a cone, the eigenangle exact."""
    k, seed = draw_number(p, "redraw_period"), int(p["seed"])
    rim = 1 - np.cos(float(p["half_angle"]))
    angle = angle_of(uniform("StarTracker", seed, k, 1)[0, 0] * rim)
    sine = np.linalg.norm(p["q_BN"][1:])
    axis = tilted(p["q_BN"][1:] / sine, directions("StarTracker", seed, k)[0], angle)
    return {"q_BN_meas": np.append(p["q_BN"][0], sine * axis)}


def unit_vectors(p: Values) -> Point:
    """Sec. 4.3.2, with a distribution whose 1 - cos(beta) is exponential of mean sigma^2 and cut off at the cone."""
    k, seed, alpha = draw_number(p, "redraw_period"), int(p["seed"]), float(p["half_angle"])
    square = (float(p["spread"]) * alpha) ** 2
    rows = []
    for j, y in enumerate(seen(p["q_BN"], p["directions_N"])):
        stream = f"UnitVectorSensor.{j}"
        held = -np.expm1(-(1 - np.cos(alpha)) / square)  # the share of the distribution within the cone
        versine = -square * np.log1p(-uniform(stream, seed, k, 1)[0, 0] * held)
        rows.append(tilted(y, directions(stream, seed, k)[0], angle_of(float(versine))))
    return {"directions_B_meas": np.array(rows)}


def wandering_rate(p: Values) -> Array:
    k, seed = draw_number(p, "hold_time"), int(p["seed"])
    size = p["max_rate"] * uniform("RandomWalkStarTracker", seed, k, 1)[0, 0]
    return np.asarray(size * directions("RandomWalkStarTracker", seed, k)[0])


def size_at_the_end(p: Values, omega: Array) -> float:
    """Of the vector part of q_EB, after it has turned at this rate for a hold."""
    end = rotation(p["q_EB"]) * Rotation.from_rotvec(float(p["hold_time"]) * omega)
    return float(np.linalg.norm(end.as_quat()[:3]))


def wandering(p: Values) -> Point:
    """The rate of draw k, reversed or dropped where its hold would end outside the bound; q_EB is the error then."""
    omega = wandering_rate(p)
    for choice in (omega, -omega, np.zeros(3)):
        if p["error_bound"] >= 1 or size_at_the_end(p, choice) <= p["error_bound"]:
            break
    turned = rotation(p["q_BN"]) * rotation(p["q_EB"])
    q = turned.as_quat(scalar_first=True)
    sign = np.sign(q[0] * (p["q_BN"][0] * p["q_EB"][0] - p["q_BN"][1:] @ p["q_EB"][1:]))
    return {"q_EB": p["q_EB"], "q_BN_meas": sign * q, "rate": choice}


def wandering_point(rng: np.random.Generator) -> Point:
    """The draw, or the reversed one, leads just up to the bound or just beyond."""
    axis = rng.normal(size=3)
    v = rng.uniform(0.2, 0.5) * axis / np.linalg.norm(axis)
    point = {
        "max_rate": rng.uniform(0.2, 1),
        "hold_time": rng.uniform(0.5, 1),
        "seed": rng.integers(1000),
        "q_EB": np.append(np.sqrt(1 - v @ v), v),
        "q_BN": quaternion(rng),
        "time": rng.uniform(0, 5),
    }
    end = size_at_the_end(point, rng.choice([-1, 1]) * wandering_rate(point))
    return {**point, "error_bound": min(1.0, end * (1 + rng.choice([-1e-3, 1e-3])))}


def near_half_a_turn(rng: np.random.Generator) -> Array:
    """Or further from it: where the shorter way changes sides."""
    sigma = rng.normal(size=3)
    return np.asarray(rng.choice([0.5, 0.99]) * sigma / np.linalg.norm(sigma))


def attitude_and_rate(p: Values, memory: dict[str, int], u: Values) -> Point:
    """Rodrigues parameters a quarter of the drawn turn, then those of the attitude; the shorter of both turns."""
    k = memory["k"] = memory.get("k", -1) + 1
    phi, nu = (normal(f"AttitudeRateSensor.{channel}", p["seed"], k)[0] for channel in ("attitude", "rate"))
    turn = Rotation.from_mrp(u["sigma_BO"]) * Rotation.from_mrp(p["attitude_noise"] * phi / 4)
    return {"sigma_BO_meas": turn.as_mrp(), "omega_BN_B_meas": u["omega_BN_B"] + p["rate_noise"] * nu}


def inertial(p: Values, memory: dict[str, int], u: Values) -> Point:
    k = memory["k"] = memory.get("k", -1) + 1
    nu, mu = (normal(f"InertialMeasurementUnit.{c}", p["seed"], k)[0] for c in ("gyro", "accelerometer"))
    return {
        "omega_BN_B_meas": u["omega_BN_B"] + p["gyro_bias"] + p["gyro_noise"] * nu,
        "specific_force_B_meas": u["specific_force_B"] + p["accelerometer_bias"] + p["accelerometer_noise"] * mu,
    }


def magnetic(p: Values, memory: dict[str, int], u: Values) -> Point:
    k = memory["k"] = memory.get("k", -1) + 1
    field_B = rotation(u["q_BN"]).inv().apply(u["magnetic_field_N"])
    return {"magnetic_field_B_meas": field_B + p["bias"] + p["noise"] * normal("Magnetometer", p["seed"], k)[0]}


LAWS = {
    "StarTracker": Law(
        draw=lambda rng: {
            "half_angle": rng.uniform(0.1, 1),
            "redraw_period": rng.uniform(0.1, 1),
            "seed": rng.integers(1000),
            "q_BN": quaternion(rng),
            "time": rng.uniform(0, 5),
        },
        outputs=star_tracker,
    ),
    "UnitVectorSensor": Law(
        draw=lambda rng: {
            "directions_N": rng.normal(size=(3, 3)),
            "q_BN": quaternion(rng),
            "half_angle": rng.uniform(0.1, 1),
            "spread": rng.uniform(0.2, 2),
            "redraw_period": rng.uniform(0.1, 1),
            "seed": rng.integers(1000),
            "time": rng.uniform(0, 5),
        },
        outputs=unit_vectors,
    ),
    "RandomWalkStarTracker": Law(
        draw=wandering_point,
        outputs=lambda p: {n: v for n, v in wandering(p).items() if n != "rate"},
        rates=lambda p: {"q_EB": kinematics(p["q_EB"], wandering(p)["rate"])},
        smooth={"hold_time": 100.0, "error_bound": 1.0},
    ),
}

SAMPLED = {
    "AttitudeRateSensor": Sampled(
        draw=lambda rng: {
            "attitude_noise": rng.uniform(0, 0.5),
            "rate_noise": rng.uniform(0, 0.5),
            "seed": rng.integers(1000),
            "period": np.array(PERIOD),
        },
        inputs=lambda rng: {"sigma_BO": near_half_a_turn(rng), "omega_BN_B": rng.normal(size=3)},
        step=attitude_and_rate,
    ),
    "InertialMeasurementUnit": Sampled(
        draw=lambda rng: {
            "gyro_bias": rng.normal(size=3),
            "gyro_noise": rng.uniform(0, 1),
            "accelerometer_bias": rng.normal(size=3),
            "accelerometer_noise": rng.uniform(0, 1),
            "seed": rng.integers(1000),
            "period": np.array(PERIOD),
        },
        inputs=lambda rng: {"omega_BN_B": rng.normal(size=3), "specific_force_B": rng.normal(size=3)},
        step=inertial,
    ),
    "Magnetometer": Sampled(
        draw=lambda rng: {
            "bias": rng.normal(size=3),
            "noise": rng.uniform(0, 1),
            "seed": rng.integers(1000),
            "period": np.array(PERIOD),
        },
        inputs=lambda rng: {"q_BN": quaternion(rng), "magnetic_field_N": rng.normal(size=3)},
        step=magnetic,
    ),
}
