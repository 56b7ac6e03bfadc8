"""Everything that cannot be run as the file says is refused in one line that names the thing and the way out."""

from __future__ import annotations

import struct
import zipfile

import pytest
from packages import (
    bindings,
    component,
    connections,
    elements,
    mapping,
    note,
    parameters,
    ssd,
    system,
)

from adcs import AdcsError, read_ssp

A = component("a", "output y Real m; output far; output plain; output yes Boolean; output n Integer; output angle")
B = component("b", "input u Real m; input plain; input on Boolean; input angle; parameter k; output z")
GOOD = elements(A, B) + connections("a.y -> b.u")

ONE = 'Real value="1"'
AGAIN = '<ssv:Parameter name="k"><ssv:Real value="2"/></ssv:Parameter>'
NO_FACTOR = '<ssv:Units><ssc:Unit name="none"><ssc:BaseUnit rad="1" factor="0"/></ssc:Unit></ssv:Units>'
STEP = note("Experiment", 'step="0"')
LINES = elements(component("b", "input x_y").replace('"x_y"', '"x&#10;y"'))
V = component("a", "output v; output M")
W = component("b", "input w; input u")


def refusal(path, **settings):
    with pytest.raises(AdcsError) as caught:
        read_ssp(path, **settings)
    message = str(caught.value)
    assert "\n" not in message
    assert path.name in message
    return message


def test_the_file_of_which_the_bad_ones_are_made_is_good(package):
    assert [c.target for c in read_ssp(package(ssd(GOOD))).system.connections] == ["b.u"]


def linked(*lines):
    return elements(A, B) + connections(*lines)


def bound(*values):
    return elements(component("b", "", bindings(*values)))


def mapped(values, *entries):
    return bound(
        f"><ssd:ParameterValues>{values}</ssd:ParameterValues><ssd:ParameterMapping>{mapping(*entries)}"
        "</ssd:ParameterMapping>"
    )


def noted(attributes):
    return linked("a.y -> b.u || " + note("Connection", attributes))


def table(kind, *pairs):
    entries = "".join(f'<ssc:MapEntry source="{a}" target="{b}"/>' for a, b in pairs)
    return f"<ssc:{kind}MappingTransformation>{entries}</ssc:{kind}MappingTransformation>"


