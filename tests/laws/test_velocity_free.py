"""The components of the velocity-free loop against the recomputation, the loop against the identity of its proof."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.stats import kstest

from adcs import CoupledModel, ModelExchange, Save, System, run
from adcs.library.velocity_free import systems
from adcs.library.velocity_free.settings import DRAG_AND_OBLATENESS, ORBIT, Uncertainty
from orchestration.instances.instance import CallFailed
from references import velocity_free as ref
from references.law import inertia, quaternion
from references.observer_pd import Array, body_acceleration, error, kinematics, rate_along, rotation, skew
from references.velocity_free import INERTIA, Loop
from tests.one_fmu import VERSIONS, Component

from .at_points import POINTS, draw, opened


def test_the_orbit_obeys_newton_and_keeps_its_energy() -> None:
    """Differences of the closed form: r' = v, v' = -mu r / |r|^3; and after one period it is where it was."""
    for point in draw("KeplerOrbit", 3):
        mu, a, t0 = float(point["mu"]), float(point["semi_major_axis"]), float(point["time"])
        with opened("KeplerOrbit", 2, point) as orbit:

            def position(t: float, _: Array) -> Array:
                orbit.at(t)
                return np.concatenate([orbit.get("r_ON_N"), orbit.get("v_ON_N")])

            slope = rate_along(position, t0, np.zeros(1), np.zeros(1), h=10.0)
            here = position(t0, np.zeros(1))
            r, v = here[:3], here[3:]
            np.testing.assert_allclose(slope[:3], v, rtol=0, atol=1e-7 * np.linalg.norm(v))
            gravity = -mu * r / np.linalg.norm(r) ** 3
            np.testing.assert_allclose(slope[3:], gravity, rtol=0, atol=1e-7 * np.linalg.norm(gravity))
            assert v @ v / 2 - mu / np.linalg.norm(r) == pytest.approx(-mu / (2 * a), rel=1e-12)
            again = position(t0 + 2 * np.pi * np.sqrt(a**3 / mu), np.zeros(1))
            np.testing.assert_allclose(again[:3], r, rtol=0, atol=1e-10 * a)


# --- the star tracker whose error wanders -----------------------------------------------------------------------------


def wandering(hold: float, bound: float, seed: int = 1, stop: float = 100.0, version: int = 2) -> tuple[Array, Array]:
    """q_EB and its rate omega_EB_E in each hold, (N, 4) and (N, 3)."""
    start = {"max_rate": 0.02, "hold_time": hold, "error_bound": bound, "seed": seed, "q_BN": [0.6, 0.48, -0.64, 0]}
    attitudes, rates = [], []
    with Component("RandomWalkStarTracker", version, start, co_simulation=True) as tracker:
        for k in range(round(stop / hold)):
            attitudes.append(tracker.get("q_EB"))
            rates.append(tracker.get("omega_EB_E"))
            tracker.fmu.doStep(k * hold, hold)
    return np.array(attitudes), np.array(rates)


@pytest.mark.parametrize("version", VERSIONS)
def test_the_error_turns_with_the_held_rate(version: int) -> None:
    """From draw to draw the exponential of the held rate; the measurement is C(q_EB) C(q_BN)."""
    attitudes, rates = wandering(0.5, 1.0, stop=50.0, version=version)
    np.testing.assert_array_equal(attitudes[0], np.eye(4)[0])
    for q, w, after in zip(attitudes[:-1], rates[:-1], attitudes[1:], strict=True):
        turned = rotation(q) * Rotation.from_rotvec(0.5 * w)
        np.testing.assert_allclose(turned.as_quat(scalar_first=True), after, rtol=0, atol=1e-12)
    rng = np.random.default_rng(2)
    for _ in range(POINTS):
        q_EB, q_BN = quaternion(rng), quaternion(rng)
        with Component("RandomWalkStarTracker", version, {"max_rate": 0.0}) as tracker:
            tracker.set_states({"q_EB": q_EB})
            tracker.set({"q_BN": q_BN})
            np.testing.assert_allclose(tracker.get("q_BN_meas"), ref.G(q_BN) @ q_EB, rtol=0, atol=1e-14)
            slope = tracker.directional(["q_BN_meas"], "q_BN", np.eye(4)[1])
            np.testing.assert_allclose(slope, ref.G(np.eye(4)[1]) @ q_EB, rtol=0, atol=1e-14)


def test_rates_are_uniform_in_size_and_direction_and_belong_to_the_seed() -> None:
    _, rates = wandering(0.01, 1.0, stop=40.0)
    size = np.linalg.norm(rates, axis=1)
    assert kstest(size / 0.02, "uniform").pvalue > 0.01
    assert kstest(rates[:, 2] / size / 2 + 0.5, "uniform").pvalue > 0.01
    assert kstest(np.arctan2(rates[:, 1], rates[:, 0]) / (2 * np.pi) + 0.5, "uniform").pvalue > 0.01
    _, again = wandering(0.01, 1.0, stop=1.0, version=3)
    np.testing.assert_array_equal(again, rates[:100])
    _, other = wandering(0.01, 1.0, seed=2, stop=1.0)
    assert np.abs(other - rates[:100]).min() > 0


@pytest.mark.parametrize("hold", [0.1, 1.0, 5.0])
def test_the_bound_is_kept_for_any_hold(hold: float) -> None:
    """(27), (28). Unbounded, the same draws leave the ball; and a hold of 5 s can cross all of it."""
    stop = max(200.0, 400 * hold)
    attitudes, rates = wandering(hold, 0.01, stop=stop)
    error_size = np.linalg.norm(attitudes[:, 1:], axis=1)
    assert error_size.max() <= 0.01 * (1 + 1e-9)
    assert error_size.max() > 0.0095
    assert np.linalg.norm(rates, axis=1).max() <= 0.02
    free, free_rates = wandering(hold, 1.0, stop=stop)
    sizes = np.linalg.norm(free_rates, axis=1)
    moving = np.linalg.norm(rates, axis=1) > 0  # a draw that fits neither way is dropped
    np.testing.assert_allclose(np.linalg.norm(rates, axis=1)[moving], sizes[moving], rtol=1e-12)
    assert np.linalg.norm(free[:, 1:], axis=1).max() > 0.01


def wandered(hold: float, seed: int, stop: float) -> Array:
    """The vector part of q_EB at the end, in one step."""
    start = {"max_rate": 0.02, "hold_time": hold, "seed": seed}
    with Component("RandomWalkStarTracker", 2, start, co_simulation=True) as tracker:
        tracker.fmu.doStep(0.0, stop)
        return tracker.get("q_EB")[1:]


def test_the_error_has_no_limit_as_the_hold_goes_to_zero() -> None:
    """Unbounded it grows like max_rate / 6 sqrt(3 t hold): a hundred times shorter holds, ten times smaller errors."""
    sizes = []
    for hold in (1.0, 0.01):
        ends = [wandered(hold, seed, 20.0) for seed in range(1, 41)]
        sizes.append(np.sqrt(np.mean(np.sum(np.square(ends), axis=1))))
        assert sizes[-1] == pytest.approx(0.02 / np.sqrt(12) * np.sqrt(20.0 * hold), rel=0.25)
    assert sizes[0] / sizes[1] == pytest.approx(10, rel=0.3)


# --- closed loops -----------------------------------------------------------------------------------------------------

BUILDERS: dict[bool, Callable[[], System]] = {False: systems.stabilisation, True: systems.tracking}
STOP = 10.0
TIMES = np.linspace(0, STOP, 101)


@pytest.fixture(scope="module")
def runs() -> dict[bool, Array]:
    return {tracking: Loop(tracking).run(TIMES) for tracking in BUILDERS}


@pytest.mark.parametrize("fmi_version", ["2.0", "3.0"])
@pytest.mark.parametrize("tracking", BUILDERS)
def test_coupled_loop_follows_the_recomputed_one(runs: dict[bool, Array], tracking: bool, fmi_version: Any) -> None:
    """All states to 1e-8, absolutely; they are of the size 0.1 to 1."""
    system = BUILDERS[tracking]()
    tight: dict[str, Any] = {"fmi_version": fmi_version, "method": ModelExchange(rtol=1e-12, atol=1e-13)}
    result = run(system, stop_time=STOP, step=0.1, **tight)
    names = ("plant.q_BN", "plant.omega_BN_B", "guidance.q_RN", "filter.sigma_BR")
    ours = np.concatenate([result[name] for name in names], axis=1)
    assert np.abs(ours - runs[tracking][:, :15]).max() < 1e-8
    torques = [Loop(tracking).signals(t, x[:15])["torque_B"] for t, x in zip(TIMES, runs[tracking], strict=True)]
    assert np.abs(result["controller.torque_B"] - torques).max() < 1e-8


def identity_residual(system: System, loop: Loop, stop: float = STOP) -> tuple[Array, Array]:
    """Along the FMUs' trajectory: d/dt V_0 by the FMUs' own derivatives less -b |sigmaDot|^2; and V_0."""
    times = np.arange(0, stop + 1e-9, 1.0)
    with CoupledModel(system) as model:
        index = {name: i for i, name in enumerate(model.state_names)}
        blocks = (("plant.q_BN", 4), ("plant.omega_BN_B", 3), ("guidance.q_RN", 4), ("filter.sigma_BR", 4))
        order = [index[f"{name}[{i + 1}]"] for name, n in blocks for i in range(n)]
        x = solve_ivp(model.rhs, (0, stop), model.x0, "DOP853", times, rtol=1e-12, atol=1e-13).y.T
        values = np.array([loop.lyapunov(t, row[order]) for t, row in zip(times, x, strict=True)])
        residual = [
            rate_along(lambda t, z: np.array(loop.lyapunov(t, z[order])), t, row, model.rhs(t, row))
            - loop.lyapunov_rate(t, row[order])
            for t, row in zip(times, x, strict=True)
        ]
        return np.array(residual), values


@pytest.mark.parametrize("tracking", BUILDERS)
def test_the_identity_of_the_proof_holds_along_the_trajectory(runs: dict[bool, Array], tracking: bool) -> None:
    """V_0' = -b |sigmaDot|^2, where V_0 starts at 1.7e-3 and its rate peaks at 5e-4 N m/s: 1e-8 of 1, and of V_0."""
    residual, values = identity_residual(BUILDERS[tracking](), Loop(tracking))
    assert np.abs(residual).max() < 1e-11
    np.testing.assert_allclose(values - values[0], runs[tracking][::10, 15], rtol=0, atol=1e-8 * values[0])


