"""Events: the very times at which functions change their signs, times that were set, and what happens there."""

import ctypes
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

import adcs
from adcs import CoSimulation, ModelExchange, System
from fmus.build import build
from tests.mock_header import mock_header
from tests.one_fmu import Raw

VERSIONS = ("2.0", "3.0")
METHODS = (CoSimulation(), ModelExchange(), ModelExchange("CVode", rtol=1e-9))
BALL = mock_header(
    "BallAndValve",
    """\
    T time = 0.0, command = 0.0, delay = 0.3, restitution = 0.8;
    T height = 1.0, heightDot = 0.0, speed = 0.0, speedDot = 0.0, volume = 0.0, volumeDot = 0.0;
    T bounces = 0.0, first = 0.0, opens_at = never, closes_at = never, open = 0.0;
    T above = 0.0, wanted = 0.0, flow = 0.0;

    template <class V>
    void declare(V& v) {
        v.time(time);
        v.input("command", command, unit::one, "above 0.5 the valve is to open, delayed");
        v.parameter("delay", delay, unit::s, "of the valve").fixed().at_least(0);
        v.parameter("restitution", restitution, unit::one, "of the ball").fixed();
        v.state("height", height, heightDot, unit::m, "of the ball");
        v.state("speed", speed, speedDot, unit::m_per_s, "upwards");
        v.state("volume", volume, volumeDot, unit::one, "that has flowed");
        v.event("above", above, unit::m, "the ground");
        v.event("wanted", wanted, unit::one, "whether the valve is to be open");
        v.held("bounces", bounces, unit::one, "number of them").output();
        v.held("first", first, unit::one, "calls at the start").output();
        v.held("opens_at", opens_at, unit::s, "when the valve opens").wakes();
        v.held("closes_at", closes_at, unit::s, "when it closes").wakes();
        v.held("open", open, unit::one, "1: open").output();
        v.output("flow", flow, unit::one, "through the valve");
    }

    void outputs() {
        above = height;
        wanted = command - 0.5;
        flow = open;
    }

    void events(const Events& e) {
        if (e.first) first += 1.0;
        if (e.has_crossed(0) && speed < 0.0) {
            speed = -restitution * speed;
            bounces += 1.0;
        }
        if (e.has_crossed(1)) (wanted > 0.0 ? opens_at : closes_at) = time + delay;
        if (time >= opens_at) {
            open = 1.0;
            opens_at = never;
        }
        if (time >= closes_at) {
            open = 0.0;
            closes_at = never;
        }
    }

    void derivatives() {
        heightDot = speed;
        speedDot = -9.81;
        volumeDot = flow;
    }
""",
    summary="what happens at events",
    lifted=True,
)


