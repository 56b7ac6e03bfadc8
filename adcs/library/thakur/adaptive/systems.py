"""The closed loops of Sec. 3.4: adaptive tracking and the comparison controller, on three bodies."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

from adcs.library.thakur.adaptive import settings as settings
from adcs.library.thakur.adaptive.settings import Reading
from adcs.library.thakur.catalogue import SYSTEMS
from orchestration.system import System

ESTIMATING = {"theta_est": settings.THETA_START}
KNOWING = {"theta_est": settings.THETA}
APPENDAGE = {**settings.ADAPTIVE_GAINS, **settings.APPENDAGE_ADAPTATION, **ESTIMATING}
FUEL = {
    **settings.ADAPTIVE_GAINS,
    **settings.FUEL_ADAPTATION,
    **settings.FUEL_PROJECTION,
    **ESTIMATING,
    "max_internal_step": settings.FUEL_INTERNAL_STEP,
}
COMPARISON = {**settings.COMPARISON_GAINS, "gamma": settings.COMPARISON_ADAPTATION, **ESTIMATING}


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


class Loop(NamedTuple):
    """A law with its parameters, on a body."""

    body: Callable[[System], None]
    controller: str
    law: Mapping[str, Any]


LOOPS = {
    "adaptive-baseline": Loop(_rigid, "AdaptiveTracking", {**settings.ADAPTIVE_GAINS, "gamma_1": 0.0, **KNOWING}),
    "comparison-baseline": Loop(
        _rigid, "NonCertaintyEquivalenceTracking", {**settings.COMPARISON_GAINS, "gamma": 0.0, **KNOWING}
    ),
    "adaptive-appendage": Loop(_with_appendages, "AdaptiveAppendageTracking", APPENDAGE),
    "adaptive-appendage-full": Loop(_with_appendages, "AdaptiveAppendageTrackingFull", APPENDAGE),
    "comparison-appendage": Loop(_with_appendages, "NonCertaintyEquivalenceTracking", COMPARISON),
    "adaptive-fuel": Loop(_losing_fuel, "AdaptiveFuelTracking", FUEL),
    "adaptive-fuel-full": Loop(_losing_fuel, "AdaptiveFuelTrackingFull", FUEL),
    "comparison-fuel": Loop(_losing_fuel, "NonCertaintyEquivalenceTracking", COMPARISON),
}
"""Every loop by the name of its system; the comparison law knows nothing of how the inertia changes."""


def build(name: str, reading: Reading = "printed", **gains: float) -> System:
    """One of the loops; `gains` replace parameters of the law."""
    loop = LOOPS[name]
    system = System(name, SYSTEMS[name])
    frequency = settings.FREQUENCIES[reading]
    system.add("guidance", "FixedAxisReference", {**settings.GUIDANCE, "frequency": frequency})
    loop.body(system)
    system.add("controller", loop.controller, {**loop.law, **gains})
    for variable in ("q_RN", "omega_RN_R", "omegaDot_RN_R"):
        system.connect(f"guidance.{variable}", f"controller.{variable}")
    for variable in ("q_BN", "omega_BN_B"):
        system.connect(f"plant.{variable}", f"controller.{variable}")
    system.connect("controller.torque_B", "plant.torque_B")
    for variable in ("position_B", "velocity_B"):
        if variable in system.components["controller"].fmu.ports:  # a law that knows how the appendages move
            system.connect(f"paths.{variable}", f"controller.{variable}")
    return system


BUILDERS: dict[str, Callable[..., System]] = {name: partial(build, name) for name in LOOPS}
baseline, comparison_baseline = BUILDERS["adaptive-baseline"], BUILDERS["comparison-baseline"]
appendage, appendage_full = BUILDERS["adaptive-appendage"], BUILDERS["adaptive-appendage-full"]
fuel, fuel_full = BUILDERS["adaptive-fuel"], BUILDERS["adaptive-fuel-full"]
comparison_appendage, comparison_fuel = BUILDERS["comparison-appendage"], BUILDERS["comparison-fuel"]
