"""The adaptive law with guaranteed bounds, its guidance, error generator and disturbance."""

from typing import Any

import numpy as np

from .. import deruiter as ref
from ..deruiter import Gains
from ..law import Law, Point, Values, inertia, quaternion
from ..observer_pd import Array, kinematics


def on_sphere(rng: np.random.Generator, n: int, radius: float) -> Array:
    v = rng.normal(size=n)
    return v / np.linalg.norm(v) * radius


def draw_controller(rng: np.random.Generator) -> dict[str, Any]:
    """Estimates inside and outside the inner ball, dead zones in and out of reach."""
    J = inertia(rng)
    eta, epsilon, epsilon_p = rng.uniform(0.2, 1), rng.uniform(0.05, 0.5), rng.uniform(0.05, 0.5)
    eta_p = rng.uniform(0.3, 0.95) / np.linalg.eigvalsh(J)[-1] / np.sqrt(5 / 3 * (1 + epsilon_p))
    return {
        "J_B": J,
        "k": rng.uniform(0.1, 2),
        "lambda": rng.uniform(0.02, 1),
        "gamma": rng.uniform(0.1, 2),
        "gamma_p": rng.uniform(1e-4, 1e-3),
        "dead_zone": rng.choice([0.01, 0.5, 100.0], p=[0.4, 0.4, 0.2]),
        "eta": eta,
        "eta_p": eta_p,
        "epsilon": epsilon,
        "epsilon_p": epsilon_p,
        "theta_offset": on_sphere(rng, 18, eta * np.sqrt(1 + epsilon * rng.uniform(-0.5, 1))),
        "theta_p_offset": on_sphere(rng, 6, eta_p * np.sqrt(1 + epsilon_p * rng.uniform(-0.5, 1))),
        "q_BN": quaternion(rng),
        "omega_BN_B": rng.normal(size=3),
        "q_RN": quaternion(rng),
        "omega_RN_R": rng.normal(size=3),
        "omegaDot_RN_R": rng.normal(size=3),
    }


def control(p: Values, mutant: str | None = None) -> Point:
    g = Gains.of(p)
    theta, theta_p = g.centre[0] + p["theta_offset"], g.centre[1] + p["theta_p_offset"]
    y = ref.law(
        g, p["q_BN"], p["omega_BN_B"], p["q_RN"], p["omega_RN_R"], p["omegaDot_RN_R"], theta, theta_p, mutant=mutant
    )
    return {**y, "theta": theta, "theta_p": theta_p}


def control_outputs(p: Values) -> Point:
    y, g = control(p), Gains.of(p)
    return {
        "theta_offset": p["theta_offset"],
        "theta_p_offset": p["theta_p_offset"],
        "torque_B": y["torque"],
        "q_BR": y["q_e"],
        "omega_BR_B": y["omega_e"],
        "filtered_rate_B": y["filtered"],
        "theta_est": y["theta"],
        "theta_p_est": y["theta_p"],
        "theta_level": np.asarray(ref.level(p["theta_offset"], g.eta, g.epsilon)),
        "theta_p_level": np.asarray(ref.level(p["theta_p_offset"], g.eta_p, g.epsilon_p)),
    }


def reference_rates(p: Values) -> tuple[Array, Array]:
    names = ("bias", "amplitude", "frequency", "phase")
    return ref.sinusoids(float(p["time"]), *(p[f"rate_{n}"] for n in names))


def of_size(name: str, expected: Array, point: Values) -> Array:
    return np.asarray(1e-12 * np.abs(expected) + 1e-12 * max(1.0, float(np.abs(expected).max())))


LAWS = {
    "BoundedAdaptiveTracking": Law(
        rounding=of_size,
        draw=draw_controller,
        smooth={
            "dead_zone": 0.0,
            "theta_offset": np.zeros(18),
            "theta_p_offset": np.zeros(6),
            "gamma": 0.01,
            "gamma_p": 1e-6,
        },
        outputs=control_outputs,
        rates=lambda p: {
            "theta_offset": control(p)["theta_dot"],
            "theta_p_offset": control(p)["theta_p_dot"],
        },
    ),
    "SinusoidalRateReference": Law(
        rounding=of_size,
        draw=lambda rng: {
            "rate_bias": rng.normal(size=3),
            "rate_amplitude": rng.normal(size=3),
            "rate_frequency": rng.normal(size=3),
            "rate_phase": rng.uniform(-4, 4, 3),
            "q_RN": quaternion(rng),
            "time": np.asarray(rng.uniform(0, 20)),
        },
        outputs=lambda p: {
            "q_RN": p["q_RN"],
            **dict(zip(("omega_RN_R", "omegaDot_RN_R"), reference_rates(p), strict=True)),
        },
        rates=lambda p: {"q_RN": kinematics(p["q_RN"], reference_rates(p)[0])},
    ),
    "BoundedEstimationError": Law(
        rounding=of_size,
        draw=lambda rng: {
            "attitude_bound": np.asarray(rng.uniform(0, 0.9)),
            "rate_bound": np.asarray(rng.uniform(0, 0.5)),
            "attitude_frequency": rng.normal(size=3),
            "rate_frequency": rng.normal(size=3),
            "attitude_phase": rng.uniform(-4, 4, 3),
            "rate_phase": rng.uniform(-4, 4, 3),
            "q_BN": quaternion(rng),
            "omega_BN_B": rng.normal(size=3),
            "time": np.asarray(rng.uniform(0, 20)),
        },
        outputs=lambda p: ref.estimates(p, float(p["time"]), p["q_BN"], p["omega_BN_B"]),
    ),
    "SinusoidalTorque": Law(
        rounding=of_size,
        draw=lambda rng: {
            "torque_bias": rng.normal(size=3),
            "torque_amplitude": rng.normal(size=3),
            "torque_frequency": rng.normal(size=3),
            "torque_phase": rng.uniform(-4, 4, 3),
            "time": np.asarray(rng.uniform(0, 20)),
        },
        outputs=lambda p: {
            "torque_B": ref.sinusoids(
                float(p["time"]), *(p[f"torque_{n}"] for n in ("bias", "amplitude", "frequency", "phase"))
            )[0]
        },
    ),
}
