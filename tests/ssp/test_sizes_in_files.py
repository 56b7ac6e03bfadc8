"""Structural parameters come first: they say how large the arrays are of which everything else speaks."""

from __future__ import annotations

import zipfile

import pytest
from lxml import etree
from packages import Variable, bindings, component, connections, elements, make_fmu, mapping, parameters, ssd, system

from adcs import AdcsError, System, read_ssp, run, write_ssp

PINS = "structuralParameter n UInt64; input u Float64 [{0}]; output y Float64 [{0}]"
ANY = PINS.format("?")


def size(number):
    return f'UInt64 value="{number}"'


def row(*values):
    return f'<ssv:Float64 value="{" ".join(map(str, values))}"/><ssc:Dimension size="{len(values)}"/>'


def given(**values):
    return bindings(parameters(values, version="2.0"))


FIVE = row(1, 2, 3, 4, 5)


@pytest.fixture
def read(package, foreign):
    """read(structure) -> system of a and b, whose inputs u, outputs y = 2 u and sums of u have the size n = 3."""

    def make(inside, parts=None):
        parts = {f"resources/{name}.fmu": foreign("sizes") for name in "ab"} | (parts or {})
        return read_ssp(package(ssd(inside, version="2.0"), parts)).system

    return make


def test_a_parameter_set_resizes_before_all_else(read):
    """Connectors, start values and connections are those of the size given."""
    pins = PINS.format(5)
    first = component("a", pins, given(u=FIVE, n=size(5)))
    found = read(elements(first, component("b", pins, given(n=size(5)))) + connections("a.y -> b.u"))
    assert found.components["a"].fmu.ports["y"].shape == (5,)
    assert [(c.source, c.target) for c in found.connections] == [("a.y", "b.u")]
    result = run(found, stop_time=1.0, step=1.0)
    assert result["b.y"].tolist() == [[4, 8, 12, 16, 20]] * 2
    assert result["b.total"].tolist() == [30, 30]


def test_without_a_value_the_fmu_has_its_own(read):
    found = read(elements(component("a", PINS.format(3), given(u=row(7, 8, 9)))))
    assert run(found, stop_time=1.0, step=1.0)["a.total"].tolist() == [24, 24]


HALF = '<ssc:LinearTransformation factor="0.5"/>'
MAPPED = (
    f"><ssd:ParameterValues>{parameters({'m': size(10), 'v': FIVE}, version='2.0')}</ssd:ParameterValues>"
    f"<ssd:ParameterMapping>{mapping(f'm -> n || {HALF}', 'v -> u')}</ssd:ParameterMapping>"
)
INNER = elements(component("a", ANY, given(u=FIVE))) + connections("size -> a.n")
NESTED = "structuralParameter size UInt64"
TWO = bindings(parameters({"n": size(2)}, version="2.0"), parameters({"n": size(5), "u": FIVE}, version="2.0"))
WAYS = {
    "of the component": elements(component("a", "", given(n=size(5), u=FIVE))),
    "of the system": given(**{"a.n": size(5), "a.u": FIVE}) + elements(component("a")),
    "the last one counts": elements(component("a", "", TWO)),
    "the higher one counts": given(**{"a.n": size(5)}) + elements(component("a", "", given(n=size(2), u=FIVE))),
    "mapped": elements(component("a", "", bindings(MAPPED))),
    "of another type": elements(component("a", "", given(n='Integer value="5"', u=FIVE))),
    "through a system": elements(system("s", NESTED, INNER, given(size=size(5)))),
    "through a system, from outside": given(**{"s.size": size(5)}) + elements(system("s", NESTED, INNER)),
    "through two systems": elements(
        system(
            "outer",
            "structuralParameter all UInt64",
            elements(system("s", NESTED, INNER)) + connections("all -> s.size"),
            given(all=size(5)),
        )
    ),
}


@pytest.mark.parametrize("way", WAYS)
def test_every_way_to_a_structural_parameter(way, read):
    found = read(WAYS[way])
    (only,) = found.components.values()
    assert only.start == {"n": (5,), "u": (1.0, 2.0, 3.0, 4.0, 5.0)}
    assert run(found, stop_time=1.0, step=1.0)[f"{only.name}.total"].tolist() == [15, 15]


