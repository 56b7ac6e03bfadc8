"""The whole table of units: names mean what an independent reader takes them for, and each can be that of a state."""

import math
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from lxml import etree

import adcs
from fmus.build import describe
from fmus.describe import Description, Unit
from fmus.model_description import fmi2, fmi3
from fmus.paths import SOURCES
from tests.mock_header import mock_header

TABLE = dict(
    re.findall(r'inline constexpr Unit (\w+)\{"([^"]+)"', (SOURCES / "fmi" / "units.hpp").read_text(encoding="utf-8"))
)
"""The names of units, by their names in C++."""

BASE = ("kg", "m", "s", "A", "K", "rad")
IN_OTHERS = {
    "N": "kg m s-2",
    "J": "N m",
    "W": "J s-1",
    "Pa": "N m-2",
    "Hz": "s-1",
    "C": "A s",
    "V": "W A-1",
    "F": "C V-1",
    "ohm": "V A-1",
    "Wb": "V s",
    "T": "Wb m-2",
    "H": "Wb A-1",
    "km": "m",
    "min": "s",
    "h": "s",
    "deg": "rad",
    "rpm": "rad s-1",
    "1": "",
    "%": "",
    "ppm": "",
}
FACTORS = {
    "km": 1000,
    "min": 60,
    "h": 3600,
    "%": 0.01,
    "ppm": 1e-6,
    "deg": math.pi / 180,
    "rpm": 2 * math.pi / 60,
}

BODY = """\
    {members}

    template <class V>
    void declare(V& v) {{
        {declared}
    }}
    void derivatives() {{
        {body}
    }}
"""


def law(folder: Path, units: tuple[str, ...], own: str = "") -> Path:
    """A header with a state in each unit, whose name in C++ it has."""
    header = folder / "units.hpp"
    body = BODY.format(
        members="\n    ".join(f"T x_{u} = 1.0, x_{u}_dot = 0.0;" for u in units),
        declared="\n        ".join(f'v.state("x_{u}", x_{u}, x_{u}_dot, unit::{u}, "state");' for u in units),
        body="\n        ".join(f"x_{u}_dot = -x_{u};" for u in units),
    )
    header.write_text(mock_header("Units", body, "states", own=own))
    return header


def meaning(name: str) -> tuple[dict[str, int], float]:
    """The exponents of base units that are not 0, and the factor."""
    above, _, below = name.partition("/")
    exponents, factor = Counter[str](), 1.0
    for part, sign in ((above, 1), (below.removeprefix("(").removesuffix(")"), -1)):
        for word in filter(None, part.split(".")):
            symbol, power = re.fullmatch(r"(1|%|[A-Za-z]+)(\d*)", word).groups()
            power = sign * int(power or 1)
            factor *= FACTORS.get(symbol, 1) ** power
            for base, exponent in in_base(symbol):
                exponents[base] += power * exponent
    return {base: n for base, n in exponents.items() if n != 0}, factor


def in_base(symbol: str) -> Iterator[tuple[str, int]]:
    if symbol in BASE:
        yield symbol, 1
        return
    for word in IN_OTHERS[symbol].split():
        other, exponent = re.fullmatch(r"([A-Za-z]+)(-?\d*)", word).groups()
        yield from ((base, int(exponent or 1) * n) for base, n in in_base(other))


@pytest.fixture(scope="module")
def descriptions(tmp_path_factory: pytest.TempPathFactory) -> list[Description]:
    """Of components that have a state in each unit of the table, as many as fit."""
    names = tuple(TABLE)
    parts = (names[i : i + 40] for i in range(0, len(names), 40))
    return [describe(str(law(tmp_path_factory.mktemp("units"), part))) for part in parts]


@pytest.fixture(scope="module")
def units(descriptions: list[Description]) -> dict[str, Unit]:
    return {unit.name: unit for d in descriptions for unit in d.units}


def test_the_table_is_read() -> None:
    assert len(TABLE) > 90
    assert len(set(TABLE.values())) == len(TABLE)
    assert {"A.m2", "A", "V", "K", "Hz", "rpm", "Wb", "T.m2", "N.m.s/rad", "%"} <= set(TABLE.values())


def test_names_in_the_code_say_the_unit() -> None:
    words = {"1": "one", "%": "percent"}
    for code, name in TABLE.items():
        spelt = re.sub(r"[.(]", "_", name.replace("/(", "/").replace(")", "")).replace("/", "_per_")
        assert code == words.get(name, re.sub(r"^1_", "one_", spelt))


def test_exponents_and_factors_are_those_of_the_name(units: dict[str, Unit]) -> None:
    assert set(TABLE.values()) <= set(units)
    for name, unit in units.items():
        exponents, factor = meaning(name)
        assert unit.exponents == exponents, name
        assert unit.factor == pytest.approx(factor, rel=4e-16), name


