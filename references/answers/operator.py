"""What an operator moves: the commanded reference and the torque switch."""

import numpy as np

from ..law import Law, Point, Values, quaternion
from ..observer_pd import Array


def to_the_last_bit(name: str, expected: Array, point: Values) -> Array:
    """A unit quaternion is normalised as it comes in, by less than a rounding."""
    return np.asarray(1e-15)


def reference_point(rng: np.random.Generator) -> Point:
    vectors = {name: rng.normal(size=3) for name in ("omega_RN_R", "omegaDot_RN_R", "omega_CN_C")}
    quaternions = {name: quaternion(rng) for name in ("q_RN", "q_CN", "q_BN")}
    return {**quaternions, "engaged": np.array(rng.integers(2)), **vectors}


def selected(p: Values) -> Point:
    """By a choice, where the component has a sum."""
    if p["engaged"]:
        q_CN = min(p["q_CN"], -p["q_CN"], key=lambda q: float(np.linalg.norm(q - p["q_BN"])))
        return {"q_SN": q_CN, "omega_SN_S": p["omega_CN_C"], "omegaDot_SN_S": np.zeros(3)}
    return {"q_SN": p["q_RN"], "omega_SN_S": p["omega_RN_R"], "omegaDot_SN_S": p["omegaDot_RN_R"]}


def switched(p: Values) -> Point:
    return {"torque_applied_B": p["torque_B"] if p["enabled"] else np.zeros(3)}


LAWS = {
    "CommandedReference": Law(
        draw=reference_point,
        outputs=selected,
        rounding=to_the_last_bit,
        choosing=frozenset({("q_SN", "q_CN"), ("q_SN", "q_BN")}),
    ),
    "TorqueSwitch": Law(
        draw=lambda rng: {"torque_B": rng.normal(size=3), "enabled": np.array(rng.integers(2))},
        outputs=switched,
        rounding=to_the_last_bit,
    ),
}