def test_a_constant_of_another_component_is_known_beforehand(read, tmp_path):
    other = make_fmu(tmp_path / "c.fmu", [Variable("four", "constant", "UInt64", start="4")], "3.0")
    inside = elements(component("c", "constant four"), component("a", ANY, given(u=row(1, 2, 3, 4))))
    found = read(inside + connections("c.four -> a.n"), {"resources/c.fmu": other})
    assert found.components["a"].start == {"n": (4,), "u": (1.0, 2.0, 3.0, 4.0)}
    assert not found.connections


class TestSizesByConnectors:
    """A dimension of a connector may be the value of another connector (sizeConnector)."""

    def component(self, name, **values):
        pins = f"structuralParameter n; input u Float64 [={name}]"
        return elements(component("a", pins, given(**values) if values else ""))

    def test_of_a_component(self, read):
        assert read(self.component("n", n=size(5), u=FIVE)).components["a"].fmu.ports["u"].shape == (5,)
        assert read(self.component("n")).components["a"].fmu.ports["u"].shape == (3,)

    def nested(self, name):
        pins = f"structuralParameter size; parameter i Float64 [={name}]"
        inside = elements(component("a", ANY)) + connections("size -> a.n", "i -> a.u")
        return elements(system("s", pins, inside, given(size=size(5), i=FIVE)))

    def test_of_a_system(self, read):
        assert read(self.nested("size")).components["s/a"].start == {"n": (5,), "u": (1.0, 2.0, 3.0, 4.0, 5.0)}

    def test_of_a_system_and_another_one(self, read):
        inside = self.nested("other").replace('name="i"', 'name="other" kind="parameter"/><ssd:Connector name="i"', 1)
        other = f'<ssv:Parameter name="other"><ssv:{size(4)}/></ssv:Parameter></ssv:Parameters>'
        expected = "connector s.i has the dimensions 4, what it is connected to has 5: correct them"
        assert expected in refusal(read, inside.replace("</ssv:Parameters>", other))

    def test_refused(self, read):
        assert (
            "connector a.u takes its size from the connector 'm', which a does not have (there is n, u): correct its "
            "sizeConnector"
        ) in refusal(read, self.component("m"))
        assert "connector a.u takes its size from the connector 'u', which is no whole number" in refusal(
            read, self.component("u")
        )
        assert "connector s.i takes its size from the connector 'm', which its system does not have" in refusal(
            read, self.nested("m")
        )
        both = self.component("n").replace("<ssc:Dimension ", '<ssc:Dimension size="3" ')
        assert "connector a.u has a Dimension with size 3 and sizeConnector 'n': drop one of them" in refusal(
            read, both
        )


def refusal(read, inside, parts=None):
    with pytest.raises(AdcsError) as error:
        read(inside, parts)
    assert "\n" not in str(error.value)
    return str(error.value)


