"""FMUs nobody here wrote: events, clocks, early return, discarded and asynchronous steps, what an FMU may need."""

import ctypes
import re
import zipfile
from collections.abc import Callable
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path

import foreign_fmus
import numpy as np
import pytest

import adcs
from adcs import AdcsError, CoSimulation, RunFailed, Save, System, run
from orchestration.fmu.description import Clock
from orchestration.fmu.file import extracted, locate, open_fmu
from orchestration.instances.clocks import Intervals, Timer
from orchestration.instances.events import Events
from orchestration.instances.instance import CallFailed, Instance
from orchestration.instances.stepping import Stepper

STEPPINGS = ("compiled", "python")
Foreign = Callable[..., Path]


def alone(fmu, start=None):
    system = System("alone")
    system.add("c", fmu, start)
    return system


def failed(system, **settings):
    with pytest.raises(RunFailed) as error:
        run(system, **settings)
    return str(error.value), error.value.result


# Event mode without clocks


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_state_events_inside_a_step_are_where_the_fmu_found_them(foreign, stepping):
    result = run(alone(foreign("bouncer")), stop_time=1.0, step=0.25, method=CoSimulation(stepping=stepping))
    assert result["c.hits"].tolist() == [0, 0, 1, 2, 3]
    assert result["c.x"] == pytest.approx([0.0, 0.25, 0.2, 0.15, 0.1], abs=1e-15)


def test_an_event_at_a_communication_point_shows_in_its_row(foreign):
    result = run(alone(foreign("bouncer"), {"level": 0.5}), stop_time=1.0, step=0.25)
    assert result["c.hits"].tolist() == [0, 0, 1, 1, 2]
    assert result["c.x"].tolist() == [0.0, 0.25, 0.0, 0.25, 0.0]


@pytest.mark.parametrize("step", [0.25, 0.1, 1.0])
def test_time_events_are_hit_exactly(foreign, step):
    result = run(alone(foreign("bouncer"), {"level": 100.0, "period": 0.3}), stop_time=2.0, step=step)
    assert result["c.hits"][-1] == 6
    assert result["c.late"].max() < 1e-15


def test_time_events_next_to_communication_points_are_not_missed(foreign):
    rng = np.random.default_rng(3)
    for _ in range(12):
        step = 1 / rng.integers(3, 40)
        period = step * rng.integers(1, 5) * (1 + rng.choice([-1e-11, -1e-16, 0.0, 1e-16, 1e-11]))
        result = run(alone(foreign("bouncer"), {"level": 100.0, "period": period}), stop_time=40 * step, step=step)
        assert abs(result["c.hits"][-1] - 40 * step / period) < 1 + 1e-6
        assert result["c.late"].max() <= 1e-9 * step + 1e-15  # what is closer counts as the same time


def test_discrete_inputs_are_taken_in_event_mode(foreign):
    result = run(alone(foreign("latch"), {"n": 3}), stop_time=1.0, step=0.25)
    assert result["c.sum"].tolist() == [3, 6, 9, 12, 15]
    assert result["c.odd"].tolist() == [1] * 5


# Clocks


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_clocks_of_every_kind_tick_at_their_instants(foreign, stepping):
    result = run(alone(foreign("clocks"), {"u": 3.0}), stop_time=1.0, step=0.1, method=CoSimulation(stepping=stepping))
    instants = {
        "steady": [0.1, 0.35, 0.6, 0.85],  # interval 0.25 after a shift of 0.1
        "third": [0.0, 1 / 3, 2 / 3, 1.0],  # a fraction: the third tick is at 1, not beside it
        "given": [0.0, 0.5, 1.0],
        "asked": [0.0, 0.2, 0.4, 0.6, 0.8, 1.0],
        "growing": [0.1, 0.3, 0.6, 1.0],
        "alarm": [0.67],  # 0.07 after the third tick of `steady`
    }
    for clock, ticks in instants.items():
        expected = [sum(t <= k * 0.1 + 1e-12 for t in ticks) for k in range(11)]
        assert result[f"c.{clock}_n"].tolist() == expected, clock
    last = [max([0.0, *(t for t in instants["steady"] if t <= k * 0.1 + 1e-12)]) for k in range(11)]
    assert result["c.last"] == pytest.approx(last, abs=1e-15)
    assert result["c.sampled"].tolist() == [0.0] + [3.0] * 10
    assert set(result["c.told"]) == {0.5}