def mutated(change: Callable[[dict[str, Any]], dict[str, Any]]) -> Callable[[Mapping[str, Any]], Array]:
    return lambda p: ref.torque(change(dict(p)))


def torque_with(c_of: Callable[[Array], Array], sign: float = 1.0, transposed: bool = True) -> Any:
    """(32) with a mistaken rotation of the reference, sign of the Coriolis term, or E(q)^T."""

    def law(p: Mapping[str, Any]) -> Array:
        c, dq = error(p["q_BN"], p["q_RN"])
        c = c_of(c)
        w = c @ p["omega_RN_R"]
        eta = sign * skew(w) @ p["J_B"] @ w + p["J_B"] @ c @ p["omegaDot_RN_R"]
        e = ref.E(dq if transposed else dq * [1, -1, -1, -1])
        result: Array = -p["a"] * dq[1:] - p["b"] / 2 * e.T @ p["sigmaDot_BR"] + eta
        return result

    return law


MUTANTS: dict[str, tuple[bool, dict[str, Any]]] = {
    "sigma without its dot, as printed": (
        False,
        {"control": mutated(lambda p: p | {"sigmaDot_BR": p["sigma_BR"]})},
    ),
    "b for b/2": (False, {"control": mutated(lambda p: p | {"b": 2 * p["b"]})}),
    "b 0.1 % off": (False, {"control": mutated(lambda p: p | {"b": 1.001 * p["b"]})}),
    "a 0.1 % off": (False, {"control": mutated(lambda p: p | {"a": 1.001 * p["a"]})}),
    "E of the conjugate": (False, {"control": torque_with(lambda c: c, transposed=False)}),
    "C transposed": (True, {"control": torque_with(lambda c: c.T)}),
    "Coriolis term with a minus": (True, {"control": torque_with(lambda c: c, -1.0)}),
    "error quaternion the other way": (
        False,
        {"control": mutated(lambda p: p | {"q_BN": p["q_RN"], "q_RN": p["q_BN"]})},
    ),
    "filter of twice the bandwidth": (False, {"filtered": lambda sigma, dq: 2 * (dq - sigma)}),
    "feed-forward left out": (True, {"control": mutated(lambda p: p | {"omegaDot_RN_R": np.zeros(3)})}),
    "wrong inertia in the law": (True, {"control": mutated(lambda p: p | {"J_B": 1.01 * p["J_B"]})}),
}


