"""De Ruiter's adaptive law, its guidance, error generator and disturbance: each alone, and the loop they close."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from adcs import AdcsError, CoupledModel, ModelExchange, System, run
from adcs.library.deruiter import systems
from adcs.library.deruiter.settings import NOMINAL_INERTIA, Choices
from orchestration.instances.instance import CallFailed
from references import deruiter as ref
from references.answers.deruiter import control, on_sphere, reference_rates
from references.deruiter import HATS, MUTANTS, Gains, Loop
from references.law import inertia, quaternion
from references.observer_pd import Array, rotation, skew
from tests.one_fmu import VERSIONS, Component

from .at_points import draw

POINTS = 24


# --- each component alone ---------------------------------------------------------------------------------------------


def test_the_random_points_reach_every_branch_of_the_law() -> None:
    resting = acting = acting_p = free = 0
    for p in draw("BoundedAdaptiveTracking", POINTS):
        y, g = control(p), Gains.of(p)
        if np.linalg.norm(y["filtered"]) <= g.dead_zone:
            resting += 1
            assert not y["theta_dot"].any()
            continue
        push = -g.gamma * ref.regressor(p["omega_BN_B"]).T @ y["filtered"]
        push_p = g.gamma_p * ref.torque_regressor(y["torque"]).T @ y["filtered"]
        acting += not np.allclose(push, y["theta_dot"])
        acting_p += not np.allclose(push_p, y["theta_p_dot"], rtol=1e-9, atol=0)
        free += np.allclose(push, y["theta_dot"])
    assert min(resting, acting, acting_p, free) >= 2


@pytest.mark.parametrize("version", VERSIONS)
def test_estimation_errors_stay_within_their_bounds_and_come_close(version: int) -> None:
    """Sizes of the errors and of their time derivatives, over 20000 s with the study's frequencies."""
    choices = Choices()
    bounds = choices.errors()
    true = {"q_BN": quaternion(np.random.default_rng(1)), "omega_BN_B": np.array([0.1, -0.2, 0.3])}
    h, sizes = 0.05, {"v_q": [], "v_w": [], "v_q_dot": [], "v_w_dot": []}  # type: ignore[var-annotated]
    with Component("BoundedEstimationError", version, choices.generator()) as component:
        component.set(true)

        def errors(t: float) -> tuple[Array, Array]:
            component.at(t)
            return component.get("q_EB")[1:], component.get("rate_error_B")

        for t in np.arange(0.0, 20000.0, 5.0):
            (a, b), (c, d) = errors(t), errors(t + h)
            for name, value in (("v_q", a), ("v_w", b), ("v_q_dot", (c - a) / h), ("v_w_dot", (d - b) / h)):
                sizes[name].append(np.linalg.norm(value))
    expected = {"v_q": bounds.attitude, "v_w": bounds.rate}
    expected |= {"v_q_dot": bounds.attitude_rate, "v_w_dot": bounds.rate_rate}
    for name, bound in expected.items():
        assert 0.98 * bound < max(sizes[name]) <= bound * (1 + 1e-12), name


@pytest.mark.parametrize("version", VERSIONS)
def test_reference_rate_integrates_to_the_attitude(version: int) -> None:
    """Over 40 s in Co-Simulation, against DOP853 on rotation matrices: C' = -S(omega) C."""
    p = draw("SinusoidalRateReference", 1)[0]

    def flow(t: float, c: Array) -> Array:
        return (-skew(reference_rates({**p, "time": t})[0]) @ c.reshape(3, 3)).ravel()

    start = rotation(p["q_RN"]).as_matrix().T.ravel()
    end = solve_ivp(flow, (0, 40), start, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1].reshape(3, 3)
    values = {n: v for n, v in p.items() if n != "time"}
    with Component("SinusoidalRateReference", version, values, co_simulation=True) as component:
        component.fmu.doStep(0.0, 40.0)
        q = component.get("q_RN")
    np.testing.assert_allclose(rotation(q).as_matrix().T, end, atol=1e-8)


@pytest.mark.parametrize("mutant", MUTANTS)
def test_the_recomputation_tells_mistakes_apart(mutant: str) -> None:
    """Each deliberate mistake in the recomputed law is far from the component at some of the points."""
    largest = 0.0
    for p in draw("BoundedAdaptiveTracking", POINTS):
        right, wrong = control(p), control(p, mutant)
        for name in ("torque", "theta_dot", "theta_p_dot"):
            largest = max(largest, np.abs(wrong[name] - right[name]).max() / max(1e-9, np.abs(right[name]).max()))
    assert largest > 0.1


