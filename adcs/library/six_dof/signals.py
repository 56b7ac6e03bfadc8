"""The errors of the loop, force and torque, from a recorded run."""

from __future__ import annotations

from adcs.library import attitude
from adcs.library.six_dof.settings import MASS
from adcs.library.trajectory import Quantity, Trajectory
from orchestration.results.result import Result

# Double precision resolves positions of 7e6 m, and what is made of them, no better than the last number.
POSITION = Quantity("position error", "e_R", "m", 1e-7)
VELOCITY = Quantity("velocity error", "e_V", "m/s", 1e-9)
ATTITUDE = Quantity("attitude error", "e_ε", floor=1e-12)
RATE = Quantity("rate error", "ω - C ω_d", "rad/s", 1e-13)
FORCE = Quantity("control force", "F", "N", 1e-7)
TORQUE = Quantity("control torque", "τ", "N·m")
DELTA_V = Quantity("velocity increment", "∫‖F‖dt / m", "m/s")
GRADIENT_FORCE = Quantity("gravity on the extent of the body", "f", "N")
GRADIENT_TORQUE = Quantity("gravity gradient torque", "g", "N·m")
ERRORS = (POSITION, VELOCITY, ATTITUDE, RATE)


def signals(result: Result) -> Trajectory:
    """A run of one of the systems."""
    q_BR = result["controller.q_BR"]
    values = {
        POSITION: result["controller.r_RB_B"],
        VELOCITY: result["orbit.v_ON_N"] - result["plant.v_BN_N"],
        ATTITUDE: q_BR[:, 1:],
        RATE: attitude.rate_error(result["plant.omega_BN_B"], q_BR, result["guidance.omega_RN_R"]),
        FORCE: result["actuator.force_B"],
        TORQUE: result["actuator.torque_B"],
        DELTA_V: result["actuator.impulse"] / MASS,
        GRADIENT_FORCE: result["plant.gravity_gradient_force_B"],
        GRADIENT_TORQUE: result["plant.gravity_gradient_torque_B"],
    }
    return Trajectory(result.time, values)
