"""The errors of Sec. 5.4 from a recorded run."""

from __future__ import annotations

from adcs.library import attitude
from adcs.library.thakur.observer.settings import PD_GAINS
from adcs.library.trajectory import Quantity, Trajectory
from orchestration.results.result import Result

ATTITUDE = Quantity("attitude tracking error", "q_BR,v")
RATE = Quantity("rate tracking error", "ω_BR", "rad/s")
ATTITUDE_ESTIMATE = Quantity("attitude estimation error", "q_BE,v")
RATE_ESTIMATE = Quantity("rate estimation error", "ω - ω̂", "rad/s")
TORQUE = Quantity("control torque", "u", "N·m")
FEEDBACK = Quantity("feedback torque", "k_p q_v + k_v ω_e", "N·m")  # the part of the torque without feedforward
TRACKING, ESTIMATION = (ATTITUDE, RATE), (ATTITUDE_ESTIMATE, RATE_ESTIMATE)
ERRORS = (*TRACKING, *ESTIMATION)


def signals(result: Result) -> Trajectory:
    """A run of a loop: errors of the truth, also where law and observer see a measurement; torques. All (N, 3).

    Errors of estimation are there only if an observer is.
    """
    q_BN, omega_BN_B = result["plant.q_BN"], result["plant.omega_BN_B"]
    q_BR = attitude.relative_quaternion(q_BN, result["guidance.q_RN"])
    k_p, k_v = PD_GAINS["k_p"], PD_GAINS["k_v"]
    values = {
        ATTITUDE: q_BR[:, 1:],
        RATE: attitude.rate_error(omega_BN_B, q_BR, result["guidance.omega_RN_R"]),
        TORQUE: result["controller.torque_B"],
        FEEDBACK: -k_p * result["controller.q_BR"][:, 1:] - k_v * result["controller.omega_BR_B"],
    }
    if "observer.q_EN" in result.names:
        values |= estimation(result).values
    return Trajectory(result.time, values)


def estimation(result: Result) -> Trajectory:
    """The errors of estimation alone, of a run with an observer."""
    q_BE = attitude.relative_quaternion(result["plant.q_BN"], result["observer.q_EN"])
    rate = attitude.rate_error(result["plant.omega_BN_B"], q_BE, result["observer.omega_EN_E"])
    return Trajectory(result.time, {ATTITUDE_ESTIMATE: q_BE[:, 1:], RATE_ESTIMATE: rate})
