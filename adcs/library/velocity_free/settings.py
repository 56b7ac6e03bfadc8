"""The numbers of Sec. V, once, and the choices that the text leaves open."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians, sqrt
from typing import Any

from adcs.library.choices import Checked, Must, at_least, choice, positive

REFERENCE = (
    "Velocity-free passivity-based attitude tracking with measurement errors, disturbances and inertia mismatch, Sec. V"
)

Vector = tuple[float, ...]

INERTIA = ((0.0465, -0.0007, 0.0004), (-0.0007, 0.0486, -0.0021), (0.0004, -0.0021, 0.0482))  # kg.m2, Eq. (91)
ASSUMED_INERTIA = ((0.046, 0.0, 0.0), (0.0, 0.049, 0.0), (0.0, 0.0, 0.048))  # kg.m2, of the tracking controller
GAINS = {"a": 0.2, "b": 0.8}  # N.m, N.m.s
ERROR_BOUND = RATE_BOUND = 0.01  # mu_v, mu_omega
TORQUE_BOUND = 1e-4  # N.m, mu_d; the exponent is lost in print
INERTIA_BOUND = 0.005  # kg.m2, mu_J
START_ATTITUDE, START_RATE = 0.1, 0.1  # of the gain regions; the second is printed as 0.01, see the docs
START: dict[str, Vector] = {
    "q_BN": (sqrt(0.9925), 0.05, 0.05, 0.05),
    "omega_BN_B": (-0.09, 0.03, -0.03),  # rad/s
}
REFERENCE_RATE = {  # 0.05 sin(0.5 t) rad/s about each axis
    "rate_bias": (0.0, 0.0, 0.0),
    "rate_amplitude": (0.05, 0.05, 0.05),
    "rate_frequency": (0.5, 0.5, 0.5),
    "rate_phase": (0.0, 0.0, 0.0),
}
AT_REST = REFERENCE_RATE | {"rate_amplitude": (0.0, 0.0, 0.0)}
RATE_LIMIT, ACCELERATION_LIMIT = 0.05 * sqrt(3), 0.025 * sqrt(3)  # nu_omega, nu_omegaDot when tracking

EARTH = {"mu": 398.6e12, "earth_radius": 6371.0e3}
ORBIT: dict[str, float] = {"semi_major_axis": 6371.0e3 + 765.0e3, "inclination": radians(70.0), **EARTH}
DRAG_AND_OBLATENESS: dict[str, Any] = {
    "drag_coefficient": 2.5,
    "area": 0.04,
    "density": 1.99e-14,
    "lever_arm_B": (0.01, 0.0, 0.0),
    "j2": 1082.6e-6,
    **EARTH,
}


@dataclass(frozen=True)
class Uncertainty:
    """What the text leaves open about measurement error and disturbance."""

    hold_time: float = 0.1  # s
    error_bound: float = ERROR_BOUND
    seed: int = 1
    mass: float = 1.0  # kg

    @property
    def tracker(self) -> dict[str, float | int]:
        """Parameters of the star tracker; its rates stay below 2 mu_omega (28)."""
        kept = {"hold_time": self.hold_time, "error_bound": self.error_bound, "seed": self.seed}
        return {"max_rate": 2 * RATE_BOUND, **kept}


WITHIN_RUN = Must(lambda start, c: 0 <= start < c.stop_time, "earlier than stop_time")
SHORT = Must(lambda step, _: 0 < step <= 0.05, "a positive time up to 0.05 s")
FEASIBLE = Must(lambda points, _: 5 <= points <= 201, "5 to 201")


@dataclass(frozen=True)
class Choices(Checked):
    """What the text does not say, or what is lost in print. All of it is printed in the report."""

    seeds: int = choice(10, "number of runs with uncertainties, in each of the two problems", at_least(1))
    seed: int = choice(1, "seed of the first of them; the others count up from it", at_least(0))
    hold_time: float = choice(0.1, "the random rate of the measurement error is held [s]", positive("time"))
    mass: float = choice(1.0, "mass of the spacecraft, missing in (92) [kg]", positive("mass"))
    stop_time: float = choice(200.0, "end of every run [s]", positive("time"))
    steady_from: float = choice(100.0, "the residual set is looked at from here on [s]", WITHIN_RUN)
    step: float = choice(0.002, "exchange step of the runs with uncertainties [s]", SHORT)
    start_rate: float = choice(START_RATE, "|dw(0)| of the gain regions [rad/s]", at_least(0))
    grid: int = choice(41, "points per axis on which the gain regions are looked for", FEASIBLE)