STRUCTURES = {
    # connections
    "unknown element": (linked("x.y -> b.u"), "connection x.y -> b.u: there is no element 'x' (there is a, b)"),
    "unknown connector": (linked("a.yy -> b.u"), "'a' has no connector 'yy' (did you mean y?)"),
    "unknown connector of the system": (linked("i -> b.u"), "the root system has no connector 'i'"),
    "two sources": (linked("a.y -> b.u", "a.far -> b.u"), "b.u has another source already, connection a.y -> b.u"),
    "output to output": (linked("a.y -> b.z"), "both ends give a value, none takes one (output and output)"),
    "input to input": (linked("b.u -> b.plain"), "both ends take a value, none gives one (input and input)"),
    "wrong unit": (linked("a.angle -> b.u"), "units differ, 'deg' and 'm', and do not measure the same"),
    "kinds of values": (linked("a.yes -> b.plain"), "types Boolean and Float64 do not go together"),
    "computed parameter": (linked("a.y -> b.k"), "a value that is computed goes into parameter b.k"),
    "cycle of system connectors": (
        elements(*(system(n, "input i; output o", connections("i -> o")) for n in "st"))
        + connections("s.o -> t.i", "t.o -> s.i"),
        "connectors of systems form a cycle",
    ),
    "table after transformation": (
        elements(
            A,
            system(
                "s",
                "input i",
                elements(component("c", "input n", source="resources/b.fmu"))
                + connections(f"i -> c.n || {table('Integer', (1, 2))}"),
            ),
        )
        + connections('a.n -> s.i || <ssc:LinearTransformation factor="2"/>'),
        "a mapping table and a linear transformation or unit conversion follow each other",
    ),
    "two entries": (
        linked(f"a.n -> b.plain || {table('Integer', (1, 2), (1, 3))}"),
        "two entries for one source value",
    ),
    "enumeration of nothing": (
        linked(f"a.n -> b.plain || {table('Enumeration', ('x', 'y'))}"),
        "no enumeration is known",
    ),
    "factor zero": (linked('a.y -> b.u || <ssc:LinearTransformation factor="0"/>'), "the factor not zero"),
    "unit without factor": (
        bound(parameters({"turn": f'{ONE} unit="none"'}, more=NO_FACTOR)),
        "units 'none' and 'rad': a factor is zero or not finite",
    ),
    "huge number of steps": (noted(f'delaySteps="{"9" * 5000}"'), "expected a whole number from 0"),
    "bad delay": (noted('delay="x"'), "delay = 'x', expected a number"),
    "bad delay steps": (noted('delaySteps="-1"'), "delaySteps = '-1', expected a whole number from 0"),
    # components and connectors
    "bad every": (
        elements(component("b", "", note("Component", 'every="0"'))),
        "every = '0', expected a whole number from 1",
    ),
    "missing FMU": (
        elements(component("c")),
        "the FMU of component c is missing: the archive has no file 'resources/c.fmu'",
    ),
    "FMU outside": (elements(component("b", source="../b.fmu")), "'../b.fmu': only files inside the .ssp are read"),
    "FMU elsewhere": (elements(component("b", source="https://x.org/b.fmu")), "only files inside the .ssp are read"),
    "no FMU": (elements(component("b", source="SystemStructure.ssd")), "component b: SystemStructure.ssd"),
    "type of component": (
        GOOD.replace('name="a" ', 'name="a" type="text/x-modelica" '),
        "component a has the type 'text/x-modelica', which is not supported: only FMUs and SSP systems are",
    ),
    "implementation": (
        GOOD.replace('name="a" ', 'name="a" implementation="ModelExchange" '),
        "component a: implementation 'ModelExchange', which resources/a.fmu does not have: correct it, or leave it out",
    ),
    "signal dictionary": (
        elements(A, '<ssd:SignalDictionaryReference name="d" dictionary="x"/>'),
        "d is a SignalDictionaryReference, which is not supported: connect the components directly",
    ),
    "lines in names": (LINES, "connector b.x y: resources/b.fmu has no"),
    "two elements": (elements(A, A), "two elements have the name 'a'"),
    "names that become one": (
        elements(*(component(n, source="resources/b.fmu") for n in ("x.y", "x_y"))),
        "have the name 'x_y' in the flat system",
    ),
    "two connectors": (elements(component("b", "input u; input u")), "two connectors have the name b.u"),
    "connector without variable": (
        elements(component("b", "input uu")),
        "connector b.uu: resources/b.fmu has no such variable",
    ),
    "kind of connector": (
        elements(component("b", "output u")),
        "b.u is of kind 'output', the FMU's variable is of causality 'input'",
    ),
    "type of connector": (
        elements(component("b", "input u Boolean")),
        "b.u is of type Boolean, the FMU's variable is Float64",
    ),
    "unit of connector": (elements(component("b", "input u Real s")), "b.u has the unit 's', the FMU's variable 'm'"),
    "undefined unit": (
        elements(component("b", "input u Real mile")),
        "b.u has the unit 'mile', the FMU's variable 'm'",
    ),
    # parameters
    "unknown parameter": (
        bound(parameters({"kk": ONE})),
        "b has no variable for the parameter 'kk' (did you mean k",
    ),
    "unknown parameter of a system": (
        bindings(parameters({"b.kk": ONE})) + elements(B),
        "the system has no variable for the parameter 'b.kk' (did you mean b.k",
    ),
    "wrong unit of a parameter": (
        bound(parameters({"turn": f'{ONE} unit="m"'}, ("m",))),
        "'m' and 'rad', and do not measure the same",
    ),
    "undefined unit of a parameter": (
        bound(parameters({"turn": f'{ONE} unit="furlong"'})),
        "units differ, 'furlong' and 'rad', and 'furlong' is not defined: define it",
    ),
    "type of a parameter": (
        bound(parameters({"k": 'Boolean value="true"'})),
        "parameter binding 1 of b: parameter 'k': b.k = True: expected a number",
    ),
    "real for integer": (
        bound(parameters({"seed": 'Real value="1.5"'})),
        "parameter 'seed': b.seed = 1.5: expected an integer",
    ),
    "text for real": (bound(parameters({"k": 'String value="1"'})), "b.k = '1': expected a number"),
    "unknown item": (
        bound(parameters({"tint": 'Enumeration value="pink"'})),
        "is the item 'pink', the enumeration has red, green, blue",
    ),
    "value that is no item": (
        bound(parameters({"tint": 'Integer value="3"'})),
        "b.tint = 3 is no item of this enumeration: use 'red' or 1, 'green' or 2, 'blue' or 7",
    ),
    "item for real": (
        bound(parameters({"k": 'Enumeration value="x"'})),
        "is an item of an enumeration, 'x', and goes to something else",
    ),
    "constant": (bound(parameters({"fixed": ONE})), "b.fixed cannot be given a start value"),
    "not finite": (bound(parameters({"k": 'Real value="INF"'})), "b.k = inf is not finite"),
    "twice": (
        bound(parameters({"k": ONE}).replace("</ssv:Parameters>", f"{AGAIN}</ssv:Parameters>")),
        "has two parameters 'k'",
    ),
    "no file of parameters": (bound('source="resources/x.ssv">'), "the file of parameter binding 1 of b is missing"),
    "no parameters": (bound(">"), "parameter binding 1 of b has neither a source nor one ParameterSet inside"),
    "type of binding": (bound('type="text/csv" source="x.csv">'), "parameter binding 1 of b has the type 'text/csv'"),
    "parameters in a component": (
        bound('sourceBase="component" source="x.ssv">'),
        "is inside its component, which is not supported",
    ),
    "mapping of nothing": (mapped(parameters({"x": ONE}), "y -> k"), "maps the parameter 'y', which is not there"),
    "mapping to nothing": (mapped(parameters({"x": ONE}), "x -> kk"), "b has no variable for the parameter 'kk'"),
    "mapping to one": (mapped(parameters({"x": ONE, "y": ONE}), "x -> k", "y -> k"), "maps two parameters to 'k'"),
    # the documents themselves
    "schema of the structure": (GOOD.replace("kind=", "kinds="), "SystemStructure.ssd is not valid SSP 1.0, line 2"),
    "schema of parameters": (bound(parameters({"k": "Real"})), "binding 1 of b is not valid SSP 1.0, line 2"),
    "SSP 2.0 in 1.0": (
        elements(component("b", "input w Real rad/s [3]")),
        "is not valid SSP 1.0, line 2: Element 'Dimension': This element is not expected",
    ),
}