# --- the parametrisation ----------------------------------------------------------------------------------------------


def test_parameters_give_the_torque_free_acceleration_and_the_inverse_inertia() -> None:
    rng = np.random.default_rng(4)
    for _ in range(20):
        J, omega, torque = inertia(rng), rng.normal(size=3), rng.normal(size=3)
        theta, theta_p = ref.parameters(J)
        expected = np.linalg.solve(J, np.cross(omega, J @ omega))
        np.testing.assert_allclose(ref.regressor(omega) @ theta, expected, rtol=1e-11, atol=1e-12)
        np.testing.assert_allclose(ref.torque_regressor(torque) @ theta_p, np.linalg.solve(J, torque), atol=1e-12)


def test_projection_has_the_two_properties_that_the_proof_needs() -> None:
    """(v - b)^T (Proj(v, y) - y) <= 0 for b in F, and no outward motion on the sphere of radius sqrt(1 + eps) eta.

    With the printed v for y the first property is lost, and the sphere does not hold the estimate either.
    """
    rng = np.random.default_rng(5)
    broken = 0
    for _ in range(300):
        eta, eps = rng.uniform(0.1, 2), rng.uniform(0.05, 0.5)
        centre, y = rng.normal(size=(2, 6))
        inside = centre + on_sphere(rng, 6, eta * rng.uniform())
        v = centre + on_sphere(rng, 6, eta * np.sqrt(1 + eps) * rng.uniform(0.5, 1))
        edge = centre + on_sphere(rng, 6, eta * np.sqrt(1 + eps))
        assert (v - inside) @ (ref.project(v, centre, y, eta, eps) - y) <= 1e-12
        assert (edge - centre) @ ref.project(edge, centre, y, eta, eps) <= 1e-12
        broken += (v - inside) @ (ref.project(v, centre, y, eta, eps, "v") - y) > 1e-3
    assert broken > 50


def test_radius_of_g_is_the_root_of_one_plus_epsilon_times_eta() -> None:
    """There d = 1, where the projection takes all outward motion away; not so at the printed sqrt(1 + eps eta)."""
    eta, eps, n = 0.35, 0.1, np.eye(18)[3]
    assert ref.level(np.sqrt(1 + eps) * eta * n, eta, eps) == pytest.approx(1, abs=1e-12)
    assert abs(n @ ref.project(np.sqrt(1 + eps) * eta * n, 0 * n, n, eta, eps)) < 1e-12
    assert ref.level(np.sqrt(1 + eps * eta) * n, eta, eps) > 70


# --- the closed loop --------------------------------------------------------------------------------------------------

CHOICES = Choices()
FAST = Choices(gamma=1e3, gamma_p=0.5)
"""Adaptation many times faster: the estimates reach the edge of their balls, and the projection acts."""
SYSTEMS: dict[str, tuple[Callable[[], System], str]] = {
    "exact": (lambda: systems.exact_states(CHOICES), "exact"),
    "exact, disturbed, projection at work": (lambda: systems.exact_states(FAST, disturbed=True), "exact"),
    "bounded errors": (lambda: systems.bounded_errors(CHOICES), "errors"),
    "observer": (lambda: systems.observer(CHOICES, inertia=NOMINAL_INERTIA), "observer"),
}


def values_of(system: System) -> dict[str, dict[str, Any]]:
    """What the system's components start with, for the recomputed loop."""
    values: dict[str, dict[str, Any]] = {}
    for component in system.components.values():
        ports = component.fmu.ports
        start = {n: np.reshape(v, ports[n].shape) for n, v in component.start.items()}
        values[component.name] = {n: v if v.shape else v.item() for n, v in start.items()}
    return values


def recomputed(name: str, mutant: str | None = None) -> Loop:
    build, source = SYSTEMS[name]
    return Loop(values_of(build()), source, mutant)  # type: ignore[arg-type]


SIGNALS = {
    "plant.q_BN": "q",
    "plant.omega_BN_B": "omega",
    "guidance.q_RN": "q_r",
    "guidance.omega_RN_R": "omega_r",
    "guidance.omegaDot_RN_R": "omega_r_dot",
    "controller.torque_B": "torque",
    "controller.q_BR": "q_e",
    "controller.omega_BR_B": "omega_e",
    "controller.filtered_rate_B": "filtered",
    "controller.theta_est": "theta",
    "controller.theta_p_est": "theta_p",
}


