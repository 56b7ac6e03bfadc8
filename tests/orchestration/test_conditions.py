"""Conditions that end a run: what they mean row by row, which names they find, and what is refused."""

import operator
import sys
from collections.abc import Callable
from types import FrameType
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import adcs
from adcs import AdcsError, CoSimulation, Save, System, run
from adcs.catalogue import SYSTEMS
from orchestration.results.result import Recording
from orchestration.running.conditions.condition import Condition
from orchestration.running.hooks.until import Until

PLANT = System("two")
PLANT.add("plant", "RigidBody")
ENERGY, Q2 = ("plant.kinetic_energy", 0), ("plant.q_BN[2]", 1)
NAN = float("nan")


def condition(text, system=PLANT, record=None):
    return Condition.parse(text, system, Recording(system, record))


def met(text, values, times=None):
    """Of each of these values of the kinetic energy (J), whether the condition is met there."""
    recording = Recording(PLANT, ["plant.kinetic_energy"])
    found = Condition.parse(text, PLANT, recording)
    times = np.arange(float(len(values))) if times is None else np.array(times)
    return [found.first(times[i : i + 1], np.array([[value]])) == 0 for i, value in enumerate(values)]


@pytest.mark.parametrize("stepping", ["compiled", "python"])
@pytest.mark.parametrize(
    ("text", "end"),
    [
        ("source.y[1] >= 2 and time > 3", 3.25),
        ("source.y[1] >= 4 or time >= 1.5", 1.5),
        ("not source.y[3] < 4", 1.0),
        ("not (source.y[3] < 4 or time <= 2)", 2.25),
        ("2.5 < source.y[1] <= 3", 1.75),
        ("abs(source.y[1] - 3) < 0.1", 2.0),
        ("-source.y[2] * 2 + 1 < -10 / 2", 1.25),
        ("min(gain.y) / max(gain.y) > 0.5", 1.25),
        ("norm(source.y) > 2 * norm(gain.y[1]) - 3", 0.0),
        ("1 / (time - 1) > 1e300", 1.0),
        ("1/source.y[1] < 0.25", 3.25),
        ("time >= 9.9", 10.0),
        ("max(source.y) - min(source.y) > 2.5 or time < -1", None),
    ],
)
def test_a_run_ends_with_the_first_row_that_meets_it(chain, stepping, text, end):
    result = run(chain(), stop_time=10, step=0.25, method=CoSimulation(stepping=stepping), hooks=[adcs.until(text)])
    assert result.time[-1] == (10.0 if end is None else end)
    assert result.manifest["outcome"].get("met") == (None if end is None else {"condition": text, "time": end})


def test_time_is_that_of_the_row_whichever_rows_are_kept(chain):
    every_third = run(
        chain(), start_time=100, stop_time=120, step=0.25, save=Save(every=3), hooks=[adcs.until("time > 110")]
    )
    assert every_third.time.tolist() == [100 + 0.75 * k for k in range(15)]  # 110.5 s is the first row after 110 s
    shorter = run(SYSTEMS["observer-pd"].build(), stop_time=0.25, step=0.1, hooks=[adcs.until("time > 0.2")])
    assert shorter.time.tolist() == [0.0, 0.1, 0.2, 0.25]
    assert shorter.manifest["outcome"]["met"] == {"condition": "time > 0.2", "time": 0.25}


@pytest.mark.parametrize("order", [("time >= 2", "time >= 1.5"), ("time >= 1.5", "time >= 2")])
def test_of_several_conditions_the_first_that_is_met_ends_the_run(chain, order):
    watched, until = order
    result = run(chain(), stop_time=10, step=0.25, hooks=[adcs.until(until), Until(watched)])
    assert result.manifest["outcome"]["met"] == {"condition": "time >= 1.5", "time": 1.5}


def test_a_comparison_with_nan_never_holds():
    values = [NAN, 1.0, 3.0]
    assert met("plant.kinetic_energy < 2", values) == [False, True, False]
    assert met("not plant.kinetic_energy < 2", values) == [False, False, True]
    assert met("not not plant.kinetic_energy < 2", values) == [False, True, False]
    assert met("not (plant.kinetic_energy < 2 and time >= 0)", values) == [False, False, True]
    assert met("plant.kinetic_energy < 2 or time >= 0", values) == [True, True, True]
    assert met("abs(plant.kinetic_energy * 0 / 0) >= 0", [1.0]) == [False]
    assert met("max(plant.kinetic_energy) + 1 > 0 or not -plant.kinetic_energy < 5", [NAN]) == [False]


