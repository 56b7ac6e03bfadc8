"""Several names of a variable are one variable: FMI 3.0 has `<Alias>`, FMI 2.0 variables with the same reference."""

from __future__ import annotations

import numpy as np
import pytest

import adcs
from adcs import AdcsError, CoSimulation, Save, System, run
from adcs.cli.words import assign
from orchestration.running.hooks.changes import Changes
from orchestration.single import single

TIMES = np.array([0.0, 0.1, 0.2])


@pytest.fixture
def names(foreign):
    return lambda version="3.0": foreign("names", version)


@pytest.fixture
def ramp(mock):
    """A source whose three outputs are 10, 20 and 30 plus the time."""

    def add(system):
        system.add("ramp", mock("source", "3.0"), {"offset": [10.0, 20.0, 30.0]})

    return add


def chain(names, ramp, into="u", out="y", last="u"):
    """ramp -> a -> b, wired by these names."""
    system = System("chain")
    for name in "ab":
        system.add(name, names)
    ramp(system)
    for i in (1, 2):
        system.connect(f"ramp.y[{i}]", f"a.{into}[{i}]")
    system.connect(f"a.{out}", f"b.{last}")
    return system


@pytest.mark.parametrize("stepping", ["compiled", "python"])
@pytest.mark.parametrize(("into", "out", "last"), [("u", "y", "u"), ("uu", "y", "u"), ("u", "yy", "uu")])
def test_what_goes_through_another_name_is_there_at_once(names, ramp, stepping, into, out, last):
    result = run(chain(names(), ramp, into, out, last), stop_time=0.2, step=0.1, method=CoSimulation(stepping=stepping))
    assert result["b.y"].tolist() == [[10 + t, 20 + t] for t in TIMES]


@pytest.mark.parametrize("stepping", ["compiled", "python"])
def test_an_output_of_fmi_2_that_is_an_input_follows_it(names, ramp, stepping):
    result = run(chain(names("2.0"), ramp, out="uu"), stop_time=0.2, step=0.1, method=CoSimulation(stepping=stepping))
    expected = [[10 + t, 20 + t] for t in TIMES]
    assert result.names == ["a.y", "a.uu", "a.yy", "b.y", "b.uu", "b.yy", "ramp.y"]
    assert [result[name].tolist() for name in ("a.uu", "a.yy", "b.uu", "b.yy")] == [expected] * 4


def test_names_of_one_variable_mixed_by_elements(names, ramp):
    system = System("mixed")
    system.add("a", names())
    ramp(system)
    system.connect("ramp.y[1]", "a.u[1]")
    system.connect("ramp.y[2]", "a.uu[2]")
    assert run(system, stop_time=0.1, step=0.1)["a.y"].tolist() == [[10.0, 20.0], [10.1, 20.1]]
    with pytest.raises(AdcsError, match=r"ramp\.y\[2\] is already connected to it, an input has one source$"):
        system.connect("ramp.y[3]", "a.u[2]")
    system.disconnect("a.u[2]")
    system.connect("ramp.y[3]", "a.u[2]")
    assert run(system, stop_time=0.1, step=0.1)["a.y"].tolist() == [[10.0, 30.0], [10.1, 30.1]]


@pytest.mark.parametrize(("version", "into", "out"), [("3.0", "uu", "yy"), ("3.0", "u", "yy"), ("2.0", "u", "uu")])
def test_a_loop_through_another_name_is_seen(names, version, into, out):
    system = System("loop")
    for name in "ab":
        system.add(name, names(version))
    system.connect(f"a.{out}", f"b.{into}")
    system.connect(f"b.{out}", f"a.{into}")
    with pytest.raises(AdcsError, match=r"^algebraic loop: "):
        run(system, stop_time=0.2, step=0.1)


def test_start_values(names):
    for start in ({"u": [5.0, 6.0]}, {"uu": [5.0, 6.0]}, {"u": [5.0, 6.0], "uu": [5.0, 6.0]}):
        assert run(single(names(), start), stop_time=0.1, step=0.1)["names.y"].tolist() == [[5.0, 6.0]] * 2
    with pytest.raises(
        AdcsError, match=r"^c\.u and c\.uu are names of one variable, and are given different start val"
    ):
        System("two").add("c", names(), {"u": [5.0, 6.0], "uu": [6.0, 6.0]})


def test_start_values_on_the_command_line(names):
    system = single(names())
    assign(system, ["names.uu=1,2", "names.uu=5,6"])
    assert system.components["names"].start == {"u": (5.0, 6.0)}
    with pytest.raises(
        AdcsError, match=r"^--set names\.u and --set names\.uu are for two names of one variable: give one"
    ):
        assign(system, ["names.uu=1,2", "names.u=1,2"])


