"""The closed loop of the paper: no translational or angular velocity goes to filter or controller."""

from __future__ import annotations

from collections.abc import Callable

from adcs.library.six_dof.catalogue import SYSTEMS
from adcs.library.six_dof.settings import EARTH, GAINS, INERTIA, ORBIT, REFERENCE_RATE, Scaling, Start
from orchestration.system import System


def six_dof(start: Start | None = None, scaling: Scaling | None = None) -> System:
    """The loop with actuators that give what is asked for."""
    return _loop("six-dof", start or Start(), scaling or Scaling(), 0.0, 0.0)


def saturated(max_force: float = 2.0, max_torque: float = 0.03, start: Start | None = None) -> System:
    """The loop with limited actuators [N], [N.m]."""
    return _loop("six-dof-saturated", start or Start(), Scaling(), max_force, max_torque)


BUILDERS: dict[str, Callable[[], System]] = {"six-dof": six_dof, "six-dof-saturated": saturated}
"""Both by the names of their systems."""


def _loop(name: str, start: Start, scaling: Scaling, max_force: float, max_torque: float) -> System:
    system = System(name, SYSTEMS[name])
    body = {"mass": start.mass, "J_B": INERTIA, "mu": EARTH["mu"]}
    system.add("orbit", "KeplerOrbit", ORBIT)
    system.add("guidance", "SinusoidalRateReference", REFERENCE_RATE)
    motion = {"r_BN_N": start.r_BN_N, "v_BN_N": start.v_BN_N, "q_BN": start.q_BN, "omega_BN_B": start.omega_BN_B}
    system.add("plant", "SixDofBody", {**body, "earth_radius": EARTH["earth_radius"], **motion})
    system.add("filter", "PoseErrorFilter", {**GAINS, **scaling.parameters, **start.filter_state})
    system.add("controller", "SixDofOutputFeedback", {**body, **GAINS, **scaling.parameters})
    system.add("actuator", "ForceTorqueActuator", {"max_force": max_force, "max_torque": max_torque})
    for user in ("filter", "controller"):
        system.connect("plant.r_BN_N", f"{user}.r_BN_N")
        system.connect("plant.q_BN", f"{user}.q_BN")
        system.connect("orbit.r_ON_N", f"{user}.r_RN_N")
        system.connect("guidance.q_RN", f"{user}.q_RN")
        system.connect("guidance.omega_RN_R", f"{user}.omega_RN_R")
    system.connect("guidance.omegaDot_RN_R", "controller.omegaDot_RN_R")
    system.connect("filter.e_f_R", "controller.e_f_R")
    system.connect("filter.e_f_eps", "controller.e_f_eps")
    for effect in ("force", "torque"):
        system.connect(f"controller.{effect}_B", f"actuator.{effect}_command_B")
        system.connect(f"actuator.{effect}_B", f"plant.{effect}_B")
    return system
