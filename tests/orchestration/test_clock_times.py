"""Intervals and shifts of clocks that are no times are refused by name, whenever they come."""

from fractions import Fraction
from pathlib import Path

import foreign_fmus
import pytest

import adcs
from adcs import AdcsError, CoSimulation, RunFailed, System, run
from orchestration.fmu.description import Clock
from orchestration.instances.clocks import Intervals, Timer
from orchestration.instances.instance import CallFailed
from orchestration.running.method import method_of

RETUNED, CHANGED, COUNTED = 1, 2, 3
WRONG = {"nan": 1, "inf": 2, "-1.0": 3}
STEPPINGS = ["compiled", "python"]


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("clocks")


def alone(fmu, **start):
    system = System("alone")
    system.add("c", fmu, start)
    return system


def clock(kind, *, fractional=False):
    return Clock("tick", 1, "input", kind, None, 0.0, fractional=fractional)


def asked(interval, shift, resolution=1):
    """Answer as an FMU that says these numbers; fractions are counter and resolution."""

    def call(action, method, references, *results):
        results[0][0] = interval if "Interval" in method else shift
        if method.endswith("Fraction"):
            results[1][0] = resolution
        if "Interval" in method:
            results[-1][0] = 2  # changed

    return Intervals(call, lambda text: CallFailed("c", text))


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_good_intervals_tick(folder, stepping):
    fmu = foreign_fmus.build("eager", folder, "3.0")
    assert run(alone(fmu), stop_time=0.5, step=0.1, method=CoSimulation(stepping=stepping))["c.ticks"].tolist() == [
        0,
        1,
        2,
        3,
        4,
        5,
    ]


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("number", WRONG)
@pytest.mark.parametrize(("which", "name"), [(RETUNED, "retuned"), (CHANGED, "changed"), (COUNTED, "counted")])
def test_intervals_that_become_wrong_on_the_way(folder, stepping, number, which, name):
    """With an infinite one a clock would never tick again, without a word."""
    fmu = foreign_fmus.build("eager", folder, "3.0")
    with pytest.raises(RunFailed) as error:
        run(
            alone(fmu, which=which, wrong=WRONG[number]),
            stop_time=1.0,
            step=0.1,
            method=CoSimulation(stepping=stepping),
        )
    text = f"c failed at t = 0.2 s: the interval of clock {name} is {number} s: expected a positive time"
    assert str(error.value) == f"{text}; 3 rows are kept"


@pytest.mark.parametrize("wrong", [float("nan"), float("inf"), float("-inf"), -0.5])
@pytest.mark.parametrize("kind", ["fixed", "tunable", "changing", "countdown"])
def test_intervals_that_are_wrong_from_the_start(kind, wrong):
    with pytest.raises(CallFailed, match=rf"^c: the interval of clock tick is {wrong} s: expected a positive time$"):
        asked(wrong, 0.0).begin(clock(kind), 0.0)


@pytest.mark.parametrize("kind", ["changing", "countdown"])
def test_an_aperiodic_clock_may_tick_at_once(kind):
    assert asked(0.0, 0.0).begin(clock(kind), 2.0).next == 2.0
    timer = Timer(clock(kind), 0.0, interval=1.0)
    asked(0.0, 0.0).update(timer, 3.0, ticked=True)
    assert timer.next == 3.0


@pytest.mark.parametrize("kind", ["fixed", "tunable"])
def test_a_periodic_clock_may_not(kind):
    with pytest.raises(CallFailed, match=r"^c: the interval of clock tick is 0\.0 s: expected a positive time$"):
        asked(0.0, 0.0).begin(clock(kind), 2.0)


@pytest.mark.parametrize("wrong", [float("nan"), float("inf"), float("-inf"), -0.5])
@pytest.mark.parametrize("kind", ["fixed", "tunable"])
def test_shifts_that_are_no_times(kind, wrong):
    with pytest.raises(CallFailed, match=rf"^c: the shift of clock tick is {wrong} s: expected a time from 0$"):
        asked(0.1, wrong).begin(clock(kind), 0.0)


