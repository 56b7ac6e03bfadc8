"""Values of every type: start values, inputs, outputs; enumerations, texts, binary values, array sizes."""

import json
from collections.abc import Callable
from pathlib import Path

import foreign_fmus
import numpy as np
import pytest

from adcs import AdcsError, CoSimulation, Save, System, run
from orchestration.fmu.file import open_fmu
from orchestration.fmu.typed_values import item_name
from orchestration.fmu.values import parse_value
from orchestration.running.parts import parts

Foreign = Callable[..., Path]
TYPES = {"2.0": ["Float64", "Int32", "Boolean"], "3.0": foreign_fmus.NUMBERS}
EXTREMES = {
    "Float64": (-1.7e308, 5e-324),
    "Float32": (float(np.float32(3.4e38)), float(np.float32(1e-40))),
    **{t: (np.iinfo(t.lower()).min, np.iinfo(t.lower()).max) for t in foreign_fmus.INTEGERS if "64" not in t},
    "Int64": (-(2**53), 2**53),
    "UInt64": (0, 2**53),
    "Boolean": (True, False),
}


def alone(fmu, start):
    system = System("alone")
    system.add("c", fmu, start)
    return system


def inputs(version, values=None):
    return {f"u_{t}": (values or {}).get(t, False if t == "Boolean" else 7) for t in TYPES[version]}


def test_start_values_come_from_the_file(foreign, version):
    ports = open_fmu(foreign("types", version)).ports
    for t in TYPES[version]:
        assert ports[f"p_{t}"].start == ((True,) if t == "Boolean" else (100,))
        assert ports[f"p_{t}"].type == t
    assert ports["word"].start == ("four",)
    if version == "3.0":
        assert ports["words"].start == ("one", "three")
        assert ports["words"].shape == (2,)
        assert ports["blob"].start == (b"\x00\xff\x10",)


@pytest.mark.parametrize("stepping", ["compiled", "python"])
@pytest.mark.parametrize("which", [0, 1])
def test_values_of_every_numeric_type_arrive(foreign, version, stepping, which):
    values = {t: EXTREMES[t][which] for t in TYPES[version]}
    start = inputs(version, values) | {f"p_{t}": value for t, value in values.items()}
    result = run(
        alone(foreign("types", version), start), stop_time=1.0, step=1.0, method=CoSimulation(stepping=stepping)
    )
    for t, value in values.items():
        assert result[f"c.y_{t}"].tolist() == [value, value], t
        assert result[f"c.q_{t}"].tolist() == [value, value], t


def test_integers_beyond_those_of_doubles_can_be_given_but_not_recorded(foreign):
    start = inputs("3.0") | {"p_UInt64": 2**64 - 1, "p_Int64": -(2**63)}
    system = alone(foreign("types"), start)
    assert run(system, stop_time=1.0, step=1.0, save=Save(["c.y_Int8"]))["c.y_Int8"].tolist() == [7, 7]
    with pytest.raises(AdcsError, match=r"q_Int64 = -9223372036854775808 is beyond 2\^53"):
        run(system, stop_time=1.0, step=1.0, save=Save(["c.q_Int64"]))


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("p_UInt8", 256, "c.p_UInt8 = 256 is outside the range of UInt8"),
        ("p_Int8", 1.5, "c.p_Int8 = 1.5: expected an integer"),
        ("p_Boolean", 2, "c.p_Boolean = 2: expected True or False"),
        ("word", 5, "c.word = 5: expected a text"),
        ("phase", "walk", "c.phase = 'walk' is no item of this enumeration: use 'idle' or 1, 'run' or 2, 'stop' or 5"),
        ("phase", 3, "c.phase = 3 is no item of this enumeration: use 'idle' or 1, 'run' or 2, 'stop' or 5"),
        (
            "blob",
            "0ff",
            "c.blob = '0ff' is neither hexadecimal digits, two for a byte, nor base64:... with valid base64",
        ),
        ("blob", "base64:?", "c.blob = 'base64:?' is neither hexadecimal digits, two for a byte, nor base64:... with "),
        ("blob", 5, "c.blob = 5: expected bytes, or a text in hexadecimal digits or as base64:..."),
        ("blob", ["00", "01"], "c.blob: expected a single value, got 2 values"),
        ("words", ["one"], "c.words: expected 2 values, got 1 values"),
    ],
)
def test_values_that_do_not_fit_are_refused(foreign, name, value, message):
    with pytest.raises(AdcsError) as error:
        alone(foreign("types"), {name: value})
    assert str(error.value).startswith(message)


def test_enumerations_by_name_and_by_number(foreign, version):
    for given in ("stop", 5):
        system = alone(foreign("types", version), inputs(version) | {"phase": given})
        assert run(system, stop_time=1.0, step=1.0)["c.phase_out"].tolist() == [5, 5]
    port = open_fmu(foreign("types", version)).ports["phase"]
    assert dict(port.items) == foreign_fmus.PHASES
    assert [item_name(port, n) for n in (1, 2, 5, 7)] == ["idle", "run", "stop", "7"]


