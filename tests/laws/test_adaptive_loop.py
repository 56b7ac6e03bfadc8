"""The loops of ch. 3 as one ODE: against the recomputation, along the identities, and with mistakes built in."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from adcs import CoupledModel, ModelExchange, Save, System, run
from adcs.library.thakur.adaptive import systems as systems
from references.adaptive import (
    DIAGONAL,
    MASSES,
    Adaptation,
    AdaptiveLoop,
    ComparisonLoop,
    combined,
    every_element,
    solve,
)
from references.observer_pd import Array, rate_along, rotation

NO_BASIS = np.zeros((0, 3, 3))
J_1_FUEL = np.diag([4e-3, 4e-3, 5e-3])
THETA_TRUE = (20.0, 1.2, 0.9, 17.0, 1.4, 15.0)
FUEL_THETA, FUEL_SIGMA = Adaptation(8.0, 40.0, 10.0), Adaptation(20.5, 0.008, 0.008)

LOOPS = {
    "baseline": AdaptiveLoop("rigid", NO_BASIS, Adaptation(0.0), Adaptation(0.0), theta_0=THETA_TRUE),
    "appendage": AdaptiveLoop(
        "appendage", MASSES, Adaptation(60.0), Adaptation(200.0), J_1=combined(MASSES, np.array([1.0, 1.3]))
    ),
    "appendage_full": AdaptiveLoop(
        "appendage", every_element(6), Adaptation(60.0), Adaptation(200.0), J_1=combined(MASSES, np.array([1.0, 1.3]))
    ),
    "fuel": AdaptiveLoop("fuel", DIAGONAL, FUEL_THETA, FUEL_SIGMA, J_1=J_1_FUEL),
    "fuel_full": AdaptiveLoop("fuel", every_element(3), FUEL_THETA, FUEL_SIGMA, J_1=J_1_FUEL),
}
SIGMA = {
    "baseline": "",
    "appendage": "mass_est",
    "appendage_full": "J_1_est",
    "fuel": "sigma_est",
    "fuel_full": "J_1_est",
}
PROJECTED = {  # bounds that the appendage's estimates reach
    "controller.theta_bound": 33.0,
    "controller.theta_margin": 3.0,
    "controller.sigma_bound": 0.8,
    "controller.sigma_margin": 0.8,
}
USUAL, TIGHT = ModelExchange(), ModelExchange(rtol=1e-12, atol=1e-13)


def built(name: str, changes: dict[str, Any] | None = None) -> System:
    system: System = getattr(systems, name)()
    for variable, value in (changes or {}).items():
        system.set(variable, value)
    return system


def columns(names: list[str], prefix: str) -> list[int]:
    """Places of a variable's elements, row by row, in the coupled state."""
    return [i for i, n in enumerate(names) if n == prefix or n.startswith(f"{prefix}[")]


def to_loop(names: list[str], sigma: str) -> Callable[[Array], Array]:
    """From the coupled state to that of `AdaptiveLoop`."""
    impulse = columns(names, "plant.torque_impulse")
    parts = ["plant.q_BN", "plant.omega_BN_B", "guidance.angle", "", "controller.theta_est", f"controller.{sigma}"]
    places = [columns(names, part) if part else impulse for part in parts]

    def translate(x: Array) -> Array:
        rows = [x[place] if part or impulse else np.zeros(1) for place, part in zip(places, parts, strict=True)]
        return np.concatenate(rows)

    return translate


def to_comparison(names: list[str]) -> Callable[[Array], Array]:
    parts = ("plant.q_BN", "plant.omega_BN_B", "guidance.angle", *(f"controller.{n}" for n in _ESTIMATES))
    places = [place for part in parts for place in columns(names, part)]
    return lambda x: x[places]


_ESTIMATES = ("theta_est", "omega_f", "W_f")


def along(
    system: System, stop: float, step: float, method: ModelExchange = USUAL
) -> tuple[Array, Array, Array, list[str]]:
    """Times, coupled states and their derivatives along the components' own trajectory, and the states' names."""
    result = run(system, stop_time=stop, step=step, save=Save(["plant.q_BN"]), method=method)
    with CoupledModel(system) as model:
        rates = [model.rhs(t, x) for t, x in zip(result.time, result.states, strict=True)]
        return result.time, result.states, np.array(rates), model.state_names


@pytest.mark.parametrize(
    ("name", "stop", "changes"),
    [
        ("baseline", 8.0, {}),
        ("appendage", 8.0, {}),
        ("appendage", 6.0, PROJECTED),
        ("appendage_full", 3.0, {}),
        ("fuel", 0.3, {}),
        ("fuel_full", 0.15, {}),
    ],
)
def test_coupled_components_follow_the_recomputed_loop(name: str, stop: float, changes: dict[str, Any]) -> None:
    loop = LOOPS[name]
    if changes:
        loop = replace(loop, theta_law=Adaptation(60.0, 33.0, 3.0), sigma_law=Adaptation(200.0, 0.8, 0.8))
    times, states, _, names = along(built(name, changes), stop, stop / 4, TIGHT)
    expected = solve(loop.rates, loop.start, times)
    translate = to_loop(names, SIGMA[name])
    for t, x, y in zip(times, states, expected, strict=True):
        got = translate(x)
        y[8] *= loop.kind == "fuel"
        np.testing.assert_allclose(got, y, rtol=0, atol=1e-8, err_msg=f"{name} at {t} s")


