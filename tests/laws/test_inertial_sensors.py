"""The inertial measurement unit and the magnetometer: every draw recomputed, and what noise and bias amount to."""

from collections.abc import Callable, Mapping
from math import sqrt
from typing import Any

import numpy as np
import pytest
from scipy.stats import combine_pvalues, kstest

from adcs import System, run
from orchestration.instances.instance import CallFailed
from references.answers import SAMPLED
from references.law import quaternion
from references.observer_pd import Array
from tests.one_fmu import VERSIONS, Component

PERIOD = 0.05
Draw = Callable[[np.random.Generator], dict[str, Any]]


def draw_inertial(rng: np.random.Generator) -> dict[str, Any]:
    return {
        "omega_BN_B": rng.normal(size=3),
        "specific_force_B": rng.normal(size=3),
        "gyro_bias": rng.normal(size=3) * 1e-2,
        "gyro_noise": rng.uniform(0, 0.1),
        "accelerometer_bias": rng.normal(size=3) * 0.1,
        "accelerometer_noise": rng.uniform(0, 0.3),
        "seed": int(rng.integers(2**31)),
        "period": PERIOD,
    }


def draw_magnetic(rng: np.random.Generator) -> dict[str, Any]:
    return {
        "q_BN": quaternion(rng),
        "magnetic_field_N": rng.normal(size=3) * 3e-5,
        "bias": rng.normal(size=3) * 1e-7,
        "noise": rng.uniform(0, 3e-7),
        "seed": int(rng.integers(2**31)),
        "period": PERIOD,
    }


SENSORS: dict[str, tuple[Draw, tuple[str, ...], float]] = {
    "InertialMeasurementUnit": (draw_inertial, ("gyro_noise", "accelerometer_noise"), 1.0),
    "Magnetometer": (draw_magnetic, ("noise",), 1e-5),
}
"""How to draw a point, the parameters of the noise, and the size of a measurement."""


def measurement(name: str, p: Mapping[str, Any], k: int) -> dict[str, Array]:
    """What draw k makes of the inputs."""
    return SAMPLED[name].step(p, {"k": k - 1}, p)


def points(name: str, n: int = 20) -> list[dict[str, Any]]:
    rng = np.random.default_rng(list(name.encode()))
    return [SENSORS[name][0](rng) for _ in range(n)]


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", SENSORS)
def test_without_a_period_there_is_neither_noise_nor_holding(name: str, version: int) -> None:
    _, noises, scale = SENSORS[name]
    for point in points(name):
        point |= {"period": 0.0, **dict.fromkeys(noises, 0.0)}
        with Component(name, version, point) as component:
            for time in (0.0, 0.37):
                component.at(time)
                for variable, value in measurement(name, point, 0).items():
                    np.testing.assert_allclose(component.get(variable), value, rtol=0, atol=1e-12 * scale)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", SENSORS)
def test_a_sample_is_held_and_later_changes_are_not_seen(name: str, version: int) -> None:
    (point,) = points(name, 1)
    continuous = point | {"period": 0.0, **dict.fromkeys(SENSORS[name][1], 0.0)}
    with Component(name, version, point) as held, Component(name, version, continuous) as direct:
        inputs = held.names("input")
        outputs = held.names("output")
        before = [held.get(o) for o in outputs], [direct.get(o) for o in outputs]
        for component in (held, direct):
            component.at(0.9 * PERIOD)
            component.set({i: -point[i] if i != "q_BN" else np.roll(point[i], 1) for i in inputs})
        for output, was, was_direct in zip(outputs, *before, strict=True):
            np.testing.assert_array_equal(held.get(output), was)
            assert not np.array_equal(direct.get(output), was_direct)


@pytest.mark.parametrize("name", SENSORS)
def test_directional_derivatives_of_continuous_measurement(name: str) -> None:
    """By each input, against differences along it."""
    _, noises, scale = SENSORS[name]
    for point in points(name, 3):
        point |= {"period": 0.0, **dict.fromkeys(noises, 0.0)}
        with Component(name, 2, point) as component:
            outputs = component.names("output")
            for known in component.names("input"):
                for direction in np.eye(point[known].size):
                    seen = component.directional(outputs, known, direction)
                    if known == "q_BN":  # C(q) is a quadratic form of q, so central differences are exact
                        ends = [field(point, point[known] + s * direction) for s in (0.5, -0.5)]
                        expected = ends[0] - ends[1]
                    else:
                        ends = [
                            np.concatenate(list(measurement(name, point | {known: s * direction}, 0).values()))
                            for s in (1, 0)
                        ]
                        expected = ends[0] - ends[1]
                    np.testing.assert_allclose(seen, expected, rtol=0, atol=1e-12 * max(1.0, scale))


def field(point: Mapping[str, Any], q: Array) -> Array:
    """C(q) B for a quaternion of any length, from its definition as a product of quaternions, q* B q."""
    left = np.array(
        [[q[0], q[1], q[2], q[3]], [-q[1], q[0], q[3], -q[2]], [-q[2], -q[3], q[0], q[1]], [-q[3], q[2], -q[1], q[0]]]
    )
    right = np.array(
        [[q[0], -q[1], -q[2], -q[3]], [q[1], q[0], q[3], -q[2]], [q[2], -q[3], q[0], q[1]], [q[3], q[2], -q[1], q[0]]]
    )
    return np.asarray((left @ right @ [0.0, *point["magnetic_field_N"]])[1:])