@pytest.mark.parametrize("name", MUTANTS)
def test_mutants_break_the_identity(runs: dict[bool, Array], name: str) -> None:
    """The residual that the test above bounds by 1e-11 is a thousand times larger for laws with one mistake."""
    tracking, change_ = MUTANTS[name]
    wrong = replace(Loop(tracking), **change_)
    largest = 0.0
    for t, row in zip(TIMES[:60:6], runs[tracking][:60:6, :15], strict=True):
        slope = rate_along(lambda t, z: np.array(Loop(tracking).lyapunov(t, z)), t, row, wrong.rates(t, row))
        largest = max(largest, abs(float(slope) - Loop(tracking).lyapunov_rate(t, row)))
    assert largest > 1e-8, f"{name}: {largest:.1e}"


# --- sampled, and one step late ---------------------------------------------------------------------------------------


def late_rates(step: float, stop: float) -> Array:
    """|omega| of the stabilised body when the torque reaches it one exchange step late, the rest at once."""
    system = systems.stabilisation()
    opened_ = {
        name: Component(str(c.source), 2, {n: np.reshape(v, c.fmu.ports[n].shape) for n, v in c.start.items()}, True)
        for name, c in system.components.items()
    }
    links = [(*c.source.split("."), *c.target.split(".")) for c in system.connections]
    links.sort(key=lambda link: ("filter", "controller", "plant").index(link[2]))  # along the flow
    rates = []
    for k in range(round(stop / step)):
        late = opened_["controller"].get("torque_B") if k else np.zeros(3)
        for source, output, target, input_ in links:
            opened_[target].set({input_: opened_[source].get(output)})
        opened_["plant"].set({"torque_B": late})
        for component in opened_.values():
            component.fmu.doStep(k * step, step)
        rates.append(np.linalg.norm(opened_["plant"].get("omega_BN_B")))
    for component in opened_.values():
        component.fmu.terminate()
        component.fmu.freeInstance()
    return np.array(rates)


