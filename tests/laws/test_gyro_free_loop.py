"""The loops of chapter 4 and Secs. 5.4.3, 5.4.4 as one ODE, against recomputed loops; and Theorem 4.2.3."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from adcs import CoSimulation, CoupledModel, ModelExchange, Save, run
from adcs.catalogue import SYSTEMS
from adcs.library.thakur.gyro_free.level import printed_level, start_value, sufficient_level
from adcs.library.thakur.gyro_free.settings import Start
from adcs.library.thakur.gyro_free.systems import gyro_free
from adcs.library.thakur.observer.settings import INERTIA, INERTIA_ERRORS
from adcs.library.thakur.observer.systems import observer_inertia_error, observer_pd, quest_observer_pd
from orchestration.fmu.file import FmiVersion
from references import observer_pd as base
from references.gyro_free import Loop, Settings, resting_attitudes, seen
from references.observer_pd import Array, rate_along, rotation

from .gyro_free_mutants import MUTANTS

NAMES = {"gyro-free": False, "gyro-free-full-state": True}
END = 40.0  # s, after which the angle has fallen from 32 to 2 deg
TIMES = np.arange(0, END + 0.5, 1.0)
EXACT: dict[str, Any] = {"method": ModelExchange(rtol=1e-12, atol=1e-14)}


@pytest.fixture(scope="module")
def paths() -> dict[bool, Array]:
    """The recomputed loops over the first 40 s."""
    return {full_state: Loop(full_state).run(TIMES) for full_state in (False, True)}


@pytest.mark.parametrize("fmi_version", ["2.0", "3.0"])
@pytest.mark.parametrize("name", NAMES)
def test_coupled_model_exchange_follows_the_recomputed_loop(
    paths: dict[bool, Array], name: str, fmi_version: FmiVersion
) -> None:
    loop, expected = Loop(NAMES[name]), paths[NAMES[name]]
    result = run(SYSTEMS[name].build(), stop_time=END, step=1.0, fmi_version=fmi_version, **EXACT)
    signals = {
        "plant.q_BN": expected[:, :4],
        "plant.omega_BN_B": expected[:, 4:7],
        "controller.torque_B": np.array([loop.torque(x)[0] for x in expected]),
    }
    if not loop.full_state:
        signals["controller.z"] = expected[:, 7:]
        signals["controller.zDot"] = np.array([loop.torque(x)[1] for x in expected])
    for variable, values in signals.items():
        deviation = np.abs(result[variable] - values).max() / np.abs(values).max()
        assert deviation < 1e-9, f"{variable}: {deviation:.1e} of its largest value"


def residuals(loop: Loop, rhs: Callable[[float, Array], Array], path: Array) -> float:
    """The largest difference between V' along the rates `rhs` and what the proof says, over the path's largest V'."""
    claimed = np.array([loop.lyapunov_rate(x) for x in path])
    actual = np.array([rate_along(lambda _, x: np.array(loop.lyapunov(x)), 0.0, x, rhs(0.0, x)) for x in path])
    return float(np.abs(actual - claimed).max() / np.abs(claimed).max())


@pytest.mark.parametrize("name", NAMES)
def test_lyapunov_identity_along_the_trajectory_of_the_components(name: str) -> None:
    """V' = -1/2 kz z'^T Q z', and -kw |omega|^2 for full state; V' reaches -5.3e-4 and -6.2e-4 W."""
    loop = Loop(NAMES[name])
    with CoupledModel(SYSTEMS[name].build()) as model:
        z_start: Any = [] if loop.full_state else model.outputs(0.0, model.x0)["controller.z"]
        shift = np.concatenate([np.zeros(7), z_start])
        order = [
            model.state_names.index(f"{n}[{i + 1}]") for n, k in STATES if n in loop_states(loop) for i in range(k)
        ]

        def rhs(t: float, x: Array) -> Array:
            """The components' rates in the order of the recomputed loop."""
            state = np.empty(len(order))
            state[order] = x - shift
            return model.rhs(t, state)[order]

        x0 = model.x0[order] + shift
        path = solve_ivp(rhs, (0, END), x0, "DOP853", TIMES, rtol=1e-12, atol=1e-14).y.T
        assert residuals(loop, rhs, path) < 1e-8
        values = np.array([loop.lyapunov(x) for x in path])
        assert np.diff(values).max() < 0
        rates = np.array([loop.lyapunov_rate(x) for x in path])
        assert -rates.min() == pytest.approx(6.17e-4 if loop.full_state else 5.30e-4, rel=0.01)


STATES = (("plant.q_BN", 4), ("plant.omega_BN_B", 3), ("controller.z_moved", 3))


def loop_states(loop: Loop) -> set[str]:
    return {n for n, _ in STATES[: 2 if loop.full_state else 3]}


@pytest.mark.parametrize("name", MUTANTS)
def test_a_wrong_law_breaks_the_identity(paths: dict[bool, Array], name: str) -> None:
    """At the same states; the least of them by 5 % of the largest V', millions of times the tolerance above."""
    loop = replace(Loop(), control=MUTANTS[name])
    assert residuals(Loop(), Loop().rates, paths[False]) < 1e-8
    assert residuals(Loop(), loop.rates, paths[False]) > 0.05


def test_a_transposed_error_breaks_the_identity(paths: dict[bool, Array]) -> None:
    """Vectors seen through C(q)^T, in either law."""
    for full_state, path in paths.items():
        loop = Loop(full_state, see=lambda q, x: seen(q * [1, -1, -1, -1], x))
        assert residuals(Loop(full_state), loop.rates, path) > 0.1


