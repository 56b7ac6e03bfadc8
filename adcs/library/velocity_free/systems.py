"""The closed loops of Sec. V: stabilisation and tracking, ideal and with all uncertainties."""

from __future__ import annotations

from collections.abc import Callable

from adcs.library.velocity_free.catalogue import SYSTEMS
from adcs.library.velocity_free.settings import (
    ASSUMED_INERTIA,
    AT_REST,
    DRAG_AND_OBLATENESS,
    GAINS,
    INERTIA,
    ORBIT,
    REFERENCE_RATE,
    START,
    Uncertainty,
)
from orchestration.system import System


def stabilisation() -> System:
    """Bring the body to rest at the identity attitude, everything known."""
    return _loop("velocity-free-stabilisation", False, None)


def tracking() -> System:
    """Follow the swinging reference, everything known."""
    return _loop("velocity-free-tracking", True, None)


def uncertain_stabilisation(uncertainty: Uncertainty | None = None) -> System:
    """Stabilisation with measurement error and environment torque; at rest the law uses no inertia."""
    return _loop("velocity-free-stabilisation-uncertain", False, uncertainty or Uncertainty())


def uncertain_tracking(uncertainty: Uncertainty | None = None) -> System:
    """Tracking with measurement error, environment torque and a wrong inertia in the law."""
    return _loop("velocity-free-tracking-uncertain", True, uncertainty or Uncertainty())


BUILDERS: dict[str, Callable[[], System]] = {
    "velocity-free-stabilisation": stabilisation,
    "velocity-free-tracking": tracking,
    "velocity-free-stabilisation-uncertain": uncertain_stabilisation,
    "velocity-free-tracking-uncertain": uncertain_tracking,
}
"""Every loop by the name of its system."""


def _loop(name: str, moving: bool, uncertainty: Uncertainty | None) -> System:
    system = System(name, SYSTEMS[name])
    system.add("guidance", "SinusoidalRateReference", REFERENCE_RATE if moving else AT_REST)
    system.add("plant", "RigidBody", {"J_B": INERTIA, **START})
    # sigma(0) is the error quaternion at the start; the reference starts at the identity
    system.add("filter", "AttitudeErrorFilter", {"sigma_BR": START["q_BN"]})
    assumed = INERTIA if uncertainty is None else ASSUMED_INERTIA
    system.add("controller", "VelocityFreeTracking", {"J_B": assumed, **GAINS})
    if uncertainty is None:
        measured = "plant.q_BN"
        system.set("plant.torque_disturbance_B", (0.0, 0.0, 0.0))
    else:
        measured = "tracker.q_BN_meas"
        system.add("orbit", "KeplerOrbit", ORBIT)
        system.add(
            "environment", "EnvironmentTorque", {"J_B": INERTIA, "mass": uncertainty.mass, **DRAG_AND_OBLATENESS}
        )
        system.add("tracker", "RandomWalkStarTracker", uncertainty.tracker)
        system.connect("plant.q_BN", "tracker.q_BN")
        system.connect("plant.q_BN", "environment.q_BN")
        system.connect("orbit.r_ON_N", "environment.r_BN_N")
        system.connect("orbit.v_ON_N", "environment.v_BN_N")
        system.connect("environment.torque_B", "plant.torque_disturbance_B")
    for user in ("filter", "controller"):
        system.connect(measured, f"{user}.q_BN")
        system.connect("guidance.q_RN", f"{user}.q_RN")
    system.connect("guidance.omega_RN_R", "controller.omega_RN_R")
    system.connect("guidance.omegaDot_RN_R", "controller.omegaDot_RN_R")
    system.connect("filter.sigmaDot_BR", "controller.sigmaDot_BR")
    system.connect("controller.torque_B", "plant.torque_B")
    return system
