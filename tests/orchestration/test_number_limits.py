"""Numbers that a type does not hold, or a double does not hand on, are refused alike in every path."""

import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import foreign_fmus
import numpy as np
import pytest

import adcs
from adcs import AdcsError, CoSimulation, RunFailed, Save, Session, System, run
from orchestration.fmu.number_types import RANGES, first_beyond, first_misfit
from orchestration.running.hooks.inputs import Table

Foreign = Callable[..., Path]
STEPPINGS = ["compiled", "python"]
FIRST = 2**53 + 1  # of the integers that no double is
WAYS = ["start", "change", "table", "connection"]


@pytest.fixture(scope="session")
def types(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return foreign_fmus.build("types", tmp_path_factory.mktemp("limits"), "3.0")


def inputs(**values):
    of_none = {f"u_{t}": False if t == "Boolean" else 7 for t in foreign_fmus.NUMBERS}
    return of_none | values


def alone(fmu, **start):
    system = System("alone")
    system.add("c", fmu, inputs(**start))
    return system


def given(types, tmp_path, way, kind, value, stepping="compiled"):
    """Give an input of a type a value; return what it has at last."""
    system, settings, name = alone(types), {}, f"u_{kind}"
    if way == "start":
        system.set(f"c.{name}", value)
    elif way == "change":
        settings["hooks"] = [adcs.at(0.0, {f"c.{name}": value})]
    elif way == "table":
        table = tmp_path / "table.csv"
        table.write_text(f"time,c.{name}\n0,{value}\n")
        settings["hooks"] = [adcs.inputs(table)]
    else:
        system = System("pair")
        source = "Float64" if kind.startswith("Float") else "Int64"
        system.add("a", types, inputs() | {f"p_{source}": value})
        system.add("c", types, {n: v for n, v in inputs().items() if n != name})
        system.connect(f"a.q_{source}", f"c.{name}")
    record = [f"c.y_{kind}"]
    return run(system, stop_time=0.1, step=0.1, method=CoSimulation(stepping=stepping), save=Save(record), **settings)[
        record[0]
    ][-1]


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize(("kind", "sign"), [("Int64", 1), ("Int64", -1), ("UInt64", 1)])
def test_the_limit_of_what_is_recorded_is_exact(types, stepping, kind, sign):
    settings = {"stop_time": 0.1, "step": 0.1, "method": CoSimulation(stepping=stepping), "save": Save([f"c.q_{kind}"])}
    result = run(alone(types, **{f"p_{kind}": sign * 2**53}), **settings)
    assert [int(v) for v in result[f"c.q_{kind}"]] == [sign * 2**53] * 2
    with pytest.raises(RunFailed) as error:
        run(alone(types, **{f"p_{kind}": sign * FIRST}), **settings)
    text = f"c failed at t = 0 s: q_{kind} = {sign * FIRST} is beyond 2^53, and cannot be handed on or recorded exactly"
    assert str(error.value) == f"{text}; 0 rows are kept"


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("kind", ["Int64", "UInt64"])
def test_the_limit_of_what_is_handed_on_is_exact(types, tmp_path, stepping, kind):
    system = System("pair")
    system.add("a", types, inputs(**{f"p_{kind}": 2**53}))
    system.add("c", types, {n: v for n, v in inputs().items() if n != f"u_{kind}"})
    system.connect(f"a.q_{kind}", f"c.u_{kind}")
    settings = {"stop_time": 0.1, "step": 0.1, "method": CoSimulation(stepping=stepping), "save": Save([f"c.y_{kind}"])}
    assert [int(v) for v in run(system, **settings)[f"c.y_{kind}"]] == [2**53] * 2
    system.set(f"a.p_{kind}", FIRST)
    with pytest.raises(AdcsError, match=rf"^a: q_{kind} = {FIRST} is beyond 2\^53"):
        run(system, **settings)


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize(
    ("value", "scale", "arrives"),
    [
        (2**53, {"offset": 1.0}, None),
        (2**53, {"offset": -1.0}, 2**53 - 1),
        (3002399751580331, {"factor": 3.0}, None),  # times 3 is 2^53 + 1
        (-3002399751580331, {"factor": 3.0}, None),
        (3002399751580330, {"factor": 3.0}, 2**53 - 2),
        (2**53 - 1, {"factor": 3.0, "offset": -2.0 * 2**53}, 2**53 - 3),  # though no double is the product
        (0, {"factor": 1e300}, None),
    ],
)
def test_what_a_factor_or_offset_rounds_is_refused(types, stepping, value, scale, arrives):
    system = System("pair")
    system.add("a", types, inputs(p_Int64=value))
    system.add("c", types, {n: v for n, v in inputs().items() if n != "u_Int64"})
    system.connect("a.q_Int64", "c.u_Int64", **scale)
    settings = {"stop_time": 0.1, "step": 0.1, "method": CoSimulation(stepping=stepping), "save": Save(["c.y_Int64"])}
    if arrives is not None:
        assert [int(v) for v in run(system, **settings)["c.y_Int64"]] == [arrives] * 2
        return
    with pytest.raises(AdcsError, match=r"^c: u_Int64 = "):
        run(system, **settings)


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_integers_given_as_such_arrive_whole(types, stepping):
    """Start values and changes are no doubles on their way."""
    system = alone(types, u_Int64=FIRST, p_UInt64=2**64 - 1)
    with Session(system, step=0.1, stepping=stepping, record=["c.y_Int8"]) as simulation:
        instance = simulation.instances["c"]

        def read(name, kind):
            return instance.read(instance.fmu.ports[name].references, 1, type=kind)

        assert read("y_Int64", "Int64") == [FIRST]
        assert read("q_UInt64", "UInt64") == [2**64 - 1]
        simulation.set("c.u_Int64", -FIRST)
        assert read("y_Int64", "Int64") == [-FIRST]
        with pytest.raises(AdcsError, match=rf"^c: get: -{FIRST} is beyond 2\^53"):
            instance.get(instance.fmu.ports["y_Int64"].references, 1, type="Int64")


def test_a_float_that_may_have_been_another_integer_is_none(types):
    for value in (2.0**53 + 2, np.float64(2.0**60)):
        with pytest.raises(AdcsError, match=r"^c\.p_UInt64 = .* is beyond 2\^53, and cannot be handed on"):
            alone(types, p_UInt64=value)
    assert alone(types, p_UInt64=2.0**53).components["c"].start["p_UInt64"] == (2**53,)


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_the_start_value_of_a_delayed_input_travels_as_a_double(types, stepping):
    system = System("pair")
    system.add("a", types, inputs())
    system.add("c", types, inputs(u_Int64=FIRST))
    system.connect("a.q_Int64", "c.u_Int64", delay_steps=1)
    with pytest.raises(AdcsError, match=rf"^c\.u_Int64 = {FIRST} is beyond 2\^53, and cannot be handed on"):
        run(system, stop_time=0.1, step=0.1, method=CoSimulation(stepping=stepping))


@pytest.mark.parametrize("cell", [f"{FIRST}", f" {FIRST}.0", f"-{FIRST}"])
def test_the_limit_is_exact_in_tables(types, tmp_path, cell):
    """As a double it is 2^53, and would pass."""
    assert float(cell) in (2**53, -(2**53))
    with pytest.raises(AdcsError, match=rf"table\.csv: c\.u_Int64 = -?{FIRST} at 0 s is beyond 2\^53"):
        given(types, tmp_path, "table", "Int64", cell)
    assert given(types, tmp_path, "table", "Int64", 2**53) == 2**53
    with pytest.raises(AdcsError, match=rf"table\.csv: c\.u_UInt64 = {2**64 - 1} at 0 s is beyond 2\^53"):
        given(types, tmp_path, "table", "UInt64", 2**64 - 1)
    with pytest.raises(AdcsError, match=r"table\.csv: c\.u_UInt64 = 1e\+300 at 0 s is outside the range of UInt64"):
        given(types, tmp_path, "table", "UInt64", 1e300)
    times = np.array([0.0])
    with pytest.raises(AdcsError, match=rf"c\.u_UInt64 = {FIRST} at 0 s is beyond"):
        Table(alone(types), times, {"c.u_UInt64": np.array([FIRST])})


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    ("kind", "value"),
    [("Float32", 1e300), ("Float32", -3.5e38), ("Int8", 128), ("UInt16", -1), ("UInt32", 2**32), ("Int32", 2**31)],
)
def test_numbers_outside_the_range_of_a_type_are_refused_in_every_path(types, tmp_path, stepping, way, kind, value):
    with pytest.raises(AdcsError) as error:
        given(types, tmp_path, way, kind, value, stepping)
    text = str(error.value)
    assert "\n" not in text
    shown = float(value) if way == "table" else value
    why = {
        "table": f"at 0 s is outside the range of {kind}",
        "connection": f"does not fit type {kind}, it comes from a.q_",
    }
    assert f"u_{kind} = {shown!r} {why.get(way, f'is outside the range of {kind}')}" in text


