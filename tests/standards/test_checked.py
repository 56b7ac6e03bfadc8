"""What is looked at and has no other effect, and small things that have one, which no other test shows."""

import importlib
import zipfile
from types import SimpleNamespace

import pytest
from fmpy.validation import _validate_variable_names

import fmus
from adcs import AdcsError, System, read_ssp, run
from adcs.catalogue import find_system
from fmus.check import check
from fmus.checks.description import _PLAIN_NAME
from orchestration.fmu.file import open_fmu
from orchestration.single import single

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


@pytest.mark.parametrize(
    ("name", "plain"),
    [
        *(("a_1", True), ("a.b[1,2].c", True), ("_x[10]", True)),
        *(
            ("a b", False),
            ("1a", False),
            ("a.", False),
            ("a[]", False),
            ("der(a)", False),
            ("'a b'", False),
            ("ä", False),
        ),
    ],
)
def test_only_names_that_are_not_plain_cost_a_parser(name, plain):
    """Whose answer is the same for the others: that they are right."""
    assert bool(_PLAIN_NAME.fullmatch(name)) == plain
    if plain:
        variable = SimpleNamespace(name=name, sourceline=1)
        model = SimpleNamespace(variableNamingConvention="structured", modelVariables=[variable])
        assert _validate_variable_names(model) == []


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


def described(version, kind, own, of_type="", inner=""):
    """A description with a variable v of a type T."""
    if version == "3.0":
        variable = f'<{kind} name="v" valueReference="1" declaredType="T" {own}/>'
        return description3(variable, f'<{kind}Type name="T" {of_type}>{inner}</{kind}Type>')
    variable = f'<ScalarVariable name="v" valueReference="1"><{kind} declaredType="T" {own}/></ScalarVariable>'
    return description2(variable, f'<SimpleType name="T"><{kind} {of_type}>{inner}</{kind}></SimpleType>')


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize(
    ("said", "message"),
    [
        ('nominal="0"', "nominal 0, expected a positive number"),
        ('nominal="-2"', "nominal -2, expected a positive number"),
        ('nominal="NaN"', "nominal NaN, expected a positive number"),
        ('nominal="INF"', "nominal INF, expected a positive number"),
        ('min="3" max="2"', "min 3 is above max 2"),
        ('min="NaN"', "min is not a number"),
    ],
)
def test_ranges_and_nominals_that_make_no_sense(tmp_path, version, said, message):
    kind = "Float64" if version == "3.0" else "Real"
    for own, of_type, name in ((said, "", "v"), ("", said, "type T")):
        texts = found(packed(tmp_path / "c.fmu", described(version, kind, own, of_type))).split(" | ")
        assert [text for text in texts if message in text] == [f"{name}: {message}"]
    fine = found(packed(tmp_path / "c.fmu", described(version, kind, 'nominal="2" min="-1" max="-1"')))
    assert "nominal" not in fine
    assert "max" not in fine


def test_a_range_of_which_the_type_has_one_bound(tmp_path):
    text = found(packed(tmp_path / "c.fmu", described("3.0", "Int8", 'max="2"', 'min="3"')))
    assert text.count("v: min 3 is above max 2") == text.count("min 3") == 1


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_items_of_an_enumeration_differ(tmp_path, version):
    items = '<Item name="a" value="1"/><Item name="a" value="2"/><Item name="b" value="2"/>'
    text = found(packed(tmp_path / "c.fmu", described(version, "Enumeration", "", inner=items)))
    assert text.count("type T: 2 items have the name a") == text.count("type T: 2 items have the value 2") == 1


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize(
    ("said", "message"),
    [
        ('start="3"', "v: start 3 is the value of no item, expected one of 1, 2, 7"),
        ('start="7" max="2"', "v: start 7 is the value of no item, expected one of 1, 2"),
        ('start="7"', None),
        ("", None),
    ],
)
def test_the_start_of_an_enumeration_is_the_value_of_an_item(tmp_path, version, said, message):
    """Which is refused by --set and --at alike."""
    items = '<Item name="a" value="1"/><Item name="b" value="2"/><Item name="c" value="7"/>'
    texts = found(packed(tmp_path / "c.fmu", described(version, "Enumeration", said, inner=items))).split(" | ")
    assert [text for text in texts if " item" in text] == ([] if message is None else [message])


def test_the_start_of_an_array_of_an_enumeration(tmp_path):
    variable = (
        '<Enumeration name="v" valueReference="1" declaredType="T" start="0 1 0 5"><Dimension start="4"/></Enumeration>'
    )
    items = "".join(f'<Item name="i{n}" value="{n}"/>' for n in range(1, 13) if n != 5)
    xml = description3(variable, f'<EnumerationType name="T">{items}</EnumerationType>')
    texts = found(packed(tmp_path / "c.fmu", xml)).split(" | ")
    known = "expected one of 1, 2, 3, 4, 6, 7 and 5 more"
    assert [t for t in texts if " item" in t] == [f"v: start {n} is the value of no item, {known}" for n in (0, 5)]


