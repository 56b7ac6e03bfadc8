"""Booleans, integers, enumerations and texts, as FMI has them in both versions."""

import csv
import ctypes
import re
import struct
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.fmi1 import FMICallException

import adcs
from adcs import AdcsError, CoSimulation, ModelExchange, System
from adcs.cli import app
from fmus import fmu_path
from fmus.check import check
from orchestration.fmu.file import open_fmu
from tests.invoking import invoke
from tests.one_fmu import Raw, unpacked

from .test_saved_states import VALUES, forged

VERSIONS = (2, 3)
HEADER = """\
/// # Mode logic
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct ModeLogic {
    static constexpr auto summary = "what is no number of type T";
    static constexpr auto reference = "";
    static constexpr auto kind = "controller";
    static constexpr const char* modes[] = {"off", "on", "safe"};

    T level = 0.0, y = 0.0, period = 0.1, rate = 1.0, x = 0.0, xDot = 0.0;
    bool enabled = true, inverted = false, lit = false, slow = false, latched = false, seen = false;
    std::int32_t copies = 3, count = 2, copied = 0, ticks = 0;
    std::int32_t wanted = 1, start_mode = 0, mode = 0, held_mode = 0, offset = 0;
    const char* says = "nothing yet";

    template <class V>
    void declare(V& v) {
        v.sampled(period);
        v.input("level", level, unit::one, "what is compared");
        v.input("enabled", enabled, "works");
        v.input("copies", copies, "how many").at_least(0).at_most(9);
        v.input("wanted", wanted, modes, "the mode asked for");
        v.parameter("inverted", inverted, "the other way round");
        v.parameter("count", count, "how many").fixed();
        v.parameter("start_mode", start_mode, modes, "the mode where none works");
        v.parameter("offset", offset, "added to the mode");
        v.parameter("rate", rate, unit::one_per_s, "of x");
        v.parameter("period", period, unit::s, "of samples").fixed().above(0);
        v.state("x", x, xDot, unit::one, "a state");
        v.held("latched", latched, "the level was above 1 at a sample").output();
        v.held("seen", seen, "there was a sample");
        v.held("ticks", ticks, "samples taken").output();
        v.held("held_mode", held_mode, modes, "the mode asked for at the sample").output();
        v.output("lit", lit, "the level is high");
        v.output("slow", slow, "lit, as it was at the sample").sampled();
        v.output("copied", copied, "copies, if it works");
        v.output("mode", mode, modes, "what it does");
        v.output("says", says, "what it does, in words");
        v.output("y", y, unit::one, "the level, if it works");
    }
    void sample(const Sample& s) {
        latched = latched || level > 1.0;
        seen = true;
        ticks = static_cast<std::int32_t>(s.k) + 1;
        held_mode = wanted;
    }
    void outputs() {
        lit = enabled && (level > 0.5) != inverted;
        slow = lit;
        copied = enabled ? copies * count : 0;
        mode = (enabled ? wanted : start_mode) + offset;
        says = mode == 0 ? "sleeping" : mode == 1 ? "working" : "waiting";
        y = enabled ? level : T(0.0);
    }
    void derivatives() { xDot = inverted ? -rate : rate; }
};

}  // namespace adcs
"""
WHEEL = """\
/// # A wheel that can be full
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct FullWheel {
    static constexpr auto summary = "a wheel that can be full";
    static constexpr auto reference = "";
    static constexpr auto kind = "plant";
    static constexpr const char* modes[] = {"filling", "full"};

    T torque = 1.0, h_max = 0.25, h = 0.0, hDot = 0.0, room = 0.0, outwards = 0.0;
    bool full = false;
    std::int32_t mode = 0;
    const char* says = "";

    template <class V>
    void declare(V& v) {
        v.input("torque", torque, unit::N_m, "torque");
        v.parameter("h_max", h_max, unit::N_m_s, "most of it");
        v.state("h", h, hDot, unit::N_m_s, "momentum");
        v.event("room", room, unit::N_m_s, "momentum that it can still take");
        v.event("outwards", outwards, unit::W, "whether the torque would add to it");
        v.held("full", full, "no more").output();
        v.held("mode", mode, modes, "what it does").output();
        v.output("says", says, "what it does, in words");
    }
    void outputs() {
        room = h_max - abs(h);
        outwards = torque * h;
        says = full ? "no more" : "goes on";
    }
    void events(const Events&) {
        full = room <= 0.0 && outwards > 0.0;
        mode = full ? 1 : 0;
    }
    void derivatives() { hDot = full ? T(0.0) : torque; }
};

}  // namespace adcs
"""
OUTPUTS = ("latched", "seen", "ticks", "held_mode", "lit", "slow", "copied", "mode", "says", "y", "x")


