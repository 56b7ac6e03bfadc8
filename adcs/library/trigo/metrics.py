"""The measures of Sec. 9.3 from a recorded run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from adcs.library.attitude import norm, rms
from adcs.library.trigo.settings import ARCSEC
from adcs.library.trigo.systems import ESTIMATE
from orchestration.results.result import Result

Array = NDArray[np.float64]

_TINY = 1e-6  # s, against rounding of the time grid
INTERVALS = {"entire": (0.0, inf), "steady": (300.0, 500.0), "scanning": (500.0, inf)}  # s
# s, without the peaks where a stretch begins and the scan sets in
SETTLED = {"steady": (320.0, 499.5), "scanning": (520.0, inf)}
ESTIMATED_FROM = 505.0  # s


@dataclass(frozen=True)
class Metrics:
    """Of one run: RMS of the pointing error by stretch [arcsec], of disturbance and estimation error [N.m]; work [J].

    `worst` has the largest pointing [arcsec] and rate error [arcsec/s] by stretch, without the peaks at its beginning;
    `command_rate` [rad/s2] and `torque` [N.m] are the largest rate of x_2,c and the largest torque asked for.
    """

    pointing: Mapping[str, float]
    worst: Mapping[str, tuple[float, float]]
    estimation: float
    disturbance: float
    workload: float
    command_rate: float
    torque: float


def pointing_error(result: Result) -> Array:
    """theta_e = 4 atan |sigma_e| [arcsec] (9.10), (N,)."""
    return np.asarray(4 * np.arctan(norm(result["law.sigma_RB"])) / ARCSEC)


def rate_error(result: Result) -> Array:
    """|z_2| [arcsec/s] (9.11), (N,)."""
    return np.asarray(norm(result["law.z_2_B"]) / ARCSEC)


def disturbance(result: Result) -> Array:
    """The torque that the model of inertia J_0 lacks [N.m], in B, (N, 3)."""
    return np.asarray(result["plant.torque_unmodelled_B"])


def measure(result: Result) -> Metrics:
    """The measures at the control instants, which are the rows; the start itself is left out."""
    time, theta, omega, torque = result.time, pointing_error(result), rate_error(result), disturbance(result)
    error = torque - result[ESTIMATE] if ESTIMATE in result.names else torque

    def part(start: float, end: float) -> Array:
        return np.asarray((time >= start - _TINY) & (time <= end + _TINY) & (time > _TINY))

    late = part(ESTIMATED_FROM, inf)
    return Metrics(
        pointing={name: rms(theta[part(*interval)]) for name, interval in INTERVALS.items()},
        worst={
            name: (float(theta[kept].max()), float(omega[kept].max()))
            for name, interval in SETTLED.items()
            if (kept := part(*interval)).any()
        },
        estimation=rms(norm(error[late])),
        disturbance=rms(norm(torque[late])),
        workload=float(result["plant.workload"][-1]),
        command_rate=float(norm(result["law.omegaDot_c_B"]).max()),
        torque=float(norm(result["law.torque_raw_B"]).max()),
    )