@pytest.mark.parametrize("name", ["M for its transpose", "factor 1/2 of M"])
def test_a_wrong_law_may_converge_all_the_same(name: str) -> None:
    """Which is why convergence is no test."""
    loop = replace(Loop(), control=MUTANTS[name])
    x = solve_ivp(loop.rates, (0, 150), loop.start, "LSODA", rtol=1e-6, atol=1e-8).y[:, -1]
    assert 1 - abs(x[:4] @ loop.settings.q_r) < 1e-6


# --- Theorem 4.2.3 ----------------------------------------------------------------------------------------------------


def test_the_printed_start_condition_is_not_sufficient() -> None:
    """Three attitudes with V(0) below the level of Eq. (4.27), at which the components rest without any torque."""
    s = Settings()
    values = []
    for eigenvalue, q in resting_attitudes(s):
        start = Start(tuple(q), (0.0, 0.0, 0.0))
        assert start_value(start) == pytest.approx(s.gains.k_p * (3 - eigenvalue), rel=1e-12)
        assert start_value(start) < printed_level()
        result = run(gyro_free(start), stop_time=30.0, step=1.0, method=ModelExchange())
        assert np.abs(result["controller.torque_B"]).max() < 1e-12
        assert np.abs(result["plant.q_BN"] - q).max() < 1e-9
        error = rotation(s.q_r).inv() * rotation(result["plant.q_BN"][-1])
        assert np.degrees(error.magnitude()) == pytest.approx(180, abs=1e-6)
        values.append(start_value(start))
    assert sufficient_level() == pytest.approx(min(values), rel=1e-12)
    assert sufficient_level() == pytest.approx(0.03 * (2 - np.sqrt(0.5)), rel=1e-12)
    assert printed_level() == pytest.approx(0.09)


@pytest.mark.parametrize("part", [0.999, 0.9, 0.5])
def test_below_the_corrected_level_the_body_comes_to_the_attitude_wanted(part: float) -> None:
    """Also right below, turned from rest by nearly 180 degrees about the worst axis, where the pull is smallest."""
    s = Settings()
    _, worst = resting_attitudes(s)[-1]
    axis = (rotation(s.q_r).inv() * rotation(worst)).as_rotvec() / np.pi
    angle = 2 * np.arcsin(np.sqrt(part))  # V grows with sin^2 of half the angle
    q = (rotation(s.q_r) * Rotation.from_rotvec(angle * axis)).as_quat(scalar_first=True)
    start = Start(tuple(q), (0.0, 0.0, 0.0))
    assert start_value(start) == pytest.approx(part * sufficient_level(), rel=1e-9)
    result = run(gyro_free(start), stop_time=500.0, step=5.0, method=ModelExchange(rtol=1e-8, atol=1e-10))
    assert 1 - abs(result["plant.q_BN"][-1] @ s.q_r) < 1e-8
    assert np.abs(result["plant.omega_BN_B"][-1]).max() < 1e-5


def test_a_filter_at_zero_asks_for_much_more_torque() -> None:
    """z(0) = 0 instead of z(0) = -Am^-1 B Omega(0)."""
    peaks = [
        np.linalg.norm(run(system, stop_time=5.0, step=0.01, **EXACT)["controller.torque_B"], axis=1).max()
        for system in (gyro_free(), gyro_free(controller={"filter_at_rest": False, "z_0": (0.0, 0.0, 0.0)}))
    ]
    assert peaks[0] == pytest.approx(0.01393, rel=1e-3)
    assert peaks[1] / peaks[0] > 15


# --- QUEST and inertia errors -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["model-exchange", "co-simulation"])
def test_quest_in_the_loop_changes_nothing(method: str) -> None:
    """Through an attitude whose scalar part falls to -0.98: without continuity of the sign it would."""
    settings: dict[str, Any] = {"stop_time": 100.0, "step": 0.05, "method": CoSimulation()}
    names = ["plant.q_BN", "plant.omega_BN_B", "observer.omega_EN_E", "controller.torque_B"]
    with_quest = run(quest_observer_pd(), **settings, save=Save([*names, "quest.q_BN_est"]))
    direct = run(observer_pd(), **settings, save=Save(names))
    assert direct["plant.q_BN"][:, 0].min() < -0.97
    for name in names:
        assert np.abs(with_quest[name] - direct[name]).max() < 1e-9, name
    np.testing.assert_allclose(with_quest["quest.q_BN_est"], with_quest["plant.q_BN"], rtol=0, atol=1e-12)


@pytest.mark.parametrize("error", [np.zeros((3, 3)), *map(np.array, INERTIA_ERRORS)])
def test_the_observer_with_a_wrong_inertia_follows_the_recomputed_one(error: Array) -> None:
    true, assumed = np.array(INERTIA), np.array(INERTIA) + error
    s = base.Settings()

    def rates(_: float, x: Array) -> Array:
        q_hat, omega_hat = base.observer_rates(assumed, 1.0, 3.0, x[:4], np.zeros(3), x[7:11], x[11:])
        body = base.body_acceleration(true, x[4:7], np.zeros(3))
        return np.concatenate([base.kinematics(x[:4], x[4:7]), body, q_hat, omega_hat])

    x0 = np.concatenate([s.q, s.omega, s.q, s.omega_hat])
    times = np.arange(0, 101, 5.0)
    expected = solve_ivp(rates, (0, 100), x0, "DOP853", times, rtol=1e-12, atol=1e-14).y.T
    result = run(observer_inertia_error(tuple(map(tuple, error))), stop_time=100.0, step=5.0, **EXACT)
    names = ("plant.q_BN", "plant.omega_BN_B", "observer.q_EN", "observer.omega_EN_E")
    np.testing.assert_allclose(np.hstack([result[n] for n in names]), expected, rtol=0, atol=1e-9)
