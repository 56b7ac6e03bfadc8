"""What Sec. 4.3 looks at, from a recorded run: truth and command."""

from __future__ import annotations

import numpy as np

from adcs.library import attitude
from adcs.library.thakur.gyro_free.settings import Q_RN
from adcs.library.trajectory import Quantity, Trajectory
from orchestration.results.error_angles import turned_by
from orchestration.results.result import Result

ANGLE = Quantity("rotation angle", "φ", "deg")
RATE = Quantity("angular velocity", "ω", "rad/s")
TORQUE = Quantity("control torque", "u", "N·m")
FILTER = Quantity("filter state", "z")
LYAPUNOV = Quantity("Lyapunov matrix", "P")
MEASURES = (ANGLE, RATE, TORQUE)


def motion(result: Result) -> Trajectory:
    """The run of `gyro-free` or `gyro-free-full-state`; of the filter only the first has something."""
    q_BR = attitude.relative_quaternion(result["plant.q_BN"], Q_RN)
    # cos(phi) = (tr E - 1)/2 of the text, without its loss of digits near zero
    values = {
        ANGLE: np.degrees(turned_by(q_BR)),
        RATE: result["plant.omega_BN_B"],
        TORQUE: result["controller.torque_B"],
    }
    if "controller.z" in result.names:
        values[FILTER] = result["controller.z"]
    if "controller.P" in result.names:
        values[LYAPUNOV] = result["controller.P"]
    return Trajectory(result.time, values)
