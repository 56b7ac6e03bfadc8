"""Clocks, what they sample, and outputs that are held between their instants."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import adcs
from adcs import CoSimulation, ModelExchange, System
from fmus.build import build
from tests.mock_header import mock_header
from tests.one_fmu import Raw

VERSIONS = ("2.0", "3.0")
CLOCKED = mock_header(
    "TwoClocks",
    """\
    T time = 0.0, u = 0.0, fast_period = 0.1, slow_period = 0.25, slow_offset = 0.05;
    T count = 0.0, started = -1.0, memory = 0.0, slow_time = 0.0;
    T seen = 0.0, passing = 0.0, seen_slowly = 0.0, area = 0.0, areaDot = 0.0;

    template <class V>
    void declare(V& v) {
        v.time(time);
        v.input("u", u, unit::one, "signal");
        v.parameter("fast_period", fast_period, unit::s, "period of the first clock").fixed().at_least(0);
        v.parameter("slow_period", slow_period, unit::s, "period of the second").fixed().at_least(0);
        v.parameter("slow_offset", slow_offset, unit::s, "its offset").fixed();
        v.sampled(fast_period);
        v.sampled(slow_period, slow_offset);
        v.held("count", count, unit::one, "index of the sample").output();
        v.held("started", started, unit::one, "index of the first one").output();
        v.held("memory", memory, unit::one, "sum of what was seen before");
        v.held("slow_time", slow_time, unit::s, "time of the second clock's sample").output();
        v.output("seen", seen, unit::one, "signal and memory").sampled();
        v.output("seen_slowly", seen_slowly, unit::one, "signal").sampled(1).nominal(2.0);
        v.output("passing", passing, unit::one, "signal, now");
        v.state("area", area, areaDot, unit::one, "integral of what is seen");
    }

    void sample(const Sample& s) {
        if (s.clock == 1) {
            slow_time = time;
            return;
        }
        count = static_cast<double>(s.k);
        if (s.first) started = count;
        memory += u;
    }

    void outputs() {
        seen = u + 10.0 * memory;
        passing = seen_slowly = u;
    }

    void derivatives() { areaDot = seen; }
""",
    summary="what two clocks sample",
    lifted=True,
)


@pytest.fixture(scope="module")
def header(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("clocks") / "two_clocks.hpp"
    path.write_text(CLOCKED)
    return path


def clocked(header: Path, **parameters: float) -> System:
    system = System("clocks", "a ramp, sampled")
    system.add("it", str(header), {"u": 1.0} | parameters)
    return system


def ramp(system: System, folder: Path, **how: Any) -> adcs.Result:
    """u = t."""
    table = folder / "ramp.csv"
    table.write_text("time [s],it.u\n0,0\n10,10\n")
    return adcs.run(system, hooks=[adcs.inputs(table)], **how)


def expected(time: np.ndarray, period: float, offset: float = 0.0) -> np.ndarray:
    """Index of the latest instant."""
    return np.floor((time - offset) / period + 1e-9)


@pytest.mark.parametrize("fmi_version", VERSIONS)
@pytest.mark.parametrize("step", [0.05, 0.1, 0.25, 0.4])
def test_each_clock_has_its_own_instants_also_within_a_step(header: Path, fmi_version: str, step: float) -> None:
    result = adcs.run(clocked(header), stop_time=2.0, step=step, fmi_version=fmi_version, method=CoSimulation())
    k = expected(result.time, 0.1)
    np.testing.assert_array_equal(result["it.count"], k)
    np.testing.assert_array_equal(result["it.started"], 0)
    slow = expected(result.time, 0.25, 0.05)
    np.testing.assert_allclose(result["it.slow_time"], np.where(slow < 0, 0, 0.05 + 0.25 * slow), atol=1e-12)


@pytest.mark.parametrize("fmi_version", VERSIONS)
@pytest.mark.parametrize("method", [CoSimulation(), ModelExchange(), ModelExchange("CVode")])
def test_sampled_outputs_are_held_and_others_are_not(
    header: Path, fmi_version: str, method: CoSimulation | ModelExchange
) -> None:
    result = ramp(clocked(header), header.parent, stop_time=2.0, step=0.05, fmi_version=fmi_version, method=method)
    k = expected(result.time, 0.1)
    seen = 0.1 * k + 10 * 0.1 * k * (k + 1) / 2  # u, and ten times the sum of u up to now
    np.testing.assert_allclose(result["it.seen"], seen, atol=1e-9)
    np.testing.assert_allclose(result["it.passing"], result.time, atol=1e-12)
    slow = expected(result.time, 0.25, 0.05)
    at = np.where(slow < 0, 0.0, 0.05 + 0.25 * slow)
    if isinstance(method, ModelExchange):
        np.testing.assert_allclose(result["it.seen_slowly"], at, atol=1e-9)
    area = np.concatenate([[0], np.cumsum(seen[:-1] * 0.05)])
    np.testing.assert_allclose(result["it.area"], area, atol=1e-9)


@pytest.mark.parametrize("fmi_version", VERSIONS)
def test_a_period_of_zero_makes_an_output_continuous(header: Path, fmi_version: str) -> None:
    system = clocked(header, fast_period=0.0)
    result = ramp(system, header.parent, stop_time=1.0, step=0.05, fmi_version=fmi_version, method=CoSimulation())
    np.testing.assert_allclose(result["it.seen"], result.time, atol=1e-12)
    np.testing.assert_array_equal(result["it.started"], -1)
    slow = expected(result.time, 0.25, 0.05)
    np.testing.assert_allclose(result["it.seen_slowly"], np.where(slow < 0, 0.0, 0.05 + 0.25 * slow), atol=1e-9)


def test_the_first_sample_of_a_later_start_is_the_earlier_instants(header: Path) -> None:
    result = adcs.run(clocked(header), start_time=0.37, stop_time=1.0, step=0.01, method=CoSimulation())
    np.testing.assert_array_equal(result["it.started"], 3)
    np.testing.assert_array_equal(result["it.count"], expected(result.time, 0.1))


@pytest.fixture(params=[2, 3])
def raw(request: pytest.FixtureRequest, header: Path) -> Iterator[Raw]:
    build([str(header)])
    with Raw(str(header), request.param) as instance:
        yield instance


def test_a_repeated_sample_is_the_same_and_the_first_stays_the_first(raw: Raw) -> None:
    raw.initialize(u=1.0)
    assert raw.get("seen") == 11.0
    raw.set({"u": 2.0})  # at the same instant: the same sample, of another value
    assert (raw.get("seen"), raw.get("started")) == (22.0, 0.0)
    raw.step(0.0, 0.05)
    raw.set({"u": 5.0})
    assert (raw.get("seen"), raw.get("passing")) == (22.0, 5.0)
    raw.step(0.05, 0.05)
    assert (raw.get("seen"), raw.get("started"), raw.get("count")) == (75.0, 0.0, 1.0)


def test_saved_states_carry_clocks_and_held_outputs(raw: Raw) -> None:
    raw.initialize(u=1.0)
    raw.step(0.0, 0.13)
    raw.set({"u": 3.0})
    state = raw.to_bytes(raw.save())
    names = ("seen", "seen_slowly", "passing", "area", "count", "started", "slow_time")

    def go_on() -> list[float]:
        found = [float(raw.get(name)[0]) for name in names]
        for k in range(20):
            raw.step(0.13 + 0.07 * k, 0.07)
            found += [float(raw.get(name)[0]) for name in names]
        return found

    once = go_on()
    raw.restore(raw.from_bytes(state))
    assert go_on() == once