def test_every_unit_has_one_for_the_rate(descriptions: list[Description], units: dict[str, Unit]) -> None:
    for d in descriptions:
        variables = {v.vr: v for v in d.variables}
        rates = [v for v in d.variables if v.derivative_of is not None]
        assert len(rates) == sum(v.name.startswith("x_") for v in d.variables)
        for rate in rates:
            state, per_second = units[variables[rate.derivative_of].unit], units[rate.unit]
            expected = Counter(state.exponents)
            expected["s"] -= 1
            assert per_second.exponents == {base: n for base, n in expected.items() if n != 0}, rate.unit
            assert per_second.factor == state.factor


def test_rates_have_names_that_people_write(descriptions: list[Description]) -> None:
    unit = {v.name: v.unit for d in descriptions for v in d.variables}
    written = {
        "N": "N/s",
        "m_per_s2": "m/s3",
        "kg_per_s": "kg/s2",
        "N_per_m": "N/(m.s)",
        "deg_per_h": "deg/(h.s)",
        "one_per_kg_m2_s": "1/(kg.m2.s2)",
        "W_per_m2_K": "W/(m2.K.s)",
        "K": "K/s",
        "one": "1/s",
        "percent": "%/s",
        "rad_per_s3": "rad/s4",
        "N_m_s": "N.m",
        "C": "A",
        "T_m2": "V",
        "s2": "s",
        "J": "W",
        "rpm": "rpm/s",
    }
    assert {code: unit[f"der(x_{code})"] for code in written} == written


def test_people_see_degrees_and_microteslas(units: dict[str, Unit]) -> None:
    shown = {name: [(d.name, d.factor) for d in unit.display] for name, unit in units.items() if unit.display}
    degrees = pytest.approx(180 / math.pi)
    assert shown == {
        "rad": [("deg", degrees)],
        **{f"rad/s{n}": [(f"deg/s{n}", degrees)] for n in ("", 2, 3, 4)},
        "T": [("uT", 1e6)],
        "T/s": [("uT/s", 1e6)],
        "T/s2": [("uT/s2", 1e6)],
    }


@pytest.mark.parametrize("xml", [fmi2, fmi3])
def test_unit_definitions_of_both_standards(descriptions: list[Description], xml) -> None:
    for d in descriptions:
        definitions = etree.fromstring(xml(d)).findall("UnitDefinitions/Unit")
        assert len({unit.get("name") for unit in definitions}) == len(definitions) == len(d.units)
        for unit in definitions:
            exponents, factor = meaning(unit.get("name"))
            said = dict(unit.find("BaseUnit").attrib)
            assert float(said.pop("factor", 1)) == pytest.approx(factor, rel=4e-16)
            assert {base: int(n) for base, n in said.items()} == exponents


def test_a_component_with_such_states_is_an_fmu_without_findings(tmp_path: Path) -> None:
    header = law(tmp_path, ("N_m", "T", "W", "K", "rpm", "kg_per_s", "N_per_m"))
    assert len(adcs.build([str(header)])) == 2
    assert not [f for f in adcs.check(header) if f.severity != "note"]


def test_one_of_your_own_is_a_line(tmp_path: Path) -> None:
    own = 'namespace unit {\ninline constexpr Unit m_per_N{"m/N"};\n}\n'
    own += 'namespace unit {\ninline constexpr Unit packets{"packet", Dimension{}};\n}\n'
    found = describe(str(law(tmp_path, ("m_per_N", "packets"), own)))
    assert {u.name: u.exponents for u in found.units} == {
        "s": {"s": 1},
        "m/N": {"kg": -1, "s": 2},
        "m/(N.s)": {"kg": -1, "s": 1},
        "packet": {},
        "packet/s": {"s": -1},
    }


@pytest.mark.parametrize("name", ["Nm", "N.", "N/m/s", "J/kg.K", "N/(m", "", "N m", "m-2"])
def test_a_name_of_unknown_symbols_is_refused(tmp_path: Path, name: str) -> None:
    own = f'namespace unit {{\ninline constexpr Unit mine{{"{name}"}};\n}}\n'
    with pytest.raises(adcs.AdcsError, match=r"is made of symbols that units\.hpp has not"):
        describe(str(law(tmp_path, ("mine",), own)))


def test_two_units_of_one_name_are_refused(tmp_path: Path) -> None:
    own = 'namespace unit {\ninline constexpr Unit mine{"N", Dimension{1}};\n}\n'
    with pytest.raises(adcs.AdcsError, match="the unit of x_mine has the name of another one"):
        describe(str(law(tmp_path, ("N", "mine"), own)))
