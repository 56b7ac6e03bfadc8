"""Guidance, plant, observer and law of the loop without a gyro."""

from .. import observer_pd as ref
from ..law import Law, Point, Values, inertia, quaternion
from ..observer_pd import Reference, rotation


def profile(p: Values) -> Reference:
    scalars = {n: float(p[n]) for n in ("amplitude", "frequency", "decay", "ramp", "wobble")}
    return Reference(**scalars, axis=tuple(p["axis"]), q_0=tuple(p["q_RN_0"]))


def observer_error(p: Values) -> Point:
    c, q = ref.error(p["q_BN"], p["q_EN"])
    return {"omega_BN_B_est": c @ p["omega_EN_E"], "q_BE": q}


def control_error(p: Values) -> Point:
    c, q = ref.error(p["q_BN"], p["q_RN"])
    torque = ref.pd_torque(
        p["J_B"], p["k_p"], p["k_v"], p["q_BN"], p["omega_BN_B"], p["q_RN"], p["omega_RN_R"], p["omegaDot_RN_R"]
    )
    return {"torque_B": torque, "q_BR": q, "omega_BR_B": p["omega_BN_B"] - c @ p["omega_RN_R"]}


LAWS = {
    "FixedAxisReference": Law(
        draw=lambda rng: {
            "amplitude": rng.normal(),
            "frequency": rng.uniform(0, 2),
            "decay": rng.uniform(0, 0.05),
            "ramp": rng.normal(),
            "wobble": rng.normal(),
            "axis": rng.normal(size=3),
            "q_RN_0": quaternion(rng),
            "angle": rng.uniform(-10, 10),
            "time": rng.uniform(0, 20),
        },
        outputs=lambda p: {
            "angle": p["angle"],
            "q_RN": profile(p).attitude(p["angle"]),
            "omega_RN_R": profile(p).omega(p["time"]),
            "omegaDot_RN_R": profile(p).omega_dot(p["time"]),
        },
        rates=lambda p: {"angle": profile(p).rate(p["time"]).real},
    ),
    "RigidBody": Law(
        draw=lambda rng: {
            "J_B": inertia(rng),
            "q_BN": quaternion(rng),
            "omega_BN_B": rng.normal(size=3),
            "torque_B": rng.normal(size=3),
            "torque_disturbance_B": rng.normal(size=3),
        },
        outputs=lambda p: {
            "q_BN": p["q_BN"],
            "omega_BN_B": p["omega_BN_B"],
            "H_N": rotation(p["q_BN"]).apply(p["J_B"] @ p["omega_BN_B"]),
            "kinetic_energy": p["omega_BN_B"] @ p["J_B"] @ p["omega_BN_B"] / 2,
        },
        rates=lambda p: {
            "q_BN": ref.kinematics(p["q_BN"], p["omega_BN_B"]),
            "omega_BN_B": ref.body_acceleration(p["J_B"], p["omega_BN_B"], p["torque_B"] + p["torque_disturbance_B"]),
        },
    ),
    "SmoothRateObserver": Law(
        draw=lambda rng: {
            "J_B": inertia(rng),
            "lambda": rng.uniform(0.1, 3),
            "gamma": rng.uniform(0.1, 5),
            "q_EN": quaternion(rng),
            "omega_EN_E": rng.normal(size=3),
            "q_BN": quaternion(rng),
            "torque_B": rng.normal(size=3),
        },
        outputs=lambda p: {"q_EN": p["q_EN"], "omega_EN_E": p["omega_EN_E"], **observer_error(p)},
        rates=lambda p: dict(
            zip(
                ("q_EN", "omega_EN_E"),
                ref.observer_rates(
                    p["J_B"], p["lambda"], p["gamma"], p["q_BN"], p["torque_B"], p["q_EN"], p["omega_EN_E"]
                ),
                strict=True,
            )
        ),
    ),
    "PdTracking": Law(
        draw=lambda rng: {
            "J_B": inertia(rng),
            "k_p": rng.uniform(0.1, 3),
            "k_v": rng.uniform(0.1, 10),
            "q_BN": quaternion(rng),
            "omega_BN_B": rng.normal(size=3),
            "q_RN": quaternion(rng),
            "omega_RN_R": rng.normal(size=3),
            "omegaDot_RN_R": rng.normal(size=3),
        },
        outputs=control_error,
    ),
}