@pytest.fixture(scope="module")
def header(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("types") / "mode_logic.hpp"
    path.write_text(HEADER)
    return path


@pytest.fixture(params=[(version, cosim) for version in VERSIONS for cosim in (True, False)], ids=str)
def raw(header: Path, request: pytest.FixtureRequest) -> Iterator[Raw]:
    with Raw(str(header), *request.param) as made:
        yield made


def text(value: object) -> object:
    """fmpy gives texts as bytes in FMI 2."""
    return value.decode() if isinstance(value, bytes) else value


def read(raw: Raw) -> dict[str, object]:
    return {name: text(raw.get(name)[0]) for name in OUTPUTS}


def settle(raw: Raw) -> None:
    """Until the sample at the start counts."""
    if hasattr(raw.fmu, "doStep"):
        raw.step(0.0, 0.05)
    else:
        raw.event_update()


def test_values_come_and_go_as_what_they_are(raw: Raw) -> None:
    raw.initialize(level=2.0, enabled=1, copies=4, wanted=2, inverted=0)
    expected = {
        "latched": 1,
        "seen": 1,
        "ticks": 1,
        "held_mode": 2,
        "lit": 1,
        "slow": 1,
        "copied": 8,
        "mode": 2,
        "says": "waiting",
        "y": 2.0,
        "x": 0.0,
    }
    assert read(raw) == expected
    settle(raw)
    expected["x"] = raw.get("x")[0]
    for name, value in {"level": 0.0, "enabled": 0, "copies": 1, "wanted": 1, "start_mode": 0}.items():
        raw.set({name: value})
        assert raw.get(name)[0] == value
    off = {"lit": 0, "copied": 0, "mode": 0, "says": "sleeping", "y": 0.0}
    assert read(raw) == expected | off  # what is sampled, and what is held, waits for the next sample
    raw.set({"enabled": 1})
    raw.set({"inverted": 1})
    assert read(raw) == expected | {"copied": 2, "mode": 1, "says": "working", "y": 0.0, "lit": 1}


@pytest.mark.parametrize("version", VERSIONS)
def test_what_is_sampled_is_held_until_the_next_sample(header: Path, version: int) -> None:
    with Raw(str(header), version) as raw:
        raw.initialize(level=2.0)
        raw.step(0.0, 0.05)
        raw.set({"level": 0.0})
        raw.set({"wanted": 0})
        assert (raw.get("slow")[0], raw.get("lit")[0], raw.get("held_mode")[0], raw.get("ticks")[0]) == (1, 0, 1, 1)
        raw.step(0.05, 0.05)
        assert (raw.get("slow")[0], raw.get("lit")[0], raw.get("held_mode")[0], raw.get("ticks")[0]) == (0, 0, 0, 2)
        assert raw.get("latched")[0] == 1


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("enabled", 2, "enabled = 2 refused: 0 or 1 is expected"),
        ("inverted", -1, "inverted = -1 refused: 0 or 1 is expected"),
        ("wanted", 3, "wanted = 3 refused: one of its items is expected, 0 (off), 1 (on), 2 (safe)"),
        ("start_mode", -1, "start_mode = -1 refused: one of its items is expected, 0 (off), 1 (on), 2 (safe)"),
        ("copies", 10, "copies = 10 refused: must be at most 9"),
        ("lit", 1, "lit can not be set because the component computes it"),
        ("mode", 1, "mode can not be set because the component computes it"),
    ],
)
def test_bad_values_are_refused_by_name(raw: Raw, name: str, value: int, message: str) -> None:
    if raw.version == 3 and raw.kinds[name] == "Boolean":
        byte = ctypes.cast((ctypes.c_uint8 * 1)(value & 255), ctypes.POINTER(ctypes.c_bool))  # fmpy would make a bool
        reference = (ctypes.c_uint32 * 1)(raw.references[name][0])
        assert raw.fmu.dll.fmi3SetBoolean(ctypes.c_void_p(raw.fmu.component), reference, 1, byte, 1) == 3
        message = message.replace("-1", "255")
    else:
        with pytest.raises(FMICallException):
            raw.set({name: value})
    assert raw.messages[-1][2].endswith(message)


