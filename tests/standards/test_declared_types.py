"""What a declared type says, the variables of that type say where they say nothing themselves."""

import pytest

from adcs import AdcsError
from orchestration.fmu.file import open_fmu
from orchestration.fmu.ranges import declared_ranges
from orchestration.fmu.typed_values import item_numbers
from orchestration.fmu.values import parse_value

from .small import description2, description3, packed

UNITS = '<Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" offset="-273.15"/></Unit>'
SAYS = (
    'quantity="T" unit="K" displayUnit="degC" relativeQuantity="true" min="-1" max="2.5" nominal="4" unbounded="true"'
)


@pytest.fixture
def opened(tmp_path):
    def make(version, variables, types):
        write = description2 if version == "2.0" else description3
        return open_fmu(packed(tmp_path / "c.fmu", write(variables, types, UNITS)))

    return make


def real(version, said=""):
    """A variable `v` of the declared type T, and what it says itself."""
    if version == "2.0":
        variable = f'<ScalarVariable name="v" valueReference="1"><Real declaredType="T" {said}/></ScalarVariable>'
        return variable, f'<SimpleType name="T"><Real {SAYS}/></SimpleType>'
    return f'<Float64 name="v" valueReference="1" declaredType="T" {said}/>', f'<Float64Type name="T" {SAYS}/>'


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_every_attribute_of_a_type_is_the_default(opened, version):
    fmu = opened(version, *real(version))
    _, variable = fmu.model.modelVariables
    assert (fmu.ports["v"].unit, fmu.ports["v"].relative) == ("K", True)
    assert (variable.displayUnit, variable.quantity, variable.unbounded) == ("degC", "T", True)
    assert float(variable.nominal) == 4.0
    assert declared_ranges(fmu) == {"v": (-1.0, 2.5)}
    assert parse_value(fmu, fmu.ports["v"], "5degC") == 5.0


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_what_a_variable_says_itself_counts_more(opened, version):
    fmu = opened(version, *real(version, 'unit="1" relativeQuantity="false" max="9" nominal="7" unbounded="false"'))
    _, variable = fmu.model.modelVariables
    assert (fmu.ports["v"].unit, fmu.ports["v"].relative, variable.unbounded) == ("1", False, False)
    assert float(variable.nominal) == 7.0
    assert declared_ranges(fmu) == {"v": (-1.0, 9.0)}


def test_enumerations_with_other_items_are_no_array(opened):
    of = (
        '<ScalarVariable name="{0}" valueReference="{1}" causality="parameter" variability="tunable"><Enumeration {2}/>'
    )
    said = (
        ("e[1]", 1, 'declaredType="A" start="1"'),
        ("e[2]", 2, 'declaredType="B" start="5"'),
        ("f[1]", 3, 'declaredType="A" start="1" max="1"'),
        ("f[2]", 4, 'declaredType="A" start="2"'),
        ("g[1]", 5, 'declaredType="A" start="1"'),
        ("g[2]", 6, 'declaredType="A" start="2"'),
    )
    item = '<Item name="{0}" value="{1}"/>'
    types = "".join(
        f'<SimpleType name="{name}"><Enumeration>{"".join(item.format(*i) for i in items)}</Enumeration></SimpleType>'
        for name, items in (("A", (("a1", 1), ("a2", 2))), ("B", (("b5", 5), ("b6", 6))))
    )
    ports = opened("2.0", "".join(f"{of.format(*each)}</ScalarVariable>" for each in said), types).ports
    assert [name for name in ports if name[0] in "efg"] == ["e[1]", "e[2]", "f[1]", "f[2]", "g"]
    assert [ports[name].items for name in ("e[2]", "f[1]")] == [(("b5", 5), ("b6", 6)), (("a1", 1),)]


