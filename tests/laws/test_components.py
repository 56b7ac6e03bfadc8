"""Each component alone: outputs, derivatives and directional derivatives at random points against the recomputation."""

import numpy as np
import pytest
from scipy.stats import chisquare, kstest

from references.law import quaternion
from references.observer_pd import Array
from tests.one_fmu import VERSIONS, Component

# --- star tracker -----------------------------------------------------------------------------------------------------

HALF_ANGLE = np.deg2rad(0.5)
PERIOD = 0.1


def draws(version: int, seed: int, n: int, q: Array, co_simulation: bool = False) -> Array:
    """q_BN_meas in the middle of the first n redraw intervals, for a constant true attitude."""
    start = {"half_angle": HALF_ANGLE, "redraw_period": PERIOD, "seed": seed, "q_BN": q}
    with Component("StarTracker", version, start, co_simulation) as tracker:
        rows = []
        for k in range(n):
            if co_simulation:
                tracker.fmu.doStep(k * PERIOD + (k > 0) * -PERIOD / 2, PERIOD if k else PERIOD / 2)
            else:
                tracker.at((k + 0.5) * PERIOD)
            rows.append(tracker.get("q_BN_meas"))
        return np.array(rows)


def axis_and_angle(q: Array) -> tuple[Array, Array]:
    """Eigenaxis and eigenangle in [0, 2 pi]."""
    sine = np.linalg.norm(q[..., 1:], axis=-1)
    return q[..., 1:] / sine[..., None], 2 * np.arctan2(sine, q[..., 0])


Q_TRUE = np.array([0.6, 0.48, -0.64, 0.0])

# The measurement of Q_TRUE for two seeds: draws 0, 1 and 49, and draw 0. The same on every platform.
GOLDEN = {
    1: [
        [0.6, 0.4759193613396646, -0.6430300199720176, 0.0036269707515288827],
        [0.6, 0.4836697684961474, -0.6372311469374385, -0.000142883447867259],
        [0.6, 0.4794677821337797, -0.6403974258854296, -0.0013352209667385436],
    ],
    2024: [[0.6, 0.4812827875985272, -0.6390081544907271, 0.005954565957817263]],
}


@pytest.mark.parametrize("version", VERSIONS)
def test_star_tracker_is_exact_without_noise(version: int) -> None:
    rng = np.random.default_rng(3)
    with Component("StarTracker", version, {"half_angle": 0.0}) as tracker:
        for k, q in enumerate([np.eye(4)[0], -np.eye(4)[0], np.eye(4)[2], *(quaternion(rng) for _ in range(20))]):
            tracker.at(0.37 * k)
            tracker.set({"q_BN": q})
            np.testing.assert_array_equal(tracker.get("q_BN_meas"), q)


def test_star_tracker_tilts_the_eigenaxis_within_the_cone() -> None:
    q = draws(2, 1, 4000, Q_TRUE)
    axis_true, angle_true = axis_and_angle(Q_TRUE)
    axis, angle = axis_and_angle(q)
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1, atol=1e-14)
    np.testing.assert_allclose(angle, angle_true, atol=1e-14)
    # Uniform on the cap: its height above the rim and the direction of the tilt are uniform and independent.
    along = np.linalg.norm(axis - axis_true, axis=1) ** 2 / 2
    height = along / (1 - np.cos(HALF_ANGLE))
    assert height.max() <= 1 + 1e-9
    e_1 = np.array([axis_true[1], -axis_true[0], 0.0])
    e_2 = np.cross(axis_true, e_1)
    turn = np.arctan2(axis @ e_2, axis @ e_1) / (2 * np.pi) + 0.5
    assert kstest(height, "uniform").pvalue > 0.01
    assert kstest(turn, "uniform").pvalue > 0.01
    counts = np.histogram2d(height, turn, bins=(8, 8), range=[(0, 1), (0, 1)])[0]
    assert chisquare(counts.ravel()).pvalue > 0.01
    for series in (height, turn):
        assert abs(np.corrcoef(series[:-1], series[1:])[0, 1]) < 3 / np.sqrt(len(series)), "successive draws"