def test_a_text_cannot_be_set_and_other_types_are_refused(raw: Raw) -> None:
    with pytest.raises(FMICallException):
        raw.fmu.setString(raw.references["says"], ["no"])
    assert raw.messages[-1][2].endswith("SetString: says can not be set because the component computes it")
    for kind, name in (("Boolean", "wanted"), ("String", "lit"), (raw.kinds["y"], "enabled")):
        sizes = () if raw.version == 2 else (1,)
        with pytest.raises(FMICallException):
            getattr(raw.fmu, f"get{kind}")(raw.references[name], *sizes)
        assert raw.messages[-1][2].endswith(f"Get{kind}: {name} has another type")
    assert raw.kinds["mode"] == ("Integer" if raw.version == 2 else "Int64")


def test_an_item_that_is_none_is_a_law_s_mistake(raw: Raw) -> None:
    raw.initialize(wanted=2)
    raw.set({"offset": 1})
    with pytest.raises(FMICallException):
        raw.get("mode")
    assert raw.messages[-1][2].endswith("at t = 0: mode is 3, which is none of its items: 0 (off), 1 (on), 2 (safe)")


def test_saved_states_carry_everything_and_texts_come_back(raw: Raw) -> None:
    raw.initialize(level=2.0, enabled=0, wanted=2, copies=5, inverted=1)
    before, state = read(raw), raw.save()
    data = raw.to_bytes(state)
    assert before["says"] == "sleeping"
    for name, value in {"level": 0.0, "enabled": 1, "wanted": 1, "copies": 1, "inverted": 0}.items():
        raw.set({name: value})
    assert read(raw) != before
    raw.restore(state)
    assert raw.to_bytes(raw.save()) == data  # before anything is computed again
    assert read(raw) == before
    raw.set({"enabled": 1})
    raw.get("says")
    raw.restore(raw.from_bytes(data))
    assert text(raw.get("says")[0]) == "sleeping"
    assert raw.get("enabled")[0] == 0


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("enabled", 2.0, "enabled = 2 in the saved state, but 0 or 1 is expected"),
        ("lit", 0.5, "lit = 0.5 in the saved state, but 0 or 1 is expected"),
        ("wanted", 3.0, "wanted = 3 in the saved state"),
        ("mode", -1.0, "mode = -1 in the saved state"),
        ("held_mode", 0.5, "held_mode = 0.5 in the saved state, but an integer is expected"),
        ("says", 1.0, "says = 1 in the saved state, but 0 is expected"),
    ],
)
def test_foreign_values_of_a_saved_state_are_refused(raw: Raw, name: str, value: float, message: str) -> None:
    raw.initialize()
    before = read(raw)
    data = raw.to_bytes(raw.save())
    bad = forged(data, VALUES + 8 * raw.references[name][0], struct.pack("<d", value))
    with pytest.raises(FMICallException):
        raw.restore(raw.from_bytes(bad))
    assert raw.messages[-1][2].endswith(message)
    assert read(raw) == before


@pytest.mark.parametrize(("place", "value"), [(0, 2.0), (2, 9.3e18), (2, 0.5), (3, 3.0)])
def test_what_was_held_before_a_sample_is_looked_at_as_well(raw: Raw, place: int, value: float) -> None:
    """They are latched, seen, ticks, held_mode and slow, behind the values of all variables."""
    raw.initialize()
    behind = VALUES + 8 * (1 + max(max(references) for references in raw.references.values()))
    data = raw.to_bytes(raw.save())
    assert len(data) == behind + 8 * 5
    with pytest.raises(FMICallException):
        raw.restore(raw.from_bytes(forged(data, behind + 8 * place, struct.pack("<d", value))))
    assert raw.messages[-1][2].endswith(f"a held value of the saved state is {value:g}")


@pytest.mark.parametrize("version", VERSIONS)
def test_the_description_has_the_types_of_the_standard(header: Path, version: int) -> None:
    path = fmu_path(str(header), f"{version}.0")
    model = read_model_description(str(path), validate=True)
    variables = {v.name: v for v in model.modelVariables}
    integer, real = ("Integer", "Real") if version == 2 else ("Int32", "Float64")
    kinds = {"enabled": "Boolean", "wanted": "Enumeration", "copies": integer, "says": "String", "y": real}
    assert {name: variables[name].type for name in kinds} == kinds
    assert (variables["enabled"].start, variables["inverted"].start, variables["wanted"].start) == (
        "true",
        "false",
        "1",
    )
    assert variables["wanted"].declaredType is variables["mode"].declaredType
    assert variables["wanted"].declaredType.name == "ModeLogic.wanted"
    items = [(item.name, item.value) for item in variables["mode"].declaredType.items]
    assert items == [("off", "0"), ("on", "1"), ("safe", "2")]
    assert {variables[name].variability for name in ("enabled", "wanted", "lit", "says", "ticks")} == {"discrete"}
    assert check(path) == []
    with zipfile.ZipFile(path) as archive:
        page = archive.read("documentation/index.html").decode()
    assert "<td>on</td><td>0 off, 1 on, 2 safe</td><td>the mode asked for</td>" in page
    assert "<td>true</td><td></td><td>works</td>" in page


