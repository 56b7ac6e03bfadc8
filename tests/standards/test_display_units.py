"""Values in display units: shown = factor * value + offset, or factor / value where the unit is inverse."""

import pytest

from adcs import AdcsError
from orchestration.fmu.file import open_fmu
from orchestration.fmu.values import parse_value

from .small import description2, description3, packed

VARIABLES = (
    '<Float64 name="p" valueReference="1" unit="S"/><Float64 name="t" valueReference="2" unit="K"/>'
    '<Float64 name="d" valueReference="3" unit="K" relativeQuantity="true"/>'
    '<Float64 name="c" valueReference="4" unit="l/100km"/><Float64 name="w" valueReference="5" unit="s"/>'
)
UNITS = (
    '<Unit name="S"><DisplayUnit name="Ohm" inverse="true"/><DisplayUnit name="mS" factor="1000"/></Unit>'
    '<Unit name="K"><DisplayUnit name="degF" factor="1.8" offset="-459.67"/>'
    '<DisplayUnit name="zero" factor="0"/><DisplayUnit name="endless" factor="INF"/>'
    '<DisplayUnit name="none" factor="NaN"/><DisplayUnit name="far" offset="INF"/>'
    '<DisplayUnit name="near" offset="-INF"/></Unit>'
    '<Unit name="s"><DisplayUnit name="void" factor="0" inverse="true"/>'
    '<DisplayUnit name="lots" factor="-INF" inverse="true"/></Unit>'
    '<Unit name="l/100km"><DisplayUnit name="mpg" factor="235.214583" inverse="true"/></Unit>'
)


@pytest.fixture
def fmu(tmp_path):
    return open_fmu(packed(tmp_path / "c.fmu", description3(VARIABLES, units=UNITS)))


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("p", "4Ohm", 0.25),
        ("p", "-0.5Ohm", -2.0),
        ("p", "4S", 4.0),
        ("p", "4", 4.0),
        ("p", "4mS", 0.004),
        ("t", "-459.67degF", 0.0),
        ("t", "0degF", 459.67 / 1.8),
        ("d", "18degF", 10.0),  # a difference has no offset
        ("c", "58.80364575mpg", 4.0),
    ],
)
def test_a_value_in_a_display_unit(fmu, name, text, value):
    assert float(parse_value(fmu, fmu.ports[name], text)) == pytest.approx(value, rel=1e-15, abs=1e-13)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("p", "0Ohm", "p = '0Ohm' is not finite in S: expected a finite number"),
        ("t", "3zero", "t = '3zero' is not finite in K: expected a finite number"),
        ("t", "3endless", "t = '3endless' is not finite in K: expected a finite number"),
        ("t", "3none", "t = '3none' is not finite in K: expected a finite number"),
        ("t", "3far", "t = '3far' is not finite in K: expected a finite number"),
        ("t", "3near", "t = '3near' is not finite in K: expected a finite number"),
        ("w", "3void", "w = '3void' is not finite in s: expected a finite number"),
        ("w", "3lots", "w = '3lots' is not finite in s: expected a finite number"),
        ("p", "1e999Ohm", "p = '1e999Ohm' is not finite in S: expected a finite number"),
        ("p", "InfinityOhm", "p = 'InfinityOhm' is not finite in S: expected a finite number"),
        ("p", "[[1],[2,3]]Ohm", "p = '[[1],[2,3]]Ohm': expected numbers before 'Ohm'"),
    ],
)
def test_values_that_are_none_in_the_unit_are_refused(fmu, name, text, message):
    with pytest.raises(AdcsError) as error:
        parse_value(fmu, fmu.ports[name], text)
    assert str(error.value) == message


def test_an_inverse_unit_with_an_offset_is_refused(tmp_path):
    units = '<Unit name="S"><DisplayUnit name="Ohm" inverse="true" offset="2"/></Unit>'
    with pytest.raises(AdcsError) as error:
        open_fmu(packed(tmp_path / "c.fmu", description3("", units=units)))
    assert str(error.value) == (
        f"{tmp_path}/c.fmu is not valid: line 1: the display unit 'Ohm' of 'S' is inverse and has the offset 2: "
        "expected none"
    )


def test_display_units_of_fmi_2(tmp_path):
    variable = '<ScalarVariable name="t" valueReference="1"><Real unit="K"/></ScalarVariable>'
    units = '<Unit name="K"><DisplayUnit name="degC" factor="1" offset="-273.15"/></Unit>'
    fmu = open_fmu(packed(tmp_path / "c.fmu", description2(variable, units=units)))
    assert float(parse_value(fmu, fmu.ports["t"], "0degC")) == 273.15
