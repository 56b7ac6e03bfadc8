"""Noise: each number recomputed to the last bit, and none that has to do with another, whatever seeds are given.

The bounds follow from the number of values and of comparisons: with all of them right, a family of comparisons is above
its bound for one choice of seeds in a thousand. The seeds are fixed, so what passes once passes always.
"""

from collections.abc import Callable, Iterator, Mapping
from math import sin, sqrt
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy.stats import chisquare, kstest, kstwobign, norm

from adcs import System, run
from adcs.library.hardware.systems import hil_spacecraft
from fmus import catalog, fmu_path
from orchestration.fmu.file import open_fmu
from orchestration.fmu.seeds import seeds_of
from references.noise import State, Words, directions, mixed, normal, start, uniform, words
from references.observer_pd import Array, rotation
from tests.one_fmu import VERSIONS, Component

CHANCE = 1e-3
"""That a family of comparisons fails though nothing is wrong."""

LAGS = 25
SEEDS = (0, 1, 2, 2**31 - 1)
PERIOD = 0.1

STREAMS = {
    "AttitudeRateSensor.attitude": normal,
    "AttitudeRateSensor.rate": normal,
    "InertialMeasurementUnit.gyro": normal,
    "InertialMeasurementUnit.accelerometer": normal,
    "Magnetometer": normal,
    "RandomWalkStarTracker": directions,
    "StarTracker": directions,
    "UnitVectorSensor.0": directions,
    "UnitVectorSensor.1": directions,
    "UnitVectorSensor.2": directions,
}
"""All that is drawn, and what is made of it."""


# --- the same numbers -------------------------------------------------------------------------------------------------


def seen(component: Component) -> dict[str, Array]:
    """What a component drew last, as far as it can be read: unit vectors and numbers of standard deviation 1."""
    match component.description.modelName:
        case "StarTracker":
            return {"StarTracker": component.get("tilt_direction")}
        case "UnitVectorSensor":
            return {f"UnitVectorSensor.{j}": row for j, row in enumerate(component.get("tilt_directions"))}
        case "RandomWalkStarTracker":
            return {"RandomWalkStarTracker": component.get("omega_EB_E")}
        case "Magnetometer":
            return {"Magnetometer": component.get("magnetic_field_B_meas")}
        case "InertialMeasurementUnit":
            return {
                "InertialMeasurementUnit.gyro": component.get("omega_BN_B_meas"),
                "InertialMeasurementUnit.accelerometer": component.get("specific_force_B_meas"),
            }
        case "AttitudeRateSensor":
            return {
                "AttitudeRateSensor.attitude": component.get("sigma_BO_meas") / 0.025,
                "AttitudeRateSensor.rate": component.get("omega_BN_B_meas"),
            }
        case name:
            raise AssertionError(f"{name} draws, and nothing here recomputes it")


NOISY: dict[str, dict[str, Any]] = {
    "StarTracker": {"half_angle": 0.01, "redraw_period": PERIOD},
    "UnitVectorSensor": {"half_angle": 0.01, "redraw_period": PERIOD},
    "RandomWalkStarTracker": {"max_rate": 1.0, "hold_time": PERIOD},
    "Magnetometer": {"noise": 1.0, "period": PERIOD},
    "InertialMeasurementUnit": {"gyro_noise": 1.0, "accelerometer_noise": 1.0, "period": PERIOD},
    "AttitudeRateSensor": {"attitude_noise": 0.1, "rate_noise": 1.0, "period": PERIOD},
}
"""Noise of the size 1 about zero, or small where it is a turn."""


def test_the_components_that_draw_are_the_ones_looked_at_here() -> None:
    headers = {c.name: c.header.read_text(encoding="utf-8") for c in catalog.components()}
    assert {name for name, text in headers.items() if "#include <random>" in text or "Random " in text} == set(NOISY)
    assert {name for name in headers if seeds_of(open_fmu(fmu_path(name, "2.0")).ports.values())} == set(NOISY)
    assert {stream.partition(".")[0] for stream in STREAMS} == set(NOISY)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", NOISY)