def measured(seed: int, version: int = 2, step: float = PERIOD) -> dict[str, Array]:
    """2000 samples of a constant truth, less the truth."""
    system = System("sensors")
    noise = {"period": PERIOD, "seed": seed}
    imu = {
        "gyro_noise": 2e-4,
        "accelerometer_noise": 3e-3,
        "gyro_bias": [1e-3, -2e-3, 3e-3],
        "accelerometer_bias": [0.1, 0, 0],
    }
    system.add(
        "imu", "InertialMeasurementUnit", {**imu, **noise, "omega_BN_B": [0.1, 0.2, 0.3], "specific_force_B": [0, 0, 1]}
    )
    truth = {"q_BN": [1, 0, 0, 0], "magnetic_field_N": [2e-5, 0, -3e-5]}
    system.add("magnetometer", "Magnetometer", {"noise": 1e-7, "bias": [0, 5e-7, 0], **noise, **truth})
    result = run(system, stop_time=2000 * PERIOD - PERIOD, step=step, fmi_version=f"{version}.0")
    every = round(PERIOD / step)
    return {
        "rate": (result["imu.omega_BN_B_meas"] - [0.1, 0.2, 0.3])[::every],
        "force": (result["imu.specific_force_B_meas"] - [0, 0, 1])[::every],
        "field": (result["magnetometer.magnetic_field_B_meas"] - [2e-5, 0, -3e-5])[::every],
    }


def test_noise_is_gaussian_around_the_bias_and_of_the_size_asked_for() -> None:
    errors = measured(1)
    chances = []
    for name, size, bias in (
        ("rate", 2e-4, [1e-3, -2e-3, 3e-3]),
        ("force", 3e-3, [0.1, 0, 0]),
        ("field", 1e-7, [0, 5e-7, 0]),
    ):
        noise = (errors[name] - bias) / size
        for axis in noise.T:
            chances.append(kstest(axis, "norm").pvalue)
            assert abs(np.corrcoef(axis[:-1], axis[1:])[0, 1]) < 4 / sqrt(len(axis)), "successive draws"
    assert combine_pvalues(chances).pvalue > 0.01  # nine tests: one of them below 0.01 is no surprise
    together = np.column_stack([errors["rate"], errors["force"]])
    assert np.abs(np.corrcoef(together.T) - np.eye(6)).max() < 4 / sqrt(len(together))


def test_draws_depend_on_the_seed_alone() -> None:
    first = measured(1)
    for name, value in measured(1, version=3, step=PERIOD / 5).items():
        np.testing.assert_array_equal(value, first[name])
    other = measured(2)
    assert abs(np.corrcoef(first["rate"][:, 0], other["rate"][:, 0])[0, 1]) < 4 / sqrt(2000)


@pytest.mark.parametrize(
    ("mutant", "change"),
    [
        ("bias subtracted", lambda p: {"gyro_bias": -p["gyro_bias"]}),
        ("noise of the next draw", lambda p: {"seed": p["seed"] + 1}),
        ("gyro noise on the accelerometer", lambda p: {"accelerometer_noise": p["gyro_noise"]}),
        ("biases exchanged", lambda p: {"gyro_bias": p["accelerometer_bias"]}),
    ],
)
def test_mistakes_would_be_seen(mutant: str, change: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
    """The recomputation with a mistake in it differs by far more than the tolerance above."""
    for point in points("InertialMeasurementUnit", 5):
        right, wrong = (measurement("InertialMeasurementUnit", p, 3) for p in (point, point | change(point)))
        assert max(np.abs(right[n] - wrong[n]).max() for n in right) > 1e-6, mutant


def test_a_transposed_rotation_would_be_seen() -> None:
    for point in points("Magnetometer", 5):
        right, wrong = (
            measurement("Magnetometer", point | {"q_BN": q}, 3)["magnetic_field_B_meas"]
            for q in (point["q_BN"], point["q_BN"] * [1, -1, -1, -1])
        )
        assert np.abs(right - wrong).max() > 1e-6


@pytest.mark.parametrize(
    ("name", "start", "message"),
    [
        (
            "InertialMeasurementUnit",
            {"gyro_noise": 1e-3},
            "gyro_noise or accelerometer_noise is above 0, but period is 0",
        ),
        ("InertialMeasurementUnit", {"accelerometer_noise": -1.0}, "accelerometer_noise"),
        ("InertialMeasurementUnit", {"period": -0.1}, "period"),
        ("Magnetometer", {"noise": 1e-7}, "noise is above 0, but period is 0"),
        ("Magnetometer", {"q_BN": [0, 0, 0, 0]}, "q_BN"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(name: str, start: dict[str, Any], message: str) -> None:
    inputs = {"Magnetometer": {"q_BN": [1, 0, 0, 0], "magnetic_field_N": [0, 0, 0]}}.get(
        name, {"omega_BN_B": [0, 0, 0], "specific_force_B": [0, 0, 0]}
    )
    system = System("bad")
    system.add("it", name, {**inputs, **start})
    with pytest.raises(CallFailed) as error:
        run(system, stop_time=1.0, step=0.1)
    assert message in str(error.value)
    assert "\n" not in str(error.value)