def test_texts(foreign, version):
    start = inputs(version) | {"word": "grün"}
    if version == "3.0":
        start["words"] = ["", "a b"]
    result = run(alone(foreign("types", version), start), stop_time=1.0, step=1.0)
    assert result["c.letters"][0] == len("grün".encode()) + (3 if version == "3.0" else 8)


@pytest.mark.parametrize("given", [b"\x01\x02\xf0", "0102f0", "01 02 F0", "base64:AQLw"])
def test_binary_values(foreign, given):
    result = run(alone(foreign("types"), inputs("3.0") | {"blob": given}), stop_time=1.0, step=1.0)
    assert result["c.bytes"][0] == 1 + 2 + 240


def test_a_manifest_holds_binary_values_as_they_are_given_again(foreign, tmp_path):
    system = alone(foreign("types"), inputs("3.0") | {"blob": b"\x01\x00"})
    result = run(system, stop_time=1.0, step=1.0)
    result.write_manifest(tmp_path / "manifest.json")
    start = json.loads((tmp_path / "manifest.json").read_text())["system"]["components"]["c"]["start"]
    assert start["blob"] == "0100"
    again = System("again")
    again.add("c", foreign("types"), start)
    assert np.array_equal(run(again, **parts(result.manifest["settings"])[0]).data, result.data)


def test_an_empty_binary_value(foreign):
    result = run(alone(foreign("types"), inputs("3.0") | {"blob": b""}), stop_time=1.0, step=1.0)
    assert result["c.bytes"][0] == 0


def test_values_written_as_text(foreign):
    fmu = open_fmu(foreign("types"))

    def parsed(name, text):
        return parse_value(fmu, fmu.ports[name], text)

    assert parsed("phase", " stop ") == "stop"
    assert parsed("phase", "2") == 2
    assert parsed("blob", "base64:AQLw") == "base64:AQLw"
    assert parsed("p_Boolean", "true") is True
    assert parsed("p_UInt64", "18446744073709551615") == 2**64 - 1
    with pytest.raises(AdcsError, match="phase = 'walk' cannot be read"):
        parsed("phase", "walk")


def test_arrays_have_the_length_that_a_structural_parameter_says(foreign):
    ports = open_fmu(foreign("sizes")).ports
    assert ports["u"].shape == ports["y"].shape == (3,)
    result = run(alone(foreign("sizes"), {"u": [1, 2, 3]}), stop_time=1.0, step=1.0)
    assert result["c.y"].tolist() == [[2, 4, 6]] * 2
    assert result["c.total"].tolist() == [6, 6]


@pytest.mark.parametrize("stepping", ["compiled", "python"])
def test_structural_parameters_can_be_set(foreign, stepping):
    system = alone(foreign("sizes"), {"u": [1, 2, 3, 4, 5], "n": 5})
    system.add("next", foreign("sizes"), {"n": 5})
    system.connect("c.y", "next.u")
    result = run(system, stop_time=1.0, step=1.0, method=CoSimulation(stepping=stepping))
    assert result["next.y"].tolist() == [[4, 8, 12, 16, 20]] * 2
    assert result["next.total"].tolist() == [30, 30]


def test_structural_parameters_are_refused_where_they_make_no_sense(foreign):
    with pytest.raises(AdcsError, match=r"^c\.u: expected 4 values, got 3 values$"):
        alone(foreign("sizes"), {"u": [1, 2, 3], "n": 4})
    with pytest.raises(AdcsError, match=r"^c\.n = 0: expected a size from 1$"):
        alone(foreign("sizes"), {"n": 0})
    system = alone(foreign("sizes"), {"u": [0] * 30, "n": 30})
    with pytest.raises(AdcsError, match=r"^c: setting n = 30 returned error: n is at most 20$"):
        run(system, stop_time=1.0, step=1.0)


def test_structural_parameters_can_be_set_later(foreign):
    system = alone(foreign("sizes"), {})
    system.set("c.n", 5)
    system.set("c.u", [1, 2, 3, 4, 5])
    with pytest.raises(AdcsError, match=r"^c\.n = 4: c\.u was given 5 values and has 4 values then: set n first$"):
        system.set("c.n", 4)
    assert run(system, stop_time=1.0, step=1.0)["c.total"].tolist() == [15, 15]


def test_structural_parameters_are_not_set_where_connections_would_not_fit(foreign):
    system = alone(foreign("sizes"), {"u": [1, 2, 3]})
    system.add("next", foreign("sizes"))
    system.connect("c.y", "next.u")
    with pytest.raises(
        AdcsError, match=r"^next\.n = 5: next\.u is connected \(c\.y to next\.u\) and has 5 values then"
    ):
        system.set("next.n", 5)
    assert run(system, stop_time=1.0, step=1.0)["next.total"].tolist() == [12, 12]
