"""During a run: changes at given times, inputs from a table, conditions that end it, pace, a component that hangs."""

import subprocess
import sys
import time

import numpy as np
import pytest

import adcs
from adcs import AdcsError, CoSimulation, RunFailed, Save, Session, System, run
from adcs.catalogue import SYSTEMS
from orchestration.instances.instance import Instance
from orchestration.running.hooks.changes import Changes
from orchestration.running.parts import parts

STEPPINGS = ["compiled", "python"]
T5 = SYSTEMS["observer-pd"]


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_tunable_parameter_changes_at_its_time(version, stepping):
    common = {"stop_time": 2, "step": 0.125, "fmi_version": version, "method": CoSimulation(stepping=stepping)}
    changes = [(1.0, "controller.k_p", 4.5), (0.5, "plant.torque_disturbance_B", [0.0, 1.0, 0.0])]
    plain, changed = run(T5.build(), **common), run(T5.build(), **common, hooks=[Changes(changes)])
    same = plain.time <= 0.5  # a disturbance acts from its time on, and is seen at the next point
    assert np.array_equal(plain.data[same], changed.data[same])
    assert not np.array_equal(plain["plant.omega_BN_B"][5], changed["plant.omega_BN_B"][5])
    # the torque at t = 1 s is that of the new gain already
    at = changed.time.tolist().index(1.0)
    only_disturbed = run(T5.build(), **common, hooks=[Changes(changes[1:])])
    gained = changed["controller.torque_B"][at] - only_disturbed["controller.torque_B"][at]
    assert np.allclose(gained, -3.0 * changed["controller.q_BR"][at][1:], rtol=0, atol=1e-14)
    assert changed.manifest["settings"]["changes"] == [[1.0, "controller.k_p", 4.5], [*changes[1][:2], [0.0, 1.0, 0.0]]]
    again = run(T5.build(), **parts(changed.manifest["settings"])[0])
    assert np.array_equal(again.data, changed.data)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ((1.05, "controller.k_p", 2.0), "the change of controller.k_p at 1.05 s lies between two communication points"),
        ((9.0, "controller.k_p", 2.0), "the change of controller.k_p at 9 s lies outside the run, 0 to 2 s"),
        ((1.0, "controller.k_q", 2.0), "has no variable 'k_q': did you mean k_v or k_p?"),
        ((1.0, "controller.k_p", [1.0, 2.0]), "controller.k_p: expected a single value, got 2 values"),
        ((1.0, "controller.q_BN", [1.0, 0, 0, 0]), "controller.q_BN is connected to tracker.q_BN_meas: it cannot"),
        ((1.0, "plant.q_BN", [1.0, 0, 0, 0]), "plant.q_BN cannot be set during a run: it is a continuous output"),
    ],
)
def test_refused_changes(change, message):
    with pytest.raises(AdcsError) as error:
        run(T5.build(), stop_time=2, step=0.1, hooks=[Changes([change])])
    assert message in str(error.value)


def test_a_change_that_the_fmu_refuses_is_named_with_its_time():
    with pytest.raises(
        RunFailed, match=r"^controller failed at t = 1 s: setting k_p = -1.0 returned error: .*k_p = -1"
    ):
        run(T5.build(), stop_time=2, step=0.1, hooks=[adcs.at(1.0, {"controller.k_p": -1.0})])


