"""The components of ch. 3 alone: outputs, derivatives and directional derivatives at random points; what is refused."""

from typing import Any

import numpy as np
import pytest

from adcs import AdcsError, CoupledModel, System, run
from orchestration.running.method import method_of
from references.adaptive import DIAGONAL
from references.answers.adaptive import certainty_equivalence
from tests.one_fmu import Component

from .at_points import draw

INERTIAS = ("J_0_B", "J_1_B")


def test_the_points_reach_both_sides_of_the_projection() -> None:
    """Else the comparison above would not see it."""
    acting = []
    for point in draw("AdaptiveFuelTracking"):
        _, rates = certainty_equivalence(point, "sigma_est", DIAGONAL)
        _, plain = certainty_equivalence({**point, "sigma_bound": 1e6, "theta_bound": 1e6}, "sigma_est", DIAGONAL)
        acting.append([np.abs(rates[n] - plain[n]).max() > 1e-6 for n in ("theta_est", "sigma_est")])
    share = np.mean(acting, axis=0)
    assert ((share > 0.1) & (share < 0.9)).all()


# --- what is refused, and what is reported ----------------------------------------------------------------------------


def started(component: str, start: dict[str, Any]) -> CoupledModel:
    """The component alone, initialised; every input has a constant value."""
    system = System("alone")
    system.add("it", component, start)
    return CoupledModel(system)


LEVEL = {
    "q_BN": [1, 0, 0, 0],
    "q_RN": [1, 0, 0, 0],
    "omega_BN_B": [0, 0, 0],
    "omega_RN_R": [0, 0, 0],
    "omegaDot_RN_R": [0, 0, 0],
}
NO_TORQUE = {"torque_B": [0, 0, 0], "torque_disturbance_B": [0, 0, 0]}
STILL = {"position_B": np.zeros((2, 3)), "velocity_B": np.zeros((2, 3))}


@pytest.mark.parametrize(
    ("component", "start", "message"),
    [
        pytest.param(
            "AppendageBody",
            {**NO_TORQUE, **STILL, "mass": [1.0, -1.3]},
            "mass[2] = -1.3 refused: must be at least 0",
            id="a negative mass",
        ),
        pytest.param(
            "AppendageBody",
            {**NO_TORQUE, **STILL, "J_0_B": np.diag([20.0, 17.0, -15.0])},
            "J_0_B = [20 0 0; 0 17 0; 0 0 -15] is not positive definite",
            id="indefinite inertia",
        ),
        pytest.param(
            "FuelLossBody",
            {**NO_TORQUE, "fuel": 3000.0},
            "J_0_B - fuel J_1_B is not positive definite: without fuel no inertia would be left, choose less fuel or a "
            "smaller J_1_B",
            id="more fuel than inertia",
        ),
        pytest.param(
            "FuelLossBody",
            {**NO_TORQUE, "J_1_B": np.diag([4e-3, -4e-3, 5e-3])},
            "is not positive definite: a symmetric matrix of positive eigenvalues is expected",
            id="fuel of negative inertia",
        ),
        pytest.param(
            "AdaptiveTracking",
            {**LEVEL, "theta_bound": 10.0, "theta_margin": 10.0},
            "theta_est starts outside the set that its projection keeps it in: its norm must be below "
            "sqrt(theta_bound^2 + theta_margin^2)",
            id="an estimate outside its set",
        ),
        pytest.param(
            "AdaptiveFuelTracking",
            {**LEVEL, "sigma_est": [0.01, 0.01, 0.0]},
            "the estimate of J_1 starts outside the set that its projection keeps it in: its norm must be below "
            "sqrt(sigma_bound^2 + sigma_margin^2)",
            id="an estimate of J_1 outside its set",
        ),
        pytest.param(
            "AdaptiveAppendageTracking",
            {**LEVEL, **STILL, "gamma_2": -1.0},
            "gamma_2 = -1 refused: must be at least 0",
            id="adaptation flipped by its gain",
        ),
    ],
)
def test_what_makes_no_sense_is_refused(component: str, start: dict[str, Any], message: str) -> None:
    with pytest.raises(AdcsError) as refused, started(component, start):
        pass
    assert message in str(refused.value)


