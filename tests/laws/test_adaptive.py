"""The components of ch. 3 alone: outputs, derivatives and directional derivatives at random points; what is refused."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

from adcs import AdcsError, CoupledModel, System, run
from orchestration.running.method import method_of
from tests.adaptor import test_dependencies as dependencies

from . import adaptive_reference as ref
from . import reference
from .adaptive_reference import DIAGONAL, MASSES, Adaptation, errors, every_element
from .at_points import (
    Law,
    Point,
    compare,
    directions,
    draw,
    inertia,
    integrates_with_fourth_order,
    opened,
    quaternion,
    slopes,
    to_1e_12,
)
from .fmu_access import VERSIONS, Component
from .reference import Array, rotation

Draw = Callable[[np.random.Generator], Point]


def tracking_point(rng: np.random.Generator) -> Point:
    return {
        "q_BN": quaternion(rng),
        "omega_BN_B": rng.normal(size=3),
        "q_RN": quaternion(rng),
        "omega_RN_R": rng.normal(size=3),
        "omegaDot_RN_R": rng.normal(size=3),
    }


def certainty_point(rng: np.random.Generator) -> Point:
    """Half of the points lie where the projection of theta_est may act; its start value does not."""
    theta = rng.normal(size=6)
    theta *= rng.uniform(40, 60) / np.linalg.norm(theta)
    bound = np.linalg.norm(theta) * rng.choice([0.9, 1.1])
    gains = {"beta": rng.uniform(1, 30), "k_v": rng.uniform(1, 30), "gamma_1": rng.uniform(0, 80)}
    projection = {"theta_bound": bound, "theta_margin": rng.uniform(0.6, 1) * bound}
    return {**tracking_point(rng), **gains, **projection, "theta_est": theta}


def estimate_point(rng: np.random.Generator, name: str, shape: tuple[int, ...], size: float) -> Point:
    estimate = rng.normal(size=shape) * size
    bound = np.linalg.norm(estimate) * rng.choice([0.9, 1.1])
    # rates of moderate size, so that differences resolve them
    projection = {"sigma_bound": bound, "sigma_margin": rng.uniform(0.6, 1) * bound}
    return {name: estimate, "gamma_2": rng.uniform(0, 8), **projection}


def appendage_motion(rng: np.random.Generator) -> Point:
    return {"position_B": rng.normal(size=(2, 3)), "velocity_B": rng.normal(size=(2, 3))}


def tracking_errors(p: Mapping[str, Any]) -> ref.Errors:
    return errors(p["q_BN"], p["omega_BN_B"], p["q_RN"], p["omega_RN_R"], p["omegaDot_RN_R"])


def certainty_equivalence(p: Mapping[str, Any], name: str, basis: Array) -> tuple[Point, Point]:
    """Outputs and derivatives of a law whose estimate of J_1 is called `name`, in the given parametrisation."""
    e, omega = tracking_errors(p), p["omega_BN_B"]
    W = ref.w_1(e, omega)
    u = -p["beta"] * e.q_e[1:] - p["k_v"] * e.omega_e - W @ p["theta_est"]
    theta_law = Adaptation(p["gamma_1"], p["theta_bound"], p["theta_margin"])
    outputs = {"q_BR": e.q_e, "omega_BR_B": e.omega_e, "theta_est": p["theta_est"]}
    rates = {"theta_est": theta_law.rate(p["theta_est"], W.T @ e.s)}
    if name:
        sigma = np.ravel(p[name])
        if "position_B" in p:
            W = ref.w_2(e, omega, basis, ref.point_psi(p["position_B"]))
            W = W + ref.w_3(e, omega, basis, ref.point_psi_dot(p["position_B"], p["velocity_B"]))
        else:
            unit_rate = ref.w_3(e, omega, basis, np.eye(3))
            W = ref.w_2(e, omega, basis, p["torque_impulse"] * np.eye(3))
            norm = ref.implicit_norm(u - W @ sigma, unit_rate @ sigma)
            W = W + norm * unit_rate
            rates["torque_impulse"] = np.array(norm)
            outputs |= {"torque_impulse": p["torque_impulse"], "torque_norm": np.array(norm)}
            outputs["implementability"] = 1 - np.linalg.norm(unit_rate @ sigma)
        u = u - W @ sigma
        sigma_law = Adaptation(p["gamma_2"], p["sigma_bound"], p["sigma_margin"])
        rates[name] = sigma_law.rate(sigma, W.T @ e.s).reshape(np.shape(p[name]))
        outputs[name] = p[name]
    return {**outputs, "torque_B": u}, rates


def certainty_law(draw: Draw, name: str = "", basis: Array | None = None) -> Law:
    used = np.zeros((0, 3, 3)) if basis is None else basis
    return Law(
        draw=draw,
        outputs=lambda p: certainty_equivalence(p, name, used)[0],
        rates=lambda p: certainty_equivalence(p, name, used)[1],
    )


def comparison(p: Mapping[str, Any]) -> dict[str, Array]:
    arguments = (p["theta_est"], p["omega_f"], np.reshape(p["W_f"], (3, 6)), p["gamma"], p["k_p"], p["k_w"])
    return ref.comparison_law(tracking_errors(p), p["omega_BN_B"], *arguments)


def body_rates(p: Mapping[str, Any], J: Array, J_dot: Array, torque: Array) -> Point:
    omega = p["omega_BN_B"]
    right = -J_dot @ omega - reference.skew(omega) @ J @ omega + torque
    return {"q_BN": reference.kinematics(p["q_BN"], omega), "omega_BN_B": np.linalg.solve(J, right)}


def body_outputs(p: Mapping[str, Any], J: Array) -> Point:
    momentum = rotation(p["q_BN"]).apply(J @ p["omega_BN_B"])
    return {"q_BN": p["q_BN"], "omega_BN_B": p["omega_BN_B"], "J_B": J, "H_N": momentum}


def loaded(p: Mapping[str, Any]) -> Array:
    return p["J_0_B"] + np.asarray(np.kron(p["mass"], np.eye(3)) @ ref.point_psi(p["position_B"]))


def loaded_rate(p: Mapping[str, Any]) -> Array:
    return np.asarray(np.kron(p["mass"], np.eye(3)) @ ref.point_psi_dot(p["position_B"], p["velocity_B"]))


def body_point(rng: np.random.Generator) -> Point:
    torques = {"torque_B": rng.normal(size=3), "torque_disturbance_B": rng.normal(size=3)}
    return {"q_BN": quaternion(rng), "omega_BN_B": rng.normal(size=3), **torques}


def fuel_point(rng: np.random.Generator) -> Point:
    """The tank is never quite empty, and J stays definite."""
    J_1 = 1e-3 * inertia(rng)
    fuel = rng.uniform(100, 200)
    J_0 = inertia(rng) + fuel * J_1
    return {**body_point(rng), "J_0_B": J_0, "J_1_B": J_1, "fuel": fuel, "torque_impulse": 0.9 * fuel * rng.uniform()}


def fuel_rates(p: Mapping[str, Any]) -> Point:
    norm = np.linalg.norm(p["torque_B"])
    J = p["J_0_B"] - p["torque_impulse"] * p["J_1_B"]
    torque = p["torque_B"] + p["torque_disturbance_B"]
    return {**body_rates(p, J, -norm * p["J_1_B"], torque), "torque_impulse": np.array(norm)}


def fuel_outputs(p: Mapping[str, Any]) -> Point:
    J = p["J_0_B"] - p["torque_impulse"] * p["J_1_B"]
    own = {"torque_impulse": p["torque_impulse"], "fuel_left": p["fuel"] - p["torque_impulse"]}
    return {**body_outputs(p, J), **own}


def paths_of(p: Mapping[str, Any]) -> ref.Appendage:
    return ref.Appendage(tuple(map(tuple, p["position_B_0"])), float(p["extension"]), float(p["frequency"]))


LAWS = {
    "AppendagePaths": Law(
        draw=lambda rng: {
            "position_B_0": rng.normal(size=(2, 3)),
            "extension": rng.uniform(0, 2),
            "frequency": rng.uniform(0, 1),
            "time": rng.uniform(0, 20),
        },
        outputs=lambda p: {
            "position_B": paths_of(p).positions(float(p["time"])),
            "velocity_B": paths_of(p).velocities(float(p["time"])),
        },
        rates=lambda _: {},
    ),
    "AppendageBody": Law(
        draw=lambda rng: {
            **body_point(rng),
            **appendage_motion(rng),
            "J_0_B": inertia(rng),
            "mass": rng.uniform(0, 3, 2),
        },
        outputs=lambda p: body_outputs(p, loaded(p)),
        rates=lambda p: body_rates(p, loaded(p), loaded_rate(p), p["torque_B"] + p["torque_disturbance_B"]),
    ),
    "FuelLossBody": Law(draw=fuel_point, outputs=fuel_outputs, rates=fuel_rates),
    "AdaptiveTracking": certainty_law(certainty_point),
    "AdaptiveAppendageTracking": certainty_law(
        lambda rng: {**certainty_point(rng), **appendage_motion(rng), **estimate_point(rng, "mass_est", (2,), 1)},
        "mass_est",
        MASSES,
    ),
    "AdaptiveAppendageTrackingFull": certainty_law(
        lambda rng: {**certainty_point(rng), **appendage_motion(rng), **estimate_point(rng, "J_1_est", (3, 6), 1)},
        "J_1_est",
        every_element(6),
    ),
    "AdaptiveFuelTracking": certainty_law(
        lambda rng: {
            **certainty_point(rng),
            **estimate_point(rng, "sigma_est", (3,), 0.05),
            "torque_impulse": rng.uniform(0, 20),
        },
        "sigma_est",
        DIAGONAL,
    ),
    "AdaptiveFuelTrackingFull": certainty_law(
        lambda rng: {
            **certainty_point(rng),
            **estimate_point(rng, "J_1_est", (3, 3), 0.03),
            "torque_impulse": rng.uniform(0, 20),
        },
        "J_1_est",
        every_element(3),
    ),
    "NonCertaintyEquivalenceTracking": Law(
        draw=lambda rng: {
            **tracking_point(rng),
            "k_p": rng.uniform(0.1, 2),
            "k_w": rng.uniform(0.1, 2),
            "gamma": rng.uniform(0, 10),
            "theta_est": rng.normal(size=6) * 10,
            "omega_f": rng.normal(size=3),
            "W_f": rng.normal(size=(3, 6)),
        },
        outputs=lambda p: {
            "q_BR": comparison(p)["q_e"],
            "omega_BR_B": comparison(p)["omega_e"],
            "torque_B": comparison(p)["torque"],
            "theta_sum": comparison(p)["theta_sum"],
            **{name: p[name] for name in ("theta_est", "omega_f", "W_f")},
        },
        rates=lambda p: {
            "theta_est": comparison(p)["theta_dot"],
            "omega_f": comparison(p)["omega_f_dot"],
            "W_f": comparison(p)["W_f_dot"],
        },
    ),
}


INERTIAS = ("J_0_B", "J_1_B")


def symmetric_directions(name: str, value: Array) -> list[Array]:
    return directions(name, value, inertias=("J_B", *INERTIAS))


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", LAWS)
def test_outputs_and_derivatives(name: str, version: int) -> None:
    for point in draw(name, LAWS[name]):
        with opened(name, version, point) as component:
            compare(component, LAWS[name], point, to_1e_12)


@pytest.mark.parametrize("name", LAWS)
def test_directional_derivatives(name: str) -> None:
    for point in draw(name, LAWS[name], 3):
        with opened(name, 2, point) as component:
            for known, analytic, numeric in slopes(component, point, symmetric_directions):
                np.testing.assert_allclose(analytic, numeric, rtol=1e-8, atol=1e-8, err_msg=f"by {known}")


@pytest.mark.parametrize("name", ["AppendageBody", "FuelLossBody", "NonCertaintyEquivalenceTracking"])
def test_co_simulation_integrates_with_fourth_order(name: str) -> None:
    integrates_with_fourth_order(name, 2, LAWS[name], *draw(name, LAWS[name], 1))


def test_the_points_reach_both_sides_of_the_projection() -> None:
    """Else the comparison above would not see it."""
    acting = []
    for point in draw("AdaptiveFuelTracking", LAWS["AdaptiveFuelTracking"]):
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


@pytest.mark.parametrize("name", LAWS)
def test_declared_dependencies_are_those_of_the_directional_derivatives(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As for the other components, from starts where the projections act and the fuel law is valid."""
    draw = dependencies.random_start
    chosen = {"theta_bound": 0.8, "theta_margin": 3.0, "sigma_bound": 0.02, "sigma_margin": 3.0}

    def start(rng: np.random.Generator, raw: dependencies.Raw) -> Point:
        values = {n: v for n, v in draw(rng, raw).items() if n not in (*INERTIAS, "fuel")}
        values |= {n: np.array([x]) for n, x in chosen.items() if n in values}
        if "theta_est" in values:
            values["theta_est"] *= rng.choice([-1, 1], 6)
        values |= {"J_1_B": 1e-3 * (np.eye(3) + 0.1)} if name == "FuelLossBody" else {}
        return {n: 0.2 * v if n in ("sigma_est", "J_1_est", "mass_est") else v for n, v in values.items()}

    monkeypatch.setattr(dependencies, "random_start", start)
    dependencies.test_declared_dependencies_are_those_of_the_directional_derivatives(name)
