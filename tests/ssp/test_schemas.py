"""The schemas of SSP 2.0, which are made from those of 1.0."""

from __future__ import annotations

import pytest
from lxml import etree
from packages import component, connections, elements, parameters, ssd

from orchestration.ssp.schemas import schema

PIN = '<ssd:Connector name="x" kind="{}">{}</ssd:Connector>'


def with_connector(inner, kind="input"):
    return elements(component("a")).replace(
        "</ssd:Component>", f"<ssd:Connectors>{PIN.format(kind, inner)}</ssd:Connectors></ssd:Component>"
    )


METADATA = (
    '<ssc:MetaData kind="general" type="text/plain" source="x.txt"><ssc:Content>x</ssc:Content>'
    '<ssc:Signature role="authenticity" type="y"/></ssc:MetaData>'
)
ONLY_IN_2 = {
    "dimension": with_connector('<ssc:Float64 unit="m"/><ssc:Dimension size="3"/><ssc:Dimension sizeConnector="n"/>'),
    "clock": with_connector('<ssc:Clock intervalVariability="triggered"/><ssd:Clock name="c"/>'),
    "clocked": with_connector('<ssc:Float32/><ssd:Clock name="c"/>'),
    **{
        t: with_connector(f"<ssc:{t}/>")
        for t in ("Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")
    },
    **{k: with_connector("", k) for k in ("structuralParameter", "constant", "local", "unspecified")},
    "inner place": with_connector('<ssd:ConnectorGeometry x="0" y="1" systemInnerX="0.5" systemInnerY="0.5"/>'),
    "indices": connections('a.x -> b.y | startIndices="1 2" endIndices="3"'),
    "no source": elements('<ssd:Component name="a"/>'),
    "scheduled": elements('<ssd:Component name="a" source="x" implementation="ScheduledExecution"/>'),
    "metadata": elements(component("a", "", METADATA)),
}
ARRAYS = {
    "reals": '<ssv:Real value="1 2 3"/>',
    "integers": '<ssv:Integer value="1 2 3"/>',
    "booleans": '<ssv:Boolean value="true false"/>',
    "typed": '<ssv:UInt8 value="1 255"/>',
    "floats": '<ssv:Float32 value="1 2" unit="m"/>',
    "texts": '<ssv:String><ssv:Value value="a"/><ssv:Value value="b"/></ssv:String>',
    "items": '<ssv:Enumeration name="E"><ssv:Value value="a"/></ssv:Enumeration>',
    "binaries": '<ssv:Binary><ssv:Value value="00ff"/></ssv:Binary>',
    "dimension": '<ssv:Real value="1"/><ssc:Dimension size="1"/>',
}


def valid(kind, version, text):
    return schema(kind, version).validate(etree.fromstring(text.encode()))


@pytest.mark.parametrize("case", ONLY_IN_2)
def test_structures_of_2(case):
    assert valid("ssd", "2.0", ssd(ONLY_IN_2[case], version="2.0"))
    assert not valid("ssd", "1.0", ssd(ONLY_IN_2[case], version="1.0"))
    assert not valid("ssd", "2.0", ssd(ONLY_IN_2[case], version="1.0"))  # versions are not mixed within a document


@pytest.mark.parametrize("case", ARRAYS)
def test_parameters_of_2(case):
    assert valid("ssv", "2.0", parameters({"x": ARRAYS[case]}, version="2.0"))
    assert not valid("ssv", "1.0", parameters({"x": ARRAYS[case]}))


@pytest.mark.parametrize(
    "value", ['UInt8 value="256"', 'Int8 value="-129"', 'Boolean value="yes"', 'Real value="x"', "Real"]
)
def test_bad_values_in_both(value):
    for version in ("1.0", "2.0"):
        assert not valid("ssv", version, parameters({"x": value}, version=version))


@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_what_both_have_in_common(version):
    inside = elements(component("a", "input x Real m; output y Boolean")) + connections("a.y -> b.x")
    assert valid("ssd", version, ssd(inside, version=version))
    assert valid("ssv", version, parameters({"x": 'Real value="1"'}, version=version))
    assert not valid("ssd", version, ssd(inside.replace('kind="input"', 'kind="sink"'), version=version))
    assert not valid("ssd", version, ssd(inside.replace("startConnector", "connector"), version=version))