def test_star_tracker_eigenaxis_of_identity_stays_finite() -> None:
    np.testing.assert_allclose(draws(2, 1, 5, np.eye(4)[0]), [np.eye(4)[0]] * 5, atol=1e-15)
    small = np.array([1.0, 3e-9, -4e-9, 0.0])
    np.testing.assert_allclose(draws(2, 1, 5, small), [small] * 5, atol=5e-11)


@pytest.mark.parametrize("version", VERSIONS)
def test_star_tracker_redraws_at_multiples_of_its_period_and_holds_in_between(version: int) -> None:
    start = {"half_angle": HALF_ANGLE, "redraw_period": PERIOD, "seed": 1, "q_BN": Q_TRUE}
    with Component("StarTracker", version, start) as tracker:
        held = [tracker.get("q_BN_meas")]
        for k in range(1, 200):
            assert tracker.next_event == k * PERIOD, "announced as an index times the period, not accumulated"
            tracker.at(np.nextafter(k * PERIOD, 0))
            np.testing.assert_array_equal(tracker.get("q_BN_meas"), held[-1])
            tracker.at(k * PERIOD)
            held.append(tracker.get("q_BN_meas"))
            assert not np.array_equal(held[-1], held[-2])
            tracker.set({"q_BN": -Q_TRUE})  # the draw is held, not the measurement
            np.testing.assert_array_equal(tracker.get("q_BN_meas"), -held[-1])
            tracker.set({"q_BN": Q_TRUE})
    np.testing.assert_array_equal(held, draws(version, 1, 200, Q_TRUE))


@pytest.mark.parametrize("version", VERSIONS)
def test_star_tracker_started_late_draws_what_it_would_have_drawn(version: int) -> None:
    start = {"half_angle": HALF_ANGLE, "redraw_period": PERIOD, "seed": 1, "q_BN": Q_TRUE}
    expected = draws(version, 1, 4, Q_TRUE)
    with Component("StarTracker", version, start, start_time=0.25) as tracker:
        np.testing.assert_array_equal(tracker.get("q_BN_meas"), expected[2])
        assert tracker.next_event == 3 * PERIOD
        tracker.at(0.35)
        np.testing.assert_array_equal(tracker.get("q_BN_meas"), expected[3])


@pytest.mark.parametrize("version", VERSIONS)
def test_star_tracker_redraws_at_the_communication_points_of_co_simulation(version: int) -> None:
    """30 * 0.01 and 3 * 0.1 are different numbers; the redraw must be seen at the 30th point all the same."""
    expected = draws(version, 1, 21, Q_TRUE)
    start = {"half_angle": HALF_ANGLE, "redraw_period": PERIOD, "seed": 1, "q_BN": Q_TRUE}
    with Component("StarTracker", version, start, co_simulation=True) as tracker:
        for k in range(201):
            np.testing.assert_array_equal(tracker.get("q_BN_meas"), expected[k // 10], err_msg=f"point {k}")
            tracker.fmu.doStep(k * 0.01, 0.01)


def test_star_tracker_draws_depend_on_the_seed_alone() -> None:
    first = draws(2, 1, 50, Q_TRUE)
    np.testing.assert_array_equal(first, draws(3, 1, 50, Q_TRUE))
    np.testing.assert_array_equal(first, draws(2, 1, 50, Q_TRUE, co_simulation=True))
    np.testing.assert_array_equal(first, draws(3, 1, 50, Q_TRUE, co_simulation=True))
    np.testing.assert_allclose(first[[0, 1, 49]], GOLDEN[1], rtol=0, atol=1e-15)
    np.testing.assert_allclose(draws(2, 2024, 1, Q_TRUE), GOLDEN[2024], rtol=0, atol=1e-15)


def test_star_tracker_seeds_are_independent() -> None:
    tilts = np.array([(draws(2, seed, 1000, Q_TRUE) - Q_TRUE)[:, 1] for seed in (1, 2, 3, 1001)])
    correlation = np.corrcoef(tilts) - np.eye(4)
    assert np.abs(correlation).max() < 3 / np.sqrt(1000)
