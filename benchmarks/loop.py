"""The loop that every variant runs: a rigid body under PD tracking of a constant attitude, fed back without delay."""

from __future__ import annotations

import numpy as np

from adcs import System

STEP = 0.01
"""s, between two exchanges: one step of the integrator."""

INERTIA = np.array([[10.0, 1.2, 0.5], [1.2, 19.0, 1.5], [0.5, 1.5, 25.0]])
K_P, K_V = 1.5, 5.0
START_Q_BN = np.array([0.97**0.5, -0.1, 0.1, -0.1])
START_OMEGA_BN_B = np.array([0.005, 0.006, 0.004])
Q_RN = np.array([0.9**0.5, 0.1, 0.3, 0.0])
_ZERO = np.zeros(3)


def system(max_internal_step: float = STEP) -> System:
    """The loop as a system of two FMUs; `max_internal_step` (s) is the integrator's."""
    made = System("rigid-body-pd", "Rigid body under PD tracking of a constant attitude")
    made.add(
        "plant",
        "RigidBody",
        {
            "J_B": INERTIA,
            "q_BN": START_Q_BN,
            "omega_BN_B": START_OMEGA_BN_B,
            "torque_disturbance_B": _ZERO,
            "max_internal_step": max_internal_step,
        },
    )
    gains = {"J_B": INERTIA, "k_p": K_P, "k_v": K_V}
    made.add("controller", "PdTracking", {**gains, "q_RN": Q_RN, "omega_RN_R": _ZERO, "omegaDot_RN_R": _ZERO})
    made.connect("plant.q_BN", "controller.q_BN")
    made.connect("plant.omega_BN_B", "controller.omega_BN_B")
    made.connect("controller.torque_B", "plant.torque_B")
    return made
