"""Unit vector sensor, gyro-free law, PD on vectors and QUEST, each alone, against the recomputation."""

from typing import Any

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from scipy.stats import chisquare, combine_pvalues, kstest

from adcs import System, run
from orchestration.instances.instance import CallFailed
from references import gyro_free as ref
from references.answers.gyro_free import gains, gyro_free
from references.law import quaternion
from references.observer_pd import Array
from tests.one_fmu import VERSIONS, Component

from .at_points import draw, opened
from .gyro_free_mutants import MUTANTS


@pytest.mark.parametrize("name", MUTANTS)
def test_a_wrong_law_differs_at_random_points(name: str) -> None:
    """By more than a hundred million times what the comparison above allows."""
    for point in draw("GyroFreeStabilization", 5):
        right, wrong = gyro_free(point), gyro_free(point, MUTANTS[name])
        assert np.abs(right["torque_B"] - wrong["torque_B"]).max() > 1e-4


def test_the_other_lyapunov_equation_gives_another_p() -> None:
    """Am P + P Am^T = -Q would go unnoticed with the diagonal Am of the text."""
    p = draw("GyroFreeStabilization", 1)[0]
    difference = ref.lyapunov_solution(p["A_m"], p["Q"]) - ref.lyapunov_solution(p["A_m"].T, p["Q"])
    assert np.abs(difference).max() > 0.1


# --- the filter's start, and P ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("co_simulation", [False, True])
@pytest.mark.parametrize("version", VERSIONS)
def test_the_filter_starts_at_rest_from_the_first_measurement(version: int, co_simulation: bool) -> None:
    for point in draw("GyroFreeStabilization", 3):
        start = {**point, "filter_at_rest": 1, "z_moved": np.zeros(3)}
        y_r = ref.seen(point["q_RN"], point["directions_N"])
        expected = ref.resting_filter(gains(point), point["directions_B"], y_r)
        with opened("GyroFreeStabilization", version, start, co_simulation=co_simulation) as component:
            scale = np.abs(point["A_m"]).max() * max(1.0, np.abs(expected).max())
            np.testing.assert_allclose(component.get("z"), expected, rtol=1e-11)
            np.testing.assert_allclose(component.get("zDot"), 0, atol=1e-14 * scale)
            p = ref.lyapunov_solution(point["A_m"], point["Q"])
            np.testing.assert_allclose(component.get("P"), p, rtol=1e-11, atol=1e-12 * np.abs(p).max())
            if co_simulation:
                component.fmu.doStep(0.0, 0.01)
            else:
                component.at(5.0)
            component.set({"directions_B": draw("VectorPd", 1)[0]["directions_B"]})
            np.testing.assert_allclose(component.get("z_start"), expected, rtol=1e-11)  # set once


def test_the_printed_p() -> None:
    """Sec. 4.3: Am = diag(-3, -10, -5), Q = 10.5 I give P = diag(1.75, 0.525, 1.05)."""
    with Component("GyroFreeStabilization", 2) as component:
        np.testing.assert_allclose(component.get("P"), np.diag([1.75, 0.525, 1.05]), rtol=1e-15, atol=1e-16)


# --- the sensor's noise -----------------------------------------------------------------------------------------------

HALF_ANGLE = np.deg2rad(2.0)
Q_TRUE = np.array([0.6, 0.48, -0.64, 0.0])
X = np.array([[0, 0, 1.0], [1.0, 0, 0], [1.0, 1.0, 0]])


def draws(n: int, **start: Any) -> Array:
    """The measurements (n, 3, 3) in the middle of the first n redraw intervals, at a constant attitude."""
    values = {"half_angle": HALF_ANGLE, "redraw_period": 0.1, "seed": 1, "q_BN": Q_TRUE, "directions_N": X, **start}
    with Component("UnitVectorSensor", 2, values) as sensor:
        rows = []
        for k in range(n):
            sensor.at((k + 0.5) * 0.1)
            rows.append(sensor.get("directions_B_meas"))
        return np.array(rows)


