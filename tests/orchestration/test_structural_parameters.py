"""Structural parameters: sizes of arrays, together or 0, and others that are no sizes; what follows from a new size."""

from __future__ import annotations

import json

import h5py
import numpy as np
import pytest
import scipy.io

from adcs import AdcsError, CoSimulation, System, run
from adcs.cli.app import app
from orchestration.fmu.file import open_fmu
from orchestration.single import single
from tests.invoking import invoke


@pytest.fixture
def square(foreign):
    return foreign("square", "3.0")


@pytest.mark.parametrize("stepping", ["compiled", "python"])
def test_two_that_are_valid_only_together(square, stepping):
    u = np.arange(9.0).reshape(3, 3)
    result = run(
        single(square, {"rows": 3, "columns": 3, "u": u}),
        stop_time=0.1,
        step=0.1,
        method=CoSimulation(stepping=stepping),
    )
    assert result["square.y"].tolist() == [u.tolist()] * 2
    assert result["square.entered"].tolist() == [1, 1]  # configuration mode, once
    with pytest.raises(AdcsError, match=r"^square: setting rows = 3 returned error: rows and columns must be equal$"):
        run(single(square, {"rows": 3}), stop_time=0.1, step=0.1)


def test_under_another_name(square):
    system = single(square, {"height": 3, "columns": 3, "u": np.eye(3)})
    assert run(system, stop_time=0.1, step=0.1)["square.y"].shape == (2, 3, 3)
    with pytest.raises(
        AdcsError, match=r"^square\.rows = 2: square\.u was given 3 x 3 values and has 2 x 3 values then"
    ):
        system.set("square.height", 2)
    with pytest.raises(
        AdcsError, match=r"^square\.rows and square\.height are names of one variable, and are given diff"
    ):
        System("two").add("square", square, {"rows": 3, "height": 2})


def test_those_that_are_no_sizes(square):
    start = {"margin": 0.5, "deep": False, "level": -2, "label": "hello"}
    assert run(single(square), stop_time=0.1, step=0.1)["square.seen"][0].tolist() == [0.25, 1.0, 3.0, 1.0]
    assert run(single(square, start), stop_time=0.1, step=0.1)["square.seen"][0].tolist() == [0.5, 0.0, -2.0, 5.0]


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ({"rows": 5}, r"square\.rows = 5: expected a size from 0 to 4"),
        (
            {"columns": 10**9},
            r"square\.columns = 1000000000: u would have 2,000,000,000 elements, more than 1,000,000, ",
        ),
        ({"rows": -1}, r"square\.rows = -1 is outside the range of UInt64"),
        ({"rows": 2.5}, r"square\.rows = 2\.5: expected an integer"),
        ({"deep": 2}, r"square\.deep = 2: expected True or False"),
        ({"label": 3}, r"square\.label = 3: expected a text"),
        ({"margin": float("nan")}, r"square\.margin = nan is not finite"),
    ],
)
def test_values_that_are_refused(square, start, message):
    with pytest.raises(AdcsError, match=f"^{message}"):
        single(square, start)


@pytest.mark.parametrize("late", [False, True])
def test_values_that_another_size_makes_invalid(foreign, late):
    system = System("resized")
    system.add("c", foreign("invalid"), {} if late else {"n": 3})
    if late:
        system.set("c.n", 3)
    assert system.components["c"].start == {"n": (3,), "same": (2.0, 2.0, 2.0)}
    with pytest.raises(
        AdcsError, match=r"^c\.each has 3 values by its structural parameters, and the FMU has no start "
    ):
        run(system, stop_time=0.1, step=0.1)
    system.set("c.each", [1.0, 2.0, 3.0])
    assert run(system, stop_time=0.1, step=0.1)["c.sums"].tolist() == [[6.0, 6.0]] * 2
    system.set("c.same", [1.0, 1.0, 1.0])
    assert run(system, stop_time=0.1, step=0.1)["c.sums"].tolist() == [[3.0, 6.0]] * 2
    with pytest.raises(AdcsError, match=r"^c\.n = 2: c\.same was given 3 values and has 2 values then: set n first$"):
        system.set("c.n", 2)


def test_values_of_a_size_that_is_given_and_stays(foreign):
    result = run(single(foreign("invalid"), {"n": 2}), stop_time=0.1, step=0.1)
    assert result["invalid.sums"].tolist() == [[4.0, 7.0]] * 2


@pytest.mark.parametrize("stepping", ["compiled", "python"])
def test_arrays_of_size_0(square, stepping, tmp_path):
    system = System("empty")
    for name in "ab":
        system.add(name, square, {"rows": 0, "columns": 0})
    system.connect("a.y", "b.u")
    system.connect("b.y", "a.u", delay_steps=2)
    result = run(system, stop_time=0.2, step=0.1, method=CoSimulation(stepping=stepping))
    assert result["b.y"].shape == (3, 0, 0)
    assert result["b.entered"].tolist() == [1, 1, 1]
    result.write_csv(tmp_path / "result.csv")
    assert (tmp_path / "result.csv").read_text().splitlines()[0].startswith("time[s],a.seen[1][-]")
    result.write_mat(tmp_path / "result.mat")
    assert scipy.io.loadmat(tmp_path / "result.mat")["b"]["y"][0, 0].size == 0
    result.write_hdf5(tmp_path / "result.h5")
    with h5py.File(tmp_path / "result.h5") as file:
        assert file["b/y"].shape == (3, 0, 0)
        assert file["b/seen"][:].tolist() == [[0.25, 1.0, 3.0, 1.0]] * 3


@pytest.mark.parametrize("kind", ["csv", "hdf5"])
def test_on_the_command_line(square, tmp_path, kind):
    out = tmp_path / kind
    options = [f"--{name}={value}" for name, value in (("stop", 0.2), ("step", 0.1), ("out", out), ("format", kind))]
    words = ["square.label=hello", "square.rows=0", "square.deep=false", "square.columns=0", "square.margin=2.5"]
    given = [option for word in words for option in ("--set", word)]
    result = invoke(app, ["run", str(square), *given, *options, "--in-process"])
    assert result.exit_code == 0, result.output
    start = json.loads((out / "manifest.json").read_text())
    assert "hello" in json.dumps(start)
    if kind == "csv":
        assert (out / "result.csv").read_text().splitlines()[1] == "0.0,2.5,0.0,3.0,5.0,1"


def test_an_initial_size_of_0_is_no_description(square, tmp_path):
    from test_fmu_files import edited

    start = '<UInt64 name="rows" valueReference="0" causality="structuralParameter" variability="fixed" start="'
    none = edited(square, tmp_path / "none.fmu", xml=(f'{start}2"', f'{start}0"'))
    with pytest.raises(AdcsError, match=r"is not valid: u has a dimension of size 0, which FMI 3\.0 allows only where"):
        open_fmu(none)