def test_an_exchange_of_100_ms_is_stable_without_delay_and_diverges_with_one_step_of_it() -> None:
    result = run(systems.stabilisation(), stop_time=40.0, step=0.1, save=Save(["plant.omega_BN_B"]))
    rate = np.linalg.norm(result["plant.omega_BN_B"], axis=1)
    assert rate[-1] < 0.01 * rate[0]
    late = late_rates(0.1, 40.0)
    assert late[-50:].max() > 3 * rate[0]
    assert late_rates(0.05, 40.0)[-50:].max() < 0.1 * rate[0]  # half the delay is harmless


def test_a_hold_of_a_quarter_of_a_second_is_too_long_even_without_delay() -> None:
    result = run(systems.stabilisation(), stop_time=60.0, step=0.25, save=Save(["plant.omega_BN_B"]))
    assert np.linalg.norm(result["plant.omega_BN_B"][-1]) > 3 * np.linalg.norm(result["plant.omega_BN_B"][0])


# --- what is lost or wrong in print -----------------------------------------------------------------------------------


def test_the_rate_equation_20_holds_with_the_inertia_of_21() -> None:
    """(20), (21): J dw' = -dw x (J dw + Jbar w_r) + u - eta with Jbar = 2 J - tr(J) I, against Euler's equation."""
    rng = np.random.default_rng(4)
    for _ in range(POINTS):
        J, q, q_r = inertia(rng), quaternion(rng), quaternion(rng)
        omega, w_r, w_r_dot, u = rng.normal(size=(4, 3))
        c, _ = error(q, q_r)
        w = c @ w_r
        dw = omega - w
        eta = skew(w) @ J @ w + J @ c @ w_r_dot
        printed = -skew(dw) @ (J @ dw + (2 * J - np.trace(J) * np.eye(3)) @ w) + u - eta
        exact = J @ (body_acceleration(J, omega, u) + skew(dw) @ w - c @ w_r_dot)
        np.testing.assert_allclose(printed, exact, rtol=0, atol=1e-12 * np.linalg.norm(J) * 10)


