"""Differences (relativeQuantity): the offset of a unit is none of theirs, wherever a value goes from unit to unit."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest
from packages import bindings, component, connections, elements, mapping, parameters, ssd, system

from adcs import AdcsError, System, read_ssp
from adcs.cli.words import assigned

UNITS = (
    '<UnitDefinitions><Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" offset="-273.15"/>'
    '<DisplayUnit name="degF" factor="1.8" offset="-459.67"/></Unit>'
    '<Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit></UnitDefinitions>'
)
VARIABLES = {
    "u": ("input", "continuous", "", "0"),
    "y": ("output", "continuous", "", None),
    "dT": ("parameter", "tunable", "", "5"),
    "T": ("parameter", "tunable", "absolute", "300"),
}
BY = ("variable", "type")


def fmu(path: Path, version: str, unit: str, by: str) -> Path:
    """Differences u, y, dT and a temperature T; it is said of the variables, or of their type, which T overrules."""
    said = ' relativeQuantity="true"' if by == "variable" else ' declaredType="Difference"'
    overruled = "" if by == "variable" else f'{said} relativeQuantity="false"'
    inside = f'Real unit="{unit}" relativeQuantity="true"' if by == "type" else f'Real unit="{unit}"'
    lines = []
    for number, (name, (causality, variability, kind, start)) in enumerate(VARIABLES.items(), 1):
        common = f'name="{name}" valueReference="{number}" causality="{causality}" variability="{variability}"'
        value = f'unit="{unit}"{overruled if kind else said}' + ("" if start is None else f' start="{start}"')
        lines.append(
            f"<ScalarVariable {common}><Real {value}/></ScalarVariable>"
            if version == "2.0"
            else f"<Float64 {common} {value}/>"
        )
    if version == "2.0":
        types = f'<TypeDefinitions><SimpleType name="Difference"><{inside}/></SimpleType></TypeDefinitions>'
        structure = '<Outputs><Unknown index="2"/></Outputs><InitialUnknowns><Unknown index="2"/></InitialUnknowns>'
        head = 'guid="{x}"'
    else:
        types = f"<TypeDefinitions><{inside.replace('Real', 'Float64Type name=' + chr(34) + 'Difference' + chr(34))}/>"
        types += "</TypeDefinitions>"
        structure = '<Output valueReference="2"/><InitialUnknown valueReference="2"/>'
        head = 'instantiationToken="{x}"'
        lines.append('<Float64 name="time" valueReference="9" causality="independent" variability="continuous"/>')
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(
            "modelDescription.xml",
            f'<?xml version="1.0" encoding="UTF-8"?>\n<fmiModelDescription fmiVersion="{version}" modelName="delta" '
            f'{head}><CoSimulation modelIdentifier="delta"/>{UNITS}{types}'
            f"<ModelVariables>{''.join(lines)}</ModelVariables><ModelStructure>{structure}</ModelStructure>"
            "</fmiModelDescription>",
        )
    return path


@pytest.fixture(params=[(v, by) for v in ("2.0", "3.0") for by in BY], ids=lambda p: "-".join(p))
def deltas(request, tmp_path) -> dict[str, Path]:
    """FMUs whose unit is K and degC."""
    version, by = request.param
    return {unit: fmu(tmp_path / f"{unit}.fmu", version, unit, by) for unit in ("K", "degC")}


@pytest.fixture
def pair(deltas) -> System:
    built = System("pair")
    built.add("a", deltas["K"], {"u": 0.0})
    built.add("b", deltas["degC"])
    return built


def test_connections(pair):
    pair.connect("a.y", "b.u")
    assert pair.connections[0].plain


@pytest.mark.parametrize(
    ("text", "value"),
    [("a.dT=5degC", 5.0), ("a.dT=9degF", 5.0), ("a.dT=5", 5.0), ("a.T=5degC", 278.15), ("a.T=41degF", 278.15)],
)
@pytest.mark.parametrize("option", ["--set", "--at"])
def test_values_with_units(pair, option, text, value):
    name, given = assigned(pair, text, option)
    pair.set(name, given)
    assert pair.components["a"].start[name[2:]] == (pytest.approx(value, abs=1e-12),)


def test_a_difference_is_no_temperature(deltas, tmp_path):
    """Which of the two numbers is meant, nobody can know."""
    plain = tmp_path / "plain.fmu"
    with zipfile.ZipFile(deltas["degC"]) as source, zipfile.ZipFile(plain, "w") as target:
        text = source.read("modelDescription.xml").decode().replace('relativeQuantity="true"', "")
        target.writestr("modelDescription.xml", text)
    built = System("mixed")
    built.add("a", deltas["K"], {"u": 0.0})
    built.add("b", plain)
    with pytest.raises(AdcsError) as error:
        built.connect("a.y", "b.u")
    assert str(error.value) == (
        "cannot connect a.y to b.u: units differ, 'K' and 'degC', and only one is of a difference (relativeQuantity): "
        "give a factor and an offset"
    )
    built.connect("a.y", "b.u", offset=-273.15)


# SSP


@pytest.fixture
def packed(deltas, tmp_path):
    def read(text, **files):
        path = tmp_path / "deltas.ssp"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("SystemStructure.ssd", text)
            archive.write(deltas["K"], "resources/a.fmu")
            archive.write(deltas["degC"], "resources/b.fmu")
            for name, content in files.items():
                archive.writestr(f"resources/{name}.ssv", content)
        return read_ssp(path).system

    return read


CONNECTORS = {"a": "output y Real K; input u Real K", "b": "input u Real degC; output y Real degC"}
PARTS = tuple(component(name, pins) for name, pins in CONNECTORS.items())


def test_ssp_connections(packed):
    built = packed(ssd(elements(*PARTS) + connections("a.y -> b.u")))
    assert built.connections[0].plain


def test_ssp_connections_through_connectors_of_systems(packed):
    inner = system("s", "input x Real degC", elements(PARTS[1]) + connections("x -> b.u"))
    built = packed(ssd(elements(PARTS[0], inner) + connections("a.y -> s.x")))
    (only,) = built.connections
    assert (only.source, only.target, only.factor, only.offset) == ("a.y", "s/b.u", 1.0, 0.0)


@pytest.mark.parametrize("inline", [True, False])
def test_ssp_parameter_sets(packed, inline):
    """5 degC of difference are 5 K; as a temperature they are 278.15 K."""
    values = parameters(
        {"dT": '<ssv:Real value="5" unit="degC"/>', "T": '<ssv:Real value="5" unit="degC"/>'}, ("degC",)
    )
    binding = bindings(values) if inline else bindings('source="resources/set.ssv">')
    inside = elements(component("a", CONNECTORS["a"], binding), PARTS[1])
    built = packed(ssd(inside), **({} if inline else {"set": values}))
    assert built.components["a"].start["dT"] == (5.0,)
    assert built.components["a"].start["T"] == (278.15,)


def test_ssp_parameters_of_connectors_of_systems(packed):
    values = parameters({"x": '<ssv:Real value="5" unit="degC"/>'}, ("degC",))
    inner = system("s", "input x Real K", elements(PARTS[1]) + connections("x -> b.u"), bindings(values))
    assert packed(ssd(elements(inner))).components["s/b"].start["u"] == (5.0,)
    values = parameters({"x": '<ssv:Real value="5" unit="K"/>'}, ("K",))
    inner = system("s", "input x", elements(PARTS[1]) + connections("x -> b.u"), bindings(values))
    assert packed(ssd(elements(inner))).components["s/b"].start["u"] == (5.0,)


def test_ssp_mappings_work_on_top(packed):
    values = parameters({"half": '<ssv:Real value="2.5" unit="degC"/>'}, ("degC",))
    entry = mapping("half -> dT || <ssc:LinearTransformation factor='2'/>")
    binding = bindings(f"><ssd:ParameterValues>{values}</ssd:ParameterValues><ssd:ParameterMapping>{entry}"
                       "</ssd:ParameterMapping>")  # fmt: skip
    built = packed(ssd(elements(component("a", CONNECTORS["a"], binding), PARTS[1])))
    assert built.components["a"].start["dT"] == (5.0,)


def test_parameter_sets_inside_know_the_units_of_the_structure(packed):
    """A parameter set in a file of its own does not: there the name alone is no definition."""
    values = parameters({"T": '<ssv:Real value="5" unit="degC"/>'})
    built = packed(ssd(elements(component("a", CONNECTORS["a"], bindings(values)), PARTS[1])))
    assert built.components["a"].start["T"] == (278.15,)
    apart = elements(component("a", CONNECTORS["a"], bindings('source="resources/set.ssv">')), PARTS[1])
    with pytest.raises(AdcsError, match="units differ, 'degC' and 'K', and 'degC' is not defined: define it"):
        packed(ssd(apart), set=values)


def test_their_own_definition_counts_more(packed):
    own = '<ssv:Units><ssc:Unit name="degC"><ssc:BaseUnit K="1" offset="100"/></ssc:Unit></ssv:Units>'
    values = parameters({"T": '<ssv:Real value="5" unit="degC"/>'}, more=own)
    built = packed(ssd(elements(component("a", CONNECTORS["a"], bindings(values)), PARTS[1])))
    assert built.components["a"].start["T"] == (105.0,)