def test_what_binds_tighter():
    assert met("plant.kinetic_energy + 2 * 3 - 8 / 4 / 2 < 6", [0.5, 1.5]) == [True, False]
    assert met("time > 5 or time >= 0 and plant.kinetic_energy > 2", [1.0, 3.0]) == [False, True]
    assert met("(time > 5 or time >= 0) and plant.kinetic_energy > 2", [1.0, 3.0], [9.0, 9.0]) == [False, True]
    assert met("not time > 5 and plant.kinetic_energy > 2", [3.0, 3.0], [9.0, 1.0]) == [False, True]
    assert met("not 1 < plant.kinetic_energy < 3", [1.0, 2.0, 3.0]) == [True, False, True]
    assert met("-plant.kinetic_energy - -1 > +0", [0.5, 1.5]) == [True, False]
    assert met(" \n plant.kinetic_energy\t<2\nand(time)<.5e1 ", [1.0, 1.0], [1.0, 5.0]) == [True, False]


Part = tuple[str, Callable[[float, float], Any]]
"""A text, and what it is by an energy (J) and a time (s)."""

ARITHMETIC = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide}
SIGNS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}


def number(value: float) -> Part:
    return f"({value!r})", lambda e, t: value


def result_of(left: Part, sign: str, right: Part) -> Part:
    return f"({left[0]} {sign} {right[0]})", lambda e, t: ARITHMETIC[sign](left[1](e, t), right[1](e, t))


def size(part: Part) -> Part:
    return f"abs({part[0]})", lambda e, t: abs(part[1](e, t))


def negative(part: Part) -> Part:
    return f"(-{part[0]})", lambda e, t: -part[1](e, t)


def comparison(left: Part, sign: str, right: Part) -> Part:
    """True, False, or None with NaN."""

    def truth(e: float, t: float) -> bool | None:
        one, other = left[1](e, t), right[1](e, t)
        return None if np.isnan(one) or np.isnan(other) else bool(SIGNS[sign](one, other))

    return f"{left[0]} {sign} {right[0]}", truth


def both(one: Part, other: Part) -> Part:
    def truth(e: float, t: float) -> bool | None:
        truths = one[1](e, t), other[1](e, t)
        return False if False in truths else None if None in truths else True

    return f"({one[0]}) and ({other[0]})", truth


def inverse(part: Part) -> Part:
    def truth(e: float, t: float) -> bool | None:
        value = part[1](e, t)
        return None if value is None else not value

    return f"not ({part[0]})", truth


def either(one: Part, other: Part) -> Part:
    return f"({one[0]}) or ({other[0]})", inverse(both(inverse(one), inverse(other)))[1]


NUMBERS = st.recursive(
    st.sampled_from([-2.0, 0.0, 0.5, 3.0, 1e300]).map(number)
    | st.sampled_from([("plant.kinetic_energy", lambda e, t: e), ("time", lambda e, t: t)]),
    lambda of: (
        st.builds(result_of, of, st.sampled_from(sorted(ARITHMETIC)), of)
        | st.builds(size, of)
        | st.builds(negative, of)
    ),
    max_leaves=4,
)
TRUTHS = st.recursive(
    st.builds(comparison, NUMBERS, st.sampled_from(sorted(SIGNS)), NUMBERS),
    lambda of: st.builds(both, of, of) | st.builds(either, of, of) | st.builds(inverse, of),
    max_leaves=5,
)


@given(TRUTHS, st.lists(st.sampled_from([NAN, -1.0, 0.0, 0.5, 2.0, float("inf")]), min_size=1, max_size=4))
def test_conditions_are_what_their_parts_say(truth, values):
    text, expected = truth
    text = f"({text}) and time >= -1"  # so that there is a variable in it
    with np.errstate(all="ignore"):
        assert met(text, values) == [expected(value, float(i)) is True for i, value in enumerate(values)]


