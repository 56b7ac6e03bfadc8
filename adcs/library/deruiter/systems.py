"""The closed loop with exact states, with bounded estimation errors, and with an observer."""

from __future__ import annotations

from collections.abc import Callable

from adcs.library.deruiter.catalogue import SYSTEMS
from adcs.library.deruiter.design import EstimationBounds
from adcs.library.deruiter.settings import GUIDANCE, INERTIA, OBSERVER_GAINS, OMEGA_START, Q_START, Choices
from orchestration.system import System


def exact_states(choices: Choices | None = None, *, disturbed: bool = False, dead_zone: float | None = None) -> System:
    """The law fed with the true attitude and rate; without disturbance it has no dead zone unless one is given."""
    choices = choices or Choices()
    system = _system("bounded-adaptive")
    if dead_zone is None:
        dead_zone = choices.guarantee(EstimationBounds()).dead_zone if disturbed else 0.0
    _add_common(system, choices, dead_zone, disturbed)
    system.connect("plant.q_BN", "controller.q_BN")
    system.connect("plant.omega_BN_B", "controller.omega_BN_B")
    return system


def bounded_errors(choices: Choices | None = None, *, run: int = 0, dead_zone: float | None = None) -> System:
    """The law fed with attitude and rate that err smoothly within bounds, under disturbance."""
    choices = choices or Choices()
    system = _system("bounded-adaptive-errors")
    _add_common(system, choices, choices.guarantee(choices.errors()).dead_zone if dead_zone is None else dead_zone)
    system.add("estimate", "BoundedEstimationError", choices.generator(run))
    system.connect("plant.q_BN", "estimate.q_BN")
    system.connect("plant.omega_BN_B", "estimate.omega_BN_B")
    system.connect("estimate.q_EN", "controller.q_BN")
    system.connect("estimate.omega_BN_B_est", "controller.omega_BN_B")
    return system


def observer(choices: Choices | None = None, *, inertia: object = INERTIA, dead_zone: float | None = None) -> System:
    """The law fed with the true attitude and the rate of an observer that assumes `inertia` [kg.m2], no gyro."""
    choices = choices or Choices()
    system = _system("bounded-adaptive-observer")
    zone = choices.guarantee(choices.observer_errors()).dead_zone if dead_zone is None else dead_zone
    _add_common(system, choices, zone)
    start = {"q_EN": Q_START, "omega_EN_E": (0.0, 0.0, 0.0)}
    system.add("observer", "SmoothRateObserver", {"J_B": inertia, **OBSERVER_GAINS, **start})
    system.connect("plant.q_BN", "observer.q_BN")
    system.connect("controller.torque_B", "observer.torque_B")
    system.connect("plant.q_BN", "controller.q_BN")
    system.connect("observer.omega_BN_B_est", "controller.omega_BN_B")
    return system


BUILDERS: dict[str, Callable[[], System]] = {
    "bounded-adaptive": exact_states,
    "bounded-adaptive-errors": bounded_errors,
    "bounded-adaptive-observer": observer,
}
"""Every loop by the name of its system."""


def _system(name: str) -> System:
    return System(name, SYSTEMS[name])


def _add_common(system: System, choices: Choices, dead_zone: float, disturbed: bool = True) -> None:
    system.add("guidance", "SinusoidalRateReference", GUIDANCE)
    plant = {"J_B": INERTIA, "q_BN": Q_START, "omega_BN_B": OMEGA_START}
    system.add("plant", "RigidBody", plant if disturbed else {**plant, "torque_disturbance_B": (0.0, 0.0, 0.0)})
    if disturbed:
        system.add("disturbance", "SinusoidalTorque", choices.torque())
        system.connect("disturbance.torque_B", "plant.torque_disturbance_B")
    system.add("controller", "BoundedAdaptiveTracking", choices.controller(dead_zone))
    for name in ("q_RN", "omega_RN_R", "omegaDot_RN_R"):
        system.connect(f"guidance.{name}", f"controller.{name}")
    system.connect("controller.torque_B", "plant.torque_B")
