"""Parts of a run go together: several of a kind, all kinds at once, the same again; and a manifest has them all."""

import json

import numpy as np
import pytest

import adcs
from adcs import AdcsError, CoSimulation, Hook, ModelExchange, Save, rerun, run

TIMES = {"stop_time": "1s", "step": "10ms"}
METHODS = [CoSimulation(), CoSimulation(adaptive=1e-3), ModelExchange(), ModelExchange("CVode", rtol=1e-8)]


def table(path, axis, last):
    path.write_text(f"time,plant.torque_disturbance_B[{axis}]\n0,0\n1,{last}\n")
    return path


@pytest.fixture
def tables(tmp_path):
    return table(tmp_path / "x.csv", 1, 0.5), table(tmp_path / "y.csv", 2, 0.7)


@pytest.mark.parametrize("method", METHODS, ids=str)
def test_two_tables_are_one(tmp_path, tables, method):
    both = tmp_path / "both.csv"
    both.write_text("time,plant.torque_disturbance_B[1],plant.torque_disturbance_B[2]\n0,0,0\n1,0.5,0.7\n")
    apart = run("observer-pd", **TIMES, method=method, hooks=[adcs.inputs(path) for path in tables])
    assert apart == run("observer-pd", **TIMES, method=method, hooks=[adcs.inputs(both)])
    assert apart != run("observer-pd", **TIMES, method=method, hooks=[adcs.inputs(tables[0])])
    again = rerun(json.loads(json.dumps(apart.manifest)))
    assert (again.result == apart, again.differences) == (True, ())
    tables[1].write_text(tables[1].read_text().replace("0.7", "0.9"))
    assert rerun(apart.manifest).differences == (f"inputs-2: {tables[1]} is not as it was",)


def test_one_input_has_one_table(tmp_path, tables):
    with pytest.raises(AdcsError) as error:
        run("observer-pd", **TIMES, hooks=[adcs.inputs(tables[0]), adcs.inputs(table(tmp_path / "again.csv", 1, 0.9))])
    assert str(error.value) == (
        "plant.torque_disturbance_B[1] gets its values from outside twice: leave one of them out"
    )


@pytest.mark.parametrize("method", METHODS, ids=str)
def test_the_first_of_several_conditions_ends_the_run(method):
    later, sooner = adcs.until("time > 0.7"), adcs.until("time >= 0.4")
    for hooks in ([later, sooner], [sooner, later], [sooner, adcs.until("time > 0.395")]):
        result = run("observer-pd", **TIMES, method=method, hooks=hooks)
        assert result.time[-1] == 0.4
        assert result.manifest["outcome"]["met"]["condition"] == "time >= 0.4"
        again = rerun(json.loads(json.dumps(result.manifest)))
        assert (again.result == result, again.differences) == (True, ())


def test_changes_of_several_hooks_are_known_together():
    at = [adcs.at("0.2s", {"controller.k_p": 3.0}), adcs.at(0.5, {"controller.k_p": 5.0, "controller.k_v": 8.0})]
    result = run("observer-pd", **TIMES, hooks=at)
    assert result.manifest["settings"]["changes"] == [
        [0.2, "controller.k_p", 3.0], [0.5, "controller.k_p", 5.0], [0.5, "controller.k_v", 8.0]
    ]  # fmt: skip
    assert result == run("observer-pd", **TIMES, hooks=at[::-1])
    assert rerun(result.manifest).result == result


def test_two_checkpoints(tmp_path):
    end, often = tmp_path / "end.npz", tmp_path / "often.npz"
    whole = run("observer-pd", **TIMES)
    part = run(
        "observer-pd", stop_time=0.55, step=0.01, hooks=[adcs.checkpoint(end), adcs.checkpoint(often, every="200ms")]
    )
    assert part.manifest["checkpoint"] == [
        {"path": str(end), "every": None}, {"path": str(often), "every": 0.2}
    ]  # fmt: skip
    for path in (end, often):
        rest = run("observer-pd", **TIMES, resume=path)
        assert rest.time[0] == 0.55
        assert np.array_equal(rest.data, whole.data[55:])
        assert rest.manifest["settings"]["resume"] == str(path)
    assert rerun(part.manifest).result == part


def test_a_run_has_one_pace():
    with pytest.raises(AdcsError, match=r"^pace: a run has one, leave the others out$"):
        run("observer-pd", **TIMES, hooks=[adcs.pace(100), adcs.pace(200)])


@pytest.mark.parametrize("isolated", [False, True])
def test_all_at_once_and_the_same_again(tmp_path, tables, isolated):
    parts = {
        "method": CoSimulation(loops="newton", timeout="1min"),
        "save": Save(["controller.torque_B"], every=3, to=tmp_path / "rows.h5"),
        "hooks": [
            adcs.at("100ms", {"controller.k_p": 3.0}),
            adcs.until("norm(controller.torque_B) > 1e9 or time > 0.62"),
            *map(adcs.inputs, tables),
            adcs.pace(1000),
            adcs.checkpoint(tmp_path / "state.npz"),
        ],
    }
    one = run("observer-pd", **TIMES, **parts, isolated=isolated)
    values = np.array(one["controller.torque_B"])
    two = run("observer-pd", **TIMES, **parts, isolated=isolated)
    assert np.array_equal(two["controller.torque_B"], values)
    assert one.time.tolist() == pytest.approx(np.arange(0, 0.64, 0.03).tolist())
    assert json.loads(json.dumps(one.manifest["settings"])) == {
        "method": "co-simulation", "fmi_version": "2.0", "start_time": 0.0, "stop_time": 1.0, "step": 0.01,
        "stepping": "compiled", "record": ["controller.torque_B"], "record_every": 3, "real_time": 1000,
        "solve_loops": {"method": "newton", "tolerance": 1e-10, "max_iterations": 50},
        "changes": [[0.1, "controller.k_p", 3.0]], "inputs": [str(path) for path in tables],
        "until": "norm(controller.torque_B) > 1e9 or time > 0.62",
    }  # fmt: skip
    again = rerun(one.manifest)
    assert np.array_equal(again.result["controller.torque_B"], values)
    assert again.differences == ()


def test_parts_say_what_they_are():
    assert repr(adcs.until("time > 1")) == "<Until until = 'time > 1'>"
    assert repr(adcs.at("1s", {"a.b": 2})) == "<Changes changes = [[1.0, 'a.b', 2]]>"
    assert repr(Hook()) == "<Hook>"
    assert repr(Save(every=2)) == "Save(names=None, every=2, rows=None, to=None)"
