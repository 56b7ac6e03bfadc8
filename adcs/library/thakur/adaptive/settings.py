"""The numbers of Sec. 3.4, once."""

from __future__ import annotations

from math import pi, sqrt
from typing import Any, Literal

REFERENCE = "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Sec. 3.4"

Reading = Literal["printed", "original"]
"""Of r(t), (3.58): with the printed frequency 0.3 rad/s, or with 1 rad/s, as where the profile was first used."""

FREQUENCIES: dict[Reading, float] = {"printed": 0.3, "original": 1.0}  # rad/s
GUIDANCE: dict[str, Any] = {
    "amplitude": 0.3,
    "decay": 0.01,
    "ramp": 0.08 * pi,
    "wobble": 0.006,
    "axis": (1.0, 1.0, 1.0),
    "q_RN_0": (1.0, 0.0, 0.0, 0.0),
}
START = {
    "q_BN": (sqrt(1 - 3 * 0.1826**2), 0.1826, 0.1826, 0.1826),
    "omega_BN_B": (0.001, 0.001, 0.002),  # rad/s
    "torque_disturbance_B": (0.0, 0.0, 0.0),
}
INERTIA = ((20.0, 1.2, 0.9), (1.2, 17.0, 1.4), (0.9, 1.4, 15.0))  # kg.m2, J_0 of (3.57)
THETA = (20.0, 1.2, 0.9, 17.0, 1.4, 15.0)  # its elements
THETA_START = (21.1, 1.9, 1.4, 17.8, 2.9, 15.5)
ADAPTIVE_GAINS = {"beta": 20.0, "k_v": 24.5}
COMPARISON_GAINS = {"k_p": 0.5, "k_w": 0.5}
COMPARISON_ADAPTATION = 100.0  # gamma, in both examples

MASSES = (1.0, 1.3)  # kg
PATHS = {"position_B_0": ((0.5, 0.0, 0.0), (0.0, 0.8, 0.0)), "extension": 1.0, "frequency": 0.1}
APPENDAGE_ADAPTATION = {"gamma_1": 60.0, "gamma_2": 200.0}

FUEL_RATES = (4e-3, 4e-3, 5e-3)  # s, the diagonal of J_1
FUEL_ADAPTATION = {"gamma_1": 8.0, "gamma_2": 20.5}
FUEL_PROJECTION = {"theta_bound": 40.0, "theta_margin": 10.0, "sigma_bound": 0.008, "sigma_margin": 0.008}
FUEL_INTERNAL_STEP = 1e-4  # s, of the controller inside co-simulation: its projection acts at up to 4.5e3 1/s

STOP_TIME = 400.0  # s, the end of Figs. 3.5 to 3.7
EIGENVALUE_MAX, EIGENVALUE_MIN = 20.7352, 0.5  # kg.m2, as printed
"""Largest of J_0, and least with the tank empty."""
RATE_BOUND, ZETA, LEVEL = 1.1832, 55.56, 14.81
"""omega_B [rad/s], zeta* [rad/s] and the right-hand side of (3.46), as printed."""