def test_ticks_do_not_depend_on_the_communication_step(foreign):
    names = [f"c.{clock}_n" for clock in ("steady", "third", "given", "asked", "growing", "alarm")]
    fine = run(alone(foreign("clocks"), {"u": 0.0}), stop_time=3.0, step=0.01, save=Save(names))
    coarse = run(alone(foreign("clocks"), {"u": 0.0}), stop_time=3.0, step=0.5, save=Save(names))
    assert np.array_equal(fine.data[::50], coarse.data)


def test_a_clocked_component_hands_on_what_it_computes_from_the_values_of_this_point(foreign):
    system = alone(foreign("clocks"))
    system.add("source", foreign("short"))
    system.connect("source.x", "c.u")
    result = run(system, stop_time=1.0, step=0.05, save=Save(["c.sampled", "source.x", "c.steady_n"]))
    x, sampled, n = result["source.x"], result["c.sampled"], result["c.steady_n"]
    assert n[[1, 2, 6, 7, 12, 17]].tolist() == [0, 1, 1, 2, 3, 4]
    for k in (2, 7, 12, 17):  # 0.1, 0.35, 0.6, 0.85 s
        assert sampled[k] == x[k] == sampled[k + 1]


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_an_output_clock_triggers_another_component_at_once(foreign, stepping):
    system = System("chain")
    system.add("listener", foreign("listener"))
    system.add("counter", foreign("counter"))
    system.connect("counter.every_third", "listener.heard")
    system.connect("counter.count", "listener.u")
    result = run(system, stop_time=1.0, step=0.1, method=CoSimulation(stepping=stepping))
    assert result["counter.count"].tolist() == list(range(1, 12))
    assert result["counter.every_third"].tolist() == [(k + 1) % 3 == 0 for k in range(11)]
    assert result["counter.held"].tolist() == [(k + 1) // 3 * 3 for k in range(11)]
    assert result["listener.times"].tolist() == [(k + 1) // 3 for k in range(11)]
    assert result["listener.twice"].tolist() == [2 * ((k + 1) // 3 * 3) for k in range(11)]


def test_a_trigger_inside_a_step_arrives_at_its_end(foreign):
    system = System("chain")
    system.add("listener", foreign("listener"), {"u": 1.0})
    system.add("counter", foreign("counter"))
    system.connect("counter.every_third", "listener.heard")
    result = run(system, stop_time=1.0, step=0.25)  # ticks at 0.2, 0.5 and 0.8 s
    assert result["counter.every_third"].tolist() == [0, 1, 1, 0, 1]
    assert result["listener.times"].tolist() == [0, 1, 2, 2, 3]


def test_a_trigger_that_nothing_gives_is_refused_by_name(foreign):
    system = System("deaf")
    system.add("listener", foreign("listener"), {"u": 1.0})
    with pytest.raises(AdcsError, match=r"^input listener\.heard is not connected: connect it or give it a start va"):
        run(system, stop_time=1.0, step=0.1)
    system.set("listener.heard", False)
    assert run(system, stop_time=1.0, step=0.1)["listener.times"].tolist() == [0] * 11


def test_a_clock_inside_a_step_of_an_fmu_that_has_one_step_size_only(foreign):
    fmu = foreign("rigid_clock")
    assert run(alone(fmu), stop_time=1.0, step=0.25)["c.steady_n"].tolist() == [1, 2, 3, 4, 5]
    text, result = failed(alone(fmu), stop_time=1.0, step=0.1)
    assert text == (
        "c failed at t = 0.2 s: clock steady is due at t = 0.25 s, inside a communication step, and the FMU cannot "
        "take steps of different sizes: choose a step that ends there; 3 rows are kept"
    )
    assert len(result.time) == 3


def test_clocks_are_refused_where_they_cannot_be_ticked(foreign):
    system = alone(foreign("counter", name="deaf_counter", hasEventMode=None))
    with pytest.raises(AdcsError, match=r"^c \(deaf_counter\.fmi3\.fmu\) has clocks \(tick, every_third\), which are"):
        run(system, stop_time=1.0, step=0.1)


def test_the_fmus_of_these_tests_notice_what_is_out_of_place(foreign):
    with opened(foreign("counter")) as instance:
        instance.do_step(0.0, 0.05)
        with pytest.raises(CallFailed, match="fmi3SetClock in step mode"):
            instance.call("ticking", "setClock", [0], [True])
        with pytest.raises(CallFailed, match="fmi3EnterStepMode in step mode"):
            instance.call("going on", "enterStepMode")
        with pytest.raises(CallFailed, match="the step does not begin where the one before ended"):
            instance.call("stepping", "doStep", 0.5, 0.1)
        real = instance.handle.dll.fmi3GetInt32
        place = (ctypes.c_uint * 1)(*instance.fmu.ports["count"].references)
        assert real(ctypes.c_void_p(instance.handle.component), place, 1, (ctypes.c_int32 * 1)(), 1) == 3
        assert "while its clock is not active" in instance.last_message


# Saved states


@contextmanager
def opened(path, start=None):
    fmu = open_fmu(path)
    with extracted(fmu, "co-simulation") as places:
        instance = Instance("c", fmu, "co-simulation", *places)
        for name, value in (start or {}).items():
            instance.set_start(fmu.ports[name], [value])
        instance.enter_initialization(0.0, 10.0)
        instance.exit_initialization()
        yield instance
        instance.close(healthy=True)


def value(instance, name):
    port = instance.fmu.ports[name]
    return instance.get(port.references, port.size, type=port.type)


@pytest.mark.parametrize(
    ("model", "names"), [("clocks", ["steady_n", "growing_n", "alarm_n", "last"]), ("bouncer", ["x", "hits"])]
)
def test_a_saved_state_holds_clocks_and_events_too(foreign, model, names):
    def go_on(instance):
        seen = []
        for k in range(6, 12):
            instance.do_step(k * 0.1, 0.1)
            seen.append([value(instance, name) for name in names])
        return seen

    with opened(foreign(model)) as one, opened(foreign(model)) as other:
        assert one.special
        for k in range(6):
            one.do_step(k * 0.1, 0.1)
        state = one.save()
        content = one.serialize(state)
        first = go_on(one)
        one.restore(state)
        assert go_on(one) == first
        one.free(state)
        state = other.deserialize(content)
        other.restore(state)
        assert go_on(other) == first
        other.free(state)


@pytest.mark.parametrize(("model", "start"), [("clocks", {"u": 2.0}), ("bouncer", None), ("picky", {"u": 1.0})])
def test_a_checkpoint_is_gone_on_from_to_the_last_bit(foreign, tmp_path, model, start):
    file = tmp_path / "half.checkpoint"
    settings = {"step": 0.05}
    whole = run(alone(foreign(model), start), stop_time=1.0, **settings)
    run(alone(foreign(model), start), stop_time=0.6, hooks=[adcs.checkpoint(file)], **settings)
    rest = run(alone(foreign(model), start), stop_time=1.0, resume=file, **settings)
    assert rest.time[0] == pytest.approx(0.6)
    assert np.array_equal(rest.data, whole.data[-len(rest.data) :])


# Early return, discarded steps, asynchronous steps


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_step_returned_from_early_is_gone_on_with(foreign, stepping):
    result = run(alone(foreign("short")), stop_time=1.0, step=0.1, method=CoSimulation(stepping=stepping))
    assert result["c.steps"].tolist() == [3 * k for k in range(11)]  # 0.04 + 0.04 + 0.02
    assert result["c.x"] == pytest.approx(0.1 * np.arange(11), abs=1e-14)
    assert result["c.asked"].max() == 0  # the answer to intermediate updates is to go on


def test_a_step_that_does_not_get_on(foreign):
    text, result = failed(alone(foreign("short"), {"stuck": 0.5}), stop_time=1.0, step=0.1)
    assert text == (
        "c failed at t = 0.5 s: doStep does not get beyond t = 0.5 s: it returned early 100 times; 6 rows are kept"
    )
    assert result["c.x"][-1] == pytest.approx(0.5)


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_discarded_steps_are_taken_in_smaller_ones_from_the_saved_state(foreign, version, stepping):
    result = run(
        alone(foreign("picky", version), {"u": 1.0}), stop_time=1.0, step=0.1, method=CoSimulation(stepping=stepping)
    )
    assert result["c.steps"].tolist() == [4 * k for k in range(11)]  # of 0.025
    assert result["c.x"] == pytest.approx(0.1 * np.arange(11), abs=1e-14)  # nothing is left of what was discarded
    assert result.manifest["warnings"] == [
        "c: doStep discarded the step from t = 0 s, it was taken in smaller ones; so were 9 later ones"
    ]


def test_small_steps_are_not_discarded(foreign, version):
    result = run(alone(foreign("picky", version), {"u": 1.0}), stop_time=0.3, step=0.03)
    assert result["c.steps"].tolist() == list(range(11))
    assert result.manifest["warnings"] == []


def test_a_step_that_is_discarded_at_any_size(foreign, version):
    text, _ = failed(alone(foreign("picky", version), {"u": 1.0, "longest": 1e-9}), stop_time=1.0, step=0.1)
    got = ", having got to t = 1e-09 s" if version == "2.0" else ""
    assert text == (
        f"c failed at t = 0 s: doStep returned discard, even in steps of 2.44e-05 s{got}: the step is too long; "
        "1 rows are kept"
    )


def test_a_discarded_step_of_an_fmi_2_fmu_that_cannot_save_its_state(foreign):
    system = alone(foreign("picky", "2.0", name="bare", canGetAndSetFMUstate=None), {"u": 1.0})
    text, _ = failed(system, stop_time=1.0, step=0.1)
    assert text == (
        "c failed at t = 0 s: doStep returned discard, having got to t = 0.03 s: the step is too long; 1 rows are kept"
    )


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_an_fmi_3_fmu_needs_no_saved_state_for_a_discarded_step(foreign, stepping):
    """The standard promises that it is as before, so the compiled loop steps it, and Python only what is discarded."""
    fmu = foreign("picky", name="bare", canGetAndSetFMUState=None)
    system = alone(fmu, {"u": 1.0})
    with opened(fmu) as instance:
        assert not instance.special
    result = run(system, stop_time=1.0, step=0.1, method=CoSimulation(stepping=stepping))
    assert result["c.steps"].tolist() == [4 * k for k in range(11)]
    assert result["c.x"] == pytest.approx(0.1 * np.arange(11), abs=1e-14)
    assert result.manifest["warnings"] == [
        "c: doStep discarded the step from t = 0 s, it was taken in smaller ones; so were 9 later ones"
    ]


def test_a_state_that_cannot_be_saved_though_it_is_said_ends_no_run_that_had_no_use_for_it(foreign):
    """Without the way back a discarded step is what it is without the promise."""
    fmu = foreign("picky", "2.0")
    start = {"u": 1.0, "unsavable": 1.0}
    result = run(alone(fmu, start), stop_time=0.3, step=0.03)
    assert result["c.steps"].tolist() == list(range(11))
    (warning,) = result.manifest["warnings"]
    assert warning == (
        "c: saving the state returned error: there is no memory for it (at t = 0 s); a step that it discards is not "
        "taken in smaller ones"
    )
    text, _ = failed(alone(fmu, start), stop_time=1.0, step=0.1)
    assert text.startswith(
        "c failed at t = 0 s: doStep returned discard, having got to t = 0.03 s: the step is too long"
    )
    with pytest.raises(RunFailed, match="saving the state returned error: there is no memory for it"):
        run(alone(fmu, start), stop_time=1.0, step=0.1, method=CoSimulation(adaptive=1e-3))  # which cannot do without


def test_an_fmu_that_ends_the_simulation(foreign, version):
    result = run(alone(foreign("picky", version), {"u": 1.0, "stop": 0.5}), stop_time=1.0, step=0.1)
    ended = result.manifest["outcome"]["ended"]
    assert (ended["component"], ended["time"]) == ("c", pytest.approx(0.5))
    assert len(result.time) == 6


def test_asynchronous_steps_are_waited_for(foreign):
    result = run(alone(foreign("lazy", "2.0")), stop_time=1.0, step=0.1)
    assert result["c.steps"].tolist() == list(range(11))


def test_asynchronous_steps_that_were_not_announced(foreign):
    text, _ = failed(alone(foreign("lazy", "2.0", name="sly", canRunAsynchronuously=None)), stop_time=1.0, step=0.1)
    assert text == (
        "c failed at t = 0 s: doStep returned pending, though it does not declare canRunAsynchronuously: the FMU gave "
        "no message; 1 rows are kept"
    )


# Mistakes that the tests above would notice


def test_ticks_that_are_added_up_would_be_seen():
    third = Clock("c", 0, "input", "constant", Fraction(1, 3), Fraction(0), fractional=True)
    tenth = Clock("c", 0, "input", "constant", 0.1, 0.0, fractional=False)
    for clock, exact in ((third, 1e6), (tenth, 3e6 * 0.1)):
        timer = Timer(clock, 0.0, clock.shift, clock.interval, count=3_000_000)
        assert timer.next == exact
        added = np.add.accumulate(np.full(3_000_000, float(clock.interval)))[-1]
        assert abs(added - exact) > 1e-6


def test_going_on_from_a_discarded_step_would_be_seen(foreign, monkeypatch):
    monkeypatch.setattr("fmpy.fmi2._FMU2.setFMUState", lambda self, state: None)
    result = run(alone(foreign("picky", "2.0"), {"u": 1.0}), stop_time=1.0, step=0.1)
    assert result["c.x"][-1] > 1.5


def test_taking_an_early_return_for_the_end_would_be_seen(foreign, monkeypatch):
    do_step = Stepper._do_step
    monkeypatch.setattr(Stepper, "_do_step", lambda self, t, h: (do_step(self, t, h)[0], False, t + h))
    with pytest.raises(RunFailed, match="the step does not begin where the one before ended"):
        run(alone(foreign("short")), stop_time=1.0, step=0.1)


def test_handling_events_a_point_late_would_be_seen(foreign, monkeypatch):
    monkeypatch.setattr(Events, "_wait", lambda self, time, resolution: self._leave())
    result = run(alone(foreign("counter")), stop_time=1.0, step=0.1)
    assert result["c.count"].tolist() != list(range(1, 12))


# What is not special stays so


def test_plain_fmus_are_stepped_by_the_compiled_loop(mock, version):
    for path in (mock("integrator", version), mock("typed", version)):
        with opened(path) as instance:
            assert not instance.special
    for name in ("RigidBody", "PdTracking", "StarTracker"):  # can save their state, and never discard a step
        path = locate(name, version)
        with opened(path) as instance:
            assert instance.can_save
            assert not instance.special


# What an FMU may need


def test_resources_are_there(foreign, version):
    assert run(alone(foreign("reader", version)), stop_time=1.0, step=1.0)["c.number"].tolist() == [42, 42]


def test_one_instance_per_library(foreign, version):
    system = System("two")
    system.add("one", foreign("single", version))
    system.add("two", foreign("single", version))
    result = run(system, stop_time=1.0, step=1.0)
    assert result["one.instances"][0] == result["two.instances"][0] == 1


def test_an_execution_tool_that_is_missing_is_named(foreign, version):
    file = "tool.fmu" if version == "2.0" else "tool.fmi3.fmu"
    message = f"^c: cannot instantiate {re.escape(file)}: no licence; it needs the tool that made it, Quirk Tool 1$"
    with pytest.raises(AdcsError, match=message):
        run(alone(foreign("tool", version)), stop_time=1.0, step=1.0)


def test_scheduled_execution_is_refused_by_name(foreign, tmp_path):
    path = foreign_fmus.changed(foreign("counter"), tmp_path / "se.fmu", "<CoSimulation ", "<ScheduledExecution ")
    path = foreign_fmus.changed(path, tmp_path / "scheduled.fmu", ' hasEventMode="true"', "")
    path = foreign_fmus.changed(path, tmp_path / "se_only.fmu", ' canHandleVariableCommunicationStepSize="true"', "")
    with pytest.raises(AdcsError, match=r"^se_only\.fmu has scheduled execution only, which is not supported"):
        run(alone(path), stop_time=1.0, step=1.0)


def test_fmi_1_is_refused_by_name(tmp_path):
    path = tmp_path / "old.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(
            "modelDescription.xml",
            '<fmiModelDescription fmiVersion="1.0" modelName="old" modelIdentifier="old" guid="{1}" '
            'numberOfContinuousStates="0" numberOfEventIndicators="0"/>',
        )
    with pytest.raises(AdcsError, match=r"old\.fmu is FMI 1\.0: only 2\.0 and 3\.0 are supported"):
        open_fmu(path)


def test_a_start_value_of_the_wrong_length_is_refused(foreign, tmp_path):
    path = foreign_fmus.changed(foreign("sizes"), tmp_path / "short.fmu", 'start="1.0 2.0 3.0"', 'start="1.0 2.0"')
    with pytest.raises(
        AdcsError, match=r"short\.fmu is not valid: the start value of u has 2 elements, the variable 3$"
    ):
        open_fmu(path)


def test_descriptions_that_fmpy_does_not_read_are_read(foreign, tmp_path):
    clock = '<Clock name="tick" valueReference="0"'
    path = foreign_fmus.changed(foreign("counter"), tmp_path / "a.fmu", clock, f'{clock} declaredType="Beat"')
    types = '<TypeDefinitions><ClockType name="Beat" intervalVariability="constant"/>'
    path = foreign_fmus.changed(path, tmp_path / "b.fmu", "<TypeDefinitions>", types)
    path = foreign_fmus.changed(path, tmp_path / "c.fmu", 'clocks="0"', 'clocks=" 0  "')
    assert run(alone(path), stop_time=0.2, step=0.1)["c.count"].tolist() == [1, 2, 3]


def test_a_clock_ticks_at_the_interval_of_its_declared_type(foreign, tmp_path):
    fmu = foreign("rigid_clock")
    path = foreign_fmus.changed(fmu, tmp_path / "a.fmu", ' intervalDecimal="0.25"', ' declaredType="Steady"')
    with pytest.raises(
        AdcsError, match=r"is not valid: steady \(line \d+\): declaredType refers to 'Steady', which TypeDef"
    ):
        open_fmu(path)
    types = '<TypeDefinitions><ClockType name="Steady" intervalVariability="constant" intervalDecimal="0.25"/>'
    path = foreign_fmus.changed(path, tmp_path / "b.fmu", "<TypeDefinitions>", types)
    assert run(alone(path), stop_time=1.0, step=0.25)["c.steady_n"].tolist() == [1, 2, 3, 4, 5]


def test_time_based_clocks_are_not_for_users_to_tick(foreign):
    with pytest.raises(
        AdcsError, match=r"^c\.tick cannot be given a start value: it is a time-based clock, which ticks by itself$"
    ):
        alone(foreign("counter"), {"tick": True})


def test_a_negative_interval_is_refused_by_name(foreign):
    with pytest.raises(CallFailed, match=r"^c: the interval of clock asked is 0\.0 s: expected a positive time$"):
        run(alone(foreign("clocks"), {"u": 0.0, "period": 0.0}), stop_time=1.0, step=0.1)


@pytest.mark.parametrize("wrong", [float("nan"), float("-inf"), -0.5])
@pytest.mark.parametrize("kind", ["fixed", "changing", "countdown"])
def test_intervals_that_are_no_times_are_refused(kind, wrong):
    def call(action, method, references, *results):
        results[0][0] = wrong if method == "getIntervalDecimal" else 0.0
        if method == "getIntervalDecimal":
            results[1][0] = 2  # changed

    intervals = Intervals(call, lambda text: CallFailed("c", text))
    clock = Clock("tick", 1, "input", kind, None, 0.0, fractional=False)
    with pytest.raises(CallFailed, match=rf"^c: the interval of clock tick is {wrong} s: expected a positive time$"):
        intervals.begin(clock, 0.0)
