"""The two closed loops of Sec. 4.3: the gyro-free law, and PD control with unit vectors and the true rate."""

from __future__ import annotations

from typing import Any

from adcs.library.thakur.catalogue import SYSTEMS
from adcs.library.thakur.gyro_free.settings import DIRECTIONS, FILTER, INERTIA, K_P, K_W, K_Z, Q_RN, WEIGHTS, Start
from orchestration.system import System


def gyro_free(
    start: Start | None = None,
    *,
    half_angle: float = 0.0,
    spread: float = 1 / 3,
    redraw_period: float = 0.1,
    seed: int = 1,
    controller: dict[str, Any] | None = None,
) -> System:
    """The law (4.25)-(4.26), which sees unit vectors alone.

    `half_angle` [rad], `spread`, `redraw_period` [s] and `seed` are the sensor's; `controller` replaces parameters.
    """
    system = System("gyro-free", SYSTEMS["gyro-free"])
    parameters = {"directions_N": DIRECTIONS, "weights": WEIGHTS, "q_RN": Q_RN, "k_p": K_P, "k_z": K_Z, **FILTER}
    system.add("controller", "GyroFreeStabilization", {**parameters, **(controller or {})})
    _add_common(system, start or Start(), half_angle, spread, redraw_period, seed)
    return system


def gyro_free_full_state(
    start: Start | None = None,
    *,
    half_angle: float = 0.0,
    spread: float = 1 / 3,
    redraw_period: float = 0.1,
    seed: int = 1,
) -> System:
    """The law it is compared with, which sees unit vectors and the true angular velocity."""
    system = System("gyro-free-full-state", SYSTEMS["gyro-free-full-state"])
    parameters = {"directions_N": DIRECTIONS, "weights": WEIGHTS, "q_RN": Q_RN, "k_p": K_P, "k_w": K_W}
    system.add("controller", "VectorPd", parameters)
    _add_common(system, start or Start(), half_angle, spread, redraw_period, seed)
    system.connect("plant.omega_BN_B", "controller.omega_BN_B")
    return system


def _add_common(
    system: System, start: Start, half_angle: float, spread: float, redraw_period: float, seed: int
) -> None:
    plant = {
        "J_B": INERTIA,
        "q_BN": start.q_BN,
        "omega_BN_B": start.omega_BN_B,
        "torque_disturbance_B": (0.0, 0.0, 0.0),
    }
    system.add("plant", "RigidBody", plant)
    noise = {"half_angle": half_angle, "spread": spread, "redraw_period": redraw_period, "seed": seed}
    system.add("sensor", "UnitVectorSensor", {"directions_N": DIRECTIONS, **noise})
    system.connect("plant.q_BN", "sensor.q_BN")
    system.connect("sensor.directions_B_meas", "controller.directions_B")
    system.connect("controller.torque_B", "plant.torque_B")