@pytest.mark.parametrize("way", ["start", "change", "table"])
@pytest.mark.parametrize("kind", ["Float32", "Float64", "Int32", "UInt64"])
@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
def test_what_is_not_finite_is_refused_in_every_path(types, tmp_path, way, kind, value):
    with pytest.raises(AdcsError, match=rf"c\.u_{kind} = {value}( at 0 s)? is not finite"):
        given(types, tmp_path, way, kind, value)


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("kind", ["Float64", "Float32", "Int32"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_comes_from_outside_at_a_point_is_looked_at_there(types, stepping, kind, value):
    """Whoever drives a simulation himself gives numbers that no table has seen."""
    external = [f"c.u_{kind}"]
    with Session(alone(types), step=0.1, steps=2, stepping=stepping, external=external) as simulation:
        rows = np.empty((1, simulation.recording.size))
        simulation.source = SimpleNamespace(at=lambda times: np.array([[value]]))
        _, written, failed = simulation.advance(1, rows)
    assert written == 0
    assert str(failed) == f"c failed at t = 0 s: u_{kind} = {value} does not fit type {kind}"


@pytest.mark.parametrize("value", [3.4028235677973362e38, -3.4028235677973362e38, 1e-60])
@pytest.mark.parametrize("way", WAYS)
def test_what_rounds_to_a_float32_passes(types, tmp_path, way, value):
    """The last double that does not become infinity, and one that becomes 0."""
    assert given(types, tmp_path, way, "Float32", value) == float(np.float32(value))


def test_a_mapping_to_what_the_type_does_not_hold_is_refused(types):
    system = System("pair")
    system.add("a", types, inputs())
    system.add("c", types, {n: v for n, v in inputs().items() if n not in ("u_Float32", "u_Int8")})
    for target, there in (("u_Float32", 1e300), ("u_Int8", 200), ("u_Int8", 0.5)):
        with pytest.raises(AdcsError, match=rf"the mapping leads from 100 to .*, which is no {target[2:]}"):
            system.connect("a.q_Int64", f"c.{target}", mapping=[(100, there)])


def test_a_mapping_that_doubles_would_round_is_refused(types):
    system = System("pair")
    system.add("a", types, inputs())
    system.add("c", types, {n: v for n, v in inputs().items() if n != "u_Int64"})
    for pairs in ([(100, FIRST)], [(FIRST, 1)]):
        with pytest.raises(AdcsError, match=rf"u_Int64: {FIRST} in the mapping is beyond 2\^53"):
            system.connect("a.q_Int64", "c.u_Int64", mapping=pairs)
    system.connect("a.q_Int64", "c.u_Int64", mapping=[(100, 2**53)])


def test_a_loop_that_grows_beyond_all_numbers_is_refused(types):
    """Solving it sets inputs past the ordinary path."""
    with Session(alone(types), step=0.1) as simulation:
        instance = simulation.instances["c"]
        for kind, value in (("Float64", np.inf), ("Float32", 1e39), ("Int8", 1.5)):
            with pytest.raises(AdcsError, match=rf"^c: set: {re.escape(str(value))}"):
                instance.set(instance.fmu.ports[f"u_{kind}"].references, [value], type=kind)


@pytest.mark.parametrize("kind", RANGES)
def test_the_ends_of_every_range(kind):
    low, high = RANGES[kind]
    assert first_misfit(kind, [low, high]) is None
    for wrong in (low - 1, high + 1):
        assert first_misfit(kind, [low, wrong]) == (1, f" is outside the range of {kind}")
    if high < 2**53:
        assert first_misfit(kind, np.array([float(low), high + 1.0])) == (1, f" is outside the range of {kind}")
    assert first_misfit(kind, []) is None


def test_only_integers_beyond_the_limit_are():
    assert first_beyond([2**53, -(2**53), 0]) is None
    assert first_beyond([0, -FIRST]) == 1


def test_integers_of_any_length(types):
    system = alone(types)
    system.set("c.u_Float64", 10**30)
    assert system.components["c"].start["u_Float64"] == (1e30,)
    for kind, number in (("UInt64", 2**64), ("Int64", -(2**63) - 1), ("Int8", 10**30), ("Float64", 10**400)):
        with pytest.raises(AdcsError, match=rf"^c\.u_{kind} = -?\d+(\.\.\.)? is outside the range of {kind}$"):
            system.set(f"c.u_{kind}", number)
    with pytest.raises(AdcsError, match=r"^c\.u_Boolean = \d+ is outside the range of Boolean$"):
        system.set("c.u_Boolean", 2**64)