def test_rows_are_taken_all_at_once():
    rows = np.zeros((6, 4))
    rows[:, 1] = [0, 1, 2, 3, NAN, 5]
    found = condition("plant.q_BN[2] > 1 and time < 0.45", record=["plant.q_BN"])
    assert found.first(0.1 * np.arange(6), rows) == 2
    assert found.first(0.1 * np.arange(6) + 1, rows) is None
    assert found.first(np.zeros(0), rows[:0]) is None
    assert condition("time >= 0 or plant.q_BN[1] > 1", record=["plant.q_BN"]).first(np.arange(6.0), rows) == 0


def test_elements_of_matrices(mock):
    system = System("typed")
    system.add("typed", mock("typed"))
    rows = np.arange(12.0).reshape(2, 6)
    for element, first in (("[1,3] > 7", 1), ("[ 2, 1] < 4", 0), ("[2,3] < 5", None)):
        found = condition(f"typed.matrix{element} and time < 1", system, ["typed.matrix"])
        assert found.first(np.zeros(2), rows) == first


@pytest.mark.parametrize("name", ["star-tracker", "a and b", "sub/plant", "time", "norm", "3 * x", "plant(1)", "größe"])
def test_names_with_signs_and_words_in_them(name):
    system = System("odd")
    system.add(name, "RigidBody")
    system.add("x", "RigidBody")
    rows = np.zeros((3, 8))
    rows[:, :4] = [[1.0, 0, 0, 0], [2.0, 0, 0, 0], [3.0, 0, 0, 0]]
    rows[:, 4:] = [[5.0, 0, 0, 0], [4.0, 0, 0, 0], [0.0, 0, 0, 0]]
    record = [f"{name}.q_BN", "x.q_BN"]
    for text, first in (
        (f"{name}.q_BN[1] > 1.5", 1),
        (f"norm({name}.q_BN) >= 3", 2),
        (f"{name}.q_BN[1]*2>x.q_BN[1] and time>0", 2),
        (f"abs(-{name}.q_BN[1]) > 1 or time > 7", 1),
        (f"x.q_BN[1]/{name}.q_BN[1] < 4", 1),
    ):
        found = condition(text, system, record)
        assert found.first(np.array([0.0, 0.0, 1.0]), rows) == first, text


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("time > 20s", 3),
        ("time > 2min", 4),
        ("time>=1 min", 3),
        ("time - 1h < 0.5h and time > 5000ms", 1),
        ("not time <= 1e7us", 2),
        ("time > 2*1e1s", 3),
        ("20s<time<1h", 3),
        ("max(plant.q_BN) > 3 or time > 20 s", 3),
    ],
)
def test_times_have_units(text, first):
    found = condition(text, record=["plant.q_BN"])
    assert found.first(np.array([0.0, 10.0, 20.0, 60.0, 121.0]), np.zeros((5, 4))) == first


def test_a_component_may_be_called_as_a_unit_is():
    system = System("odd")
    system.add("s", "RigidBody")
    found = condition("time > 1 or 2 < s.q_BN[1]", system, ["s.q_BN"])
    assert found.first(np.array([0.0, 0.5, 1.5]), np.array([[0.0, 0, 0, 0], [3.0, 0, 0, 0], [0, 0, 0, 0]])) == 1


def test_the_longest_name_is_meant():
    found = condition("plant.der(q_BN)[1] > 1 and plant.q_BN[1] > 1", record=["plant.q_BN", "plant.der(q_BN)"])
    rows = np.array([[2.0, 0, 0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 2.0, 0, 0, 0], [2.0, 0, 0, 0, 2.0, 0, 0, 0]])
    assert found.first(np.zeros(3), rows) == 2