@pytest.mark.parametrize("spread", [0.2, 1 / 3, 10.0])
def test_noise_is_normal_within_the_cone(spread: float) -> None:
    """1 - cos(beta) is exponential with mean sigma^2, cut off at the cone; the side is uniform; all are independent."""
    n = 2500
    y, true = draws(n, spread=spread), ref.seen(Q_TRUE, X)
    np.testing.assert_allclose(np.linalg.norm(y, axis=2), 1, atol=1e-14)
    versine = np.sum((y - true) ** 2, axis=2) / 2
    rim = 1 - np.cos(HALF_ANGLE)
    assert versine.max() <= rim * (1 + 1e-9)
    scale = (spread * HALF_ANGLE) ** 2
    height = np.expm1(-versine / scale) / np.expm1(-rim / scale)  # uniform if the law holds
    turns, chances = [], []
    for j in range(3):
        e_1 = np.cross(true[j], [0.3, -0.5, 0.8])
        e_1 /= np.linalg.norm(e_1)
        turn = np.arctan2(y[:, j] @ np.cross(true[j], e_1), y[:, j] @ e_1) / (2 * np.pi) + 0.5
        counts = np.histogram2d(height[:, j], turn, bins=(6, 6), range=[(0, 1), (0, 1)])[0]
        chances += [kstest(height[:, j], "uniform").pvalue, kstest(turn, "uniform").pvalue]
        chances.append(chisquare(counts.ravel()).pvalue)
        turns.append(turn)
    assert combine_pvalues(chances).pvalue > 0.01  # nine tests: one of them below 0.01 would be no surprise
    series = np.array([*height.T, *turns])
    assert np.abs(np.corrcoef(series) - np.eye(6)).max() < 4 / np.sqrt(n), "the three errors"
    for row in series:
        assert abs(np.corrcoef(row[:-1], row[1:])[0, 1]) < 4 / np.sqrt(n), "successive draws"


