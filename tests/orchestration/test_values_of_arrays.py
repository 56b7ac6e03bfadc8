"""Arrays on the command line: of texts, of binary values, of one element; elements of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import foreign_fmus
import pytest

from adcs import AdcsError, System, run
from adcs.cli.words import assign, assigned
from orchestration.fmu.file import open_fmu
from orchestration.fmu.values import parse_value
from orchestration.system import checked_value

Foreign = Callable[..., Path]


def taken(foreign: Foreign, name: str, text: str, shape: tuple[int, ...] | None = None) -> Any:
    """What a text gives for a variable of the model "types", which has another shape if one is given."""
    fmu = open_fmu(foreign("types"))
    port = fmu.ports[name] if shape is None else replace(fmu.ports[name], shape=shape)
    return checked_value(f"c.{name}", port, parse_value(fmu, port, text))


@pytest.mark.parametrize(
    ("name", "shape", "text", "expected"),
    [
        ("words", (2,), '["a","b"]', ("a", "b")),
        ("words", (2,), ' [ "a, b" , "" ] ', ("a, b", "")),
        ("words", (2, 2), '[["a","b"],["c","ä]"]]', ("a", "b", "c", "ä]")),
        ("words", (1,), '["a"]', ("a",)),
        ("words", (1,), "a", ("a",)),
        ("words", (1, 1), "[a", ("[a",)),
        ("word", (), '["a","b"]', ('["a","b"]',)),
        ("blob", (2,), '["00ff","base64:AQLw"]', (b"\x00\xff", b"\x01\x02\xf0")),
        ("blob", (2, 1), '[["00"],[""]]', (b"\x00", b"")),
        ("blob", (1,), "00ff", (b"\x00\xff",)),
        ("p_Float64", (1,), "7", (7.0,)),
        ("p_Float64", (1, 1), "7", (7.0,)),
        ("p_Float64", (1,), "[7]", (7.0,)),
        ("p_UInt64", (1,), "18446744073709551615", (2**64 - 1,)),
        ("p_Boolean", (1,), "true", (True,)),
        ("phase", (1,), "stop", (5,)),
        ("phase", (2,), "stop,idle", (5, 1)),
    ],
)
def test_taken(foreign, name, shape, text, expected):
    assert taken(foreign, name, text, shape) == expected


LIST = """write a list of texts, '["a","b"]'"""


@pytest.mark.parametrize(
    ("name", "shape", "text", "expected"),
    [
        ("words", (2,), "a,b", f"words = 'a,b' cannot be read: {LIST}"),
        ("words", (2,), '["a"', f"""words = '["a"' cannot be read: {LIST}"""),
        ("words", (2,), "[1,2]", f"words = '[1,2]' cannot be read: {LIST}"),
        ("words", (1,), "[1]", f"words = '[1]' cannot be read: {LIST}"),
        ("words", (2,), "", f"words = '' cannot be read: {LIST}"),
        ("words", (2,), "[" * 100_000, "words = '[[["),
        ("words", (2,), "[" * 900 + "]" * 900, "words = '[[["),
        ("blob", (2,), "[" * 900 + "]" * 900, "blob = '[[["),
        ("words", (2,), '["a"]', "c.words: expected 2 values, got 1 values"),
        ("words", (2,), '[["a"],["b"]]', "c.words: expected 2 values, got 2 x 1 values"),
        ("blob", (2,), "00,01", f"blob = '00,01' cannot be read: {LIST}"),
        ("blob", (2,), '["00"]', "c.blob: expected 2 values, got 1 values"),
        ("blob", (2,), '[["00","01"]]', "c.blob: expected 2 values, got 1 x 2 values"),
        ("blob", (2, 2), '[["00","01"],["02"]]', "c.blob = [['00', '01'], ['02']]: expected 2 x 2 values"),
        ("blob", (2,), '["00","x"]', "c.blob = 'x' is neither hexadecimal digits"),
        ("p_Float64", (2,), "7", "c.p_Float64: expected 2 values, got a single value"),
        ("p_Float64", (), "[7]", "c.p_Float64: expected a single value, got 1 values"),
    ],
)
def test_refused(foreign, name, shape, text, expected):
    with pytest.raises(AdcsError) as error:
        taken(foreign, name, text, shape)
    assert str(error.value).startswith(expected)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 500


def test_texts_of_a_component_are_given_on_the_command_line(foreign):
    system = System("texts")
    inputs = {f"u_{t}": False if t == "Boolean" else 7 for t in foreign_fmus.NUMBERS}
    system.add("c", foreign("types"), inputs)
    assign(system, ['c.words=["ab","c"]', "c.word=four", "c.blob=0102f0"])
    result = run(system, stop_time=1.0, step=1.0)
    assert result["c.letters"][0] == 7
    assert result["c.bytes"][0] == 1 + 2 + 240


def test_an_array_that_has_become_one_of_one_element(foreign):
    system = System("one")
    system.add("c", foreign("sizes"))
    assign(system, ["c.u=7", "c.n=1"])
    assert run(system, stop_time=1.0, step=1.0)["c.total"].tolist() == [7, 7]


@pytest.mark.parametrize("name", ["c.u[1]", "c.u[3]"])
def test_one_element_is_not_set_alone(foreign, name):
    """It would be taken for the whole array."""
    system = System("elements")
    system.add("c", foreign("sizes"), {"u": [1.0, 2.0, 3.0]})
    for value in ("7", "7,8,9"):
        with pytest.raises(AdcsError) as error:
            assign(system, [f"{name}={value}"])
        assert str(error.value) == (
            f"--set {name}={value}: {name} is one of the 3 elements of c.u: give all of them, as c.u=VALUE"
        )
    assert system.components["c"].start["u"] == (1.0, 2.0, 3.0)


def test_nor_is_that_of_an_array_of_one(foreign):
    system = System("elements")
    system.add("c", foreign("sizes"), {"n": 1, "u": [7.0]})
    with pytest.raises(AdcsError, match=r"c\.u\[1\] is one of the 1 elements of c\.u: give all of them, as c\.u=VALUE"):
        assign(system, ["c.u[1]=7"])


def test_elements_of_fmi_2_are_those_of_an_array_too():
    system = System("elements")
    system.add("c", "RigidBody")
    with pytest.raises(
        AdcsError, match=r"--at c\.torque_B\[2\]=1: c\.torque_B\[2\] is one of the 3 elements of c\.torque_B"
    ):
        assigned(system, "c.torque_B[2]=1", "--at")
