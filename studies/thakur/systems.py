"""The two closed loops of Sec. 5.4: PD fed by the rate observer, and PD fed by the true rate."""

from __future__ import annotations

from orchestration import System
from studies.thakur.settings import GUIDANCE, INERTIA, OBSERVER_GAINS, PD_GAINS, Start

RECORD = (
    "guidance.q_RN",
    "guidance.omega_RN_R",
    "plant.q_BN",
    "plant.omega_BN_B",
    "controller.torque_B",
    "controller.q_BR",
    "controller.omega_BR_B",
)
RECORD_OBSERVER = (*RECORD, "observer.q_EN", "observer.omega_EN_E")


def full_state_pd(
    start: Start | None = None, *, half_angle: float = 0.0, redraw_period: float = 0.1, seed: int = 1
) -> System:
    """PD tracking (5.1) with the true angular velocity. `half_angle` [rad] is the star tracker's."""
    system = System("full-state-pd", "PD attitude tracking with the true angular velocity")
    _add_common(system, start or Start(), half_angle, redraw_period, seed)
    system.connect("plant.omega_BN_B", "controller.omega_BN_B")
    return system


def observer_pd(
    start: Start | None = None, *, half_angle: float = 0.0, redraw_period: float = 0.1, seed: int = 1
) -> System:
    """PD tracking (5.27) without gyro: the angular velocity comes from the observer (5.11)-(5.12)."""
    start = start or Start()
    system = System("observer-pd", "PD attitude tracking without gyro, by a smooth angular velocity observer")
    _add_common(system, start, half_angle, redraw_period, seed)
    system.add(
        "observer",
        "SmoothRateObserver",
        {"J_B": INERTIA, **OBSERVER_GAINS, "q_EN": start.q_BN, "omega_EN_E": start.omega_EN_E},
    )
    system.connect("tracker.q_BN_meas", "observer.q_BN")
    system.connect("controller.torque_B", "observer.torque_B")
    system.connect("observer.omega_BN_B_est", "controller.omega_BN_B")
    return system


def _add_common(system: System, start: Start, half_angle: float, redraw_period: float, seed: int) -> None:
    system.add("guidance", "FixedAxisReference", GUIDANCE)
    plant = {
        "J_B": INERTIA,
        "q_BN": start.q_BN,
        "omega_BN_B": start.omega_BN_B,
        "torque_disturbance_B": (0.0, 0.0, 0.0),
    }
    system.add("plant", "RigidBody", plant)
    system.add("tracker", "StarTracker", {"half_angle": half_angle, "redraw_period": redraw_period, "seed": seed})
    system.add("controller", "PdTracking", {"J_B": INERTIA, **PD_GAINS})
    system.connect("plant.q_BN", "tracker.q_BN")
    system.connect("tracker.q_BN_meas", "controller.q_BN")
    for name in ("q_RN", "omega_RN_R", "omegaDot_RN_R"):
        system.connect(f"guidance.{name}", f"controller.{name}")
    system.connect("controller.torque_B", "plant.torque_B")