def test_comparison_follows_the_recomputed_loop() -> None:
    system = built("comparison_baseline", {"controller.gamma": 100.0, "controller.theta_est": LOOPS["fuel"].theta_0})
    times, states, _, names = along(system, 4.0, 1.0, TIGHT)
    loop = ComparisonLoop()
    expected = solve(loop.rates, loop.start, times)
    np.testing.assert_allclose([to_comparison(names)(x) for x in states], expected, rtol=0, atol=1e-8)


def residuals(
    name: str, loop: AdaptiveLoop, stop: float, changes: dict[str, Any], method: ModelExchange = USUAL
) -> tuple[Array, Array]:
    """dV/dt by the components' derivatives less -k_v |omega_e|^2 - beta |q_ev|^2, and what the projection explains."""
    times, states, rates, names = along(built(name, changes), stop, stop / 80, method)
    translate, found, explained = to_loop(names, SIGMA[name]), [], []
    for t, x, x_dot in zip(times, states, rates, strict=True):
        plain, extra = loop.lyapunov_rate(t, translate(x))
        value = rate_along(lambda s, y: np.array(loop.lyapunov(s, translate(y))), t, x, x_dot)
        found.append(float(value) - plain)
        explained.append(extra)
    return np.array(found), np.array(explained)


@pytest.mark.parametrize(
    ("name", "stop"),
    [("baseline", 100.0), ("appendage", 100.0), ("appendage_full", 40.0)],
)
def test_lyapunov_identity(name: str, stop: float) -> None:
    """V' = -k_v |omega_e|^2 - beta |q_ev|^2 to 1e-8 W, where V' itself reaches 2 W."""
    found, explained = residuals(name, LOOPS[name], stop, {})
    assert np.abs(found).max() < 1e-8
    assert not explained.any()


@pytest.mark.parametrize(("name", "stop"), [("fuel", 40.0), ("fuel_full", 20.0)])
def test_lyapunov_inequality_with_projection(name: str, stop: float) -> None:
    """V' is at most that, and exactly so by what (3.32) says of the projection, which does act."""
    found, explained = residuals(name, LOOPS[name], stop, {}, ModelExchange("CVode"))
    assert np.abs(found - explained).max() < 1e-8
    assert found.max() < 1e-8
    assert found.min() < -1e-3


def test_lyapunov_inequality_with_projection_of_the_masses() -> None:
    loop = replace(LOOPS["appendage"], theta_law=Adaptation(60.0, 33.0, 3.0), sigma_law=Adaptation(200.0, 0.8, 0.8))
    found, explained = residuals("appendage", loop, 20.0, PROJECTED)
    assert np.abs(found - explained).max() < 1e-8
    assert np.abs(found).max() > 1e-3


@pytest.mark.parametrize(
    ("name", "radii"), [("fuel", {"theta_est": np.hypot(40, 10), "sigma_est": np.hypot(0.008, 0.008)})]
)
def test_estimates_stay_in_their_sets(name: str, radii: dict[str, float]) -> None:
    """(3.28): the bound is approached closely and not passed."""
    result = run(built(name), stop_time=30.0, step=0.01, method=ModelExchange("CVode"))
    for estimate, radius in radii.items():
        largest = np.linalg.norm(result[f"controller.{estimate}"], axis=1).max()
        assert largest < radius * (1 + 1e-9)
    assert np.linalg.norm(result["controller.sigma_est"], axis=1).max() > 0.99 * radii["sigma_est"]


def manifold_residual(loop: ComparisonLoop, stop: float = 20.0, changes: dict[str, Any] | None = None) -> float:
    """Largest |eta' + alpha eta| [rad/s2] along the components' trajectory."""
    start = {"controller.gamma": 100.0, "controller.theta_est": LOOPS["fuel"].theta_0, **(changes or {})}
    times, states, rates, names = along(built("comparison_baseline", start), stop, 0.5)
    translate = to_comparison(names)
    found = [
        rate_along(lambda s, y: loop.manifold(s, translate(y)), t, x, x_dot) + loop.manifold(t, translate(x))
        for t, x, x_dot in zip(times, states, rates, strict=True)
    ]
    return float(np.abs(found).max())


def test_comparison_error_lies_on_its_manifold() -> None:
    """eta' = -alpha eta with alpha = 1 1/s: the filtered torque is -W_f (theta_hat + beta_c)."""
    assert manifold_residual(ComparisonLoop()) < 1e-8
    assert manifold_residual(ComparisonLoop(), changes={"controller.gamma": 101.0}) > 1e-4, "the check can fail"