SOURCE = connections("a.total -> b.n")
REFUSED = {
    "connector of the old size": (
        elements(component("a", PINS.format(3), given(n=size(5), u=FIVE))),
        "connector a.u has the dimensions 3, the FMU's variable has 5: correct them",
    ),
    "start value of the old size": (
        elements(component("a", ANY, given(n=size(5), u=row(1, 2, 3)))),
        "parameter 'u': a.u: expected 5 values, got 3 values, as its Dimensions say: correct them",
    ),
    "connection to the old size": (
        elements(component("a", ANY, given(n=size(5), u=FIVE)), component("b", ANY)) + connections("a.y -> b.u"),
        "connection a.y -> b.u: sizes differ, 5 and 3: connect elements by their indices",
    ),
    "no value for what was resized": (
        elements(component("a", ANY, given(n=size(5)))),
        "a.u[1] has no value: bind a parameter to it",
    ),
    "a fraction": (
        elements(component("a", ANY, given(n='Float64 value="2.5"'))),
        "parameter 'n': a.n = 2.5: expected an integer",
    ),
    "negative": (
        elements(component("a", ANY, given(n='Int32 value="-1"'))),
        "parameter 'n': a.n = -1 is outside the range of UInt64",
    ),
    "too large": (
        elements(component("a", ANY, given(n=size(10**9)))),
        "u would have 1,000,000,000 elements, more than 1,000,000",
    ),
    "an array": (
        elements(component("a", ANY, given(n='<ssv:UInt64 value="5"/><ssc:Dimension size="1"/>'))),
        "parameter 'n': a.n: expected a single value, got 1 values, as its Dimensions say: leave them out",
    ),
    "computed": (
        elements(component("a", f"{ANY}; output total"), component("b", ANY)) + SOURCE,
        "connection a.total -> b.n: a value that is computed goes into structuralParameter b.n",
    ),
    "through a parameter": (
        elements(system("s", "parameter size UInt64", INNER, given(size=size(3)))).replace(FIVE, row(1, 2, 3)),
        "s/a.n is a structural parameter and gets its value by connectors that are not of kind structuralParameter or "
        "constant: correct their kind",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case, read):
    inside, expected = REFUSED[case]
    assert expected in refusal(read, inside)


class TestWriting:
    """A system whose FMU was resized comes back, and is written with the sizes that it has."""

    def made(self, foreign):
        made = System("resized")
        made.add("a", foreign("sizes"), {"u": [1, 2, 3, 4, 5], "n": 5})
        made.add("sub/b", foreign("sizes"), {"n": 5})
        made.add("c", foreign("sizes"), {"u": [7.0, 8.0, 9.0]})
        made.connect("a.y", "sub/b.u")
        return made

    def test_round_trip(self, foreign, tmp_path):
        made = self.made(foreign)
        write_ssp(made, tmp_path / "one.ssp", step=1.0)
        file = read_ssp(tmp_path / "one.ssp")
        assert {n: c.start for n, c in file.system.components.items()} == {
            "a": {"n": (5,), "u": (1.0, 2.0, 3.0, 4.0, 5.0)},
            "sub/b": {"n": (5,)},
            "c": {"u": (7.0, 8.0, 9.0)},
        }
        assert file.system.connections == made.connections
        write_ssp(file.system, tmp_path / "two.ssp", step=1.0)
        assert (tmp_path / "two.ssp").read_bytes() == (tmp_path / "one.ssp").read_bytes()
        ours, theirs = (run(s, stop_time=1.0, step=1.0) for s in (made, file.system))
        assert (ours.data == theirs.data).all()
        assert theirs["sub/b.total"].tolist() == [30, 30]

    def test_what_is_written(self, foreign, tmp_path):
        write_ssp(self.made(foreign), tmp_path / "one.ssp")
        with zipfile.ZipFile(tmp_path / "one.ssp") as archive:
            structure = etree.fromstring(archive.read("SystemStructure.ssd"))
            values = etree.fromstring(archive.read("resources/a.ssv"))
        sizes = [(e.getparent().get("name"), e.get("size")) for e in structure.iterfind(".//{*}Connector/{*}Dimension")]
        assert sorted(sizes) == [("a_y", "5"), ("u", "5"), ("y", "3"), ("y", "5"), ("y", "5")]
        written = [(e.get("name"), e[0].tag.rpartition("}")[2], e[0].get("value")) for e in values.iter("{*}Parameter")]
        assert written == [("n", "UInt64", "5"), ("u", "Float64", "1 2 3 4 5")]

    def test_a_size_set_last_is_written_first(self, foreign, tmp_path):
        made = System("late")
        made.add("a", foreign("sizes"), {"u": [1.0, 2.0, 3.0]})
        made.set("a.n", 3)
        write_ssp(made, tmp_path / "one.ssp")
        file = read_ssp(tmp_path / "one.ssp")
        assert list(file.system.components["a"].start) == ["n", "u"]
        write_ssp(file.system, tmp_path / "two.ssp")
        assert (tmp_path / "two.ssp").read_bytes() == (tmp_path / "one.ssp").read_bytes()

    def test_arrays_of_size_0(self, foreign, tmp_path):
        made = System("nothing")
        for name in ("a", "b"):
            made.add(name, foreign("square"), {"rows": 0, "columns": 0})
        made.connect("a.y", "b.u")
        write_ssp(made, tmp_path / "one.ssp", step=1.0)
        file = read_ssp(tmp_path / "one.ssp")
        assert file.system.connections == made.connections
        assert {n: c.start for n, c in file.system.components.items()} == {
            name: {"rows": (0,), "columns": (0,)} for name in ("a", "b")
        }
        write_ssp(file.system, tmp_path / "two.ssp", step=1.0)
        assert (tmp_path / "two.ssp").read_bytes() == (tmp_path / "one.ssp").read_bytes()

    def test_structural_parameters_of_every_type(self, foreign, tmp_path):
        made = System("types")
        values = {"rows": 3, "columns": 3, "margin": 0.5, "deep": False, "level": -2, "label": "zz"}
        made.add("a", foreign("square"), {**values, "u": [[1.0] * 3] * 3})
        write_ssp(made, tmp_path / "one.ssp")
        assert read_ssp(tmp_path / "one.ssp").system.components["a"].start == made.components["a"].start
