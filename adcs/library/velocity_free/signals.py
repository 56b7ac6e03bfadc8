"""The true errors of Sec. V, the torque, and what disturbs them, from a recorded run."""

from __future__ import annotations

from adcs.library import attitude
from adcs.library.trajectory import Quantity, Trajectory
from orchestration.results.result import Result

FLOOR = 1e-7  # an ideal run goes down to rounding, and would flatten the others
ATTITUDE = Quantity("attitude tracking error", "δq_v", floor=FLOOR)
RATE = Quantity("rate tracking error", "δω", "rad/s", FLOOR)
TORQUE = Quantity("control torque", "u", "N·m", FLOOR)
MEASUREMENT = Quantity("measurement error", "q̃_v")
DISTURBANCE = Quantity("disturbance torque", "d", "N·m")


def signals(result: Result) -> Trajectory:
    """A run of one of the four systems; the last two quantities are there with uncertainties only."""
    q_BR = attitude.relative_quaternion(result["plant.q_BN"], result["guidance.q_RN"])
    values = {
        ATTITUDE: q_BR[:, 1:],
        RATE: attitude.rate_error(result["plant.omega_BN_B"], q_BR, result["guidance.omega_RN_R"]),
        TORQUE: result["controller.torque_B"],
    }
    if "tracker.q_EB" in result.names:
        values[MEASUREMENT] = result["tracker.q_EB"][:, 1:]
        values[DISTURBANCE] = result["environment.torque_B"]
    return Trajectory(result.time, values)
