"""The closed loops: a controller, with its observer where it has one, in a scenario, at a control rate."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import get_args

import numpy as np

from adcs.library.trigo import settings
from adcs.library.trigo.catalogue import LONG_NAMES, SCENARIOS, Controller, Scenario, system_name
from adcs.library.trigo.settings import (
    AS_MADE,
    CONTROL_RATE,
    PLANT_STEP,
    Reading,
    Start,
    known_inertia,
    mirror_moments,
    parallel_axis,
)
from fmus.errors import AdcsError
from orchestration.system import System

ZERO = (0.0, 0.0, 0.0)
RECORD = (
    "guidance.sigma_RO",
    "plant.sigma_BO",
    "plant.omega_BN_B",
    "plant.workload",
    "plant.torque_unmodelled_B",
    "law.sigma_RB",
    "law.z_2_B",
    "law.omega_c_B",
    "law.omegaDot_c_B",
    "law.torque_B",
    "law.torque_raw_B",
)
ESTIMATE, INNOVATION = "observer.torque_disturbance_B_est", "observer.innovation_B"


def build(
    controller: Controller,
    scenario: Scenario = "nominal",
    reading: Reading = AS_MADE,
    rate: float = CONTROL_RATE,
    reduced_gains: bool | None = None,
) -> System:
    """One of the closed loops; `rate` in Hz. At 5 Hz NESO and I&I have reduced gains, unless `reduced_gains` says."""
    if controller not in LONG_NAMES:
        raise AdcsError(f"no controller {controller!r}: choose one of {', '.join(LONG_NAMES)}")
    if scenario not in get_args(Scenario):
        raise AdcsError(f"no scenario {scenario!r}: choose one of {', '.join(SCENARIOS)}")
    if not 0 < rate < np.inf:
        raise AdcsError(f"control rate {rate:g} Hz: expected a positive number")
    system = System(
        system_name(controller, scenario),
        f"{LONG_NAMES[controller]}, {SCENARIOS[scenario]}; control at {rate:g} Hz, {reading.name}",
    )
    period, n = 1 / rate, reading.orbital_rate(scenario, rate)
    known = {"J0_B": known_inertia(scenario), "orbital_rate": n}
    reduced = rate == 5.0 if reduced_gains is None else reduced_gains
    odd = reading.odd_start(rate)
    sampled = {"period": period, "lag": 0 if odd else reading.lag, "difference": int(reading.rate_by_difference)}
    system.add("guidance", "ScanningReference", {"slew_start": reading.slew_start, **sampled})
    omega = (0.0, -n, 0.0) if odd else ZERO
    # Held as a torque the mismatch acts on a body of the known inertia; else it is in the body.
    true = known["J0_B"] if reading.disturbance_held else settings.INERTIA
    system.add("plant", "OrbitingBody", {"J_B": true, **known, "omega_BN_B": omega, "max_internal_step": PLANT_STEP})
    system.add("sensor", "AttitudeRateSensor")
    law = {
        **known,
        "c_1": settings.C_1 * np.eye(3),
        "c_2": settings.C_2 * np.eye(3),
        "K": (0.0 if controller == "bs" else settings.DAMPING) * np.eye(3),
        "rate_limit": settings.RATE_LIMIT,
        "acceleration_limit": reading.acceleration_limit,
        "torque_limit": settings.TORQUE_LIMIT,
        "torque_rate_limit": settings.TORQUE_RATE_LIMIT,
        "period": period,
        "start_at_command": int(odd),
    }
    system.add("law", "BacksteppingControl", law)
    for name in ("sigma_BO", "omega_BN_B"):
        system.connect(f"plant.{name}", f"sensor.{name}")
        system.connect(f"sensor.{name}_meas", f"law.{name}")
    for name in ("sigma_RO", "sigmaDot_RO"):
        system.connect(f"guidance.{name}", f"law.{name}")
    system.connect("law.torque_B", "plant.torque_B")
    _add_observer(system, controller, known, period, reading, reduced)
    _add_disturbance(system, scenario, known, period, reading)
    return system


def _add_observer(
    system: System, controller: Controller, known: Start, period: float, reading: Reading, reduced: bool
) -> None:
    if controller == "tf":
        gain = settings.TF_GAIN * np.eye(3)
        start = {"G": gain, "period": period, "update_first": reading.update_first}
        system.add("observer", "TuningFunctionObserver", start)
        system.connect("law.z_2_bar_B", "observer.z_2_bar_B")
    elif controller == "neso":
        J0 = known["J0_B"]
        gain = (settings.REDUCED_NESO_GAIN if reduced else settings.NESO_GAIN) * J0
        beta = {"beta_1": np.eye(3), "beta_2": gain @ J0 if reading.neso_inertia_twice else gain}
        start = {**known, **settings.NESO, **beta, "torque_delay": reading.neso_torque_delay, "period": period}
        system.add("observer", "NonlinearExtendedStateObserver", start)
        system.connect("sensor.sigma_BO_meas", "observer.sigma_BO")
        system.connect("sensor.omega_BN_B_meas", "observer.omega_BN_B")
        system.connect("law.torque_B", "observer.torque_B")
    elif controller == "ii":
        gamma = settings.REDUCED_II_GAIN if reduced else settings.II_GAIN
        start = {"J0_B": known["J0_B"], "gamma": gamma, "period": period, "update_first": reading.update_first}
        system.add("observer", "ImmersionInvarianceObserver", start)
        system.connect("sensor.omega_BN_B_meas", "observer.omega_BN_B")
        system.connect("law.acceleration_expected_B", "observer.acceleration_expected_B")
    if "observer" in system.components:
        system.connect(ESTIMATE, "law.torque_disturbance_B_est")
    else:
        system.set("law.torque_disturbance_B_est", ZERO)


def _add_disturbance(system: System, scenario: Scenario, known: Start, period: float, reading: Reading) -> None:
    held = period if reading.disturbance_held else 0.0

    def offset(mass: float, position: tuple[float, float, float]) -> settings.Matrix:
        return parallel_axis(mass, position) if reading.parallel_axis else np.zeros((3, 3))

    if scenario == "wheel":
        mass, radius = settings.WHEEL_MASS, settings.WHEEL_RADIUS
        spin = {"axis": settings.WHEEL_AXIS, "inertia": mass * radius**2 / 2, "speed": settings.WHEEL_SPEED}
        around = {"J_offset_B": offset(mass, settings.WHEEL_POSITION), "period": held}
        system.add("wheel", "SpinningWheel", spin | around)
        system.connect("plant.omega_BN_B", "wheel.omega_BN_B")
        system.connect("wheel.torque_B", "plant.torque_disturbance_B")
    elif scenario == "mirror":
        swing = {**known, **settings.MIRROR_SWING, "J_A": mirror_moments(reading.mirror_size)}
        around = {"J_offset_B": offset(settings.MIRROR_MASS, settings.MIRROR_POSITION), "period": held}
        system.add("mirror", "OscillatingPayload", swing | {"euler": settings.MIRROR_EULER} | around)
        _connect_source(system, "mirror")
    elif scenario == "mismatch" and reading.disturbance_held:
        system.add("mismatch", "InertiaMismatch", {"J_B": settings.INERTIA, **known, "period": held})
        _connect_source(system, "mismatch")
    else:
        system.set("plant.torque_disturbance_B", ZERO)


def _connect_source(system: System, source: str) -> None:
    system.connect("plant.sigma_BO", f"{source}.sigma_BO")
    system.connect("plant.omega_BN_B", f"{source}.omega_BN_B")
    system.connect("law.torque_B", f"{source}.torque_control_B")
    system.connect(f"{source}.torque_B", "plant.torque_disturbance_B")


def exchange_step(scenario: Scenario, reading: Reading, rate: float) -> float:
    """The longest exchange step [s] that changes nothing.

    The control period, since plant and law hold everything else; the plant's step where a source acts continuously.
    """
    continuous = scenario in ("wheel", "mirror") and not reading.disturbance_held
    return PLANT_STEP if continuous else 1 / rate


def stride(step: float, rate: float) -> int:
    """Exchange steps from one control instant to the next; AdcsError unless it is a whole number of them."""
    ratio = 1 / (rate * step)
    if round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-9 * ratio:
        raise AdcsError(
            f"the control period, 1/{rate:g} s, is not a whole number of exchange steps of {step:g} s: "
            f"give a step that divides it, such as {1 / rate / max(1, round(ratio)):g} s"
        )
    return round(ratio)


def recorded(system: System) -> list[str]:
    """What measures and figures need."""
    return [*RECORD, *(name for name in (ESTIMATE, INNOVATION) if name in system.outputs())]


BUILDERS: dict[str, Callable[[], System]] = {
    system_name(controller, scenario): partial(build, controller, scenario)
    for scenario in SCENARIOS
    for controller in LONG_NAMES
}
"""Every controller in every scenario, at 10 Hz in the reading of the tables, by the name of its system."""
