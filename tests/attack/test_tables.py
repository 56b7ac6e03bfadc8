"""Tables, lists and saved states: inputs in CSV, effects of actuators, maps of signals, checkpoints, logs, headers."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import adcs
from adcs import System, run
from adcs.catalogue import SYSTEMS
from fmus import catalog
from hil_bridge.ground import tlog
from hil_bridge.ground.mapping import ROLES, find
from hil_bridge.hil.actuators import Actuators
from orchestration.running.checkpoint import Checkpoint
from orchestration.running.hooks.inputs import Table
from orchestration.running.hooks.tables import read_table

from .strategies import EXTREMES, damaged, of_words, zip_damaged
from .tries import attempt

BODY = System("body")
BODY.add("plant", "RigidBody")
OBSERVER_PD = SYSTEMS["observer-pd"].build()
TABLE = "time[s],plant.torque_B[1][N.m],plant.torque_B[2]\r\n0,1,2\r\n0.5,1e-3,-2\r\n1,0,0\r\n"
NUMBERS = ["0", "1", "-2.5", "1e-3", "nan", "inf", "1e999", "1_0", "0x1", "٣", "", " ", "1;2", '"', '""', "'"]
NAMES = ["time", "plant.torque_B[1]", "plant.torque_B", "plant.torque_B[4]", "plant.torque_B[4000000000]", "plant", "."]
NAMES += ["plant.q_BN", "[N.m]", "[s]", "[ms]", "[", "]", "plant.torque_B[1][N.m]"]
FORMAT = [",", ",", ",", "\n", "\n", "\r\n", "\r", "\0", "\ufeff", "#"]
ENCODINGS = ["utf-8", "utf-8", "utf-8", "utf-8-sig", "utf-16", "latin-1"]


def encoded(texts: st.SearchStrategy[str]) -> st.SearchStrategy[bytes]:
    return st.tuples(texts, st.sampled_from(ENCODINGS)).map(lambda both: both[0].encode(both[1], "replace"))


@given(damaged(TABLE.encode()) | encoded(of_words([*NUMBERS, *NAMES, *FORMAT], 30)))
def test_tables_of_inputs(place: Path, content: bytes) -> None:
    (place / "inputs.csv").write_bytes(content)
    came, inputs = attempt("inputs CSV", lambda: Table.from_csv(BODY, place / "inputs.csv"), len(content))
    if came:
        assert np.isfinite(inputs.at(np.array([-1.0, 0.25, 1e9]))).all()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"time,plant.torque_B[1]\n0," + b"1" * 200_000 + b"\n", "line 2: field larger than field limit (131072)"),
        (b'time,plant.torque_B[1]\n0,"' + b"1\n" * 200_000, "field larger than field limit (131072)"),
        (TABLE.encode("utf-16"), "is not a text file in UTF-8: save it so"),
        (b"time,plant.torque_B[1]\n0,1\0\n", "line 2: '1\\x00' is not a number"),
        (b"time[ms],plant.torque_B[1]\n0,1\n", "time is in 'ms', expected 's'"),
        (b"time,plant.torque_B[4000000000]\n0,1\n", "plant.torque_B[4000000000] does not exist: plant.torque_B has 3"),
        (b"time,plant.torque_B[1]\n\n\n0,one\n", "line 4: 'one' is not a number"),
    ],
)
def test_tables_that_were_once_tracebacks(tmp_path: Path, content: bytes, message: str) -> None:
    (tmp_path / "inputs.csv").write_bytes(content)
    came, text = attempt("inputs CSV", lambda: Table.from_csv(BODY, tmp_path / "inputs.csv"), len(content))
    assert not came
    assert message in text


def test_a_long_table_takes_a_time_in_proportion(tmp_path: Path) -> None:
    content = "time,plant.torque_B[1]\n" + "".join(f"{i},0.5\n" for i in range(300_000))
    (tmp_path / "inputs.csv").write_text(content)
    came, inputs = attempt("inputs CSV", lambda: Table.from_csv(BODY, tmp_path / "inputs.csv"), len(content))
    assert came
    assert inputs.at(np.array([299_999.0])).tolist() == [[0.5]]


@given(st.lists(st.lists(st.floats(), min_size=2, max_size=2), max_size=20))
def test_numbers_come_back_from_a_table_to_the_last_bit(place: Path, rows: list[list[float]]) -> None:
    buffer = io.StringIO()
    csv.writer(buffer).writerows([["a", "b"], *rows])
    (place / "numbers.csv").write_text(buffer.getvalue(), newline="")
    names, numbers = read_table(place / "numbers.csv", header=True)
    assert names == ["a", "b"]
    assert numbers.shape == (len(rows), 2)
    assert np.array_equal(numbers, np.array(rows).reshape(-1, 2), equal_nan=True)


EFFECT = "1,0,0,1\n0,1,0,1\n0,0,1,1\n"


@given(damaged(EFFECT.encode()) | encoded(of_words([*NUMBERS, *FORMAT], 30)))
def test_effects_of_actuators(place: Path, content: bytes) -> None:
    (place / "effect.csv").write_bytes(content)
    attempt("actuators CSV", lambda: Actuators.from_csv(place / "effect.csv"), len(content))


MAP = '[roles]\nattitude = "plant.q_BN"\nrate = "plant.omega_BN_B"\n[shown]\nenergy = "plant.kinetic_energy"\n'
TOML = ["[roles]\n", "[shown]\n", "[[roles]]\n", *(f"{role} = " for role in ROLES), '"plant.q_BN"', '"plant.q_BN[1]"']
TOML += ['"', "\n", "1", "[" * 2000, "{a = 1}", "1979-05-27", '""', '"plant.omega_BN_B"', '"\\u0000"', "energy = "]


@given(damaged(MAP.encode()) | encoded(of_words(TOML, 12)))
def test_maps_of_signals(place: Path, content: bytes) -> None:
    (place / "map.toml").write_bytes(content)
    attempt("map TOML", lambda: find(OBSERVER_PD, [str(place / "map.toml")]), len(content))


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("saved") / "state.npz"
    run(SYSTEMS["full-state-pd"].build(), stop_time=0.1, step=0.01, hooks=[adcs.checkpoint(path)])
    return path.read_bytes()


@given(st.data())
def test_damaged_checkpoints(place: Path, saved: bytes, data: st.DataObject) -> None:
    content = data.draw(damaged(saved) | zip_damaged(saved))
    (place / "state.npz").write_bytes(content)
    attempt("checkpoint: file", lambda: Checkpoint.read(place / "state.npz"), len(content))


JSON = st.sampled_from([None, True, 0, 1, -1, 10, 10**30, 1.5, "", "x", [], {}, [[]], "full-state-pd", *EXTREMES])


@given(st.data())
def test_checkpoints_of_something_else(place: Path, saved: bytes, data: st.DataObject) -> None:
    """All but the bytes of a component's state, which the component itself has to look at."""
    arrays: dict[str, Any] = dict(np.load(io.BytesIO(saved)))
    about = json.loads(arrays["about"].tobytes())
    match data.draw(st.sampled_from(["about", "forget", "drop", "shape", "kind", "text"])):
        case "about":
            about[data.draw(st.sampled_from(sorted(about)))] = data.draw(JSON)
        case "forget":
            del about[data.draw(st.sampled_from(sorted(about)))]
        case "drop":
            del arrays[data.draw(st.sampled_from(sorted(arrays)))]
        case "shape":
            name = data.draw(st.sampled_from(["signals", "about"]))
            arrays[name] = np.resize(arrays[name], data.draw(st.sampled_from([(), (0,), (1,), (3, 2), (10_000,)])))
        case "kind":
            name = data.draw(st.sampled_from(sorted(arrays)))
            arrays[name] = np.zeros(
                arrays[name].shape, data.draw(st.sampled_from(["<c16", "<U3", "?", "<M8[s]", "<f4"]))
            )
        case "text":
            arrays["about"] = np.frombuffer(data.draw(st.sampled_from([b"", b"{}", b"[]", b"[" * 5000, b"\xff"])), "u1")
    if "about" in arrays and arrays["about"].dtype == np.uint8 and arrays["about"].size > 2 and arrays["about"].ndim:
        arrays["about"] = np.frombuffer(json.dumps(about).encode(), np.uint8)
    content = io.BytesIO()
    np.savez(content, **arrays)
    (place / "other.npz").write_bytes(content.getvalue())
    settings: dict[str, Any] = {"stop_time": 0.2, "step": 0.01, "resume": place / "other.npz"}
    attempt("checkpoint: content", lambda: run(SYSTEMS["full-state-pd"].build(), **settings), len(content.getvalue()))


FRAMES = b"".join(
    int(1e15 + 1e4 * i).to_bytes(8, "big") + bytes([0xFD, 9, 0, 0, i, 1, 1, 0, 0, 0]) + bytes(9) + b"\x12\x34"
    for i in range(4)
)


@given(damaged(FRAMES) | st.binary(max_size=200))
def test_telemetry_logs(place: Path, content: bytes) -> None:
    (place / "x.tlog").write_bytes(content)
    attempt("telemetry log", lambda: [tlog.sender(frame) for _, frame in tlog.read(place / "x.tlog")], len(content))


@given(st.data())
def test_headers_of_components(place: Path, data: st.DataObject) -> None:
    header = data.draw(st.sampled_from([component.header for component in catalog.components()]))
    folder = place / "headers" / "plant"
    folder.mkdir(parents=True, exist_ok=True)
    content = data.draw(damaged(header.read_bytes()))
    (folder / header.name).write_bytes(content)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(catalog, "SOURCES", place / "headers")
        attempt("component headers", catalog.components, len(content))
    (folder / header.name).unlink()
