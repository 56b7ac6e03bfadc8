"""Words of the command line: values with units, times, conditions, delays, rates."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adcs import System
from adcs.cli.words import assigned, change, delay, every, seconds
from orchestration.fmu.values import parse_value
from orchestration.results.result import Recording
from orchestration.running.conditions.condition import Condition

from .strategies import ODD, of_words
from .tries import attempt

SYSTEM = System("two")
SYSTEM.add("plant", "RigidBody", {"torque_disturbance_B": [0.0] * 3})
SYSTEM.add("tracker", "StarTracker")
SYSTEM.connect("plant.q_BN", "tracker.q_BN")
RECORDING = Recording(SYSTEM, None)
HALF_ANGLE = SYSTEM.port("tracker.half_angle")[1]
TRACKER = SYSTEM.components["tracker"].fmu

VARIABLES = [
    "plant.",
    "tracker.",
    "J_B",
    "half_angle",
    "seed",
    "torque_B",
    "q_BN",
    "[1]",
    "[1,1]",
    "[4000000000]",
    "[-1]",
]
VALUES = ["0.05", "1,2,3", "[[1,2],[3,4]]", "[1,[2]]", "deg", "rad", "N.m", "true", "null", "{}", '"a"', "[", "]" * 3]
VALUES += ["[" * 3000, "9" * 5000, "NaN", "Infinity", "-", "1e400", "=", " ", "\n", "\0"]
TIMES = ["1", "0.1", "s", "ms", "min", "h", "e", "-", "+", ".", "1e999", "٣", " ", "days"]
CONDITIONS = ["norm(", "max(", "min(", ")", "plant.omega_BN_B", "plant.q_BN[1]", "<", "<=", ">", ">=", "=", " ", "1e-4"]
CONDITIONS += ["nan", "inf", " " * 3000, "(" * 500, "plant.kinetic_energy", "der(plant.q_BN)", "time", "abs(", "0"]
CONDITIONS += [
    " and ",
    " or ",
    " not ",
    "not " * 900,
    "-" * 900,
    "+time" * 900,
    "time < 5 and " * 300,
    "+",
    "*",
    "/",
    ",",
]

ASSIGNED = st.tuples(
    st.sampled_from(
        ["tracker.half_angle", "plant.torque_B", "plant.J_B", "tracker.seed", "plant.q", "x.y", "torque_B[2]"]
    ),
    st.sampled_from(["=", "=", "=", " = ", "==", " "]),
    st.sampled_from(
        ["0.05", "3deg", "1e-3 rad", "1,2,3", "[1,2,3]", "[[1,0,0],[0,1,0],[0,0,1]]", "[[1],[2,3]]deg", "x", "5"]
    ),
).map("".join)


@given(ASSIGNED | of_words([*VARIABLES, *VALUES], 10))
def test_assignments(text: str) -> None:
    def apply() -> None:
        name, value = assigned(SYSTEM, text)
        SYSTEM.set(name, value)

    attempt("--set", apply, len(text))


@given(st.sampled_from(["tracker.half_angle=", "plant.J_B=", "plant.torque_B=", "tracker.seed="]), of_words(VALUES, 5))
def test_values(name: str, text: str) -> None:
    def apply() -> None:
        SYSTEM.set(*assigned(SYSTEM, name + text))

    attempt("--set", apply, len(text))


@given(
    st.tuples(st.sampled_from(["1", "-0.5", "1e3", "1e999", "٣", ""]), st.sampled_from(TIMES)).map("".join)
    | of_words(TIMES, 5)
)
def test_times(text: str) -> None:
    came, time = attempt("times", lambda: seconds(text, "--at"), len(text))
    if came:
        assert np.isfinite(time)


@given(
    st.tuples(st.sampled_from(["1 ", "5ms ", "2min ", "x "]), ASSIGNED).map("".join)
    | of_words([*TIMES, *VARIABLES, *VALUES, " ", "="], 10)
)
def test_changes(text: str) -> None:
    attempt("--at", lambda: change(SYSTEM, text), len(text))


@given(
    st.tuples(
        st.sampled_from(["tracker.q_BN=", "tracker=", "plant=", ""]),
        st.sampled_from(["2", "0.1s", "9" * 5000, "٣", "-1", "x"]),
    ).map("".join)
    | of_words(["tracker.q_BN", "plant", "=", *TIMES], 5)
)
def test_delays_and_rates(text: str) -> None:
    attempt("--delay", lambda: delay(SYSTEM, text), len(text))
    attempt("--every", lambda: every(SYSTEM, text), len(text))


LEFT = ["norm(plant.omega_BN_B)", "max( plant.q_BN )", "plant.kinetic_energy", "plant.q_BN[2]", "plant.q_BN", "norm(x)"]
BOUNDS = ["1e-4", "-3", "nan", "inf", "", "1 2", "plant.q_BN[1]"]


@given(
    st.tuples(*map(st.sampled_from, (LEFT, ["<", " <= ", ">", ">=", "=", "<>"], BOUNDS))).map("".join)
    | of_words(CONDITIONS, 8)
)
def test_conditions(text: str) -> None:
    came, condition = attempt("--until", lambda: Condition.parse(text, SYSTEM, RECORDING), len(text))
    if came:
        assert condition.first(np.arange(3.0), np.zeros((3, RECORDING.size))) in (None, 0, 1, 2)


NAMED = st.tuples(
    st.sampled_from(["plant.", "tracker.", "plnt.", "plant"]),
    st.sampled_from(["torque_B", "q_BN", "J_B", "half_angle", "der(q_BN)", "time"]),
    st.sampled_from(["", "[1]", "[ 3 ]", "[1,1]", "[0]", "[4]", "[4000000000]", "[-1]", "[1", "[]"]),
).map("".join)


@given(NAMED | of_words([*VARIABLES, *ODD], 4))
def test_names(text: str) -> None:
    attempt("names of variables", lambda: SYSTEM.end(text), len(text))


@given(
    st.sampled_from(["norm({})", "max( {} )", " min({}) "]),
    st.sampled_from(["<", "<=", ">", ">="]),
    st.floats(allow_nan=False, allow_infinity=False),
)
def test_conditions_that_are_right(function: str, comparison: str, bound: float) -> None:
    text = f"{function.format('plant.omega_BN_B')} {comparison} {bound!r}"
    rows = np.zeros((4, RECORDING.size))
    first = sum(
        port.size for name, port in list(RECORDING.ports.items())[: RECORDING.names.index(("plant", "omega_BN_B"))]
    )
    rows[:, first : first + 3] = values = np.array(
        [[bound, 0, 0], [-1.0, 2.0, 3.0], [0, 0, np.nan], [-4.0, bound, 1e9]]
    )
    compare = {"<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal}[comparison]
    apply = {
        "norm": lambda v: np.linalg.norm(v, axis=1),
        "max": lambda v: v.max(axis=1),
        "min": lambda v: v.min(axis=1),
    }
    with np.errstate(over="ignore"):
        met = compare(apply[function.split("(")[0].strip()](values), bound)
    for times in (np.arange(4.0), np.zeros(4)):
        found = Condition.parse(text, SYSTEM, RECORDING).first(times, rows)
        assert found == (int(np.flatnonzero(met)[0]) if met.any() else None)
    assert Condition.parse(f"not ({text})", SYSTEM, RECORDING).first(np.zeros(1), rows[2:3]) is None


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_come_back_from_text_to_the_last_bit(value: float) -> None:
    assert float(parse_value(TRACKER, HALF_ANGLE, repr(value))).hex() == value.hex()
    assert parse_value(TRACKER, HALF_ANGLE, f"{value!r}deg") == value / 57.29577951308232


@given(
    st.lists(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=3, max_size=3), min_size=3, max_size=3)
)
def test_matrices_come_back_from_text_to_the_last_bit(rows: list[list[float]]) -> None:
    port = SYSTEM.port("plant.J_B")[1]
    assert parse_value(SYSTEM.components["plant"].fmu, port, json.dumps(rows)) == rows


@pytest.mark.parametrize(
    ("text", "seconds_"), [("120s", 120.0), ("5ms", 0.005), ("2min", 120.0), ("1h", 3600.0), ("-1.5", -1.5)]
)
def test_times_that_are_right(text: str, seconds_: float) -> None:
    assert seconds(text, "--at") == seconds_
