"""The figures of chapter 9 and appendix E, and how one run of a system is shown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from adcs.library.attitude import norm
from adcs.library.trigo.catalogue import Controller, Scenario
from adcs.library.trigo.metrics import disturbance, measure, pointing_error, rate_error
from adcs.library.trigo.settings import (
    ADAPTIVE,
    ATTITUDE_REQUIREMENT,
    CONTROLLERS,
    RATE_REQUIREMENT,
    STATIC,
)
from adcs.library.trigo.systems import ESTIMATE, INNOVATION
from orchestration.results.plots import Guide, Panel, Series, components
from orchestration.results.report import KeyNumber
from orchestration.results.result import Result

Array = NDArray[np.float64]

POINTING_LABEL, RATE_LABEL = "θ_e [arcsec]", "|ω_e| [arcsec/s]"
POINTING_GUIDE = Guide(ATTITUDE_REQUIREMENT, "required: 30 arcsec")
RATE_GUIDE = Guide(RATE_REQUIREMENT, "required: 1 arcsec/s")
COLORS = {controller: i for i, controller in enumerate(CONTROLLERS)}
GROUPS: dict[Scenario, str] = {
    "nominal": "Nominal scenario",
    "mismatch": "Constant inertial mismatch",
    "wheel": "Saturated reaction wheel",
    "mirror": "Moving payload",
}
# Scenario: numbers of the figures of pointing error, rate error, tracking, and torque with estimation.
FIGURES: dict[Scenario, tuple[str, str, str, str, str]] = {
    "nominal": ("9.4", "9.5", "E.1", "E.2", "E.2"),
    "mismatch": ("9.6", "9.7", "E.3", "E.4", "E.4"),
    "wheel": ("9.8", "9.9", "E.5", "E.6", "E.6"),
    "mirror": ("9.10", "9.11", "E.7", "E.8", "E.10"),
}
Runs = Mapping[Controller, Result]
SHOWN_FROM = 10.0  # s
LEFT_OUT = "The first 10 s, in which the rate command rises from 0, are left out."


def _shown(result: Result) -> NDArray[np.bool_]:
    return np.asarray(result.time >= SHOWN_FROM)


def euler_321(sigma: ArrayLike) -> Array:
    """Angles theta_1, theta_2, theta_3 [deg] of the rotation order 3-2-1 of MRP (N, 3)."""
    s = np.asarray(sigma, dtype=float)
    square = np.sum(s**2, axis=1)
    q_0, (q_1, q_2, q_3) = (1 - square) / (1 + square), (2 * s / (1 + square)[:, None]).T
    angles: Array = np.degrees(
        np.column_stack(
            [
                np.arctan2(2 * (q_2 * q_3 + q_0 * q_1), q_0**2 - q_1**2 - q_2**2 + q_3**2),
                np.arcsin(np.clip(-2 * (q_1 * q_3 - q_0 * q_2), -1, 1)),
                np.arctan2(2 * (q_1 * q_2 + q_0 * q_3), q_0**2 + q_1**2 - q_2**2 - q_3**2),
            ]
        )
    )
    return angles


def reference_panels(result: Result) -> list[Panel]:
    """Fig. 9.3."""
    time, sigma, title = result.time, result["guidance.sigma_RO"], "reference attitude"
    angles = components("θ", time, euler_321(sigma))
    return [
        Panel(f"Fig. 9.3a: {title}", "MRP", components("MRP", time, sigma), group="Reference"),
        Panel(f"Fig. 9.3b: {title}", "Euler angles 3-2-1 [deg]", angles, group="Reference"),
    ]


def scenario_panels(scenario: Scenario, runs: Runs) -> list[Panel]:
    """The figures of one scenario, all controllers beside each other."""
    pointing, rate, tracking, torque, estimation = FIGURES[scenario]
    parts: list[tuple[str, str, Sequence[Controller]]] = [("", "", tuple(CONTROLLERS))]
    if scenario in ("wheel", "mirror"):
        parts = [("a", ", static controllers", STATIC), ("b", ", adaptive controllers", ADAPTIVE)]
    panels = []
    for number, what, label, guide, values in (
        (pointing, "pointing error", POINTING_LABEL, POINTING_GUIDE, pointing_error),
        (rate, "norm of the rate error", RATE_LABEL, RATE_GUIDE, rate_error),
    ):
        for letter, those, controllers in parts:
            curves = [_series(runs[c], c, values(runs[c])) for c in controllers]
            title = f"Fig. {number}{letter}: {what}{those}"
            panels.append(Panel(title, label, curves, note=LEFT_OUT, guides=[guide]))
    note = "The others lie on the same curves."
    attitude = ("reference", "guidance.sigma_RO", "plant.sigma_BO", "MRP", 1.0)
    velocity = ("x_2,c", "law.omega_c_B", "plant.omega_BN_B", "ω [rad/s]", 1.0)
    command = ("", "", "law.torque_B", "T_c [mN·m]", 1e3)
    panels += [
        replace(_compared(f"Fig. {tracking}a: attitude", runs, *attitude), note=note),
        _compared(f"Fig. {tracking}b: angular velocity", runs, *velocity),
        _compared(f"Fig. {torque}a: control torque", runs, *command),
    ]
    for axis in range(3):
        curves = [_series(runs[c], c, 1e6 * runs[c][ESTIMATE][:, axis]) for c in ADAPTIVE]
        late = _shown(runs["ii"])
        known = 1e6 * disturbance(runs["ii"])[late, axis]
        curves.append(Series("T_d", runs["ii"].time[late], known, "dot", color=7))
        title = f"Fig. {estimation}: disturbance torque and its estimates, axis {axis + 1}"
        panels.append(Panel(title, f"T_d{axis + 1} [µN·m]", curves, note=LEFT_OUT))
    if scenario == "mirror":
        innovation = components("ω̃", runs["neso"].time, 1e6 * runs["neso"][INNOVATION])
        panels.append(Panel("Fig. E.9: innovation of the NESO", "ω - ω̂ [µrad/s]", innovation))
    return [replace(panel, group=GROUPS[scenario]) for panel in panels]


def _compared(title: str, runs: Runs, what: str, wanted: str, name: str, label: str, factor: float) -> Panel:
    """A variable under the least and the most elaborate law, beside what is wanted of it, if that is given."""
    bs, ii = runs["bs"], runs["ii"]
    curves = components(what, ii.time, ii[wanted], "dot") if wanted else []
    curves += components("BS", bs.time, factor * bs[name], "dash") + components("I&I", ii.time, factor * ii[name])
    return Panel(title, label, curves)


def _series(result: Result, controller: Controller, values: Array) -> Series:
    late = _shown(result)
    return Series(CONTROLLERS[controller], result.time[late], values[late], color=COLORS[controller])


def figures(result: Result) -> list[Panel]:
    """Of one run: errors with the requirements, attitude, rate, torque, disturbance and estimate."""
    time, known = result.time, disturbance(result)
    attitude = components("reference", time, result["guidance.sigma_RO"], "dot")
    attitude += components("body", time, result["plant.sigma_BO"])
    panels = [
        Panel("Pointing error", POINTING_LABEL, [Series("", time, pointing_error(result))], guides=[POINTING_GUIDE]),
        Panel("Norm of the rate error", RATE_LABEL, [Series("", time, rate_error(result))], guides=[RATE_GUIDE]),
        Panel("Attitude", "MRP", attitude),
        Panel("Angular velocity", "ω [rad/s]", components("ω", time, result["plant.omega_BN_B"])),
        Panel("Control torque", "T_c [mN·m]", components("T_c", time, 1e3 * result["law.torque_B"])),
    ]
    if norm(known).max() > 1e-12 or ESTIMATE in result.names:
        curves = components("T_d", time, 1e6 * known, "dot")
        if ESTIMATE in result.names:
            curves += components("estimate", time, 1e6 * result[ESTIMATE])
        panels.append(Panel("Disturbance torque", "T_d [µN·m]", curves))
    return panels


def key_numbers(result: Result) -> list[KeyNumber]:
    """RMS of the errors in the thesis' stretches of time as far as the run goes, and the workload."""
    if len(result.time) < 2:
        return []
    if result.time[-1] < 510:
        theta = pointing_error(result)
        return [KeyNumber("Pointing error, RMS", float(np.sqrt(np.mean(theta[1:] ** 2))), "arcsec", "start left out")]
    metrics = measure(result)
    numbers = [
        KeyNumber(f"Pointing error, RMS, {name}", value, "arcsec", stretch)
        for (name, value), stretch in zip(
            metrics.pointing.items(), ("start left out", "300 to 500 s", "from 500 s on"), strict=True
        )
    ]
    if ESTIMATE in result.names:
        numbers.append(KeyNumber("Estimation error, RMS", 1e6 * metrics.estimation, "µN·m", "from 505 s on"))
    numbers.append(KeyNumber("Workload", 1e3 * metrics.workload, "mJ", "of the control torque"))
    return numbers
