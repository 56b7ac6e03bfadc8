"""The components of the thesis' loops, each alone, against a recomputation from the equations."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import kstest

from adcs import System, run
from orchestration.instances.instance import CallFailed
from references.law import inertia
from references.observer_pd import Array
from tests.one_fmu import Component, array_name, unpacked


def test_what_an_observer_needs_does_not_wait_for_its_estimate() -> None:
    """The order of one control step follows from what outputs depend on at an instant."""
    declared = {
        (name, array_name(u.variable.name)[0], array_name(d.name)[0])
        for name in ("BacksteppingControl", "NonlinearExtendedStateObserver")
        for u in unpacked(name, 2)[1].outputs
        for d in u.dependencies
        if d.causality == "input"
    }
    assert ("BacksteppingControl", "torque_B", "torque_disturbance_B_est") in declared
    assert ("BacksteppingControl", "z_2_bar_B", "torque_disturbance_B_est") not in declared
    assert ("BacksteppingControl", "acceleration_expected_B", "torque_disturbance_B_est") not in declared
    assert not any(output == "torque_disturbance_B_est" for _, output, _ in declared)


def test_beyond_180_degrees_the_plant_shows_the_shadow() -> None:
    """A body that turns about one axis: sigma = tan(theta/4) up to 180 degrees, then from -1 back up to 0."""
    system = System("turning")
    turning = {"J_B": np.eye(3), "J0_B": np.eye(3), "orbital_rate": 0.0, "omega_BN_B": [0, 0, 0.5]}
    system.add("plant", "OrbitingBody", {**turning, "torque_B": [0, 0, 0], "torque_disturbance_B": [0, 0, 0]})
    result = run(system, stop_time=14.0, step=0.1)
    theta = 0.5 * result.time
    expected = np.tan(np.where(theta > np.pi, theta - 2 * np.pi, theta) / 4)
    np.testing.assert_allclose(result["plant.sigma_BO"], np.column_stack([0 * theta, 0 * theta, expected]), atol=1e-12)
    assert theta[-1] > 2 * np.pi


@pytest.mark.parametrize(
    ("sigma_BO", "sigma_RO"),
    [([0.0, 0.0, 0.9], [0.0, 0.0, -0.9]), ([0.8, 0.3, -0.2], [-0.5, -0.6, 0.4]), ([0.7, 0.7, 0.0], [-0.7, -0.7, 0.1])],
)
def test_the_law_takes_the_shorter_way(sigma_BO: list[float], sigma_RO: list[float]) -> None:
    """The error is that of the relative rotation within 180 degrees, whichever MRP is given."""
    between = Rotation.from_mrp(sigma_BO).inv() * Rotation.from_mrp(sigma_RO)
    with Component("BacksteppingControl", 2, co_simulation=True) as law:
        law.set({"sigma_BO": sigma_BO, "sigma_RO": sigma_RO})
        np.testing.assert_allclose(law.get("sigma_RB"), between.as_mrp(), atol=1e-13)


def test_sampled_sources_hold_what_they_computed() -> None:
    """With a period the torque is that of the last instant; without, that of now."""
    rng = np.random.default_rng(9)
    for name in ("SpinningWheel", "OscillatingPayload", "InertiaMismatch"):
        start = {"J_B": inertia(rng)} if name == "InertiaMismatch" else {}
        values = [{"omega_BN_B": rng.normal(size=3)} for _ in range(2)]
        with (
            Component(name, 2, {**start, "period": 0.5}, co_simulation=True) as held,
            Component(name, 2, start, co_simulation=True) as now,
        ):
            for component in (held, now):
                component.set(values[0])
            first = now.get("torque_B")
            np.testing.assert_array_equal(held.get("torque_B"), first)
            for component in (held, now):
                component.fmu.doStep(0.0, 0.3)
                component.set(values[1])
            np.testing.assert_array_equal(held.get("torque_B"), first)
            assert np.abs(now.get("torque_B") - first).max() > 1e-3 * np.abs(first).max()
            for component in (held, now):
                component.fmu.doStep(0.3, 0.2)
            np.testing.assert_array_equal(held.get("torque_B"), now.get("torque_B"))


def test_sampled_guidance_lags_and_differentiates_as_asked() -> None:
    """(D.6) by hand: the filter at each sample, the reference of `lag` periods ago, and either rate."""
    start = {"slew_start": 0.3, "slew_rate": 0.4, "angle": 0.5, "time_constant": 0.7, "scan_start": 2.0}
    for lag in (0, 1):
        system = System("guidance")
        for name, difference in (("difference", 1), ("analytic", 0)):
            sampled = {"period": 0.1, "lag": lag, "difference": difference, "scan_period": 3.0}
            system.add(name, "ScanningReference", {**start, **sampled})
        result = run(system, stop_time=3.0, step=0.1)
        theta, expected, slope = 0.0, [], []
        for k in range(31):
            t = 0.1 * (k - lag)
            u = float(np.clip(0.4 * (t - 0.3), 0, 0.5))
            theta = (0.7 * theta + 0.1 * u) / 0.8
            expected.append(0.5 * np.cos(2 * np.pi / 3 * (t - 2)) if t > 1.9999 else theta)
            slope.append(-np.pi / 3 * np.sin(2 * np.pi / 3 * (t - 2)) if t > 1.9999 else (u - theta) / 0.7)
        for name in ("difference", "analytic"):
            np.testing.assert_allclose(result[f"{name}.theta"], expected, atol=1e-13)
        sigma = result["difference.sigma_RO"]
        np.testing.assert_allclose(np.linalg.norm(sigma, axis=1), np.tan(np.abs(expected) / 4), atol=1e-13)
        rate = np.vstack([np.zeros(3), np.diff(sigma, axis=0) / 0.1])
        np.testing.assert_allclose(result["difference.sigmaDot_RO"], rate, atol=1e-12)
        along = result["analytic.sigmaDot_RO"] @ (np.array([-1, 1, 0.5]) / 1.5)
        np.testing.assert_allclose(along, np.array(slope) / np.cos(np.array(expected) / 4) ** 2 / 4, atol=1e-12)


def measured(seed: int, version: int = 2) -> tuple[Array, Array]:
    """Attitude errors [rad] and rate errors [rad/s] of 2000 samples, a draw each."""
    true = np.array([0.3, -0.2, 0.5])
    system = System("sensor")
    noise = {"attitude_noise": 2e-3, "rate_noise": 5e-4, "period": 0.1, "seed": seed}
    system.add("sensor", "AttitudeRateSensor", {**noise, "sigma_BO": true, "omega_BN_B": [0.1, 0.2, 0.3]})
    result = run(system, stop_time=199.9, step=0.1, fmi_version=f"{version}.0")
    turn = Rotation.from_mrp(true).inv() * Rotation.from_mrp(result["sensor.sigma_BO_meas"])
    return turn.as_rotvec(), result["sensor.omega_BN_B_meas"] - [0.1, 0.2, 0.3]


def test_sensor_noise_is_gaussian_of_the_size_asked_for() -> None:
    attitude, rate = measured(1)
    for values, size in ((attitude, 2e-3), (rate, 5e-4)):
        for axis in range(3):
            assert kstest(values[:, axis] / size, "norm").pvalue > 0.01
    together = np.column_stack([attitude, rate])
    correlation = np.corrcoef(together.T) - np.eye(6)
    assert np.abs(correlation).max() < 4 / np.sqrt(len(together))
    for column in together.T:
        assert abs(np.corrcoef(column[:-1], column[1:])[0, 1]) < 4 / np.sqrt(len(together))


def test_sensor_draws_depend_on_the_seed_alone() -> None:
    first, other = measured(1), measured(2)
    for a, b in zip(first, measured(1, 3), strict=True):
        np.testing.assert_array_equal(a, b)
    assert abs(np.corrcoef(first[0][:, 0], other[0][:, 0])[0, 1]) < 4 / np.sqrt(2000)


BAD = [
    ("BacksteppingControl", {"c_1": np.diag([0.1, -0.1, 0.1])}, "is not positive definite: a symmetric matrix"),
    (
        "BacksteppingControl",
        {"c_2": np.array([[1, 0.5, 0], [0, 1, 0], [0, 0, 1]])},
        "c_2 = [1 0.5 0; 0 1 0; 0 0 1] is not positive definite",
    ),
    ("BacksteppingControl", {"K": -np.eye(3)}, "K = [-1 -0 -0; -0 -1 -0; -0 -0 -1] is not positive semidefinite"),
    ("BacksteppingControl", {"torque_limit": 0.0}, "torque_limit"),
    ("BacksteppingControl", {"rate_limit": -1.0}, "rate_limit"),
    ("BacksteppingControl", {"acceleration_limit": 0.0}, "acceleration_limit"),
    ("BacksteppingControl", {"period": 0.0}, "period"),
    ("BacksteppingControl", {"sigma_BO": [0.0, 1.4, 0.0]}, "sigma_BO"),
    ("BacksteppingControl", {"sigma_RO": [0.0, 0.0, -1.2]}, "sigma_RO"),
    ("BacksteppingControl", {"J0_B": np.diag([1.0, 1.0, 3.0])}, "J0_B"),
    ("TuningFunctionObserver", {"G": np.zeros((3, 3))}, "G = [0 0 0; 0 0 0; 0 0 0] is not positive definite"),
    (
        "NonlinearExtendedStateObserver",
        {"beta_1": -np.eye(3)},
        "beta_1 = [-1 -0 -0; -0 -1 -0; -0 -0 -1] is not positive definite",
    ),
    ("NonlinearExtendedStateObserver", {"beta_2": np.zeros((3, 3))}, "beta_2 has no positive determinant"),
    ("ImmersionInvarianceObserver", {"gamma": 0.0}, "gamma"),
    ("ScanningReference", {"lag": 1}, "lag and difference belong to a sampled reference"),
    ("ScanningReference", {"angle": 3.5}, "angle"),
    ("ScanningReference", {"axis": [0.0, 0.0, 0.0]}, "axis is"),
    ("SpinningWheel", {"axis": [0.0, 0.0, 0.0]}, "axis is"),
    ("OscillatingPayload", {"J_A": [1e-5, 0.0, 1e-5]}, "J_A[2] = 0 refused: must be above 0"),
    ("AttitudeRateSensor", {"attitude_noise": 1e-3}, "attitude_noise or rate_noise is above 0, but period is 0"),
    ("AttitudeRateSensor", {"sigma_BO": [1.1, 0.0, 0.0]}, "sigma_BO"),
    ("OrbitingBody", {"q_BO": [0.0, 0.0, 0.0, 0.0]}, "q_BO"),
]


@pytest.mark.parametrize(("name", "start", "message"), BAD)
def test_what_makes_no_sense_is_refused_by_name(name: str, start: dict[str, Any], message: str) -> None:
    system = System("bad")
    inputs = {
        "BacksteppingControl": ("sigma_BO", "sigma_RO", "sigmaDot_RO", "omega_BN_B", "torque_disturbance_B_est"),
        "TuningFunctionObserver": ("z_2_bar_B",),
        "NonlinearExtendedStateObserver": ("sigma_BO", "omega_BN_B", "torque_B"),
        "ImmersionInvarianceObserver": ("omega_BN_B", "acceleration_expected_B"),
        "SpinningWheel": ("omega_BN_B",),
        "OscillatingPayload": ("sigma_BO", "omega_BN_B", "torque_control_B"),
        "AttitudeRateSensor": ("sigma_BO", "omega_BN_B"),
        "OrbitingBody": ("torque_B", "torque_disturbance_B"),
    }.get(name, ())
    system.add("it", name, {**{i: [0, 0, 0] for i in inputs}, **start})
    with pytest.raises(CallFailed) as error:
        run(system, stop_time=1.0, step=0.1)
    assert message in str(error.value)
    assert "\n" not in str(error.value)