@pytest.mark.parametrize("kind", [f"{sign}Int{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64)])
def test_ranges_of_all_integers(opened, kind):
    variables = f'<{kind} name="v" valueReference="1" declaredType="T" max="7"/><{kind} name="w" valueReference="2"/>'
    assert declared_ranges(opened("3.0", variables, f'<{kind}Type name="T" min="3" max="5"/>')) == {"v": (3.0, 7.0)}


def test_range_of_an_integer_of_fmi_2(opened):
    inside = '<Integer declaredType="T"/>'
    variable = f'<ScalarVariable name="v" valueReference="1" variability="discrete">{inside}</ScalarVariable>'
    assert declared_ranges(opened("2.0", variable, '<SimpleType name="T"><Integer min="3" max="5"/></SimpleType>')) == {
        "v": (3.0, 5.0)
    }


ITEMS = '<Item name="a" value="-4"/><Item name="b" value="1"/><Item name="c" value="5"/><Item name="d" value="11"/>'


@pytest.mark.parametrize("where", ["variable", "type"])
def test_items_outside_the_range_of_an_enumeration_are_none(opened, where):
    limits = {"variable": ("", 'min="-2" max="5"'), "type": ('min="-2" max="5"', "")}[where]
    fmu = opened(
        "3.0",
        f'<Enumeration name="v" valueReference="1" declaredType="T" {limits[1]}/>',
        f'<EnumerationType name="T" {limits[0]}>{ITEMS}</EnumerationType>',
    )
    port = fmu.ports["v"]
    assert port.items == (("b", 1), ("c", 5))
    with pytest.raises(AdcsError) as error:
        item_numbers("c.v", port, "d")
    assert str(error.value) == "c.v = 'd' is no item of this enumeration: use 'b' or 1, 'c' or 5"


CLOCK = (
    'canBeDeactivated="true" priority="3" intervalVariability="constant" supportsFraction="true" resolution="10" '
    'intervalCounter="3" shiftCounter="1" intervalDecimal="0.3" shiftDecimal="0.1"'
)


def clock(opened, said, types):
    variable = f'<Clock name="k" valueReference="1" causality="input" intervalVariability="constant" {said}/>'
    (found,) = opened("3.0", variable, f'<ClockType name="T" {types}/>').clocks
    return str(found.interval), str(found.shift), found.fractional


@pytest.mark.parametrize(
    ("said", "found"),
    [
        ("", ("None", "0.0", False)),
        ('declaredType="T"', ("3/10", "1/10", True)),
        ('declaredType="T" intervalCounter="7"', ("7/10", "1/10", True)),
        ('declaredType="T" supportsFraction="false"', ("3/10", "1/10", False)),
        # a form of its own, beside which the other form of the type does not count
        ('declaredType="T" intervalDecimal="0.5" shiftDecimal="0.25"', ("0.5", "0.25", True)),
    ],
)
def test_a_clock_takes_its_times_from_its_type(opened, said, found):
    assert clock(opened, said, CLOCK) == found


@pytest.mark.parametrize(
    ("variable", "types", "message"),
    [
        (
            '<Float64 name="v" valueReference="1" declaredType="U"/>',
            '<Float64Type name="T"/>',
            "v (line 1): declaredType refers to 'U', which TypeDefinitions does not define",
        ),
        (
            '<Clock name="v" valueReference="1" intervalVariability="triggered" declaredType="U"/>',
            "",
            "v (line 1): declaredType refers to 'U', which TypeDefinitions does not define",
        ),
        (
            '<Clock name="v" valueReference="1" intervalVariability="constant" declaredType="T"/>',
            '<ClockType name="T" intervalVariability="constant" resolution="0" intervalCounter="1"/>',
            "clock v has the resolution 0: expected a whole number from 1",
        ),
        (
            '<Float64 name="v" valueReference="1" declaredType="T"/>',
            '<Int32Type name="T"/>',
            "line 1: v has the type 'T', which is of the kind Int32Type, expected Float64Type",
        ),
    ],
)
def test_types_that_do_not_fit_are_refused(opened, tmp_path, variable, types, message):
    with pytest.raises(AdcsError) as error:
        opened("3.0", variable, types)
    assert str(error.value) == f"{tmp_path}/c.fmu is not valid: {message}"