@pytest.mark.parametrize("said", ["start='x'", "start='1.5'", "value=''"])
def test_an_enumeration_that_the_schema_refuses_costs_no_traceback(tmp_path, said):
    kind, item = ("", said) if "value" in said else (said, 'value="1"')
    assert found(packed(tmp_path / "c.fmu", described("3.0", "Enumeration", kind, inner=f'<Item name="a" {item}/>')))


def test_binary_start_values_are_no_longer_than_they_may_be(tmp_path):
    text = '<Binary name="v" valueReference="1" maxSize="2" causality="parameter" variability="fixed">{}</Binary>'
    for value, long in (("0a0b", False), ("0a0b0c", True)):
        path = packed(tmp_path / "c.fmu", description3(text.format(f'<Start value="{value}"/>')))
        assert ("v: start has 3 bytes, its maxSize is 2" in found(path)) == long


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_units_have_factors_and_unused_types_have_units(tmp_path, version):
    units = '<Unit name="K"><BaseUnit K="1" factor="0"/><DisplayUnit name="mK" factor="0"/></Unit>'
    said = found(packed(tmp_path / "c.fmu", (description3 if version == "3.0" else description2)("", units=units)))
    assert "unit K: its base unit has the factor 0" in said
    assert "unit K: its display unit mK has the factor 0" in said
    endless = '<Unit name="K"><BaseUnit K="1" offset="NaN"/><DisplayUnit name="C" offset="INF"/></Unit>'
    said = found(packed(tmp_path / "c.fmu", (description3 if version == "3.0" else description2)("", units=endless)))
    assert "unit K: its base unit has the offset nan, expected a number" in said
    assert "unit K: its display unit C has the offset inf, expected a number" in said
    unused = (
        '<Float64Type name="T" unit="W"/>' if version == "3.0" else '<SimpleType name="T"><Real unit="W"/></SimpleType>'
    )
    said = found(packed(tmp_path / "c.fmu", (description3 if version == "3.0" else description2)("", unused)))
    assert said.count("unit W is not defined") == said.count("type T: unit W is not defined") == 1


def test_stream_members_of_a_terminal_are_variables(tmp_path):
    member = (
        '<TerminalStreamMemberVariable inStreamMemberName="a" outStreamMemberName="b" '
        'inStreamVariableName="time" outStreamVariableName="gone"/>'
    )
    terminal = f'<Terminals><Terminal name="t" matchingRule="bus">{member}</Terminal></Terminals>'
    path = tmp_path / "c.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", description3(""))
        document = f'<fmiTerminalsAndIcons fmiVersion="3.0">{terminal}</fmiTerminalsAndIcons>'
        archive.writestr("terminalsAndIcons/terminalsAndIcons.xml", document)
    assert "line 1: outStreamVariableName gone is no variable" in found(path)
    assert "inStreamVariableName time" not in found(path)


def test_start_values_that_the_type_does_not_hold(tmp_path):
    variable = '<Float32 name="p" valueReference="1" causality="parameter" variability="fixed" start="1e300"/>'
    path = packed(tmp_path / "c.fmu", description3(variable))
    assert found(path).count("p: start 1e300 is outside the range of Float32") == 1
    system = System("s")
    system.add("c", path)
    with pytest.raises(AdcsError) as error:
        system.check()
    assert str(error.value) == (
        "c.p = 1e+300 by its FMU is outside the range of Float32: give it another value (--set c.p=...)"
    )
    system.set("c.p", 1.0)
    system.check()


@pytest.mark.parametrize("value", ["INF", "NaN"])
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_start_values_that_are_not_finite(tmp_path, version, value):
    tag = r'(name="k_p"[^/]*?) start="[^"]*"'
    path = changed(fmus.fmu_path("PdTracking", version), tmp_path / "c.fmu", (tag, rf'\1 start="{value}"'))
    with pytest.raises(AdcsError, match=r"^c\.k_p = (inf|nan) by its FMU is not finite: give it another value \(--set"):
        run(single(path), stop_time=0.1, step=0.1)


def test_arrays_with_the_same_elements_in_another_order(tmp_path):
    names = [("a[1]", 1), ("a[2]", 2), ("b[1]", 2), ("b[2]", 1)]
    variables = "".join(
        f'<ScalarVariable name="{n}" valueReference="{r}" causality="input"><Real start="0"/></ScalarVariable>'
        for n, r in names
    )
    path = packed(tmp_path / "c.fmu", description2(variables))
    with pytest.raises(AdcsError, match=r"^c\.a and c\.b are names of one variable, and are given different start"):
        System("s").add("c", path, {"a": [1.0, 2.0], "b": [1.0, 2.0]})
    system = System("s")
    system.add("c", path, {"a": [1.0, 2.0], "b": [2.0, 1.0]})
    system.set("c.b", [3.0, 4.0])
    assert system.components["c"].start == {"a": (4.0, 3.0), "b": (3.0, 4.0)}
    assert single(path, {"b": [3.0, 4.0]}).components["c"].start == {"b": (3.0, 4.0)}
    system = System("s")
    system.add("c", path, {"b": [3.0, 4.0]})
    system.check()
