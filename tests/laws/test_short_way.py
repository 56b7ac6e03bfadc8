"""q and -q are one attitude: what laws make of the sign, and the choice of the short way."""

import numpy as np
import pytest

from adcs import System, run
from references.observer_pd import Array
from tests.one_fmu import VERSIONS, Component

TILTED = np.array([0.8, 0.6, 0.0, 0.0])
CHOICE = (
    "PdTracking",
    "AdaptiveTracking",
    "AdaptiveAppendageTracking",
    "AdaptiveAppendageTrackingFull",
    "AdaptiveFuelTracking",
    "AdaptiveFuelTrackingFull",
    "BoundedAdaptiveTracking",
    "SmoothRateObserver",
)


def angle(q: Array) -> Array:
    return 2 * np.degrees(np.arctan2(np.linalg.norm(q[:, 1:], axis=1), np.abs(q[:, 0])))


def slew(q_BN: Array, short_way: bool) -> tuple[Array, Array]:
    """Attitude from a tumble that begins at q_BN, brought to [1 0 0 0], and the law's V_c."""
    J_B = np.diag([10.0, 19.0, 25.0])
    system = System("slew")
    still = {"omega_BN_B": [1e-3, 0, 0], "torque_disturbance_B": [0, 0, 0], "J_B": J_B}
    system.add("plant", "RigidBody", {"q_BN": q_BN, **still})
    reference = {"q_RN": [1, 0, 0, 0], "omega_RN_R": [0, 0, 0], "omegaDot_RN_R": [0, 0, 0]}
    system.add("law", "PdTracking", {**reference, "J_B": J_B, "short_way": short_way})
    for source, target in (("plant.q_BN", "law.q_BN"), ("plant.omega_BN_B", "law.omega_BN_B")):
        system.connect(source, target)
    system.connect("law.torque_B", "plant.torque_B")
    result = run(system, stop_time=120.0, step=0.01)
    omega, q = result["plant.omega_BN_B"], result["law.q_BR"]
    V = 1.5 * 2 * (1 - q[:, 0]) + 0.5 * np.einsum("ki,ij,kj->k", omega, J_B, omega)
    return result["plant.q_BN"], V


@pytest.mark.parametrize(("start", "largest"), [(TILTED, 74), (-TILTED, 180), (np.array([-1.0, 0, 0, 0]), 180)])
def test_the_sign_decides_the_way(start: Array, largest: float) -> None:
    """From -q by 286 degrees, over 180; with the short way by 74; the Lyapunov function falls either way."""
    for short_way, expected in ((False, largest), (True, min(largest, angle(start[None])[0]))):
        q, V = slew(start, short_way)
        assert angle(q).max() == pytest.approx(expected, abs=0.5)
        assert angle(q)[-1] < 0.5
        assert np.diff(V).max() < 1e-8  # the torque is held for 10 ms; a jump would be 0.1 and more


def test_the_lyapunov_function_falls_through_the_switch() -> None:
    """Thrown over 180 degrees by its spin, the law lets go on the other side, and V_c does not jump up."""
    J_B = np.diag([10.0, 19.0, 25.0])
    system = System("thrown")
    still = {"torque_disturbance_B": [0, 0, 0], "J_B": J_B}
    system.add("plant", "RigidBody", {"q_BN": [0.1, np.sqrt(0.99), 0, 0], "omega_BN_B": [1.5, 0, 0], **still})
    reference = {"q_RN": [1, 0, 0, 0], "omega_RN_R": [0, 0, 0], "omegaDot_RN_R": [0, 0, 0]}
    system.add("law", "PdTracking", {**reference, "J_B": J_B, "short_way": True})
    for source, target in (("plant.q_BN", "law.q_BN"), ("plant.omega_BN_B", "law.omega_BN_B")):
        system.connect(source, target)
    system.connect("law.torque_B", "plant.torque_B")
    result = run(system, stop_time=60.0, step=0.001)
    omega, q = result["plant.omega_BN_B"], result["law.q_BR"]
    assert result["plant.q_BN"][-1, 0] == pytest.approx(-1, abs=1e-3)
    assert (q[:, 0] >= 0).all()
    V = 1.5 * 2 * (1 - q[:, 0]) + 0.5 * np.einsum("ki,ij,kj->k", omega, J_B, omega)
    assert np.diff(V).max() < 1e-5


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", CHOICE)
def test_with_the_choice_both_signs_are_answered_alike(name: str, version: int) -> None:
    rng = np.random.default_rng(5)
    for short_way in (False, True):
        for _ in range(5):
            q = rng.normal(size=4)
            answers = []
            for sign in (1, -1):
                point = {"q_BN": sign * q / np.linalg.norm(q), "short_way": np.array(short_way)}
                with Component(name, version, point) as component:
                    outputs = [n for n in component.names("output") if n not in point]
                    answers.append(np.concatenate([component.get(n).ravel() for n in outputs]))
            assert (answers[0].tolist() == answers[1].tolist()) == short_way


@pytest.mark.parametrize("version", VERSIONS)
def test_six_degrees_of_freedom_answer_both_signs_alike(version: int) -> None:
    """Without a choice: the filter's signal goes with the sign."""
    rng = np.random.default_rng(6)
    for _ in range(5):
        q, e_f = rng.normal(size=4), 0.1 * rng.normal(size=3)
        answers = []
        for sign in (1, -1):
            point = {"q_BN": sign * q / np.linalg.norm(q), "e_f_eps": sign * e_f, "e_f_R": np.array([0.1, 0.2, 0.3])}
            with Component("SixDofOutputFeedback", version, point) as component:
                answers.append(np.concatenate([component.get("force_B"), component.get("torque_B")]))
        np.testing.assert_allclose(answers[0], answers[1], rtol=1e-12, atol=1e-12)