def own_residual(loop: AdaptiveLoop, states: Array, times: Array) -> float:
    """Of the identity, along the recomputed loop's own flow at given states."""
    found = []
    for t, x in zip(times, states, strict=True):
        value = rate_along(lambda s, y: np.array(loop.lyapunov(s, y)), t, x, loop.rates(t, x))
        found.append(abs(float(value) - sum(loop.lyapunov_rate(t, x))))
    return max(found)


@pytest.fixture(scope="module")
def visited() -> dict[str, tuple[Array, Array]]:
    """States that the loops pass through, half of them turned at random: the identity holds at any state."""
    found, rng = {}, np.random.default_rng(5)
    for name in ("appendage", "fuel"):
        times, states, _, names = along(built(name), 12.0, 0.5, ModelExchange("CVode"))
        translate = to_loop(names, SIGMA[name])
        rows = np.array([translate(x) for x in states])
        turned = rng.normal(size=(len(rows), 4))
        rows[::2, :4] = (turned / np.linalg.norm(turned, axis=1, keepdims=True))[::2]
        found[name] = (rows, times)
    return found


MISTAKES = [
    pytest.param({}, {}, id="as derived"),
    pytest.param({"phi_sign": -1.0}, {"appendage": 1.0, "fuel": 1.0}, id="wrong sign in phi"),
    pytest.param(
        {"frame": lambda _, q_r: rotation(q_r).as_matrix().T}, {"appendage": 1.0, "fuel": 1.0}, id="C(q_r) for C(q_e)"
    ),
    pytest.param({"frame": lambda c_e, _: c_e.T}, {"appendage": 1.0, "fuel": 1.0}, id="C(q_e) transposed"),
    pytest.param({"adapt_sign": -1.0}, {"appendage": 1.0, "fuel": 1.0}, id="adaptation flipped"),
    pytest.param({"rate_term": 0.0}, {"appendage": 1e-2, "fuel": 1e-2}, id="no J' omega in the plant"),
]


@pytest.mark.parametrize("name", ["appendage", "fuel"])
@pytest.mark.parametrize(("mistake", "at_least"), MISTAKES)
def test_mistakes_break_the_identity(
    visited: dict[str, tuple[Array, Array]], name: str, mistake: dict[str, Any], at_least: dict[str, float]
) -> None:
    residual = own_residual(replace(LOOPS[name], **mistake), *visited[name])
    assert residual > at_least[name] if mistake else residual < 1e-8


def test_without_adaptation_the_identity_fails(visited: dict[str, tuple[Array, Array]]) -> None:
    """The terms of V in the estimates are seen: with gamma_1 in V but no adaptation, V' is off by theta~ . Phi."""
    loop = LOOPS["appendage"]
    assert own_residual(replace(loop, adapt_sign=0.0), *visited["appendage"]) > 0.1


@pytest.mark.parametrize(
    ("mistake", "at_least"),
    [
        pytest.param({}, 0.0, id="as derived"),
        pytest.param({"second_sign": -1.0}, 0.03, id="printed sign of (3.53)"),
        pytest.param({"adapt_sign": -1.0}, 0.1, id="adaptation flipped"),
        pytest.param({"phi_sign": -1.0}, 0.005, id="wrong sign in phi"),
    ],
)
def test_mistakes_leave_the_manifold(mistake: dict[str, float], at_least: float) -> None:
    system = built("comparison_baseline", {"controller.gamma": 100.0, "controller.theta_est": LOOPS["fuel"].theta_0})
    times, states, _, names = along(system, 12.0, 0.5)
    translate, loop = to_comparison(names), replace(ComparisonLoop(), **mistake)  # type: ignore[arg-type]
    found = []
    for t, x in zip(times, [translate(x) for x in states], strict=True):
        slope = rate_along(loop.manifold, t, x, loop.rates(t, x))
        found.append(np.abs(slope + loop.manifold(t, x)).max())
    assert max(found) > at_least if mistake else max(found) < 1e-8, max(found)


def test_printed_sign_of_the_comparison_law_diverges() -> None:
    """Even for constant inertia: it passes 5 rad/s after 4.6 s; with the right sign the rate falls."""
    right, printed = ComparisonLoop(), replace(ComparisonLoop(), second_sign=-1.0)

    def escaped(t: float, x: Array) -> float:
        return float(np.linalg.norm(x[4:7]) - 5.0)

    escaped.terminal = True  # type: ignore[attr-defined]
    run_ = solve_ivp(printed.rates, (0, 20), printed.start, "LSODA", rtol=1e-8, atol=1e-10, events=escaped)
    assert run_.t_events[0] == pytest.approx([4.627], abs=1e-3)
    settled = solve(right.rates, right.start, [0.0, 20.0], rtol=1e-8)
    assert np.linalg.norm(settled[-1][4:7]) < 2.0
