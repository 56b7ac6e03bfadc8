"""Co-Simulation: the integrator inside, variable steps, sampling that can be repeated at a communication point."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.one_fmu import Raw

VERSIONS = (2, 3)
pytestmark = pytest.mark.parametrize("version", VERSIONS)
J = np.array([[10, 1.2, 0.5], [1.2, 19, 1.5], [0.5, 1.5, 25]])
OMEGA = np.array([0.5, -0.3, 0.4])


def spin(version: int, internal: float, step: float, until: float) -> np.ndarray:
    with Raw("RigidBody", version).initialize(omega_BN_B=OMEGA, max_internal_step=internal) as body:
        for k in range(round(until / step)):
            body.step(k * step, step)
        return body.get("omega_BN_B")


@pytest.fixture(scope="module")
def exact() -> np.ndarray:
    return solve_ivp(
        lambda _, w: np.linalg.solve(J, -np.cross(w, J @ w)), (0, 8), OMEGA, method="DOP853", rtol=1e-13, atol=1e-15
    ).y[:, -1]


def test_fourth_order_in_the_internal_step_whatever_the_communication_step(version: int, exact: np.ndarray) -> None:
    coarse, fine = (np.abs(spin(version, h, 2.0, 8.0) - exact).max() for h in (0.5, 0.25))
    assert 14 < coarse / fine < 18
    assert spin(version, 0.25, 2.0, 8.0) == pytest.approx(spin(version, 0.25, 0.25, 8.0), abs=1e-15)


def test_momentum_and_energy_are_kept_and_the_quaternion_has_unit_norm(version: int) -> None:
    with Raw("RigidBody", version).initialize(omega_BN_B=OMEGA) as body:
        momentum, energy = body.get("H_N"), body.get("kinetic_energy")
        for k in range(1000):
            body.step(k * 0.1, 0.1)
        assert body.get("H_N") == pytest.approx(momentum, rel=1e-9)
        assert body.get("kinetic_energy") == pytest.approx(energy, rel=1e-10)
        assert abs(np.linalg.norm(body.get("q_BN")) - 1) < 1e-15


def test_steps_of_any_size(version: int, exact: np.ndarray) -> None:
    sizes = np.random.default_rng(1).uniform(0.003, 0.2, 1000)
    times = np.concatenate([[0], np.cumsum(sizes)])
    last = np.searchsorted(times, 8.0)
    times = np.concatenate([times[:last], [8.0]])
    with Raw("RigidBody", version).initialize(omega_BN_B=OMEGA) as body:
        for t, end in pairwise(times):
            body.step(t, end - t)
        assert body.get("omega_BN_B") == pytest.approx(exact, abs=1e-10)


def test_outputs_follow_inputs_without_a_step(version: int) -> None:
    with Raw("PdTracking", version).initialize() as controller:
        controller.set({"omega_BN_B": [0.1, 0, 0]})
        assert controller.get("torque_B")[0] == pytest.approx(-0.5)
        controller.set({"omega_BN_B": [0.2, 0, 0]})
        assert controller.get("torque_B")[0] == pytest.approx(-1.0)
        controller.set({"k_v": 10.0})
        assert controller.get("torque_B")[0] == pytest.approx(-2.0)


def noise(tracker: Raw) -> np.ndarray:
    return np.concatenate([tracker.get("tilt_direction"), tracker.get("tilt_versine")])


def test_draws_do_not_depend_on_how_time_is_stepped(version: int) -> None:
    settings = {"half_angle": 0.05, "redraw_period": 0.1, "seed": 3, "q_BN": [0.5, 0.5, 0.5, 0.5]}
    with (
        Raw("StarTracker", version).initialize(**settings) as fine,
        Raw("StarTracker", version).initialize(**settings) as coarse,
    ):
        for k in range(100):
            fine.step(k * 0.01, 0.01)
            if k % 25 == 24:
                coarse.step((k - 24) * 0.01, 0.25)
                assert fine.get("q_BN_meas").tolist() == coarse.get("q_BN_meas").tolist()


def test_a_draw_holds_from_its_instant_to_the_next(version: int) -> None:
    with Raw("StarTracker", version).initialize(half_angle=0.05, redraw_period=0.1) as tracker:
        seen = [noise(tracker)]
        for k in range(40):
            tracker.step(k * 0.05, 0.05)
            seen.append(noise(tracker))
    for k in range(0, 40, 2):  # rows at 0.0, 0.05 | 0.1, 0.15 | ...
        assert seen[k].tolist() == seen[k + 1].tolist()
        assert seen[k + 2].tolist() != seen[k].tolist()


@pytest.mark.parametrize("start", [1.0, 1.03])
def test_late_start_draws_what_belongs_to_that_time(version: int, start: float) -> None:
    settings = {"half_angle": 0.05, "redraw_period": 0.1}
    with (
        Raw("StarTracker", version).initialize(**settings) as early,
        Raw("StarTracker", version).initialize(start=start, **settings) as late,
    ):
        early.step(0.0, start)
        assert noise(early)[3] > 0
        assert noise(early).tolist() == noise(late).tolist()


def test_the_input_set_at_the_sample_instant_counts(version: int) -> None:
    """Outputs read, inputs changed and outputs read again at one instant: the same draw, on the new input."""
    q_a, q_b = [0.5, 0.5, 0.5, 0.5], [0.8, 0.6, 0.0, 0.0]
    settings = {"half_angle": 0.05, "redraw_period": 0.1}
    with (
        Raw("StarTracker", version).initialize(q_BN=q_a, **settings) as asked,
        Raw("StarTracker", version).initialize(q_BN=q_b, **settings) as direct,
    ):
        asked.step(0.0, 0.1)
        asked.get("q_BN_meas")
        asked.set({"q_BN": q_b})
        direct.step(0.0, 0.1)
        assert asked.get("q_BN_meas").tolist() == direct.get("q_BN_meas").tolist()
        asked.step(0.1, 0.1)
        direct.step(0.1, 0.1)
        assert asked.get("q_BN_meas").tolist() == direct.get("q_BN_meas").tolist()


def test_time_events_announce_the_draws(version: int) -> None:
    with Raw("StarTracker", version, cosim=False).initialize(half_angle=0.05, redraw_period=0.1) as tracker:
        times = []
        for _ in range(5):
            defined, time = tracker.event_update()
            assert defined
            times.append(time)
            before = noise(tracker)
            tracker.fmu.setTime(time)
            assert noise(tracker).tolist() == before.tolist()
            tracker.fmu.enterEventMode()
            assert noise(tracker).tolist() != before.tolist()
        assert times == [k * 0.1 for k in range(1, 6)]
    with Raw("StarTracker", version, cosim=False).initialize() as exact_tracker:
        assert exact_tracker.event_update()[0] is False