@pytest.mark.parametrize("name", SYSTEMS)
def test_coupled_model_exchange_follows_the_recomputed_loop(name: str) -> None:
    """All signals, the 24 estimates among them, while the body turns fastest."""
    stop = 1.5 if "projection" in name else 12.0
    times = np.linspace(0, stop, 21)
    tolerances = {"rtol": 1e-12, "atol": 1e-14}
    expected = recomputed(name).run(times, **tolerances)
    result = run(SYSTEMS[name][0](), stop_time=stop, step=stop / 20, method=ModelExchange(**tolerances))
    for variable, signal in SIGNALS.items():
        deviation = np.abs(result[variable] - expected[signal]).max()
        assert deviation < 1e-8 * max(1e-2, np.abs(expected[signal]).max()), f"{variable}: {deviation:.1e}"
    moved = np.linalg.norm(result["controller.theta_p_offset"][-1])
    assert moved > 1e-5, "an estimate that rests would prove nothing"
    if "projection" in name:
        for estimate, radius in zip(("theta", "theta_p"), FAST.law.radii, strict=True):
            distance = np.linalg.norm(result[f"controller.{estimate}_offset"], axis=1).max() / radius
            assert 0.99 < distance <= 1 + 1e-9


def test_every_term_is_of_the_estimates_and_each_hat_is_noticed() -> None:
    """Along the run with estimation errors: with one term at its true value, torque or rates differ by far."""
    system = systems.bounded_errors(CHOICES)
    gains, values = Loop(values_of(system), "errors").gains, values_of(system)["estimate"]
    differences: dict[str | None, float] = dict.fromkeys([None, *HATS], 0.0)
    with CoupledModel(system) as model:
        at = {name: i for i, name in enumerate(model.state_names)}
        first, first_p = at["controller.theta_offset[1]"], at["controller.theta_p_offset[1]"]
        free = np.array([".q_" not in name for name in model.state_names])  # quaternions stay unit
        for t in (0.0, 3.0, 8.0):
            x = model.x0 + 0.01 * free * np.sin(np.arange(len(model.x0)) + t)
            y, x_dot = model.outputs(t, x), model.rhs(t, x)
            true = y["plant.q_BN"], y["plant.omega_BN_B"]
            seen = ref.estimates(values, t, *true)
            names = ("guidance.q_RN", "guidance.omega_RN_R", "guidance.omegaDot_RN_R")
            given = [y[n] for n in (*names, "controller.theta_est", "controller.theta_p_est")]
            ours = y["controller.torque_B"], x_dot[first : first + 18], x_dot[first_p : first_p + 6]
            for hat in differences:
                estimates = [seen["q_EN"], seen["omega_BN_B_est"]]
                law = ref.law(gains, *estimates, *given, true=true, without_hat=hat)
                pairs = zip(ours, (law["torque"], law["theta_dot"], law["theta_p_dot"]), strict=True)
                found = max(float(np.abs(a - b).max() / np.abs(b).max()) for a, b in pairs)
                differences[hat] = max(differences[hat], found)
    assert differences.pop(None) < 1e-11
    assert min(differences.values()) > 1e-5, differences


def spent(system: System, stop: float, theta: Array, theta_p: Array) -> tuple[Array, Array, Array]:
    """Along the FMUs' trajectory: V, k times the integral of |filtered rate error|^2, and what the projection takes."""
    loop = Loop(values_of(system))
    g = loop.gains
    with CoupledModel(system) as model:
        n = len(model.x0)

        def lyapunov(y: Mapping[str, Array]) -> float:
            return loop.lyapunov(
                {
                    "filtered": y["controller.filtered_rate_B"],
                    "theta": y["controller.theta_est"],
                    "theta_p": y["controller.theta_p_est"],
                }
            )

        def flow(t: float, z: Array) -> Array:
            y, x_dot = model.outputs(t, z[:n]), model.rhs(t, z[:n])
            wt = y["controller.filtered_rate_B"]
            push = -ref.regressor(y["plant.omega_BN_B"]).T @ wt
            push_p = ref.torque_regressor(y["controller.torque_B"]).T @ wt
            at = {name: i for i, name in enumerate(model.state_names)}
            rate = x_dot[at["controller.theta_offset[1]"] :][:18]
            rate_p = x_dot[at["controller.theta_p_offset[1]"] :][:6]
            taken = (y["controller.theta_est"] - theta) @ (push - rate / g.gamma)
            taken_p = (y["controller.theta_p_est"] - theta_p) @ (push_p - rate_p / g.gamma_p)
            return np.concatenate([x_dot, [g.k * wt @ wt, taken + taken_p]])

        times = np.linspace(0, stop, 11)
        z = solve_ivp(flow, (0, stop), np.append(model.x0, [0, 0]), "DOP853", times, rtol=1e-11, atol=1e-14).y.T
        values = np.array([lyapunov(model.outputs(t, row[:n])) for t, row in zip(times, z, strict=True)])
    return values, z[:, n], z[:, n + 1]


