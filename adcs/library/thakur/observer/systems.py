"""The systems of Sec. 5.4: PD fed by the true rate, by the rate observer, by QUEST; the observer alone."""

from __future__ import annotations

from adcs.library.thakur.catalogue import SYSTEMS
from adcs.library.thakur.choices import Matrix
from adcs.library.thakur.gyro_free.settings import DIRECTIONS, WEIGHTS
from adcs.library.thakur.observer.settings import GUIDANCE, INERTIA, INERTIA_ERRORS, OBSERVER_GAINS, PD_GAINS, Start
from orchestration.system import System


def full_state_pd(
    start: Start | None = None, *, half_angle: float = 0.0, redraw_period: float = 0.1, seed: int = 1
) -> System:
    """PD tracking (5.1) with the true angular velocity. `half_angle` [rad] is the star tracker's."""
    system = System("full-state-pd", SYSTEMS["full-state-pd"])
    _add_body(system, start or Start())
    _add_tracker(system, half_angle, redraw_period, seed)
    _add_controller(system, "tracker.q_BN_meas")
    system.connect("plant.omega_BN_B", "controller.omega_BN_B")
    return system


def observer_pd(
    start: Start | None = None, *, half_angle: float = 0.0, redraw_period: float = 0.1, seed: int = 1
) -> System:
    """PD tracking (5.27) without gyro: the angular velocity comes from the observer (5.11)-(5.12)."""
    start = start or Start()
    system = System("observer-pd", SYSTEMS["observer-pd"])
    _add_body(system, start)
    _add_tracker(system, half_angle, redraw_period, seed)
    _add_controller(system, "tracker.q_BN_meas")
    _add_observer(system, start, "tracker.q_BN_meas")
    return system


def quest_observer_pd(
    start: Start | None = None,
    *,
    half_angle: float = 0.0,
    spread: float = 1 / 3,
    redraw_period: float = 0.1,
    seed: int = 1,
    memory_period: float = 0.1,
) -> System:
    """The same with the attitude that QUEST makes of three measured unit vectors, Sec. 5.4.3.

    `half_angle` [rad], `spread`, `redraw_period` [s] and `seed` are those of the unit vector sensor;
    `memory_period` [s] is how often QUEST remembers the sign of its quaternion.
    """
    start = start or Start()
    system = System("quest-observer-pd", SYSTEMS["quest-observer-pd"])
    _add_body(system, start)
    noise = {"half_angle": half_angle, "spread": spread, "redraw_period": redraw_period, "seed": seed}
    system.add("sensor", "UnitVectorSensor", {"directions_N": DIRECTIONS, **noise})
    quest = {"directions_N": DIRECTIONS, "weights": WEIGHTS, "memory_period": memory_period}
    system.add("quest", "Quest", {**quest, "q_BN_first": start.q_BN})
    system.connect("plant.q_BN", "sensor.q_BN")
    system.connect("sensor.directions_B_meas", "quest.directions_B")
    _add_controller(system, "quest.q_BN_est")
    _add_observer(system, start, "quest.q_BN_est")
    return system


def observer_inertia_error(error: Matrix = INERTIA_ERRORS[0]) -> System:
    """The observer beside a body without torque, Sec. 5.4.4; `error` [kg.m2] is added to the inertia it assumes."""
    start = Start()
    system = System("observer-inertia-error", SYSTEMS["observer-inertia-error"])
    still = (0.0, 0.0, 0.0)
    plant = {"J_B": INERTIA, "q_BN": start.q_BN, "omega_BN_B": start.omega_BN_B}
    system.add("plant", "RigidBody", {**plant, "torque_B": still, "torque_disturbance_B": still})
    assumed = [[x + dx for x, dx in zip(*rows, strict=True)] for rows in zip(INERTIA, error, strict=True)]
    estimate = {"q_EN": start.q_BN, "omega_EN_E": start.omega_EN_E}
    system.add("observer", "SmoothRateObserver", {"J_B": assumed, **OBSERVER_GAINS, **estimate, "torque_B": still})
    system.connect("plant.q_BN", "observer.q_BN")
    return system


def _add_body(system: System, start: Start) -> None:
    system.add("guidance", "FixedAxisReference", GUIDANCE)
    plant = {
        "J_B": INERTIA,
        "q_BN": start.q_BN,
        "omega_BN_B": start.omega_BN_B,
        "torque_disturbance_B": (0.0, 0.0, 0.0),
    }
    system.add("plant", "RigidBody", plant)


def _add_controller(system: System, attitude: str) -> None:
    """The PD law on the attitude measured at the output `attitude`."""
    system.add("controller", "PdTracking", {"J_B": INERTIA, **PD_GAINS})
    system.connect(attitude, "controller.q_BN")
    for name in ("q_RN", "omega_RN_R", "omegaDot_RN_R"):
        system.connect(f"guidance.{name}", f"controller.{name}")
    system.connect("controller.torque_B", "plant.torque_B")


def _add_tracker(system: System, half_angle: float, redraw_period: float, seed: int) -> None:
    system.add("tracker", "StarTracker", {"half_angle": half_angle, "redraw_period": redraw_period, "seed": seed})
    system.connect("plant.q_BN", "tracker.q_BN")


def _add_observer(system: System, start: Start, attitude: str) -> None:
    """The observer of an attitude measured at the output `attitude`, and its estimate into the control law."""
    system.add(
        "observer",
        "SmoothRateObserver",
        {"J_B": INERTIA, **OBSERVER_GAINS, "q_EN": start.q_BN, "omega_EN_E": start.omega_EN_E},
    )
    system.connect(attitude, "observer.q_BN")
    system.connect("controller.torque_B", "observer.torque_B")
    system.connect("observer.omega_BN_B_est", "controller.omega_BN_B")