def test_every_draw_is_recomputed(name: str, version: int) -> None:
    """To the last bit, where the law needs no more than products and roots: logarithm and cosine are the platform's."""
    drawn = [0, 1, 2, 3, 500]
    for seed in SEEDS:
        expected = {s: draw(s, seed, drawn) for s, draw in STREAMS.items() if s.partition(".")[0] == name}
        if name == "RandomWalkStarTracker":
            expected[name] = uniform(name, seed, drawn, 1) * expected[name]
        with Component(name, version, {**NOISY[name], "seed": seed}) as component:
            for i, k in enumerate(drawn):
                component.at(k * PERIOD)
                found = seen(component)
                assert found.keys() == expected.keys()
                for stream, value in found.items():
                    exact = STREAMS[stream] is directions
                    tolerance = {"rtol": 0.0} if exact else {"rtol": 4e-15, "atol": 4e-15}
                    np.testing.assert_allclose(value, expected[stream][i], **tolerance, err_msg=f"{stream} {seed} {k}")


@pytest.mark.parametrize("version", VERSIONS)
def test_angles_of_errors_are_recomputed(version: int) -> None:
    """The number before the direction: uniform in the star tracker, made exponential in the unit vector sensor."""
    half = 0.01
    top = 2 * sin(half / 2) ** 2
    with Component("StarTracker", version, {**NOISY["StarTracker"], "seed": 3}) as component:
        component.at(7 * PERIOD)
        assert component.get("tilt_versine") == pytest.approx(uniform("StarTracker", 3, 7, 1)[0, 0] * top, rel=1e-14)
    with Component("UnitVectorSensor", version, {**NOISY["UnitVectorSensor"], "seed": 3, "spread": 1.0}) as component:
        component.at(7 * PERIOD)
        u = np.array([uniform(f"UnitVectorSensor.{j}", 3, 7, 1)[0, 0] for j in range(3)])
        expected = -(half**2) * np.log(1 + u * np.expm1(-top / half**2))
        np.testing.assert_allclose(component.get("tilt_versines"), expected, rtol=1e-11)


# --- schemes that will not do -----------------------------------------------------------------------------------------


def by_seed_and_draw(stream: str, seed: ArrayLike, k: ArrayLike) -> Words:
    """What was here first: equal seeds, equal numbers, whoever draws."""
    return mixed(mixed(words(seed)) + words(k))


def by_component(stream: str, seed: ArrayLike, k: ArrayLike) -> Words:
    """The channels of a component draw the same."""
    return start(stream.partition(".")[0], seed, k)


def by_sum(stream: str, seed: ArrayLike, k: ArrayLike) -> Words:
    """The next seed draws what this one draws later."""
    return mixed(mixed(start(stream, 0, 0)) + words(seed) + words(k))


def unmixed(stream: str, seed: ArrayLike, k: ArrayLike) -> Words:
    """Neighbouring draws lie on one sequence of the generator, a number apart."""
    return start(stream, seed, 0) + words(k) * np.uint64(0x9E3779B97F4A7C15)


# --- nothing to do with each other ------------------------------------------------------------------------------------


def bound(values: int, comparisons: int) -> float:
    """How large a correlation of so many independent values may be by chance, at the largest of so many."""
    return float(norm.isf(CHANCE / 2 / comparisons)) / sqrt(values)