@pytest.fixture
def fed(mock):
    """A gain whose input comes from outside, k = 2."""

    def build(version="2.0"):
        system = System("fed")
        system.add("gain", mock("gain", version), {"k": 2.0})
        return system

    return build


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_inputs_come_from_a_table(fed, tmp_path, version, stepping):
    table = tmp_path / "table.csv"
    table.write_text("time,gain.u[1],gain.u[3],gain.u[2]\n0.5,1,0,10\n1.5,3,0,10\n2.0,3,8,10\n")
    result = run(
        fed(version),
        stop_time=2.5,
        step=0.25,
        method=CoSimulation(stepping=stepping),
        fmi_version=version,
        hooks=[adcs.inputs(table)],
    )
    times = result.time
    assert np.array_equal(result["gain.y"][:, 0], 2 * np.interp(times, [0.5, 1.5, 2.0], [1, 3, 3]))
    assert np.array_equal(result["gain.y"][:, 1], np.full(11, 20.0))
    assert np.array_equal(result["gain.y"][:, 2], 2 * np.interp(times, [0.5, 1.5, 2.0], [0, 0, 8]))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,gain.u[1]\n0,1\n", "the first line must be `time` and the names of inputs"),
        ("", "the first line must be `time` and the names of inputs"),
        ("time;gain.u[1]\n0;1,5\n", "table.csv is separated by semicolons: separate it by commas, as in 0.5,1.25"),
        ("time,gain.v\n0,1\n", "table.csv: component 'gain' (gain.fmu) has no variable 'v'"),
        ("time,gain.y\n0,1\n", "table.csv: gain.y has 3 elements, the table has 1: give each a column, gain.y[1] and"),
        ("time,gain.y[1]\n0,1\n", "gain.y[1] is a Float64 output: values from outside go to inputs"),
        ("time,gain.u[1],gain.u[1]\n0,1,2\n", "gain.u[1] has two columns"),
        ("time,gain.u[1]\n0\n", "line 2: 1 values, the first line has 2 names, of arrays NAME[1],NAME[2],..."),
        ("time,gain.u[1]\n0,one\n", "line 2: 'one' is not a number"),
        ("time,gain.u[1]\n0,1\n0,2\n", "table.csv: times must be finite and increasing"),
        ("time,gain.u[1]\n0,nan\n", "table.csv: gain.u[1] = nan at 0 s is not finite"),
        ("time,gain.u[1]\n", "table.csv: times must be finite and increasing, and there must be at least one"),
        ("time,gain.u[1],gain.u[2]\n0,1,2\n", "input gain.u[3] is not connected"),
    ],
)
def test_refused_tables(fed, tmp_path, text, message):
    table = tmp_path / "table.csv"
    table.write_text(text)
    with pytest.raises(AdcsError) as error:
        run(fed(), stop_time=1, step=1, hooks=[adcs.inputs(table)])
    assert message in str(error.value)


def test_a_table_in_another_unit_is_refused(tmp_path):
    table = tmp_path / "table.csv"
    names = [f"plant.torque_disturbance_B[{i}][kN.m]" for i in (1, 2, 3)]
    table.write_text(f"time,{','.join(names)}\n0,1,2,3\n")
    with pytest.raises(AdcsError, match=r"plant\.torque_disturbance_B\[1\] is in 'kN\.m', expected 'N\.m'$"):
        run(T5.build(), stop_time=1, step=1, hooks=[adcs.inputs(table)])


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize(
    ("condition", "end"),
    [
        ("source.y[2] >= 3.5", 1.5),
        ("norm(source.y)>5", 1.0),
        ("max( source.y ) > 4.9", 2.0),
        ("min(source.y) > 1e3", 10.0),
        ("source.y[1] < 5", 0.0),
    ],
)
def test_a_condition_ends_the_run_at_the_first_row_that_meets_it(chain, stepping, condition, end):
    result = run(
        chain(), stop_time=10, step=0.25, method=CoSimulation(stepping=stepping), hooks=[adcs.until(condition)]
    )
    assert result.time[-1] == end
    assert np.array_equal(result["source.y"][:, 0], 1 + result.time)
    met = result.manifest["outcome"].get("met")
    assert met == (None if end == 10 else {"condition": condition, "time": end})


@pytest.mark.parametrize(
    ("condition", "message"),
    [
        ("source.y < 5", "source.y is an array, use norm(), max(), min() or one element of it"),
        ("norm(source.y) < five", "'five' at character 18 has no meaning"),
        ("norm(source.y)", "'norm(source.y)' at character 1 is no comparison"),
        ("source.x[1] < 5", "has no variable 'x[1]'"),
        ("gain.k < 5", "gain.k is not recorded, and has to be"),
    ],
)
def test_refused_conditions(chain, condition, message):
    with pytest.raises(AdcsError) as error:
        run(chain(), stop_time=1, step=1, hooks=[adcs.until(condition)])
    assert message in str(error.value)


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_pace(chain, stepping):
    began = time.perf_counter()
    paced = run(chain(), stop_time=1, step=0.1, method=CoSimulation(stepping=stepping), hooks=[adcs.pace(4.0)])
    assert time.perf_counter() - began >= 0.25
    assert np.array_equal(paced.data, run(chain(), stop_time=1, step=0.1).data)
    report = paced.manifest["real_time"]
    assert report["points"] == 11
    assert 0 <= report["late_median_s"] <= report["late_99_percent_s"] <= report["late_most_s"]


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_component_that_hangs_is_named_and_the_rows_are_kept(faulty, version, stepping):
    began = time.perf_counter()
    with pytest.raises(
        RunFailed, match=r"^wheel failed at t = 0\.5 s: doStep did not return within 0\.3 s; 3 rows are kept$"
    ) as error:
        run(faulty(version, 9), stop_time=1, step=0.25, method=CoSimulation(stepping=stepping, timeout=0.3))
    assert time.perf_counter() - began < 5
    assert error.value.result["source.y"][:, 0].tolist() == [0.0, 0.25, 0.5]