@pytest.mark.parametrize("case", STRUCTURES)
def test_structures(case, package):
    inside, expected = STRUCTURES[case]
    assert expected in refusal(package(ssd(inside)))


ARRAYS = {
    "huge connector": (
        elements(*(system(n, "input i Float64 [100000,100000]; output o Float64 [100000,100000]", "") for n in "st"))
        + connections("s.o -> t.i"),
        "s.o has 10000000000 elements, more than 1000000: refused",
    ),
    "sizes": (elements(V, W) + connections("a.M -> b.w"), "connection a.M -> b.w: sizes differ, 2 x 2 and 3"),
    "index": (elements(V, W) + connections('a.v -> b.u | startIndices="4"'), "a.v[4] does not exist, v has 3"),
    "indices": (elements(V, W) + connections('a.v -> b.u | startIndices="1 1"'), "a.v[1,1] does not exist"),
    "dimensions": (
        elements(component("b", "input w Float64 [4]")),
        "b.w has the dimensions 4, the FMU's variable has 3",
    ),
    "element twice": (
        elements(V, W) + connections("a.v -> b.w", 'a.v -> b.w | startIndices="1" endIndices="2"'),
        "b.w has another source already",
    ),
    "unknown size": (
        elements(V, system("s", "input i Float64 [?]", "")) + connections('a.v -> s.i | startIndices="1"'),
        "the dimensions of s.i are not known",
    ),
    "values": (
        elements(component("b", "", bindings(parameters({"J": 'Float64 value="1 2"'}, version="2.0")))),
        "parameter 'J' has 2 values, without a Dimension it has a single one: correct them",
    ),
    "values and variable": (
        elements(component("b", "", bindings(parameters({"J": 'Float64 value="1"'}, version="2.0")))),
        "parameter 'J': b.J: expected 2 x 2 values, got a single value, as it has no Dimension: give it those of the",
    ),
    "scheduled": (
        elements(component("b").replace("<ssd:Component ", '<ssd:Component implementation="ScheduledExecution" ')),
        "component b asks for ScheduledExecution, which is not supported",
    ),
    "no source": (elements('<ssd:Component name="b"/>'), "component b has no source: name its FMU"),
    "local to parameter": (elements(component("b", "inout u")), "b.u is of kind 'inout'"),
}


@pytest.mark.parametrize("case", ARRAYS)
def test_structures_of_ssp_2(case, package):
    inside, expected = ARRAYS[case]
    parts = {"resources/a.fmu": "sender3", "resources/b.fmu": "receiver3"}
    assert expected in refusal(package(ssd(inside, version="2.0"), parts))