EXAMPLE = "write it as in norm(plant.omega_BN_B) < 1e-3 and time > 20s"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time = 3", f"'=' at character 6 has no meaning; {EXAMPLE}"),
        ("plant.kinetic_energy == 3", f"'=' at character 22 has no meaning; {EXAMPLE}"),
        ("t > 3 and time > 2", f"'t' at character 1 has no meaning; {EXAMPLE}"),
        ("time > 20sec", "'20sec' at character 8 is no number: 'sec' is no unit, use us or ms or s or min or h; "),
        ("time > 2 parsec", f"'parsec' at character 10 has no meaning; {EXAMPLE}"),
        ("time > 3 or plant.kinetic_energy > 2s", "'2s' at character 36 is a time, and is compared with no `time`; "),
        ("time > 1e308h", f"'1e308h' at character 8 is beyond what a number can hold; {EXAMPLE}"),
        ("sin(time) > 0.5", f"'sin' at character 1 has no meaning (did you mean min?); {EXAMPLE}"),
        ("'a' < time", '"\'a\'" at character 1 has no meaning; write'),
        ("[x for x in time] < 5", f"'[' at character 1 has no meaning; {EXAMPLE}"),
        ("time if time else time", f"'if' at character 6 has no meaning; {EXAMPLE}"),
        ("kinetic_energy > 3 or time > 2", "at character 1 has no meaning (did you mean plant.kinetic_energy"),
        ("plant.q_BN[1]plant.q_BN[2] > 3", f"'plant.q_BN[2] > 3' at character 14 is not readable; {EXAMPLE}"),
        ("time > plant.q_BN[1]and time > 3", f"'and time > 3' at character 21 is not readable; {EXAMPLE}"),
        ("plnt.kinetic_energy > 3 and time > 2", "has no component 'plnt': did you mean plant?"),
        ("plant.kinetic_enrgy > 3 and time > 2", "has no variable 'kinetic_enrgy': did you mean kinetic_energy?"),
        ("plant.q_BN[5] > 3 and time > 2", "plant.q_BN[5] does not exist: plant.q_BN has 4 values, counted from 1"),
        ("plant.q_BN > 3 and time > 2", "plant.q_BN is an array, use norm(), max(), min() or one element of it"),
        ("plant.mass > 3 and time > 2", "has no variable 'mass'"),
        ("norm(plant.J_B) > 3 and time > 2", "plant.J_B is not recorded, and has to be"),
        ("max(time) > 3", f"'max(time)' at character 1 is no number, max() takes one recorded variable; {EXAMPLE}"),
        ("norm(plant.q_BN, time) > 3", "at character 1 is no number, norm() takes one recorded variable"),
        ("abs(time, time) > 3", f"'abs(time, time)' at character 1 is no number; {EXAMPLE}"),
        ("time ** 2 > 3", f"'time ** 2' at character 1 is no number; {EXAMPLE}"),
        ("(time > 3) + 1 > 2", f"'time > 3' at character 2 is no number; {EXAMPLE}"),
        ("time and time > 3", f"'time' at character 1 is no comparison; {EXAMPLE}"),
        ("plant.kinetic_energy(2) > 3", f"'plant.kinetic_energy(2)' at character 1 is no number; {EXAMPLE}"),
        ("time > 3 and", f"it ends too early; {EXAMPLE}"),
        ("", f"it ends too early; {EXAMPLE}"),
        ("time > 3)", f"')' at character 9 is not readable; {EXAMPLE}"),
        ("time > 1e999", f"'1e999' at character 8 is beyond what a number can hold; {EXAMPLE}"),
        ("time > 1__0", f"'1__0' at character 8 has no meaning; {EXAMPLE}"),
        ("time > " + "9" * 200_000 + "x", f"'{'9' * 39}... at character 8 is no number: 'x' is no unit, use us or "),
        ("1 < 2 and 2 < 3", f"no variable is in it; {EXAMPLE}"),
        ("time" + "+time" * 60 + " > 3", "it is nested deeper than 50 levels"),
        ("not " * 900 + "time > 3", "it is nested deeper than 50 levels"),
        ("-" * 900 + "time > 3", "it is nested deeper than 50 levels"),
        ("time > 3 and " * 400 + "time > 3", "it has more than 1000 names, numbers, words and signs"),
        ("(" * 900 + "time" + ")" * 90 + " > 3", "((("),
    ],
)  # fmt: skip
def test_refused(text, message):
    with pytest.raises(AdcsError) as error:
        condition(text)
    said = str(error.value)
    assert said.startswith(f"condition {repr(text)[:200]}")
    assert message in said
    assert len(said.splitlines()) == 1


def test_depth_is_refused_however_little_stack_is_left():
    limit, depth = sys.getrecursionlimit(), 0
    frame: FrameType | None = sys._getframe()
    while frame is not None:
        depth, frame = depth + 1, frame.f_back
    sys.setrecursionlimit(depth + 60)
    try:
        with pytest.raises(AdcsError, match="nested deeper than 50 levels"):
            condition("-" * 800 + "time > 3")
    finally:
        sys.setrecursionlimit(limit)