def test_the_bound_40_on_the_feed_forward_error_holds_with_the_restored_factor() -> None:
    """mu_eta = 4 sqrt(J_M J_D) nu^2 mu_v^2 + 2 J_M (2 nu^2 + nu') mu_v + (nu^2 + nu') mu_J with J_D = J_M - J_m.

    The root multiplies a rate squared to a torque: unlike in (56) it cannot be divided by J_m.
    """
    rng = np.random.default_rng(5)
    mu_v, mu_J, ratio = 0.3, 0.2, 0.0
    for _ in range(800):
        J = inertia(rng)
        low, *_, high = np.linalg.eigvalsh(J)
        D = rng.normal(size=(3, 3))
        D = (D + D.T) / np.linalg.norm(D + D.T, 2) * mu_J
        axis, w, w_dot = rng.normal(size=(3, 3))
        c_tilde = rotation(np.append(np.sqrt(1 - mu_v**2), mu_v * axis / np.linalg.norm(axis))).as_matrix()
        nu, nu_dot = np.linalg.norm(w), np.linalg.norm(w_dot)
        size = np.linalg.norm(ref.feed_forward_error(J, J + D, c_tilde, w, w_dot))
        first = 4 * np.sqrt(high * (high - low)) * nu**2 * mu_v**2
        rest = 2 * high * (2 * nu**2 + nu_dot) * mu_v + (nu**2 + nu_dot) * mu_J
        ratio = max(ratio, size / (first + rest))
    assert 0.3 < ratio <= 1


def test_the_inertia_factor_of_48_and_56() -> None:
    """|w x J w| <= sqrt(J_M J_D) |w|^2, hence |J^-1 (w x J w)| <= sqrt(J_M J_D) / J_m |w|^2."""
    rng = np.random.default_rng(6)
    for _ in range(500):
        J, w = inertia(rng), rng.normal(size=3)
        low, *_, high = np.linalg.eigvalsh(J)
        bound = np.sqrt(high * (high - low)) * (w @ w)
        assert np.linalg.norm(skew(w) @ J @ w) <= bound
        assert np.linalg.norm(np.linalg.solve(J, skew(w) @ J @ w)) <= bound / low


def test_the_filter_rate_seen_by_the_body_is_bounded_by_1_plus_mu_v_and_not_by_1() -> None:
    """|E(dq)^T sigma'| <= |E^T sigma| + |E^T dq^| <= 1 + mu_v. (58) has 1, which an antiparallel error exceeds."""
    rng = np.random.default_rng(7)
    mu_v, largest = 0.01, 0.0
    for _ in range(500):
        dq = quaternion(rng)
        axis = rng.normal(size=3)
        dq_tilde = np.append(np.sqrt(1 - mu_v**2), mu_v * axis / np.linalg.norm(axis))
        sigma = ref.G(dq) @ np.append(0, -axis / np.linalg.norm(axis))  # any unit vector may occur
        largest = max(largest, float(np.linalg.norm(ref.E(dq).T @ (ref.G(dq) @ dq_tilde - sigma))))
    assert largest == pytest.approx(1 + mu_v, abs=1e-12)