BOMB = "<!DOCTYPE x [" + '<!ENTITY a0 "ha">' + "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 10}">' for i in range(1, 12))
DOCUMENTS = {
    "empty": (b"", "SystemStructure.ssd is not well-formed XML"),
    "no XML": (b"hello", "SystemStructure.ssd is not well-formed XML"),
    "not UTF-8": (ssd(GOOD).replace("root", "röt").encode("latin-1"), "is not in UTF-8"),
    "something else": (b"<html/>", "is no SystemStructureDescription of SSP 1.0 or 2.0 but has the root element html"),
    "version": (ssd(GOOD, version="3.0").encode(), "is of SSP version '3.0': only 1.0 and 2.0 are supported"),
    "bomb": (
        ssd(GOOD).replace("\n", f"\n{BOMB}]>", 1).replace('name="root"', 'name="&a11;"').encode(),
        "has a document type declaration, which FMI and SSP do not use",
    ),
    "external entity": (
        ssd(GOOD).replace("\n", '\n<!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/passwd">]>', 1).encode(),
        "has a document type declaration, which FMI and SSP do not use",
    ),
    "hidden declaration": (
        '<?xml version="1.0" encoding="UTF-7"?>\n+ADwAIQ-DOCTYPE x+AD4- <x/>'.encode("ascii"),
        "is in utf-7, expected UTF-8",
    ),
    "deep": (("<a>" * 5000).encode(), "has elements nested more"),
    "times": (ssd(GOOD, more='<ssd:DefaultExperiment stopTime="INF"/>').encode(), "stopTime = inf: expected a number"),
    "no step": (
        ssd(GOOD, more=f"<ssd:DefaultExperiment>{STEP}</ssd:DefaultExperiment>").encode(),
        "step = 0.0: expected a positive number",
    ),
    "unit twice": (
        ssd(GOOD).replace("</ssd:Units>", '<ssc:Unit name="m"><ssc:BaseUnit/></ssc:Unit></ssd:Units>').encode(),
        "unit 'm' is defined twice",
    ),
}


@pytest.mark.parametrize("case", DOCUMENTS)
def test_documents(case, package):
    content, expected = DOCUMENTS[case]
    assert expected in refusal(package(content))


def test_documents_of_parameters(package):
    inside = elements(component("b", "", bindings('source="x.ssv">')))
    bad = {
        "<x/>": "x.ssv is no ParameterSet of SSP",
        "<!DOCTYPE x><x/>": "x.ssv has a document type declaration",
        parameters({"k": "Real"}): "x.ssv is not valid SSP 1.0, line 1",
        parameters({"kk": ONE}): "x.ssv: b has no variable for the parameter 'kk'",
    }
    for text, expected in bad.items():
        assert expected in refusal(package(ssd(inside), None, {"x.ssv": text}))


class TestArchives:
    def test_missing_file(self, tmp_path):
        assert "cannot open" in refusal(tmp_path / "none.ssp")

    def test_no_zip(self, tmp_path):
        path = tmp_path / "no.ssp"
        path.write_text("no zip")
        assert "is not a readable zip archive" in refusal(path)

    def test_no_structure(self, package):
        assert "it has no SystemStructure.ssd at its root: pack it there" in refusal(package(None))

    def test_other_structure(self, package):
        message = refusal(package(ssd(GOOD)), structure="x.ssd")
        assert "it has no system structure 'x.ssd': choose one of SystemStructure.ssd" in message

    @pytest.mark.parametrize("name", ["../evil", "/evil", "a/../../evil", "C:/evil", "a\\evil"])
    def test_paths_that_lead_outside(self, package, name):
        assert "that leads outside the archive: refused" in refusal(package(ssd(GOOD), None, {name: "x"}))

    def test_cut_short(self, package):
        path = package(ssd(GOOD))
        path.write_bytes(path.read_bytes()[:100])
        assert "is not a readable zip archive" in refusal(path)

    def test_damaged(self, package):
        path = package(ssd(GOOD))
        content = bytearray(path.read_bytes())
        content[content.index(b"SystemStructure.ssd") + 40] ^= 0xFF
        path.write_bytes(content)
        assert "'SystemStructure.ssd' cannot be unpacked" in refusal(path)

    def test_huge_documents(self, package):
        """A zip bomb: the size that the archive declares is believed, and more is not read."""
        path = package(None, None, {"x": "x"})
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as zipped:
            zipped.writestr("SystemStructure.ssd", b" " * (65 << 20))
        assert "bytes unpacked, more than" in refusal(path)

    def test_encrypted(self, package):
        path = package(ssd(GOOD))
        content = bytearray(path.read_bytes())
        entry = content.rindex(b"PK\x01\x02", 0, content.rindex(b"SystemStructure.ssd"))
        struct.pack_into("<H", content, entry + 8, 1)
        path.write_bytes(content)
        assert "'SystemStructure.ssd' is encrypted: pack it without" in refusal(path)

    def test_broken_fmu(self, package):
        path = package(ssd(elements(component("c"))), None, {"resources/c.fmu": "no FMU"})
        assert "component c: resources/c.fmu is not a readable zip archive" in refusal(path)
