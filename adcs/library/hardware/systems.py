"""A tumbling spacecraft in a low orbit with the sensors that an autopilot expects, and nobody who controls it."""

from __future__ import annotations

from math import radians

from adcs.library.hardware.catalogue import SYSTEMS
from orchestration.system import System

INERTIA = ((10.0, 1.2, 0.5), (1.2, 19.0, 1.5), (0.5, 1.5, 25.0))  # kg.m2
PERIOD = 0.004  # s, of the inertial and magnetic sensors: the 250 Hz of an autopilot's loop
TRACKER_PERIOD = 0.1  # s
MAX_TORQUE = 1.0  # N.m on each axis

_STILL = (0.0, 0.0, 0.0)


def hil_spacecraft(seed: int = 1) -> System:
    """Nothing feeds `actuator.torque_command_B` and `magnetometer.magnetic_field_N`.

    `seed` is that of all sensors: sensors of different kinds draw independent noise from it.
    """
    system = System("hil-spacecraft", SYSTEMS["hil-spacecraft"])
    system.add(
        "plant",
        "RigidBody",
        {
            "J_B": INERTIA,
            "q_BN": (0.9, 0.3, -0.2, 0.25),
            "omega_BN_B": (0.02, -0.03, 0.015),
            "torque_disturbance_B": _STILL,
        },
    )
    limits = {"max_torque": MAX_TORQUE, "torque_command_B": _STILL, "force_command_B": _STILL}
    system.add("actuator", "ForceTorqueActuator", limits)
    orbit = {"semi_major_axis": 6.878e6, "eccentricity": 0.001, "inclination": radians(51.6), "mean_anomaly": 0.3}
    system.add("orbit", "KeplerOrbit", orbit)
    imu = {
        "gyro_bias": (1e-5, -2e-5, 1.5e-5),  # rad/s
        "gyro_noise": 1e-4,
        "accelerometer_bias": (2e-3, -1e-3, 1.5e-3),  # m/s2
        "accelerometer_noise": 5e-3,
    }
    system.add("imu", "InertialMeasurementUnit", {**imu, "period": PERIOD, "seed": seed, "specific_force_B": _STILL})
    field = {"noise": 1e-7, "bias": (2e-7, -1e-7, 1e-7), "period": PERIOD, "magnetic_field_N": _STILL}
    system.add("magnetometer", "Magnetometer", {**field, "seed": seed})
    tracker = {"half_angle": radians(0.01), "redraw_period": TRACKER_PERIOD, "seed": seed}
    system.add("tracker", "StarTracker", tracker)
    system.connect("actuator.torque_B", "plant.torque_B")
    system.connect("plant.omega_BN_B", "imu.omega_BN_B")
    system.connect("plant.q_BN", "magnetometer.q_BN")
    system.connect("plant.q_BN", "tracker.q_BN")
    return system