@pytest.mark.parametrize("kind", ["fixed", "tunable", "changing", "countdown"])
def test_fractions_of_nothing(kind):
    with pytest.raises(CallFailed, match=r"^c: the interval of clock tick is 3/0 s: expected a resolution from 1$"):
        asked(3, 0, resolution=0).begin(clock(kind, fractional=True), 0.0)
    assert asked(3, 0, resolution=4).begin(clock(kind, fractional=True), 0.0).interval == Fraction(3, 4)


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_clock_that_ticks_again_and_again_is_named(folder, stepping):
    fmu = foreign_fmus.build("eager", folder, "3.0")
    with pytest.raises(RunFailed) as error:
        run(alone(fmu, which=CHANGED, wrong=4), stop_time=1.0, step=0.1, method=CoSimulation(stepping=stepping))
    assert str(error.value).startswith(
        "c failed at t = 0.2 s: the event at t = 0.2 s does not settle in 100 iterations: clock changed ticks again "
        "and again at this time, its interval is too short"
    )


def test_time_based_clocks_are_called_what_they_are(folder):
    """Whoever wants to connect, set or feed one learns that it needs nobody."""
    counter, listener = (foreign_fmus.build(name, folder, "3.0") for name in ("counter", "listener"))
    system = System("pair")
    system.add("c", counter)
    system.add("d", listener, {"u": 0.0})
    what = "a time-based clock, which ticks by itself"
    with pytest.raises(AdcsError, match=rf"^cannot connect d\.times to c\.tick: c\.tick is not an input but {what}$"):
        system.connect("d.times", "c.tick")
    with pytest.raises(AdcsError, match=rf"^cannot connect c\.tick to d\.heard: c\.tick is not an output but {what}$"):
        system.connect("c.tick", "d.heard")
    system.connect("c.every_third", "d.heard")
    with pytest.raises(AdcsError, match=rf"^c\.tick is {what}: values from outside go to inputs$"):
        system.check(["c.tick"])
    with pytest.raises(AdcsError, match=rf"^c\.tick cannot be set during a run: it is {what}, only inputs and"):
        run(system, stop_time=1.0, step=0.1, hooks=[adcs.at(0.5, {"c.tick": True})])


def test_what_helps_an_fmu_with_clocks_depends_on_what_it_has(folder):
    """Neither method may recommend the other where none works."""
    good = foreign_fmus.build("counter", folder, "3.0")
    deaf = foreign_fmus.build("counter", folder, "3.0", name="deaf", hasEventMode=None)
    only = "which are supported in co-simulation with event mode only"
    cases = {
        (
            "co-simulation",
            deaf,
        ): f"c (deaf.fmi3.fmu) has clocks (tick, every_third), {only}: it has none, export it with",
        (
            "model-exchange",
            deaf,
        ): f"c (deaf.fmi3.fmu) has clocks (tick, every_third), {only}: it has none, export it with",
        ("model-exchange", good): f"c (counter.fmi3.fmu) has clocks (tick, every_third), {only}: run the system with "
        "method 'co-simulation'",
    }
    for (method, fmu), text in cases.items():
        with pytest.raises(AdcsError) as error:
            run(
                alone(fmu),
                stop_time=1.0,
                step=0.1,
                method=method_of(method),
            )
        assert str(error.value).startswith(text)


def test_a_clocked_fmu_of_model_exchange_alone(folder, tmp_path):
    fmu = foreign_fmus.changed(
        foreign_fmus.build("counter", folder, "3.0"), tmp_path / "me.fmu", "<CoSimulation", "<ModelExchange"
    )
    fmu = foreign_fmus.changed(fmu, tmp_path / "me2.fmu", ' canHandleVariableCommunicationStepSize="true"', "")
    fmu = foreign_fmus.changed(fmu, tmp_path / "me3.fmu", ' hasEventMode="true"', "")
    for method in ("co-simulation", "model-exchange"):
        with pytest.raises(AdcsError, match=r"has clocks \(tick, every_third\), which .*: it has none, export it with"):
            run(
                alone(fmu),
                stop_time=1.0,
                step=0.1,
                method=method_of(method),
            )
