"""How a flight of the spacecraft is shown: attitude and rate, what drives it, and what its sensors say."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from orchestration.results.plots import Array, Panel, Series
from orchestration.results.report import KeyNumber
from orchestration.results.result import Result

MOTION, SENSORS = "Motion", "Sensors"
_AXES = ("x", "y", "z")


def figures(result: Result) -> list[Panel]:
    """Curves by axis."""

    def panel(title: str, label: str, values: Array, group: str, symbols: Sequence[str] = _AXES) -> Panel:
        curves = zip(symbols, values.T, strict=True)
        return Panel(title, label, [Series(symbol, result.time, curve) for symbol, curve in curves], group=group)

    degrees = float(np.degrees(1.0))
    rate = result["plant.omega_BN_B"]
    errors = result["imu.omega_BN_B_meas"] - rate
    return [
        panel("Attitude relative to N", "q_BN", result["plant.q_BN"], MOTION, ("q0", "q1", "q2", "q3")),
        panel("Angular velocity", "omega_BN [deg/s]", rate * degrees, MOTION),
        panel("Torque on the body", "torque [N m]", result["actuator.torque_B"], MOTION),
        panel("Gyro", "measured less true rate [deg/s]", errors * degrees, SENSORS),
        panel("Accelerometer", "specific force [m/s²]", result["imu.specific_force_B_meas"], SENSORS),
        panel("Magnetometer", "flux density [µT]", result["magnetometer.magnetic_field_B_meas"] * 1e6, SENSORS),
    ]


def key_numbers(result: Result) -> list[KeyNumber]:
    """Where it ends, and what it took."""
    rate = np.linalg.norm(result["plant.omega_BN_B"], axis=1)
    torque = np.abs(result["actuator.torque_B"]).max()
    return [
        KeyNumber("Rate at the start", float(np.degrees(rate[0])), "deg/s"),
        KeyNumber("Rate at the end", float(np.degrees(rate[-1])), "deg/s", f"at {result.time[-1]:g} s"),
        KeyNumber("Largest torque on an axis", float(torque), "N·m"),
        KeyNumber("Angular impulse", float(result["actuator.angular_impulse"][-1]), "N·m·s", "integral of |torque|"),
    ]