def test_a_simulation_step_by_step_that_is_changed_on_the_way():
    with Session(T5.build(), step=0.125, record=["plant.omega_BN_B"]) as simulation:
        seen = []
        for t, values in simulation:
            seen.append(values["plant.omega_BN_B"].copy())
            if t == 0.5:
                simulation.set("plant.torque_disturbance_B", [0.0, 1.0, 0.0])
            if t == 2.0:
                break
    # set after the point, it acts over the step that follows, as a change at the point does
    changes = [(0.5, "plant.torque_disturbance_B", [0.0, 1.0, 0.0])]
    expected = run(T5.build(), stop_time=2, step=0.125, hooks=[Changes(changes)])["plant.omega_BN_B"]
    assert np.array_equal(seen, expected)


def test_a_simulation_goes_back_to_a_snapshot(chain):
    refused = pytest.raises(AdcsError, match=r"^integrator \(integrator\.fmu\) cannot save its state$")
    with Session(chain(), step=0.5, steps=6) as simulation, refused:
        simulation.save()
    with Session(T5.build(), step=0.125) as simulation:
        course = iter(simulation)
        first = [next(course)[1]["plant.q_BN"].copy() for _ in range(3)]
        before = simulation.save()
        there = [next(course)[1]["plant.q_BN"].copy() for _ in range(4)]
        simulation.restore(before)
        again = iter(simulation)
        assert np.array_equal(next(again)[1]["plant.q_BN"], first[-1])
        assert np.array_equal([next(again)[1]["plant.q_BN"].copy() for _ in range(4)], there)
        simulation.free(before)


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_process_ends_well_after_it_gave_up_a_call(mock, stepping):
    """In a process of its own: what is tested for is a crash at its end."""
    faulty, source = mock("faulty"), mock("source")
    script = f"""
import time
from adcs import CoSimulation, RunFailed, System, run
system = System("late")
system.add("wheel", {str(faulty)!r}, {{"mode": 9, "from": 0.5}})
system.add("source", {str(source)!r})
try:
    run(system, stop_time=1, step=0.25, method=CoSimulation(stepping={stepping!r}, timeout=0.3))
except RunFailed as failure:
    print(failure)
time.sleep(0.2)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    assert "wheel failed at t = 0.5 s: doStep did not return within 0.3 s; 3 rows are kept" in done.stdout


def test_a_hang_while_a_change_is_made_is_named(monkeypatch):
    set_start = Instance.set_start

    def slow(self, port, values):
        if port.name == "k_p" and values == (3.0,):
            time.sleep(1.0)
        set_start(self, port, values)

    monkeypatch.setattr(Instance, "set_start", slow)
    with pytest.raises(RunFailed, match=r"^controller failed at t = 0\.5 s: setting controller\.k_p did not return"):
        run(
            T5.build(),
            stop_time=1,
            step=0.1,
            hooks=[adcs.at(0.5, {"controller.k_p": 3.0})],
            method=CoSimulation(timeout=0.3),
        )
    time.sleep(1.0)  # the call comes back, to instances that are still there


def test_an_input_from_a_table_cannot_be_changed_as_well(fed, tmp_path):
    table = tmp_path / "table.csv"
    table.write_text("time,gain.u[1],gain.u[2],gain.u[3]\n0,1,2,3\n")
    with pytest.raises(AdcsError, match=r"^gain\.u gets its values from a table: it cannot be set during a run$"):
        run(fed(), stop_time=1, step=0.5, hooks=[adcs.at(0.5, {"gain.u": [1.0, 2.0, 3.0]}), adcs.inputs(table)])


def test_the_header_of_a_result_file_of_pure_numbers_is_understood(tmp_path):
    table = tmp_path / "table.csv"
    system = System("one")
    system.add("controller", "PdTracking")
    names = [f"controller.q_BN[{i}][1]" for i in (1, 2, 3, 4)]
    table.write_text(f"time[s],{','.join(names)}\n0,1,0,0,0\n")
    rest = {"omega_BN_B": [0.0] * 3, "q_RN": [1.0, 0, 0, 0], "omega_RN_R": [0.0] * 3, "omegaDot_RN_R": [0.0] * 3}
    for name, value in rest.items():
        system.set(f"controller.{name}", value)
    result = run(system, stop_time=1, step=0.5, hooks=[adcs.inputs(table)], save=Save(["controller.q_BN"]))
    assert result["controller.q_BN"].tolist() == [[1.0, 0.0, 0.0, 0.0]] * 3


@pytest.mark.parametrize("stop", [float("nan"), float("inf"), 0.2, 0.31, -1.0])
def test_the_end_of_a_last_step_is_checked(chain, stop):
    with pytest.raises(AdcsError, match=rf"^stop_time = {stop} s: step 3 ends after 0\.2 and at 0\.3 s at the latest$"):
        Session(chain(), step=0.1, steps=3, stop_time=stop)