def test_lyapunov_identity_along_the_trajectory_of_the_components() -> None:
    """V(0) - V(T) = k times the integral of |filtered rate error|^2, to 1e-8 of V(0) = 0.0116, over 200 s."""
    system = systems.exact_states(CHOICES)
    values, used, taken = spent(system, 200.0, *Loop(values_of(system)).truth)
    assert values[0] == pytest.approx(0.011634, rel=1e-4)
    assert values[0] - values[-1] > 0.6 * values[0]
    assert np.abs(values[0] - values - used).max() < 1e-8 * values[0]
    assert np.abs(taken).max() < 1e-16, "the projection rests"


def test_lyapunov_balance_with_the_projection_at_work() -> None:
    """V(0) - V(T) is then larger, by what the projection takes away, which is never negative: theta lies in F."""
    system = systems.exact_states(FAST)
    values, used, taken = spent(system, 2.0, *Loop(values_of(system)).truth)
    assert np.abs(values[0] - values - used - taken).max() < 1e-8 * values[0]
    assert (np.diff(taken) >= 0).all()
    assert taken[-1] > 1e-3 * values[0]


@pytest.mark.parametrize("mutant", [None, *MUTANTS])
def test_a_wrong_law_breaks_the_identity(mutant: str | None) -> None:
    """The check above can fail: each mistake breaks it within 1 s by more than 1e-4 of V(0)."""
    loop = recomputed("exact", mutant)
    y = loop.run(np.linspace(0, 1, 3), rtol=1e-10, atol=1e-13)
    residual = np.abs(y["lyapunov"][0] - y["lyapunov"] - y["spent"]).max() / y["lyapunov"][0]
    if mutant is None:
        assert residual < 1e-9
    else:
        assert residual > 1e-4


# --- bad input --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("start", "message"),
    [
        (
            {"eta_p": 0.0352},
            "eta_p is too large for J_B: the estimate of the inverse inertia could become singular, unless sqrt(5/3 "
            "(1 + epsilon_p)) eta_p is below 1 / (largest principal moment of J_B)",
        ),
        ({"dead_zone": -1e-3}, "dead_zone = -0.001 refused: must be at least 0"),
        ({"eta": 0.0}, "eta = 0 refused: must be above 0"),
        ({"gamma_p": -1.0}, "gamma_p = -1 refused: must be above 0"),
        ({"J_B": np.diag([1.0, 1.0, 3.0])}, "violates the triangle inequality"),
    ],
)
def test_the_controller_refuses(start: dict[str, Any], message: str) -> None:
    system = systems.exact_states()
    for name, value in start.items():
        system.set(f"controller.{name}", value)
    with pytest.raises(CallFailed) as error:
        run(system, stop_time=1.0, step=0.1)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_an_eta_p_just_below_the_limit_is_taken() -> None:
    limit = CHOICES.law.largest_eta_p
    assert limit == pytest.approx(1 / 21 / np.sqrt(5 / 3 * 1.1))
    for eta_p, taken in ((limit * (1 - 1e-9), True), (limit * (1 + 1e-9), False)):
        system = systems.exact_states()
        system.set("controller.eta_p", eta_p)
        if taken:
            run(system, stop_time=0.2, step=0.1)
        else:
            with pytest.raises(AdcsError, match="eta_p is too large"):
                run(system, stop_time=0.2, step=0.1)


def test_the_error_generator_refuses_an_attitude_bound_of_one() -> None:
    system = systems.bounded_errors()
    system.set("estimate.attitude_bound", 1.0)
    with pytest.raises(CallFailed, match="attitude_bound is the vector part of a unit quaternion: expected below 1"):
        run(system, stop_time=1.0, step=0.1)