def test_dependencies_are_those_of_what_is_compared_and_chosen(header: Path) -> None:
    outputs = unpacked(str(header), 3)[1].outputs
    found = {u.variable.name: {d.name for d in u.dependencies} for u in outputs}
    assert found["lit"] == {"level", "enabled", "inverted"}
    assert found["y"] == {"level", "enabled"}
    assert {"enabled", "copies", "count"} <= found["copied"]
    assert found["mode"] == found["says"] >= {"enabled", "wanted", "start_mode", "offset"}
    assert "copies" not in found["mode"]


@pytest.mark.parametrize("version", VERSIONS)
def test_what_is_no_number_has_no_derivative(header: Path, version: int) -> None:
    with Raw(str(header), version) as raw:
        raw.initialize(level=2.0, inverted=1)
        for known, unknown in (("level", "lit"), ("enabled", "y")):
            with pytest.raises(FMICallException):
                raw.fmu.getDirectionalDerivative(raw.references[unknown], raw.references[known], [1.0])
            name = unknown if known == "level" else known
            assert raw.messages[-1][2].endswith(f"GetDirectionalDerivative: {name} has no derivative")
        unknowns = raw.references["y"] + raw.references["der(x)"]
        assert raw.fmu.getDirectionalDerivative(unknowns, raw.references["level"], [1.0]) == [1.0, 0.0]
        assert raw.fmu.getDirectionalDerivative(unknowns, raw.references["rate"], [1.0]) == [0.0, -1.0]


@pytest.mark.parametrize("method", [CoSimulation(), ModelExchange()], ids=str)
@pytest.mark.parametrize("version", VERSIONS)
def test_systems_wire_set_and_record_them(header: Path, version: int, method: CoSimulation | ModelExchange) -> None:
    system = System("modes", "one mode logic after another")
    system.add("first", str(header), {"level": 2.0, "enabled": True, "wanted": "safe", "copies": 2})
    system.add("second", str(header), {"level": 0.0, "inverted": 1, "copies": 1})  # 1 is True
    system.connect("first.lit", "second.enabled")
    system.connect("first.mode", "second.wanted")
    result = adcs.run(
        system,
        stop_time=0.4,
        step=0.1,
        method=method,
        fmi_version=f"{version}.0",
        hooks=[adcs.at(0.2, {"first.enabled": False})] if isinstance(method, CoSimulation) else [],
    )
    on = result.time < 0.2 if isinstance(method, CoSimulation) else np.full(result.time.shape, True)
    assert result["first.lit"].dtype == bool
    np.testing.assert_array_equal(result["first.lit"], on)
    np.testing.assert_array_equal(result["second.lit"], on)
    np.testing.assert_array_equal(result["second.mode"], np.where(on, 2, 0))
    np.testing.assert_array_equal(result["second.ticks"], 1 + np.round(result.time / 0.1))
    np.testing.assert_allclose(result["second.x"], -result.time, atol=1e-12)
    assert "first.says" not in result


def test_values_are_refused_before_a_run_with_the_way_out(header: Path) -> None:
    system = System("modes", "refused")
    with pytest.raises(AdcsError, match=r"^it\.wanted = 'fast' is no item of this enumeration: use 'off' or 0, "):
        system.add("it", str(header), {"wanted": "fast"})
    with pytest.raises(AdcsError, match=r"^it\.enabled = 2: expected True or False$"):
        system.add("it", str(header), {"enabled": 2})
    with pytest.raises(AdcsError, match=r"^it\.enabled = 0\.5: expected True or False$"):
        system.add("it", str(header), {"enabled": 0.5})
    assert open_fmu(fmu_path(str(header), "3.0")).ports["wanted"].items == (("off", 0), ("on", 1), ("safe", 2))


@pytest.mark.parametrize("interface", ["CoSimulation", "ModelExchange"])
@pytest.mark.parametrize("version", VERSIONS)
def test_another_importer_runs_them(header: Path, version: int, interface: str) -> None:
    result = simulate_fmu(
        str(fmu_path(str(header), f"{version}.0")),
        fmi_type=interface,
        stop_time=0.2,
        output_interval=0.1,
        start_values={"level": 2.0, "enabled": True, "inverted": True, "copies": 4, "wanted": 2},
        output=["lit", "mode", "copied", "ticks", "x"],
    )
    for name, value in {"lit": False, "mode": 2, "copied": 8}.items():
        np.testing.assert_array_equal(result[name], value)
    assert result["ticks"][-1] in (2, 3)  # the sample of the last instant may not have been taken yet
    np.testing.assert_allclose(result["x"][-1], -0.2, atol=1e-9)


