"""The numbers of the thesis' chapters 2, 4, 8 and 9, once, and the readings of its text."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, inf, pi, radians, sin, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adcs.library.choices import PART, Checked, Must, choice
from adcs.library.trigo.catalogue import Controller, Scenario

REFERENCE = "Thesis on robust and adaptive nonlinear attitude control of a spacecraft, chapters 8 and 9"

Matrix = NDArray[np.float64]

CONTROLLERS: dict[Controller, str] = {"bs": "BS", "rbs": "RBS", "tf": "TF", "neso": "NESO", "ii": "I&I"}
STATIC: tuple[Controller, ...] = ("bs", "rbs")
ADAPTIVE: tuple[Controller, ...] = ("tf", "neso", "ii")
STOP_TIME = 1100.0  # s
CONTROL_RATE = 10.0  # Hz, of Tables 9.6 to 9.16
RATES = (5.0, 20.0, 50.0)  # Hz, of Tables 9.17 to 9.19 besides
PLANT_STEP = 0.01  # s, Sec. 3.5.1
ARCSEC = pi / 180 / 3600  # rad
ATTITUDE_REQUIREMENT, RATE_REQUIREMENT = 30.0, 1.0  # arcsec and arcsec/s, Eq. (9.11)

INERTIA = np.diag([37 / 12, 37 / 12, 25 / 12])  # kg.m2; the 3.083 and 2.083 of (9.2), unrounded
TORQUE_LIMIT, TORQUE_RATE_LIMIT = 0.05 * sqrt(4 / 3), 6.0  # N.m, N.m/s, Table C.1
RATE_LIMIT = radians(1.0)  # rad/s
C_1, C_2, DAMPING = 0.1, 1.0, 1.0  # 1/s, Eqs. (8.73), (8.77)
TF_GAIN, II_GAIN, NESO_GAIN = 15.0, 50.0, 5.0  # Eqs. (8.81), (8.82), (8.78)
REDUCED_II_GAIN, REDUCED_NESO_GAIN = 25.0, 2.0  # at 5 Hz, Eqs. (9.21), (9.22)
NESO = {"alpha_1": 0.2, "alpha_2": 0.4, "delta_1": 0.1, "delta_2": 0.3}  # Eq. (8.79)

TILT = radians(19.471)  # beta of the wheel tetrahedron, Eq. (9.6)
WHEEL_AXIS = (cos(TILT), 0.0, sin(TILT))  # third axis of RW1 turned by 90 deg - beta, Table 9.3
WHEEL_POSITION = (0.043, 0.0, 0.014)  # m, Table 9.2
WHEEL_MASS, WHEEL_RADIUS = 1.0, 0.055  # kg, m, Table 9.1
WHEEL_SPEED = 4200 * 2 * pi / 60  # rad/s
MIRROR_MASS, MIRROR_POSITION = 0.03, (0.30, 0.20, 0.20)  # kg, m, Table 9.4
MIRROR_EULER = (0.0, radians(45), radians(45))
MIRROR_SWING = {"amplitude": radians(45), "swing_period": 15.0, "angle_0": radians(45)}


@dataclass(frozen=True)
class Reading:
    """What the text leaves open, says differently than its tables were made, or gets wrong.

    `name` is shown; times are in s, angles in rad, lengths in m.
    """

    name: str
    slew_start: float
    lag: int
    rate_by_difference: bool
    acceleration_limit: float
    disturbance_held: bool
    parallel_axis: bool
    mirror_size: tuple[float, float, float]  # (l, w, h) of (4.26)
    neso_inertia_twice: bool
    neso_torque_delay: int
    update_first: int
    exceptions: bool  # other orbital rate in some runs; other start and reference time at 5 Hz

    def orbital_rate(self, scenario: Scenario, rate: float) -> float:
        """n [rad/s]."""
        odd = scenario == "nominal" or (scenario == "wheel" and rate in (5.0, 20.0))
        return 1.070e-3 if self.exceptions and odd else 1.073e-3

    def odd_start(self, rate: float) -> bool:
        """Whether this run starts as those at 5 Hz did: at rest relative to O, the rate filter at its first command."""
        return self.exceptions and rate == 5.0


AS_MADE = Reading(
    name="as the tables were made",
    slew_start=20.62,
    lag=1,
    rate_by_difference=True,
    acceleration_limit=radians(0.10),
    disturbance_held=True,
    parallel_axis=True,
    mirror_size=(0.05, 0.05, 0.005),
    neso_inertia_twice=True,
    neso_torque_delay=1,
    update_first=1,
    exceptions=True,
)
AS_PRINTED = Reading(
    name="as printed",
    slew_start=0.0,
    lag=0,
    rate_by_difference=False,
    acceleration_limit=radians(0.15),
    disturbance_held=False,
    parallel_axis=True,
    mirror_size=(0.005, 0.05, 0.05),
    neso_inertia_twice=False,
    neso_torque_delay=0,
    update_first=0,
    exceptions=False,
)
CORRECTED = replace(
    AS_MADE,
    name="corrected",
    disturbance_held=False,
    parallel_axis=False,
    mirror_size=AS_PRINTED.mirror_size,
    neso_inertia_twice=False,
    neso_torque_delay=0,
    exceptions=False,
)
READINGS = {reading.name: reading for reading in (AS_MADE, AS_PRINTED, CORRECTED)}


def known_inertia(scenario: Scenario) -> Matrix:
    """J_0 (9.1): in the mismatch scenario J in axes 10 deg off in each of three Euler angles, unrounded."""
    if scenario != "mismatch":
        return INERTIA
    c, s = cos(radians(10)), sin(radians(10))
    about_1 = np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
    about_2 = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    about_3 = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    turn: Matrix = about_1 @ about_2 @ about_3
    turned: Matrix = turn @ INERTIA @ turn.T
    return (turned + turned.T) / 2


def parallel_axis(mass: float, position: tuple[float, float, float]) -> Matrix:
    """-m S_R^2, the last term of (4.22) and (4.29) [kg.m2]; `position` in m."""
    r = np.array(position)
    return np.asarray(mass * (r @ r * np.eye(3) - np.outer(r, r)))


def mirror_moments(size: tuple[float, float, float]) -> tuple[float, float, float]:
    """Principal moments of the cuboid (4.26) [kg.m2] for (l, w, h) in m."""
    length, width, height = size
    m = MIRROR_MASS / 12
    return m * (height**2 + width**2), m * (length**2 + height**2), m * (length**2 + width**2)


SMALL = PART._replace(words="a relative error between 0 and 1")
COMPLETE = Must(lambda stop, _: 505 < stop < inf, "more than 505 s, where the last interval of the tables begins")
YES_OR_NO = Must(lambda value, _: value in (0, 1), "0 or 1")


@dataclass(frozen=True)
class Choices(Checked):
    """How the study judges, and how much of it runs. All of it is printed in the report."""

    agreement: float = choice(0.001, "a cell is reproduced within this relative error, or half its last digit", SMALL)
    stop_time: float = choice(STOP_TIME, "end of every run [s]; the tables need 1100", COMPLETE)
    other_rates: int = choice(1, "0: only the runs at 10 Hz, 1: those at 5, 20 and 50 Hz too", YES_OR_NO)


Start = dict[str, Any]