def test_the_oblateness_rows_of_92_are_those_of_the_potential() -> None:
    """The rows are -1, -1, -3 times r_i |r|^2; with the printed 3, 3, 3 the force differs by far more than rounding."""
    rng = np.random.default_rng(8)
    for _ in range(POINTS):
        r = rotation(quaternion(rng)).apply([7e6, 0, 0])
        mu, radius, j2 = 3.986e14, 6.371e6, 1.0826e-3
        exact = ref.oblateness_acceleration(mu, radius, j2, r)
        factor = 3 * mu * j2 * radius**2 / (2 * np.linalg.norm(r) ** 7)
        rows = {k: factor * (5 * r * r[2] ** 2 - np.array(k) * r * (r @ r)) for k in ((1, 1, 3), (3, 3, 3))}
        np.testing.assert_allclose(rows[1, 1, 3], exact, rtol=0, atol=1e-14)
        assert np.linalg.norm(rows[3, 3, 3] - exact) > 1e-3 * np.linalg.norm(exact)


def test_the_oblateness_torque_needs_the_mass() -> None:
    """Twice the mass, twice the force and its torque; with the rest of Sec. V, 1 kg gives up to 1.3e-4 N m."""
    start = {"r_BN_N": [7.136e6 * np.cos(1), 0, 7.136e6 * np.sin(1)], "v_BN_N": [0, 7.474e3, 0], **DRAG_AND_OBLATENESS}
    torques = []
    for mass in (1.0, 2.0):
        with Component("EnvironmentTorque", 2, start | {"mass": mass}) as environment:
            torques.append(environment.get("oblateness_B"))
    np.testing.assert_allclose(torques[1], 2 * torques[0], rtol=1e-15)
    assert 2e-5 < np.linalg.norm(torques[0]) < 2e-4


# --- bad input --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("variable", "value", "message"),
    [
        ("environment.mass", 0.0, "mass"),
        ("environment.mass", -1.0, "mass"),
        ("orbit.semi_major_axis", 6.0e6, "the orbit meets the Earth"),
        ("tracker.hold_time", 0.0, "hold_time"),
        ("tracker.error_bound", 1.5, "error_bound"),
        ("controller.b", 0.0, "b = 0"),
        ("controller.J_B", -np.eye(3), "is not positive definite"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(variable: str, value: Any, message: str) -> None:
    system = systems.uncertain_tracking(Uncertainty())
    system.set(variable, value)
    with pytest.raises(CallFailed) as failure:
        run(system, stop_time=1.0, step=0.1)
    assert message in str(failure.value)
    assert "\n" not in str(failure.value)


def test_a_position_inside_the_earth_is_refused_at_the_start_and_on_the_way() -> None:
    """By the environment at the start; by the name of the output that has no value on the way."""
    start = {"q_BN": [1, 0, 0, 0], "r_BN_N": [6.0e6, 0, 0], "v_BN_N": [0, 7e3, 0]}
    system = System("inside")
    system.add("environment", "EnvironmentTorque", start)
    with pytest.raises(CallFailed, match="r_BN_N lies inside the Earth, within earth_radius"):
        run(system, stop_time=1.0, step=0.1)
    with Component("EnvironmentTorque", 2, start | {"r_BN_N": [7.0e6, 0, 0]}) as environment:
        environment.set({"r_BN_N": [6.0e6, 0, 0]})
        with pytest.raises(Exception, match=r"fmi2GetReal failed with status 2 \(discard\)"):
            environment.get("torque_B")


def test_the_circular_orbit_of_the_study_is_the_one_of_the_text() -> None:
    system = System("orbit")
    system.add("orbit", "KeplerOrbit", ORBIT)
    result = run(system, stop_time=6000.0, step=60.0)
    np.testing.assert_allclose(result["orbit.altitude"], 765e3, atol=1e-6)
    normal = np.cross(result["orbit.r_ON_N"], result["orbit.v_ON_N"])
    tilt = np.degrees(np.arccos(normal[:, 2] / np.linalg.norm(normal, axis=1)))
    np.testing.assert_allclose(tilt, 70.0, atol=1e-9)
    assert kinematics(np.eye(4)[0], INERTIA[0])[0] == 0
