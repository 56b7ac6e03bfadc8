"""The numbers of Sec. 5.4, once."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt
from typing import Any

from adcs.library.thakur.choices import Matrix, Vector

REFERENCE = "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Sec. 5.4"

INERTIA = ((10.0, 1.2, 0.5), (1.2, 19.0, 1.5), (0.5, 1.5, 25.0))  # kg.m2, Eq. (5.62)
INERTIA_ERRORS: tuple[Matrix, Matrix] = (  # kg.m2, delta J_1 and delta J_2 of Eq. (5.63)
    ((1.0, 1.0, 1.5), (1.0, 1.0, 1.5), (1.5, 1.5, -1.0)),
    ((-1.0, -0.4, 0.6), (-0.4, -2.0, -0.7), (0.6, -0.7, -5.0)),
)
GUIDANCE: dict[str, Any] = {
    "amplitude": 0.1,
    "frequency": 1.0,
    "decay": 0.01,
    "ramp": 0.08 * pi,
    "wobble": 0.006,
    "axis": (1.0, 1.0, 1.0),
    "q_RN_0": (sqrt(1 - 3 * 0.1826**2), 0.1826, 0.1826, 0.1826),
}
PD_GAINS = {"k_p": 1.5, "k_v": 5.0}
OBSERVER_GAINS = {"lambda": 1.0, "gamma": 3.0}
ESTIMATED_BY = 50.0  # s, by when the estimate is said to have converged; the tracking error: TRACKED_BY


@dataclass(frozen=True)
class Start:
    """Where plant and observer start; the observer's attitude starts at the true one."""

    q_BN: Vector = (sqrt(1 - 3 * 0.1**2), -0.1, 0.1, -0.1)
    omega_BN_B: Vector = (0.005, 0.006, 0.004)  # rad/s
    omega_EN_E: Vector = (-0.03, 0.01, -0.02)  # rad/s