def test_an_empty_tank_is_reported_and_gives_no_torque() -> None:
    """1 N m until the 10 N m s are spent; then the body coasts, with an inertia that is definite and constant."""
    start = {**NO_TORQUE, "torque_B": [1.0, 0.0, 0.0], "fuel": 10.0, "J_0_B": np.diag([3.0, 4.0, 5.0])}
    system = System("tank")
    system.add("plant", "FuelLossBody", {**start, "J_1_B": 0.1 * np.eye(3)})
    for method in ("co-simulation", "model-exchange"):
        result = run(
            system,
            stop_time=20.0,
            step=0.01,
            method=method_of(method),
        )
        impulse, left = result["plant.torque_impulse"], result["plant.fuel_left"]
        assert np.isfinite(result["plant.omega_BN_B"]).all()
        np.testing.assert_allclose(left[:1000], 10.0 - result.time[:1000], atol=1e-9)
        assert (left[1002:] == 0).all()
        np.testing.assert_allclose(impulse[1002:], 10.0, atol=1e-9)
        np.testing.assert_allclose(result["plant.J_B"][-1], np.diag([2.0, 3.0, 4.0]), atol=1e-12)
        # J omega' = u - J' omega - ...: the momentum grows by the torque, and stays once there is none
        np.testing.assert_allclose(result["plant.H_N"][-1], [10.0, 0.0, 0.0], atol=1e-9)


def test_beyond_its_limit_the_fuel_law_says_so_and_stays_finite() -> None:
    """|J_1_est Omega| >= 1, (3.39), along a rate that grows through the limit, with the torque with and against it."""
    estimate, seen = {"sigma_est": [0.1, 0.1, 0.1], "sigma_bound": 1.0, "sigma_margin": 1.0}, []
    for rate in (0.0, 5.0, 9.9, 10.0, 10.1, 100.0, -100.0, 1e6):
        for beta in (1e-3, 20.0):
            values = {**LEVEL, **estimate, "omega_BN_B": [rate, 0, 0], "omega_RN_R": [rate, 0, 0], "beta": beta}
            with started("AdaptiveFuelTracking", values) as model:
                outputs = model.outputs(0.0, model.x0)
                assert np.isfinite(model.rhs(0.0, model.x0)).all()
            assert all(np.isfinite(value).all() for value in outputs.values())
            margin = float(outputs["it.implementability"])
            assert margin == pytest.approx(1 - 0.1 * abs(rate), abs=1e-12)
            norm = np.linalg.norm(outputs["it.torque_B"])
            consistent = norm == pytest.approx(float(outputs["it.torque_norm"]), rel=1e-9, abs=1e-12)
            seen.append((margin > 1e-3, consistent))
    assert all(consistent for valid, consistent in seen if valid), "within the limit |u| solves (3.38)"


def test_at_rest_on_its_reference_every_law_is_finite() -> None:
    """Where the torque is zero |u| has no derivative; the directional derivatives are numbers all the same."""
    for name in ("AdaptiveFuelTracking", "AdaptiveFuelTrackingFull"):
        point = {**LEVEL, "theta_est": np.array([21.1, 1.9, 1.4, 17.8, 2.9, 15.5]), "torque_impulse": np.array(0.0)}
        with Component(name, 2, LEVEL) as component:
            unknowns = component.names("output") + [f"der({s})" for s in component.states]
            np.testing.assert_array_equal(component.get("torque_B"), np.zeros(3))
            for known in ("q_BN", "omega_BN_B", "omega_RN_R", "omegaDot_RN_R", "theta_est", "torque_impulse"):
                seed = np.ones(np.shape(point[known]))
                assert np.isfinite(component.directional(unknowns, known, seed)).all()
    with Component("FuelLossBody", 2, NO_TORQUE) as component:
        unknowns = component.names("output") + [f"der({s})" for s in component.states]
        assert np.isfinite(component.directional(unknowns, "torque_B", np.ones(3))).all()