def test_info_tells_types_items_and_texts(header: Path) -> None:
    told = " ".join(invoke(app.app, ["info", str(header)]).stdout.split())
    assert "wanted input on the mode asked for (0 off, 1 on, 2 safe)" in told
    assert "enabled input true works" in told
    assert "says output what it does, in words" in told
    told = " ".join(invoke(app.app, ["info", str(fmu_path(str(header), "3.0"))]).stdout.split())
    assert "wanted input Int64 on the mode asked for (0 off, 1 on, 2 safe)" in told
    assert "enabled input Boolean True works" in told
    assert "says output String what it does, in words" in told


def test_0_and_1_stand_for_false_and_true_wherever_values_are_written(header: Path, tmp_path: Path) -> None:
    def last(start: dict[str, object], **how: object) -> bool:
        system = System("modes", "one")
        system.add("it", str(header), {"level": 2.0, "copies": 1, "wanted": 1, **start})
        return bool(adcs.run(system, stop_time=0.3, step=0.1, method=CoSimulation(), **how)["it.lit"][-1])

    assert last({"enabled": 1})
    assert not last({"enabled": 0})
    assert not last({"enabled": True}, hooks=[adcs.at(0.1, {"it.enabled": 0})])
    assert last({"enabled": 0}, hooks=[adcs.at(0.1, {"it.enabled": 1})])
    table = tmp_path / "inputs.csv"
    table.write_text("time [s],it.enabled,it.wanted\n0,0,0\n0.2,1,2\n")
    assert last({}, hooks=[adcs.inputs(table)])
    for text, lit in (("0", False), ("1", True), ("false", False), ("true", True)):
        out = tmp_path / text
        values = [f"enabled={text}", "level=2", "copies=1", "wanted=safe"]
        given = [word for value in values for word in ("--set", value)]
        told = invoke(app.app, ["run", str(header), *given, "--stop", "0.2", "--step", "0.1", "--out", str(out)])
        assert told.exit_code == 0, told.output
        with (out / "result.csv").open() as file:
            rows = list(csv.DictReader(file))
        column = next(name for name in rows[0] if ".lit" in name)
        assert (rows[-1][column] in ("1", "True", "true", "1.0")) is lit


def test_an_integer_of_an_ssp_file_is_taken_for_a_boolean(header: Path, tmp_path: Path) -> None:
    system = System("modes", "one")
    start = {"level": 2.0, "enabled": True, "inverted": True, "copies": 1, "wanted": "safe"}
    system.add("it", str(header), start)
    file = tmp_path / "modes.ssp"
    adcs.write_ssp(system, file, stop_time=0.2, step=0.1)
    again = tmp_path / "again.ssp"
    with zipfile.ZipFile(file) as old, zipfile.ZipFile(again, "w") as new:
        changed = 0
        for name in old.namelist():
            content = old.read(name)
            if name.endswith((".ssd", ".ssv")):
                content, n = re.subn(rb'Boolean value="true"', b'Integer value="1"', content)
                changed += n
            new.writestr(name, content)
    assert changed == 2
    component = adcs.read_ssp(again).system.components["it"]
    assert {name: component.start[name] for name in ("enabled", "inverted", "wanted")} == {
        "enabled": (True,),
        "inverted": (True,),
        "wanted": (2,),
    }


@pytest.mark.parametrize("method", [CoSimulation(), ModelExchange()], ids=str)
@pytest.mark.parametrize("version", VERSIONS)
def test_events_set_booleans_and_modes(tmp_path: Path, version: int, method: CoSimulation | ModelExchange) -> None:
    header = tmp_path / "full_wheel.hpp"
    header.write_text(WHEEL)
    system = System("wheel", "fills at 0.25 s")
    system.add("it", str(header), {"torque": 1.0})
    result = adcs.run(system, stop_time=0.4, step=0.1, method=method, fmi_version=f"{version}.0")
    full = result.time > 0.25
    np.testing.assert_array_equal(result["it.full"], full)
    np.testing.assert_array_equal(result["it.mode"], full)
    np.testing.assert_allclose(result["it.h"], np.minimum(result.time, 0.25), atol=1e-12)
    found = {u.variable.name: {d.name for d in u.dependencies} for u in unpacked(str(header), 3)[1].outputs}
    assert "h" in found["h"]
    assert check(fmu_path(str(header), f"{version}.0")) == []
