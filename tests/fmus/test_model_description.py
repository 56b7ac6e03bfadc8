import io
import zipfile
from dataclasses import replace

import pytest
from fmpy.model_description import read_model_description
from lxml import etree

from adcs import AdcsError
from fmus.model_description import fmi2, fmi3


def read(xml):
    """The description as fmpy sees it, with everything that fmpy validates."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr("modelDescription.xml", xml)
    return read_model_description(buffer, validate_variable_names=True, validate_model_structure=True)


@pytest.fixture(params=[fmi2, fmi3])
def model(request, spinner):
    return read(request.param(spinner))


def test_both_interfaces_with_their_capabilities(model):
    for interface in (model.modelExchange, model.coSimulation):
        assert interface.modelIdentifier == "Spinner"
        assert interface.canGetAndSetFMUstate
        assert interface.canSerializeFMUstate
        assert not interface.needsExecutionTool
        assert not interface.canBeInstantiatedOnlyOncePerProcess
    assert model.coSimulation.canHandleVariableCommunicationStepSize
    assert model.guid == "{token}"
    assert model.numberOfContinuousStates == 2


def test_units(model):
    unit = model.unitDefinitions[1]
    assert (unit.name, unit.baseUnit.rad, unit.baseUnit.s, unit.baseUnit.kg) == ("rad/s", 1, -1, 0)
    assert [(d.name, d.factor) for d in unit.displayUnits] == [("deg/s", 57.29577951308232)]


def test_directional_derivatives_are_promised_only_if_there_are_any(spinner):
    plain = type(spinner)(**{**spinner.__dict__, "differentiable": False})
    assert b'providesDirectionalDerivative="true"' in fmi2(spinner)
    assert b'providesDirectionalDerivative="false"' in fmi2(plain)
    assert b'providesDirectionalDerivatives="true"' in fmi3(spinner)
    assert b'providesDirectionalDerivatives="false"' in fmi3(plain)
    assert fmi3(spinner).count(b'providesAdjointDerivatives="true"') == 2  # of both interfaces
    assert fmi3(plain).count(b'providesAdjointDerivatives="false"') == 2
    assert b"Adjoint" not in fmi2(spinner)  # which has none


def test_fmi2_has_scalars(spinner):
    variables = read(fmi2(spinner)).modelVariables
    assert [v.name for v in variables] == [
        *("time", "u[1]", "u[2]"),
        *("M[1,1]", "M[1,2]", "M[1,3]", "M[2,1]", "M[2,2]", "M[2,3]"),
        *("mode", "x[1]", "x[2]", "der(x[1])", "der(x[2])", "y"),
    ]
    assert [v.valueReference for v in variables] == list(range(15))
    by_name = {v.name: v for v in variables}
    assert by_name["M[2,3]"].start == "6.25"
    assert by_name["M[2,3]"].min == "0.0"
    assert (by_name["mode"].type, by_name["mode"].start, by_name["mode"].max) == ("Integer", "7", "9")
    assert by_name["u[2]"].displayUnit == "deg/s"
    assert by_name["der(x[2])"].derivative is by_name["x[2]"]
    assert by_name["x[1]"].nominal == "0.1"


def test_fmi2_model_structure_is_element_wise(spinner):
    model = read(fmi2(spinner))
    assert structure(model.outputs) == {"x[1]": ["x[1]"], "x[2]": ["x[2]"], "y": ["time", "u[2]"]}
    assert structure(model.derivatives) == {"der(x[1])": ["u[1]", "x[2]"], "der(x[2])": ["u[2]"]}
    assert structure(model.initialUnknowns) == {
        "der(x[1])": ["u[1]", "M[1,1]", "x[2]"],
        "der(x[2])": ["u[2]", "mode"],
        "y": ["time", "u[2]", "M[2,3]"],
    }


def test_fmi2_counts_from_one(spinner):
    root = etree.fromstring(fmi2(spinner))
    assert root.find("ModelStructure/Outputs/Unknown").get("index") == "11"  # x[1] is the 11th variable


def test_fmi2_names_the_sources_to_compile(spinner):
    root = etree.fromstring(fmi2(spinner, ["model.cpp", "fmi/fmi2.cpp"]))
    for interface in ("ModelExchange", "CoSimulation"):
        assert [f.get("name") for f in root.iterfind(f"{interface}/SourceFiles/File")] == ["model.cpp", "fmi/fmi2.cpp"]


def test_fmi3_has_arrays(spinner):
    variables = {v.name: v for v in read(fmi3(spinner)).modelVariables}
    assert {v.name: v.shape for v in variables.values() if v.shape} == {
        "u": (2,),
        "M": (2, 3),
        "x": (2,),
        "der(x)": (2,),
    }
    assert variables["M"].start == "1.0 2.0 3.0 4.0 5.0 6.25"
    assert variables["M"].valueReference == 3
    assert (variables["mode"].type, variables["mode"].start) == ("Int32", "7")
    assert variables["der(x)"].derivative is variables["x"]


def test_fmi3_dependencies_are_those_of_any_element(spinner):
    model = read(fmi3(spinner))
    assert structure(model.outputs) == {"x": ["x"], "y": ["time", "u"]}
    assert structure(model.derivatives) == {"der(x)": ["u", "x"]}
    assert structure(model.initialUnknowns) == {"der(x)": ["u", "M", "mode", "x"], "y": ["time", "u", "M"]}


def test_the_date_is_left_out_unless_given(spinner, monkeypatch):
    monkeypatch.delenv("SOURCE_DATE_EPOCH", raising=False)
    assert b"generationDateAndTime" not in fmi2(spinner)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    assert b'generationDateAndTime="1970-01-02T00:00:00Z"' in fmi2(spinner)


def test_an_output_without_dependencies_is_refused(spinner):
    y = spinner.variables[-1]
    broken = type(y)(**{**y.__dict__, "dependencies": None})
    with pytest.raises(AdcsError, match="y: dependencies are None, expected 1 rows"):
        fmi3(type(spinner)(**{**spinner.__dict__, "variables": (*spinner.variables[:-1], broken)}))


def structure(unknowns):
    return {u.variable.name: [known.name for known in u.dependencies] for u in unknowns}


def test_a_seed_has_a_type_of_its_own(spinner):
    """By which any tool can tell it from an integer that is called so; without a seed there is no such type."""
    mode = next(v for v in spinner.variables if v.name == "mode")
    others = [v for v in spinner.variables if v is not mode]
    seeded = replace(spinner, variables=(*others, replace(mode, is_seed=True)))
    for write in (fmi2, fmi3):
        found = {v.name: v.declaredType for v in read(write(seeded)).modelVariables}
        assert found.pop("mode").name == "adcs.Seed"
        assert not any(found.values())
        assert "Seed" not in write(spinner).decode()