@pytest.fixture(scope="module")
def header(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("events") / "ball_and_valve.hpp"
    path.write_text(BALL)
    build([str(path)])
    return path


def system(header: Path, **start: float) -> System:
    made = System("ball", "a ball and a valve")
    made.add("it", str(header), {"command": 0.0} | start)
    return made


def exact_height(time: np.ndarray, restitution: float = 0.8) -> tuple[np.ndarray, np.ndarray]:
    """Height and number of bounces, flight by flight."""
    g, begin, z, v, n = 9.81, 0.0, 1.0, 0.0, 0
    heights, bounces = np.empty_like(time), np.empty_like(time)
    for i, t in enumerate(time):
        while True:
            land = begin + (v + np.sqrt(v * v + 2 * g * z)) / g
            if t < land:
                break
            z, v, begin, n = 0.0, restitution * (g * (land - begin) - v), land, n + 1
        s = t - begin
        heights[i], bounces[i] = z + v * s - 0.5 * g * s * s, n
    return heights, bounces


@pytest.mark.parametrize("fmi_version", VERSIONS)
@pytest.mark.parametrize("method", METHODS)
def test_the_ball_bounces_at_the_very_times(header: Path, fmi_version: str, method: Any) -> None:
    result = adcs.run(system(header), stop_time=2.0, step=0.1, fmi_version=fmi_version, method=method)
    heights, bounces = exact_height(result.time)
    np.testing.assert_array_equal(result["it.bounces"], bounces)
    np.testing.assert_allclose(result["it.height"], heights, atol=1e-9 if method.kind != "co-simulation" else 1e-12)
    np.testing.assert_array_equal(result["it.first"], 1.0)
    assert bounces[-1] == 3


@pytest.mark.parametrize("fmi_version", VERSIONS)
@pytest.mark.parametrize("step", [0.05, 0.1, 0.4])
def test_exchange_steps_do_not_matter(header: Path, fmi_version: str, step: float) -> None:
    fine = adcs.run(system(header), stop_time=2.0, step=0.01, fmi_version=fmi_version, method=CoSimulation())
    coarse = adcs.run(system(header), stop_time=2.0, step=step, fmi_version=fmi_version, method=CoSimulation())
    every = round(step / 0.01)
    np.testing.assert_allclose(coarse["it.height"], fine["it.height"][::every], atol=1e-12)


@pytest.mark.parametrize("fmi_version", VERSIONS)
@pytest.mark.parametrize("method", METHODS)
def test_the_valve_opens_and_closes_late(header: Path, fmi_version: str, method: Any) -> None:
    changes = [adcs.at(0.2, {"it.command": 1.0}), adcs.at(1.0, {"it.command": 0.0})]
    result = adcs.run(system(header), stop_time=2.0, step=0.1, fmi_version=fmi_version, method=method, hooks=changes)
    t = result.time
    opened = (t > 0.5 - 1e-9) & (t < 1.3 - 1e-9)
    np.testing.assert_array_equal(result["it.open"], opened)
    np.testing.assert_allclose(result["it.volume"], np.clip(t - 0.5, 0, 0.8), atol=1e-9)


def test_an_event_at_the_start(header: Path) -> None:
    result = adcs.run(system(header, command=1.0), stop_time=1.0, step=0.1, method=CoSimulation())
    np.testing.assert_array_equal(result["it.open"], 0.0)  # nothing has crossed: it was wanted from the beginning


@pytest.fixture(params=[2, 3])
def raw(request: pytest.FixtureRequest, header: Path) -> Iterator[Raw]:
    with Raw(str(header), request.param) as instance:
        yield instance


def test_what_inputs_bring_about_is_tentative_until_time_moves_on(raw: Raw) -> None:
    raw.initialize(delay=0.0)
    raw.step(0.0, 0.1)
    raw.set({"command": 1.0})
    assert raw.get("open") == 1.0
    raw.set({"command": 0.0})  # never mind
    assert raw.get("open") == 0.0
    raw.set({"command": 1.0})
    raw.step(0.1, 0.1)
    raw.set({"command": 0.3})
    assert (raw.get("open"), raw.get("volume")) == (0.0, pytest.approx(0.1, abs=1e-15))


def test_saved_states_carry_what_is_pending(raw: Raw) -> None:
    raw.initialize()
    raw.step(0.0, 0.4)
    raw.set({"command": 1.0})
    raw.get("open")
    state = raw.to_bytes(raw.save())
    names = ("height", "speed", "volume", "bounces", "open", "flow")

    def go_on() -> list[float]:
        found = []
        for k in range(20):
            raw.step(0.4 + 0.1 * k, 0.1)
            found += [float(raw.get(name)[0]) for name in names]
        return found

    once = go_on()
    assert once[-2:] == [1.0, 1.0]
    raw.restore(raw.from_bytes(state))
    assert go_on() == once


def test_model_exchange_tells_states_that_jump_and_when_something_is_due(header: Path) -> None:
    for version in (2, 3):
        with Raw(str(header), version, cosim=False).initialize(height=0.0, speed=-1.0) as ball:
            defined, _ = ball.event_update()
            assert not defined
            indicators = np.empty(2)
            ball.fmu.getEventIndicators(indicators.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), 2)
            np.testing.assert_array_equal(indicators, [0.0, -0.5])
            ball.fmu.setTime(0.25)
            ball.fmu.enterEventMode()
            ball.set({"command": 1.0})
            assert ball.event_update() == (True, 0.25 + 0.3)


ENDLESS = (
    BALL.replace("BallAndValve", "Endless")
    .replace("if (e.first) first += 1.0;", "if (e.has_crossed(1)) open = 1.0 - open;")
    .replace("wanted = command - 0.5;", "wanted = command - 0.5 > 0.0 ? 1.0 - 2.0 * open : T(-1.0);")
)


def test_what_has_no_end_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "endless.hpp"
    path.write_text(ENDLESS)
    build([str(path)])
    with Raw(str(path), 3).initialize() as endless:
        endless.step(0.0, 0.1)
        endless.set({"command": 1.0})
        with pytest.raises(FMICallException):
            endless.step(0.1, 0.1)
        assert "at t = 0.1: events() comes to no end: " in endless.messages[-1][2]
        endless.set({"command": 0.0})
        endless.step(0.1, 0.1)


@pytest.mark.parametrize("version", [2, 3])
def test_what_an_event_says_is_told_once_when_it_counts(version: int) -> None:
    empty = "at t = 0.4: the tank is empty: the thrusters give no torque any more"
    with Raw("FuelLossBody", version).initialize(fuel=4.0, torque_B=[10.0, 0.0, 0.0]) as body:
        body.step(0.0, 0.3)
        assert not body.messages
        body.step(0.3, 0.5)
        assert body.get("fuel_left") == 0.0
        body.set({"torque_B": [5.0, 0.0, 0.0]})
        body.step(0.8, 0.5)
        ((status, _, text),) = body.messages
        assert (status, text.endswith(empty)) == (1, True)
