"""The numbers of Sec. 4.3, once."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, radians, sin, sqrt
from typing import Any

from adcs.library.thakur.choices import Vector

REFERENCE = "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Sec. 4.3"

INERTIA = ((0.29, 0.0, 0.0), (0.0, 0.29, 0.0), (0.0, 0.0, 0.5))  # kg.m2
DIRECTIONS = (
    (0.0, 0.0, 1.0),
    (1.0, 0.0, 0.0),
    (1 / sqrt(2), 1 / sqrt(2), 0.0),
)  # x_j in N; the third is printed as x_2
WEIGHTS = (1.0, 1.0, 1.0)
FILTER: dict[str, Any] = {
    "A_m": ((-3.0, 0.0, 0.0), (0.0, -10.0, 0.0), (0.0, 0.0, -5.0)),  # printed as A
    "B": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "Q": ((10.5, 0.0, 0.0), (0.0, 10.5, 0.0), (0.0, 0.0, 10.5)),
}
PRINTED_P = (1.75, 0.525, 1.05)  # its diagonal
PRINTED_C_R = ((0.3601, 0.8968, -0.2569), (-0.2569, 0.3601, 0.8968), (0.8968, -0.2569, 0.3601))
K_P, K_Z, K_W = 0.03, 0.6, 0.06
HALF_ANGLE = 0.05  # deg, of the cone in which a measured vector errs
AT_REST_BY = 120.0  # s, "within two minutes"


def about_diagonal(degrees: float) -> Vector:
    """A turn by `degrees` about [1, 1, 1] as a quaternion."""
    half = radians(degrees) / 2
    return (cos(half), *(sin(half) / sqrt(3),) * 3)


Q_RN = about_diagonal(87.7)  # C_r, which is printed to four digits
Q_BN = about_diagonal(120.0)  # C_b(0)


@dataclass(frozen=True)
class Start:
    """Where the body starts: C_b(0) turns by 120 degrees about [1, 1, 1]."""

    q_BN: Vector = Q_BN
    omega_BN_B: Vector = (-0.02, -0.02, -0.02)  # rad/s
