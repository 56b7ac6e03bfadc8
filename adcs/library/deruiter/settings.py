"""The set-up that we simulate; the paper has no simulation, so all of it is our choice."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, inf, pi, radians, sin, sqrt
from typing import Any

import numpy as np

from adcs.library.choices import Checked, Must, at_least, choice, positive
from adcs.library.deruiter.design import EstimationBounds, Guarantee, Law, Task

REFERENCE = "de Ruiter, Observer-Based Adaptive Spacecraft Attitude Control with Guaranteed Performance Bounds"

INERTIA = ((20.0, 1.2, 0.9), (1.2, 17.0, 1.4), (0.9, 1.4, 15.0))  # I, kg.m2
NOMINAL_INERTIA = ((21.0, 0.0, 0.0), (0.0, 16.5, 0.0), (0.0, 0.0, 14.5))  # I*, kg.m2
SMALLEST_MOMENT = 13.0  # lambda_I, kg.m2
GUIDANCE: dict[str, Any] = {
    "rate_bias": (0.0, 0.0, 0.0),
    "rate_amplitude": (0.010, 0.008, 0.006),  # rad/s
    "rate_frequency": (0.05, 0.04, 0.03),  # rad/s
    "rate_phase": (0.0, 1.0, pi / 2),
    "q_RN": (1.0, 0.0, 0.0, 0.0),
}
_TURN, _AXIS = radians(120), (1 / sqrt(14), -2 / sqrt(14), 3 / sqrt(14))
Q_START = (cos(_TURN / 2), *(sin(_TURN / 2) * a for a in _AXIS))  # q_BN(0); the reference starts along N
OMEGA_START = (0.05, -0.04, 0.06)  # omega_BN_B(0), rad/s
# Estimation errors and disturbance: frequencies without common measure, so that the bounds are approached in time.
_SPREAD = (1.0, sqrt(2), sqrt(3))
ERROR_FREQUENCIES = {
    "attitude_frequency": tuple(0.1 * s for s in _SPREAD),
    "rate_frequency": tuple(0.13 * s for s in _SPREAD),
}  # rad/s
DISTURBANCE_FREQUENCY = tuple(0.02 * s for s in _SPREAD)  # rad/s
OBSERVER_GAINS = {"lambda": 1.0, "gamma": 3.0}  # as in Thakur, Sec. 5.4

REFERENCE_RATE = sqrt(sum(a**2 for a in GUIDANCE["rate_amplitude"]))
REFERENCE_ACCELERATION = sqrt(
    sum((a * f) ** 2 for a, f in zip(GUIDANCE["rate_amplitude"], GUIDANCE["rate_frequency"], strict=True))
)


AFTER_STEADY = Must(lambda stop, c: c.steady_from < stop < inf, "later than steady_from, {steady_from:g} s")
ABOVE_LIMIT = Must(
    lambda margin, _: 1 < margin < inf, "a factor above 1: the dead zone must exceed its limit, Eq. (47)"
)


@dataclass(frozen=True)
class Choices(Checked):
    """All numbers of the study that can be set; they are printed in the report."""

    k: float = choice(0.3, "gain of the filtered rate error [1/s]")
    lam: float = choice(0.05, "lambda, gain of the attitude in it [1/s]")
    gamma: float = choice(20.0, "adaptation gain of theta [s2]", positive("gain"))
    gamma_p: float = choice(0.02, "adaptation gain of theta_p [s2/(kg2.m4)]", positive("gain"))
    eta: float = choice(0.35, "theta is known to lie within this of theta*")
    eta_p: float = choice(0.015, "theta_p is known to lie within this of theta_p* [1/(kg.m2)]")
    epsilon: float = choice(0.1, "room of both projections beyond eta, eta_p")
    attitude_error: float = choice(1e-3, "v_q, bound on the error of the attitude estimate")
    rate_error: float = choice(1e-4, "v_omega, bound on the error of the rate estimate [rad/s]")
    error_speed: float = choice(1.0, "factor on the frequencies of the estimation errors", positive("factor"))
    disturbance: float = choice(
        1e-3,
        "bound on the disturbance torque [N.m]",
        positive("torque: with none and exact states all bounds are 0"),
    )
    observer_rate_error: float = choice(8e-4, "bound taken for the observer's rate error, read off a first run [rad/s]")
    observer_rate_error_rate: float = choice(5e-5, "bound taken for the time derivative of that, likewise [rad/s2]")
    margin: float = choice(1.05, "dead zone over its lower limit, Eq. (47)", ABOVE_LIMIT)
    seed: int = choice(1, "seed of the phases of the estimation errors; others count up", at_least(0))
    seeds: int = choice(3, "number of runs with different phases of the estimation errors", at_least(1))
    fast: float = choice(
        1000.0, "factor on both adaptation gains of the run that brings the projection to act", positive("factor")
    )
    stop_time: float = choice(1500.0, "end of every run [s]", AFTER_STEADY)
    steady_from: float = choice(900.0, "limits superior are taken from here to the end [s]", positive("time"))

    @property
    def law(self) -> Law:
        """The law's parameters."""
        gains = {"k": self.k, "lam": self.lam, "eta": self.eta, "eta_p": self.eta_p}
        return Law(NOMINAL_INERTIA, **gains, epsilon=self.epsilon, epsilon_p=self.epsilon)

    def errors(self) -> EstimationBounds:
        """Bounds on the error generator's errors: given amplitudes, and rates that follow from the frequencies."""
        speeds = {name: self.error_speed * _rms(values) for name, values in ERROR_FREQUENCIES.items()}
        return EstimationBounds(
            self.attitude_error,
            self.rate_error,
            self.attitude_error * speeds["attitude_frequency"],
            self.rate_error * speeds["rate_frequency"],
        )

    def observer_errors(self) -> EstimationBounds:
        """Bounds taken for the observer: its attitude is the measured one, which is exact."""
        return EstimationBounds(0.0, self.observer_rate_error, 0.0, self.observer_rate_error_rate)

    def guarantee(self, estimation: EstimationBounds) -> Guarantee:
        """The theorem for these estimation errors."""
        task = Task(REFERENCE_RATE, REFERENCE_ACCELERATION, self.disturbance, SMALLEST_MOMENT)
        return Guarantee(self.law, task, estimation, self.margin, true_inertia=INERTIA)

    def controller(self, dead_zone: float) -> dict[str, Any]:
        """Start values of the controller."""
        return {
            "J_B": NOMINAL_INERTIA,
            "k": self.k,
            "lambda": self.lam,
            "gamma": self.gamma,
            "gamma_p": self.gamma_p,
            "eta": self.eta,
            "eta_p": self.eta_p,
            "epsilon": self.epsilon,
            "epsilon_p": self.epsilon,
            "dead_zone": dead_zone,
        }

    def generator(self, run: int = 0) -> dict[str, Any]:
        """Start values of the error generator, its phases drawn for the `run`-th seed."""
        phases = np.random.default_rng(self.seed + run).uniform(0, 2 * pi, (2, 3))
        frequencies = {name: tuple(self.error_speed * f for f in v) for name, v in ERROR_FREQUENCIES.items()}
        return {
            "attitude_bound": self.attitude_error,
            "rate_bound": self.rate_error,
            "attitude_phase": tuple(phases[0].tolist()),
            "rate_phase": tuple(phases[1].tolist()),
            **frequencies,
        }

    def torque(self) -> dict[str, Any]:
        """Start values of the disturbance torque, whose norm stays within the bound."""
        return {
            "torque_bias": (0.0, 0.0, 0.0),
            "torque_amplitude": (self.disturbance / sqrt(3),) * 3,
            "torque_frequency": DISTURBANCE_FREQUENCY,
            "torque_phase": (0.0, 2.0, 4.0),
        }


def _rms(values: tuple[float, ...]) -> float:
    return sqrt(sum(v**2 for v in values) / len(values))
