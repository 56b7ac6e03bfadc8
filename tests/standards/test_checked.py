"""What is looked at and has no other effect, and small things that have one, which no other test shows."""

import importlib
import zipfile

import pytest

import fmus
from adcs import AdcsError, read_ssp
from adcs.catalogue import find_system
from fmus.check import check
from orchestration.fmu.file import open_fmu

from .small import changed, description2, description3, packed

NAMED = '<Float64 name="a b" valueReference="1"/>'


@pytest.fixture(autouse=True)
def static(monkeypatch):
    """Leaves out of the checks the FMU's execution, which takes longest."""
    monkeypatch.setattr(importlib.import_module("fmus.check"), "check_behaviour", lambda path: iter(()))


def found(path):
    return " | ".join(finding.message for finding in check(path))


def test_names_follow_their_convention(tmp_path):
    text = description3(NAMED).replace(" modelName", ' variableNamingConvention="{}" modelName')
    flat, structured = (packed(tmp_path / f"{c}.fmu", text.replace("{}", c)) for c in ("flat", "structured"))
    assert '"a b"' in found(structured)
    assert '"a b"' not in found(flat)
    assert set(open_fmu(flat).ports) == set(open_fmu(structured).ports)


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("by", ["variable", "type"])
def test_display_units_are_those_of_the_unit(tmp_path, version, by):
    said = 'unit="K" displayUnit="degX"'
    own, of_type = (said, "") if by == "variable" else ("", said)
    if version == "2.0":
        variable = f'<ScalarVariable name="v" valueReference="1"><Real declaredType="T" {own}/></ScalarVariable>'
        xml = description2(variable, f'<SimpleType name="T"><Real {of_type}/></SimpleType>', '<Unit name="K"/>')
    else:
        variable = f'<Float64 name="v" valueReference="1" declaredType="T" {own}/>'
        xml = description3(variable, f'<Float64Type name="T" {of_type}/>', '<Unit name="K"/>')
    with pytest.raises(AdcsError, match=r'c\.fmu is not valid: .*"degX"'):
        open_fmu(packed(tmp_path / "c.fmu", xml))


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_an_fmu_alone_runs_its_default_experiment(tmp_path, version):
    experiment = '<DefaultExperiment startTime="1" stopTime="3" stepSize="0.5"/>'
    path = changed(fmus.fmu_path("PdTracking", version), tmp_path / "c.fmu", (r"<DefaultExperiment[^>]*/>", experiment))
    entry = find_system(str(path))
    assert (entry.start_time, entry.stop_time, entry.step) == (1.0, 3.0, 0.5)


def test_aliases_have_descriptions_of_their_own(tmp_path):
    alias = '<Alias name="b" description="the other"/><Alias name="c"/>'
    fmu = open_fmu(
        packed(
            tmp_path / "c.fmu",
            description3(f'<Float64 name="a" valueReference="1" description="one">{alias}</Float64>'),
        )
    )
    assert [fmu.ports[name].description for name in "abc"] == ["one", "the other", "one"]


@pytest.mark.parametrize("element", ["ClockedState", "Output", "InitialUnknown", "EventIndicator"])
def test_structures_name_variables(tmp_path, element):
    structure = f'<{element} valueReference="7"/>'
    with pytest.raises(AdcsError) as error:
        open_fmu(packed(tmp_path / "c.fmu", description3("", structure=structure)))
    assert str(error.value).endswith("ModelStructure, line 1: no variable has the value reference 7")


@pytest.mark.parametrize("kind", ["String", "Binary"])
def test_clocks_of_texts_are_variables(tmp_path, kind):
    clock = '<Clock name="k" valueReference="1" intervalVariability="triggered"/>'
    text = f'{clock}<{kind} name="v" valueReference="2" clocks="%"/>'
    assert "v" in open_fmu(packed(tmp_path / "good.fmu", description3(text.replace("%", "1")))).ports
    with pytest.raises(AdcsError, match="7"):
        open_fmu(packed(tmp_path / "bad.fmu", description3(text.replace("%", "7"))))


def test_build_descriptions_follow_their_schema(tmp_path):
    text = '<fmiBuildDescription fmiVersion="3.0"><BuildConfiguration modelIdentifier="m"{}/></fmiBuildDescription>'
    xml = description3("")
    good, bad = tmp_path / "good.fmu", tmp_path / "bad.fmu"
    for path, more in ((good, ""), (bad, ' speed="fast"')):
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("modelDescription.xml", xml)
            archive.writestr("sources/buildDescription.xml", text.format(more))
    assert "speed" in found(bad)
    assert "speed" not in found(good)
    assert open_fmu(bad).ports.keys() == open_fmu(good).ports.keys()


def test_a_system_has_the_description_of_the_document(tmp_path):
    head = (
        'xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" version="1.0" name="s" description="all"'
    )
    texts = [
        f"<ssd:SystemStructureDescription {head}><ssd:System{own}/></ssd:SystemStructureDescription>"
        for own in (' name="r"', ' name="r" description="own"')
    ]
    described = []
    for text in texts:
        with zipfile.ZipFile(tmp_path / "s.ssp", "w") as archive:
            archive.writestr("SystemStructure.ssd", text)
        described.append(read_ssp(tmp_path / "s.ssp").system.description)
    assert described == ["all", "own"]