def correlated(series: Mapping[str, Array], lags: int = LAGS) -> dict[tuple[str, str], tuple[int, float]]:
    """The pairs of series, all of one length, that have something to do with each other: by how much the second is
    later where they are most alike, and how much alike.

    A series is compared with itself at lags other than 0.
    """
    names = list(series)
    x = np.array(list(series.values()))
    n = x.shape[1]
    x = (x - x.mean(axis=1, keepdims=True)) / x.std(axis=1, keepdims=True)
    spectra = np.fft.rfft(x, 2 * n)
    limit = bound(n - lags, len(names) * (len(names) + 1) // 2 * (2 * lags + 1))
    found = {}
    for i, a in enumerate(names):
        r = np.abs(np.fft.irfft(spectra[i:] * spectra[i].conj(), 2 * n))[:, np.arange(-lags, lags + 1)] / n
        r[0, lags] = 0
        for j in np.flatnonzero(r.max(axis=1) > limit):
            found[a, names[i + j]] = (int(np.argmax(r[j])) - lags, float(r[j].max()))
    return found


def drawn(state: State, seeds: tuple[int, ...], n: int, first: int = 0) -> dict[str, Array]:
    """Three numbers of each stream and seed over n draws."""
    return {
        f"{stream}[{i}], seed {seed}": column
        for seed in seeds
        for stream, draw in STREAMS.items()
        for i, column in enumerate(draw(stream, seed, np.arange(first, first + n), state=state).T)
    }


def dependent(state: State, seeds: tuple[int, ...], n: int = 4096) -> dict[tuple[str, str], tuple[int, float]]:
    """The pairs that correlate over n draws, and at the same lag over the next n: chance does not repeat itself."""
    now = correlated(drawn(state, seeds, n))
    later = correlated(drawn(state, seeds, n, first=n)) if now else {}
    return {pair: (lag, size) for pair, (lag, size) in now.items() if later.get(pair, (None,))[0] == lag}


def test_streams_do_not_correlate_over_seeds_and_draws() -> None:
    """Of the 370 260 comparisons of the first four seeds one is above its bound (5.97 for 5.95), and not again."""
    for seeds in ((0, 1, 2, 3), (4, 5, 6, 7), (-1, -2, 2**31 - 1, -(2**31))):
        assert dependent(start, seeds) == {}


@pytest.mark.parametrize(
    ("scheme", "seeds", "pair", "lag"),
    [
        (by_seed_and_draw, (1,), ("InertialMeasurementUnit.gyro[0], seed 1", "Magnetometer[0], seed 1"), 0),
        (by_component, (1,), ("AttitudeRateSensor.attitude[2], seed 1", "AttitudeRateSensor.rate[2], seed 1"), 0),
        (by_sum, (1, 2), ("Magnetometer[0], seed 1", "Magnetometer[0], seed 2"), -1),
        (unmixed, (1,), ("Magnetometer[0], seed 1", "Magnetometer[1], seed 1"), -2),
    ],
)
def test_schemes_that_will_not_do_are_refused(
    scheme: State, seeds: tuple[int, ...], pair: tuple[str, str], lag: int
) -> None:
    at, size = dependent(scheme, seeds, 2048)[pair]
    assert at == lag
    assert size == pytest.approx(1, abs=0.01)


def measured(system: System, stop: float, step: float = PERIOD) -> dict[str, Array]:
    """The noise of all sensors of a system at rest, by component and axis; of a sensor that wanders, its increments."""
    result = run(system, stop_time=stop, step=step)
    series = {}
    for name in result.names:
        component, _, variable = name.partition(".")
        values = np.asarray(result[name]).reshape(len(result.time), -1)
        if variable == "q_EB":
            values = np.diff(values[:, 1:], axis=0, append=values[-1:, 1:])
        elif not variable.endswith("_meas"):
            continue
        elif variable == "q_BN_meas":
            if f"{component}.q_EB" in result.names:
                continue
            values = values[:, 1:3]
        elif variable == "directions_B_meas":
            values = values[:, [0, 1, 4, 5, 7, 8]]  # of each, two axes across it
        series |= {f"{component}.{variable}[{i}]": column for i, column in enumerate(values.T)}
    return series


AT_REST: dict[str, dict[str, Any]] = {
    "StarTracker": {"q_BN": (0.6, 0, 0, 0.8)},
    "UnitVectorSensor": {"q_BN": (1, 0, 0, 0), "directions_N": np.eye(3)[[2, 0, 0]]},
    "RandomWalkStarTracker": {"q_BN": (1, 0, 0, 0), "max_rate": 1e-4},
    "Magnetometer": {"q_BN": (1, 0, 0, 0), "magnetic_field_N": (0, 0, 0)},
    "InertialMeasurementUnit": {"omega_BN_B": (0, 0, 0), "specific_force_B": (0, 0, 0)},
    "AttitudeRateSensor": {"sigma_BO": (0, 0, 0), "omega_BN_B": (0, 0, 0), "attitude_noise": 1e-3},
}


def at_rest(names: Mapping[str, str], **common: Any) -> System:
    """Sensors with noise, component by name in the system."""
    system = System("sensors")
    for name, component in names.items():
        system.add(name, component, {**NOISY[component], **AT_REST[component], **common})
    return system


@pytest.mark.parametrize("version", [2, 3])
def test_sensors_with_equal_seeds_measure_independent_noise(version: int) -> None:
    """Every FMU with the seed that it has by itself, which is 1 in all of them."""
    series = measured(at_rest({name.lower(): name for name in NOISY}, seed=1), 409.5)
    assert len(series) == 26
    assert correlated(series) == {}


def test_sensors_of_a_kind_measure_independent_noise_unless_seeds_are_given() -> None:
    names = {f"{prefix} {name}": name for name in NOISY for prefix in ("port", "starboard")}
    assert correlated(measured(at_rest(names), 204.7)) == {}
    alike = correlated(measured(at_rest(names, seed=1), 204.7), lags=0)
    assert len(alike) == 26, "each axis with its like, and no other"
    assert all(a.partition(" ")[2] == b.partition(" ")[2] for a, b in alike)
    assert min(size for _, size in alike.values()) > 0.999


def test_runs_and_sensors_of_the_hardware_system_share_nothing() -> None:
    series = {}
    for seed in (1, 2, 3):
        system = hil_spacecraft(seed)
        system.set("plant.omega_BN_B", [0.0, 0.0, 0.0])
        system.set("actuator.max_torque", 1e-9)
        found = measured(system, 8.188, step=0.004)
        series |= {f"run {seed} {name}": x for name, x in found.items() if not name.startswith("tracker")}
    assert len(series) == 27
    assert correlated(series) == {}


# --- white, and distributed as they should be ------------------------------------------------------------------------


def whiteness(x: Array) -> float:
    """The chance that white noise has a spectrum so far from flat: Bartlett's test of the cumulative periodogram."""
    power = np.abs(np.fft.rfft(x - x.mean())[1 : (len(x) + 1) // 2]) ** 2
    flat = np.arange(1, len(power) + 1) / len(power)
    return float(kstwobign.sf(np.abs(np.cumsum(power) / power.sum() - flat).max() * sqrt(len(power))))


def test_spectra_are_flat() -> None:
    series = drawn(start, SEEDS, 8192)
    assert min(map(whiteness, series.values())) > CHANCE / len(series)


@pytest.mark.parametrize("memory", [0.1, -0.1])
def test_coloured_noise_is_refused(memory: float) -> None:
    white = normal("Magnetometer", 1, np.arange(8192))[:, 0]
    assert whiteness(white[1:] + memory * white[:-1]) < CHANCE / 200


ORDERS: dict[str, Callable[[int, int], tuple[ArrayLike, ArrayLike]]] = {
    "draws of a seed": lambda seed, n: (seed, np.arange(n)),
    "seeds upwards": lambda k, n: (np.arange(n), k),
    "seeds below zero": lambda k, n: (-np.arange(1, n + 1), k),
    "the largest seeds": lambda k, n: (2**31 - np.arange(1, n + 1), k),
    "seeds that differ in high bits": lambda k, n: (np.arange(n) << 40, k),
    "draws from far": lambda seed, n: (seed, 2**40 + np.arange(n)),
    "seed and draw upwards": lambda offset, n: (np.arange(n), np.arange(n) + offset),
    "the one up, the other down": lambda offset, n: (np.arange(n), n + offset - np.arange(n)),
}
"""Ways through seeds and draws, along which numbers must look random."""


def chances(order: str, state: State = start, n: int = 65536) -> Iterator[tuple[str, float]]:
    """How likely it is that what is drawn along the way is as uneven as it is, by kind of unevenness."""
    for stream in ("Magnetometer", "InertialMeasurementUnit.gyro", "UnitVectorSensor.1"):
        for fixed in (0, 1):
            u = uniform(stream, *ORDERS[order](fixed, n), 3, state)
            first = u[:, 0]
            for name, x, y in (("neighbours", first[::2], first[1::2]), ("numbers of a draw", u[:, 0], u[:, 1])):
                counts = np.histogram2d(x, y, bins=32, range=[(0, 1), (0, 1)])[0]
                yield f"{name} of {stream}, {fixed}", float(chisquare(counts.ravel()).pvalue)
            yield f"first of {stream}, {fixed}", float(kstest(first, "uniform").pvalue)
            bits = (first * 2**53).astype(np.uint64)[:, None] >> np.arange(53, dtype=np.uint64) & np.uint64(1)
            farthest = np.abs(2 * bits.mean(axis=0) - 1).max() * sqrt(n)
            yield f"bits of {stream}, {fixed}", float(min(1.0, 2 * 53 * norm.sf(farthest)))


@pytest.mark.parametrize("order", ORDERS)
def test_numbers_are_uniform_along_every_way(order: str) -> None:
    found = dict(chances(order))
    assert {name: p for name, p in found.items() if p < CHANCE / len(found)} == {}


def test_numbers_that_are_not_uniform_along_a_way_are_refused() -> None:
    """Seeds that are added to draws: as the one goes up and the other down, every number is the same."""
    found = dict(chances("the one up, the other down", by_sum))
    assert max(found.values()) < CHANCE / len(found)


def normality(x: Array) -> list[float]:
    """How likely so large a difference from three normal numbers is: on each axis, in size and squared."""
    cells = np.digitize(x, norm.ppf(np.linspace(0, 1, 65)[1:-1]))
    return [
        *(float(chisquare(np.bincount(c, minlength=64)).pvalue) for c in cells.T),
        *(float(kstest(axis, "norm").pvalue) for axis in x.T),
        float(kstest(np.linalg.norm(x, axis=1), "maxwell").pvalue),
        float(kstest(np.sum(x**2, axis=1), "chi2", args=(3,)).pvalue),
    ]


def sphericity(x: Array) -> list[float]:
    """How likely so large a difference from directions uniform on the sphere is."""
    turn = np.arctan2(x[:, 1], x[:, 0]) / (2 * np.pi) + 0.5
    counts = np.histogram2d(x[:, 2] / 2 + 0.5, turn, bins=16, range=[(0, 1), (0, 1)])[0]
    return [
        *(float(kstest(axis / 2 + 0.5, "uniform").pvalue) for axis in x.T),
        float(kstest(turn, "uniform").pvalue),
        float(chisquare(counts.ravel()).pvalue),
    ]


@pytest.mark.parametrize("stream", STREAMS)
def test_what_is_made_of_them_is_distributed_as_it_should(stream: str) -> None:
    x = STREAMS[stream](stream, 1, np.arange(65536))
    found = (normality if STREAMS[stream] is normal else sphericity)(x)
    assert min(found) > CHANCE / len(found)


def test_other_distributions_are_refused() -> None:
    """A sum of three uniform numbers, and normal numbers that depend on each other; the corners of a cube."""
    u = uniform("Magnetometer", 1, np.arange(65536), 9)
    sums = normality(2 * u.reshape(-1, 3, 3).sum(axis=2) - 3)
    assert min(sums) < CHANCE / len(sums)
    x = normal("Magnetometer", 1, np.arange(65536))
    alike = normality(np.column_stack([x[:, 0], x[:, 1], (x[:, 0] + x[:, 1]) / sqrt(2)]))
    assert min(alike) < CHANCE / len(alike)
    corners = u[:, :3] * 2 - 1
    cube = sphericity(corners / np.linalg.norm(corners, axis=1)[:, None])
    assert min(cube) < CHANCE / len(cube)


def test_a_turned_sensor_turns_its_noise_not() -> None:
    """The noise is that of the body's axes: the field turned into B, then the same numbers."""
    q, field = np.array([0.6, 0.48, -0.64, 0.0]), np.array([1.0, 2.0, -3.0])
    with Component("Magnetometer", 2, {**NOISY["Magnetometer"], "q_BN": q, "magnetic_field_N": field}) as component:
        expected = rotation(q).inv().apply(field) + normal("Magnetometer", 1, 0)[0]
        np.testing.assert_allclose(component.get("magnetic_field_B_meas"), expected, rtol=1e-14)