def test_changes_at_one_time(names):
    for second in ("names.u", "names.uu"):
        changes = [(0.1, "names.u", [1.0, 2.0]), (0.2 if second == "names.uu" else 0.1, second, [3.0, 4.0])]
        assert run(single(names()), stop_time=0.2, step=0.1, hooks=[Changes(changes)])["names.y"][-1].tolist() == [
            3.0,
            4.0,
        ]
    with pytest.raises(
        AdcsError, match=r"^the changes of names\.u and names\.uu at one time are for two names of one v"
    ):
        run(
            single(names()),
            stop_time=0.2,
            step=0.1,
            hooks=[adcs.at(0.1, {"names.u": [1.0, 2.0]}), adcs.at(0.1, {"names.uu": [3.0, 4.0]})],
        )


def test_a_start_value_and_a_connection(names, ramp):
    system = chain(names(), ramp, into="u")
    with pytest.raises(AdcsError, match=r"^b\.uu is connected to a\.y: a start value would have no effect$"):
        system.set("b.uu", [1.0, 2.0])
    system.disconnect("b.uu")
    system.set("b.uu", [1.0, 2.0])
    with pytest.raises(
        AdcsError, match=r"b\.u has a start value that the connection would override: drop one of them$"
    ):
        system.connect("a.y", "b.u")


def test_one_name_is_enough_for_an_input(names):
    system = System("open")
    system.add("a", names())
    with pytest.raises(AdcsError, match=r"^input a\.u is not connected: connect it or give it a start value$"):
        run(system, stop_time=0.1, step=0.1)


def test_changes_on_the_way(names, ramp):
    result = run(single(names()), stop_time=0.2, step=0.1, hooks=[adcs.at(0.1, {"names.uu": [3.0, 4.0]})])
    assert result["names.yy"].tolist() == [[1.0, 2.0], [3.0, 4.0], [3.0, 4.0]]
    with pytest.raises(AdcsError, match=r"^b\.uu is connected to a\.y: it cannot be set during a run$"):
        run(chain(names(), ramp), stop_time=0.2, step=0.1, hooks=[adcs.at(0.1, {"b.uu": [3.0, 4.0]})])


def test_values_from_a_table(names, tmp_path):
    table = tmp_path / "u.csv"
    system = System("fed")
    system.add("a", names())
    table.write_text("time,a.uu[1],a.u[2]\n0,1,2\n0.2,3,4\n")
    assert run(system, stop_time=0.2, step=0.2, hooks=[adcs.inputs(table)])["a.y"].tolist() == [[1.0, 2.0], [3.0, 4.0]]
    table.write_text("time,a.u[1],a.u[2],a.uu[2]\n0,1,2,3\n")
    with pytest.raises(
        AdcsError, match=r"^a\.uu\[2\] and a\.u\[2\] are names of one variable, which gets its values from outside tw"
    ):
        run(system, stop_time=0.2, step=0.2, hooks=[adcs.inputs(table)])


def test_a_variable_is_recorded_once_and_has_all_its_names(names, tmp_path):
    result = run(single(names()), stop_time=0.1, step=0.1)
    assert result.names == ["names.y"]
    assert result["names.yy"].tolist() == result["names.y"].tolist() == [[1.0, 2.0]] * 2
    assert result.select(["names.yy"]).names == ["names.yy"]
    wanted = run(single(names()), stop_time=0.1, step=0.1, save=Save(["names.yy"]))
    assert wanted["names.y"].tolist() == [[1.0, 2.0]] * 2
    result.write_csv(tmp_path / "result.csv")
    assert (tmp_path / "result.csv").read_text().startswith("time[s],names.y[1][-],names.y[2][-]\n")
    with pytest.raises(AdcsError, match=r"^'names\.z' was not recorded"):
        result["names.z"]


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("to_file", [False, True])
def test_elements_and_a_selection_go_by_another_name(names, tmp_path, version, to_file):
    system = single(names(version))
    result = run(system, stop_time=0.1, step=0.1, save=Save(["names.y"], to=tmp_path / "r.h5" if to_file else None))
    assert result["names.yy[2]"].tolist() == [2.0, 2.0]
    assert "names.yy[2]" in result and "names.yy[3]" not in result
    selected = result.select(["names.yy"])
    assert selected["names.yy"].tolist() == selected["names.y"].tolist() == [[1.0, 2.0]] * 2
    assert selected["names.y[1]"].tolist() == selected.block(0, 2)[:, 0].tolist() == [1.0, 1.0]


def test_a_condition_on_another_name(names):
    changes = [(0.2, "names.u", [3.0, 4.0])]
    result = run(single(names()), stop_time=1.0, step=0.1, hooks=[Changes(changes), adcs.until("max(names.yy) > 3.5")])
    assert len(result.time) == 3
