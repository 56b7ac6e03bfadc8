"""The scenario, once. The paper has no simulation: every number here is ours."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, inf, pi, radians, sin, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adcs.library.attitude import relative_quaternion, rotate
from adcs.library.choices import PART, Checked, choice, positive
from fmus.errors import AdcsError

REFERENCE = "Pan, Wong, Kapila, Output feedback control for spacecraft with coupled translation and attitude dynamics"

Vector = tuple[float, ...]
Array = NDArray[np.float64]

MASS = 100.0  # kg
INERTIA = ((22.0, 0.8, -0.5), (0.8, 18.0, 0.6), (-0.5, 0.6, 15.0))  # kg.m2
EARTH = {"mu": 398.6004418e12, "earth_radius": 6378137.0}
ORBIT = {"semi_major_axis": 7.0e6, "eccentricity": 0.02, "inclination": radians(51.6), **EARTH}  # from the perigee
REFERENCE_RATE: dict[str, Vector] = {  # rad/s and rad
    "rate_bias": (0.0, -0.0011, 0.0),
    "rate_amplitude": (0.004, 0.003, 0.005),
    "rate_frequency": (0.02, 0.03, 0.025),
    "rate_phase": (0.0, 1.0, 2.0),
}
GAINS = {"k": 3.0, "k_0": 2.0, "k_1": 1.5}
LENGTH_UNIT, TIME_UNIT, MASS_UNIT = 1.0, 20.0, 20.0  # m, s, kg
SMALLEST_SCALAR = 1e-6  # of the error quaternion at the start: the gains of the law go with its fourth power


@dataclass(frozen=True)
class Start:
    """Where the spacecraft starts relative to the reference, whose attitude starts at the identity."""

    offset_N: Vector = (20.0, -15.0, 10.0)  # m, body minus reference
    drift_N: Vector = (0.05, 0.02, -0.03)  # m/s, likewise
    angle: float = pi / 4  # rad
    axis: Vector = (1.0, 2.0, -1.0)
    omega_BN_B: Vector = (0.01, -0.008, 0.006)  # rad/s
    mass: float = MASS  # kg

    def __post_init__(self) -> None:
        """Refuse a start where the law does not exist, in one line."""
        if not (0 < self.mass < inf):
            raise AdcsError(f"mass = {self.mass:g} kg: expected a positive number")
        if np.linalg.norm(self.axis) == 0 or not np.isfinite([*self.axis, self.angle]).all():
            raise AdcsError(f"axis = {list(self.axis)}: expected a direction, with a finite angle")
        if abs(self.q_BN[0]) < SMALLEST_SCALAR:
            raise AdcsError(
                f"attitude error of {np.degrees(self.angle):g} deg: e_zeta(0) = 0, where the law does not exist; start "
                "closer to the reference"
            )
        if np.linalg.norm(self.r_BN_N) <= EARTH["earth_radius"]:
            raise AdcsError(f"offset_N = {list(self.offset_N)} m: the spacecraft would start inside the Earth")

    @property
    def q_BN(self) -> Vector:
        """Attitude, that of the error too."""
        axis = np.asarray(self.axis, dtype=float) / np.linalg.norm(self.axis)
        return (cos(self.angle / 2), *(sin(self.angle / 2) * axis).tolist())

    @property
    def r_BN_N(self) -> Vector:
        """Position: that of the perigee and the offset [m]."""
        perigee = ORBIT["semi_major_axis"] * (1 - ORBIT["eccentricity"])
        return tuple((np.array([perigee, 0.0, 0.0]) + self.offset_N).tolist())

    @property
    def v_BN_N(self) -> Vector:
        """Velocity: that at the perigee and the drift [m/s]."""
        e, tilt = ORBIT["eccentricity"], ORBIT["inclination"]
        speed = sqrt(ORBIT["mu"] / ORBIT["semi_major_axis"] * (1 + e) / (1 - e))
        return tuple((speed * np.array([0.0, cos(tilt), sin(tilt)]) + self.drift_N).tolist())

    @property
    def filter_state(self) -> dict[str, Vector]:
        """p(0) = k r_0(0) (34), in scaled units."""
        e_R = rotate(self.q_BN, -np.asarray(self.offset_N)) / LENGTH_UNIT
        e_eps = relative_quaternion(self.q_BN, (1.0, 0.0, 0.0, 0.0))[1:]
        return {"p_R": tuple((GAINS["k"] * e_R).tolist()), "p_eps": tuple((GAINS["k"] * e_eps).tolist())}


@dataclass(frozen=True)
class Scaling:
    """The units in which the law is applied; 1 s makes it as the paper has it."""

    length: float = LENGTH_UNIT  # m
    time: float = TIME_UNIT  # s
    mass: float = MASS_UNIT  # kg

    @property
    def parameters(self) -> dict[str, Any]:
        """As filter and controller take them."""
        return {"length_unit": self.length, "time_unit": self.time, "mass_unit": self.mass}


@dataclass(frozen=True)
class Choices(Checked):
    """All of the scenario that may be changed. All of it is printed in the report."""

    stop_time: float = choice(600.0, "end of every run [s]", positive("time"))
    settled: float = choice(0.01, "an error has converged once below this part of its start", PART)
    max_force: float = choice(2.0, "limit of each force axis in the saturated run [N]", positive("force"))
    max_torque: float = choice(0.03, "limit of each torque axis in the saturated run [N.m]", positive("torque"))
