"""The closed loops of Sec. 3.4: adaptive tracking and the comparison controller, on three bodies."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from adcs.library.thakur.adaptive import settings as settings
from adcs.library.thakur.adaptive.settings import Reading
from adcs.library.thakur.catalogue import SYSTEMS
from orchestration.system import System

RECORD = (
    "guidance.omega_RN_R",
    "plant.q_BN",
    "plant.omega_BN_B",
    "controller.torque_B",
    "controller.q_BR",
    "controller.omega_BR_B",
    "controller.theta_est",
)
RECORD_VARIABLE = (*RECORD, "plant.J_B")

Body = Callable[[System], None]


def baseline(reading: Reading = "printed") -> System:
    """The proposed law (3.20) on a rigid body with known inertia: no adaptation."""
    system = System("adaptive-baseline", SYSTEMS["adaptive-baseline"])
    law = {**settings.ADAPTIVE_GAINS, "gamma_1": 0.0, "theta_est": settings.THETA}
    return _closed(system, reading, _rigid, "AdaptiveTracking", law)


def comparison_baseline(reading: Reading = "printed") -> System:
    """The comparison law (3.53) on a rigid body with known inertia: no adaptation."""
    system = System("comparison-baseline", SYSTEMS["comparison-baseline"])
    law = {**settings.COMPARISON_GAINS, "gamma": 0.0, "theta_est": settings.THETA}
    return _closed(system, reading, _rigid, "NonCertaintyEquivalenceTracking", law)


def appendage(reading: Reading = "printed", **gains: float) -> System:
    """Adaptive tracking with moving appendages, Sec. 3.4.1; the law estimates the two masses."""
    system = System("adaptive-appendage", SYSTEMS["adaptive-appendage"])
    return _appendage(system, reading, "AdaptiveAppendageTracking", gains)


def appendage_full(reading: Reading = "printed", **gains: float) -> System:
    """The same, all 18 elements of J_1 estimated."""
    system = System("adaptive-appendage-full", SYSTEMS["adaptive-appendage-full"])
    return _appendage(system, reading, "AdaptiveAppendageTrackingFull", gains)


def comparison_appendage(reading: Reading = "printed") -> System:
    """The comparison law on the body with moving appendages, of which it knows nothing."""
    system = System("comparison-appendage", SYSTEMS["comparison-appendage"])
    return _closed(system, reading, _with_appendages, "NonCertaintyEquivalenceTracking", _comparison_law())


def fuel(reading: Reading = "printed", **gains: float) -> System:
    """Adaptive tracking with fuel loss, Sec. 3.4.2; the law estimates the diagonal of J_1."""
    system = System("adaptive-fuel", SYSTEMS["adaptive-fuel"])
    return _fuel(system, reading, "AdaptiveFuelTracking", gains)


def fuel_full(reading: Reading = "printed", **gains: float) -> System:
    """The same, all nine elements of J_1 estimated."""
    system = System("adaptive-fuel-full", SYSTEMS["adaptive-fuel-full"])
    return _fuel(system, reading, "AdaptiveFuelTrackingFull", gains)


def comparison_fuel(reading: Reading = "printed") -> System:
    """The comparison law on the body that loses fuel, of which it knows nothing."""
    system = System("comparison-fuel", SYSTEMS["comparison-fuel"])
    return _closed(system, reading, _losing_fuel, "NonCertaintyEquivalenceTracking", _comparison_law())


def _comparison_law() -> dict[str, Any]:
    return {
        **settings.COMPARISON_GAINS,
        "gamma": settings.COMPARISON_ADAPTATION,
        "theta_est": settings.THETA_START,
    }


def _appendage(system: System, reading: Reading, controller: str, gains: Mapping[str, float]) -> System:
    law = {**settings.ADAPTIVE_GAINS, **settings.APPENDAGE_ADAPTATION, "theta_est": settings.THETA_START, **gains}
    _closed(system, reading, _with_appendages, controller, law)
    for name in ("position_B", "velocity_B"):
        system.connect(f"paths.{name}", f"controller.{name}")
    return system


def _fuel(system: System, reading: Reading, controller: str, gains: Mapping[str, float]) -> System:
    law = {
        **settings.ADAPTIVE_GAINS,
        **settings.FUEL_ADAPTATION,
        **settings.FUEL_PROJECTION,
        "theta_est": settings.THETA_START,
        "max_internal_step": settings.FUEL_INTERNAL_STEP,
        **gains,
    }
    return _closed(system, reading, _losing_fuel, controller, law)


def _rigid(system: System) -> None:
    system.add("plant", "RigidBody", {"J_B": settings.INERTIA, **settings.START})


def _with_appendages(system: System) -> None:
    system.add("paths", "AppendagePaths", settings.PATHS)
    system.add("plant", "AppendageBody", {"J_0_B": settings.INERTIA, "mass": settings.MASSES, **settings.START})
    for name in ("position_B", "velocity_B"):
        system.connect(f"paths.{name}", f"plant.{name}")


def _losing_fuel(system: System) -> None:
    rates = [[rate * (i == j) for j in range(3)] for i, rate in enumerate(settings.FUEL_RATES)]
    system.add("plant", "FuelLossBody", {"J_0_B": settings.INERTIA, "J_1_B": rates, **settings.START})


def _closed(system: System, reading: Reading, body: Body, controller: str, law: Mapping[str, Any]) -> System:
    frequency = settings.FREQUENCIES[reading]
    system.add("guidance", "FixedAxisReference", {**settings.GUIDANCE, "frequency": frequency})
    body(system)
    system.add("controller", controller, law)
    for name in ("q_RN", "omega_RN_R", "omegaDot_RN_R"):
        system.connect(f"guidance.{name}", f"controller.{name}")
    for name in ("q_BN", "omega_BN_B"):
        system.connect(f"plant.{name}", f"controller.{name}")
    system.connect("controller.torque_B", "plant.torque_B")
    return system


BUILDERS: dict[str, Callable[[], System]] = {
    "adaptive-baseline": baseline,
    "comparison-baseline": comparison_baseline,
    "adaptive-appendage": appendage,
    "adaptive-appendage-full": appendage_full,
    "comparison-appendage": comparison_appendage,
    "adaptive-fuel": fuel,
    "adaptive-fuel-full": fuel_full,
    "comparison-fuel": comparison_fuel,
}
"""Every loop by the name of its system."""