def test_noise_depends_on_seed_and_draw_alone() -> None:
    first = draws(30)
    np.testing.assert_array_equal(first, draws(30))
    assert np.abs(first - draws(30, seed=2)).max() > 1e-3
    for version in VERSIONS:
        start = {"half_angle": HALF_ANGLE, "redraw_period": 0.1, "seed": 1, "q_BN": Q_TRUE, "directions_N": X}
        with Component("UnitVectorSensor", version, start, co_simulation=True) as sensor:
            for k in range(40):  # held for ten steps each
                np.testing.assert_array_equal(sensor.get("directions_B_meas"), first[k // 10], err_msg=f"point {k}")
                sensor.fmu.doStep(k * 0.01, 0.01)
        with Component("UnitVectorSensor", version, start, start_time=0.25) as sensor:
            np.testing.assert_array_equal(sensor.get("directions_B_meas"), first[2])
            assert sensor.next_event == 3 * 0.1


# --- QUEST ------------------------------------------------------------------------------------------------------------


def est(y: Array, **start: Any) -> tuple[Array, float]:
    """The first estimate from the vectors y, and its observability."""
    with Component("Quest", 2, {"directions_N": X, "directions_B": y, **start}) as component:
        return component.get("q_BN_est"), float(component.get("observability"))


def test_quest_is_exact_for_exact_vectors_and_through_half_turns() -> None:
    rng = np.random.default_rng(5)
    half_turns = [*np.eye(4), np.array([0, 0.6, 0.8, 0]), np.array([0, 1, 1, 1]) / np.sqrt(3)]
    tiny = [np.array([e, *(np.sqrt((1 - e**2) / 3),) * 3]) for e in (1e-3, 1e-8, 1e-15)]
    for q in (*half_turns, *tiny, *(quaternion(rng) for _ in range(20))):
        q_est, value = est(ref.seen(q, X), q_BN_first=q)
        np.testing.assert_allclose(q_est, q, rtol=0, atol=2e-14)
        assert value == pytest.approx(0.2592592592592592, rel=1e-9)  # 7/27: eigenvalues 1 and 1 -+ 1/sqrt(2)
        np.testing.assert_allclose(est(ref.seen(q, X), q_BN_first=-q)[0], -q, rtol=0, atol=2e-14)


def test_quest_needs_two_vectors_only() -> None:
    q = np.array([0.1, 0.7, -0.5, 0.5])
    y = ref.seen(q, X)
    y[1] = [0.0, 0.0, 1.0]  # not seen, whatever it says
    q_est, value = est(y, q_BN_first=q, weights=[1, 0, 2])
    np.testing.assert_allclose(q_est, q / np.linalg.norm(q), rtol=0, atol=1e-14)
    assert value == pytest.approx(2 / 9)  # (1 + 2) * 1 * 2 / 3^3


def test_quest_keeps_its_sign_over_full_turns() -> None:
    """Two and a half turns: q must come out at -q(0) after one and at q(0) after two, in both interfaces."""
    axis = np.array([1.0, 2.0, 2.0]) / 3
    for co_simulation in (False, True):
        jumps = []
        with Component("Quest", 2, {"directions_N": X, "directions_B": ref.seen(np.eye(4)[0], X)}, co_simulation) as c:
            before = np.eye(4)[0]
            for k in range(1, 300):
                if co_simulation:
                    c.fmu.doStep((k - 1) * 0.05, 0.05)
                half = np.pi / 120 * k  # at 60 deg/s
                q = np.array([np.cos(half), *(np.sin(half) * axis)])
                c.set({"directions_B": ref.seen(q, X)})
                if not co_simulation:
                    c.at(0.05 * k)
                q_est = c.get("q_BN_est")
                np.testing.assert_allclose(q_est, q, rtol=0, atol=1e-13, err_msg=f"step {k}")
                jumps.append(np.linalg.norm(q_est - before))
                before = q_est
        assert max(jumps) < 0.06


def test_quest_without_memory_would_jump() -> None:
    """The sign taken from the start alone fails over the same turn."""
    flipped = ref.quest(np.ones(3), ref.seen(np.array([-0.8, 0.2, 0.4, 0.4]), X), X, np.eye(4)[0])
    np.testing.assert_allclose(flipped, [0.8, -0.2, -0.4, -0.4], atol=1e-14)


@pytest.mark.parametrize("y", [np.zeros((3, 3)), 2.0 * np.eye(3)])
def test_quest_refuses_measured_vectors_that_are_no_unit_vectors(y: Any) -> None:
    with Component("Quest", 2, {"directions_N": X}) as component:
        component.set({"directions_B": y})
        with pytest.raises(FMICallException):
            component.get("q_BN_est")


@pytest.mark.parametrize("y", [[[0, 0, 1.0]] * 3, [[0, 0, 1.0], [0, 0, -1.0], [0, 0, 1.0]]])
def test_quest_holds_its_estimate_when_measured_vectors_are_collinear(y: Any) -> None:
    q = np.array([0.6, 0.48, -0.64, 0.0])
    with Component("Quest", 2, {"directions_N": X, "directions_B": ref.seen(q, X), "q_BN_first": q}) as component:
        component.at(0.25)
        component.set({"directions_B": y})
        assert component.get("observability") < 1e-6
        np.testing.assert_allclose(component.get("q_BN_est"), q, rtol=0, atol=1e-15)
        component.at(0.55)  # remembered twice meanwhile
        np.testing.assert_allclose(component.get("q_BN_est"), q, rtol=0, atol=1e-15)
        component.set({"directions_B": ref.seen(-np.array([0.8, 0.0, 0.6, 0.0]), X)})
        np.testing.assert_allclose(component.get("q_BN_est"), [0.8, 0, 0.6, 0], rtol=0, atol=1e-14)  # nearer than -q
    q_est, value = est(np.array([[0, 0, 1.0]] * 3))
    assert value < 1e-6
    np.testing.assert_array_equal(q_est, [1, 0, 0, 0])


def test_quest_close_to_collinear_is_still_the_solution() -> None:
    """Three directions within 0.2 deg: fewer digits, not another answer."""
    x = np.array([[0, 0, 1.0], [2e-3, 0, 1.0], [0, 3e-3, 1.0]])
    q = np.array([0.1, 0.7, -0.5, 0.5])
    q /= np.linalg.norm(q)
    q_est, value = est(ref.seen(q, x), directions_N=x, q_BN_first=q)
    assert 1e-6 < value < 1e-5
    np.testing.assert_allclose(q_est, q, rtol=0, atol=1e-9)


# --- what is refused --------------------------------------------------------------------------------------------------

COLLINEAR = "directions_N of positive weight are collinear: turning about their line cannot be seen, give two that are"
FEW = "fewer than two weights are positive: two directions at least are needed for an attitude"
REFUSED = [
    ({"weights": [1, 0, 0]}, FEW),
    ({"weights": [0, 0, 0]}, FEW),
    ({"directions_N": [[1, 2, 3], [2, 4, 6], [-1, -2, -3]]}, COLLINEAR),
    ({"directions_N": [[1, 2, 3], [2, 4, 6.0005], [0, 0, 1]], "weights": [1, 1, 0]}, COLLINEAR),
    (
        {"directions_N": [[1, 2, 3], [0, 0, 0], [0, 0, 1]]},
        "row 2 of directions_N is [0, 0, 0], but a direction is expected",
    ),
    ({"weights": [1, 1, -1]}, "weights[3] = -1 refused: must be at least 0"),
]
FILTER_REFUSED = [
    ({"A_m": np.diag([-3.0, 0.1, -5])}, "A_m is not Hurwitz: all its eigenvalues must have negative real parts"),
    ({"A_m": [[-0.1, 0, 0], [0, 0.05, 1], [0, -1, 0]]}, "A_m is not Hurwitz"),
    ({"A_m": [[0, 1, 0], [0, 0, 1], [-3, -1, -2]]}, "A_m is not Hurwitz"),  # no sign shows it: a b = 2 < c = 3
    ({"B": [[1, 2, 3], [4, 5, 6], [7, 8, 9]]}, "B is singular: it must be invertible"),
    ({"Q": np.diag([1, 1, -1.0])}, "Q = [1 0 0; 0 1 0; 0 0 -1] is not positive definite"),
    ({"Q": [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]}, "Q = [1 0.5 0; 0 1 0; 0 0 1] is not positive definite"),
]


def refusal(component: str, start: dict[str, Any]) -> str:
    system = System("refused")
    system.add("c", component, {**start, "directions_B": np.eye(3)})
    if component == "VectorPd":
        system.set("c.omega_BN_B", np.zeros(3))
    with pytest.raises(CallFailed) as failure:
        run(system, stop_time=0.1, step=0.1)
    return str(failure.value)


@pytest.mark.parametrize("component", ["GyroFreeStabilization", "VectorPd", "Quest"])
@pytest.mark.parametrize(("start", "message"), REFUSED)
def test_vectors_that_do_not_tell_the_attitude_are_refused(component: str, start: dict[str, Any], message: str) -> None:
    text = refusal(component, start)
    assert message in text
    assert "\n" not in text


@pytest.mark.parametrize(("start", "message"), FILTER_REFUSED)
def test_a_filter_for_which_the_proof_fails_is_refused(start: dict[str, Any], message: str) -> None:
    assert message in refusal("GyroFreeStabilization", start)


def test_the_sensor_refuses_what_is_no_direction() -> None:
    with pytest.raises(FMICallException):
        Component("UnitVectorSensor", 2, {"directions_N": [[1, 0, 0], [0, 1, 0], [0, 0, 0]]})
