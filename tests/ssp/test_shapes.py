"""A value has the dimensions of what it is given to, else it is refused as `System.set` refuses it."""

from __future__ import annotations

import pytest
from packages import Variable, bindings, component, connections, elements, make_fmu, parameters, ssd, system

from adcs import AdcsError, System, read_ssp, write_ssp


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """Arrays of all kinds; of FMI 3.0."""
    variables = [
        Variable("M", "parameter", shape=(2, 3), start="0"),
        Variable("v", "parameter", shape=(6,), start="0"),
        Variable("one", "parameter", shape=(1,), start="0"),
        Variable("s", "parameter", start="0"),
        Variable("words", "parameter", "String", shape=(2,), start=""),
        Variable("blobs", "parameter", "Binary", shape=(2,), start="00"),
        Variable("n", "parameter", "Int32", shape=(2, 2), start="0"),
    ]
    return make_fmu(tmp_path_factory.mktemp("box") / "box.fmu", variables, "3.0")


def value(text, *shape, kind="Float64"):
    return f'<ssv:{kind} value="{text}"/>' + "".join(f'<ssc:Dimension size="{n}"/>' for n in shape)


def texts(kind, *values, shape):
    inside = "".join(f'<ssv:Value value="{v}"/>' for v in values)
    return f"<ssv:{kind}>{inside}</ssv:{kind}>" + "".join(f'<ssc:Dimension size="{n}"/>' for n in shape)


def bound(package, box, **values):
    inside = elements(component("b", "", bindings(parameters(values, version="2.0"))))
    return read_ssp(package(ssd(inside, version="2.0"), {"resources/b.fmu": box})).system.components["b"].start


SIX = "11 12 13 21 22 23"


def test_values_of_the_variables_dimensions_are_taken_row_by_row(package, box):
    start = bound(
        package,
        box,
        M=value(SIX, 2, 3),
        v=value(SIX, 6),
        one=value("7", 1),
        s=value("8"),
        words=texts("String", "a b", "", shape=(2,)),
        blobs=texts("Binary", "00ff", "10", shape=(2,)),
        n=value("1 2 3 4", 2, 2, kind="Int32"),
    )
    six = (11.0, 12.0, 13.0, 21.0, 22.0, 23.0)
    assert start.pop("words") == ("a b", "")
    assert start.pop("blobs") == (b"\x00\xff", b"\x10")
    assert start == {"M": six, "v": six, "one": (7.0,), "s": (8.0,), "n": (1, 2, 3, 4)}


@pytest.mark.parametrize(
    ("name", "given", "expected"),
    [
        ("M", value(SIX, 3, 2), "b.M: expected 2 x 3 values, got 3 x 2 values, as its Dimensions say: correct them"),
        ("M", value(SIX, 6), "b.M: expected 2 x 3 values, got 6 values, as its Dimensions say: correct them"),
        ("M", value(SIX, 1, 6), "b.M: expected 2 x 3 values, got 1 x 6 values, as its"),
        ("M", value(SIX, 2, 3, 1), "b.M: expected 2 x 3 values, got 2 x 3 x 1 values, as its"),
        ("M", value("1 2 3 4", 2, 2), "b.M: expected 2 x 3 values, got 2 x 2 values, as its"),
        ("M", value("1"), "b.M: expected 2 x 3 values, got a single value, as it has no Dimension: give it those of"),
        ("M", value(SIX), "parameter 'M' has 6 values, without a Dimension it has a single one: correct them"),
        ("M", value(SIX, 2, 2), "parameter 'M' has 6 values, its Dimensions say 2 x 2: correct them"),
        ("v", value(SIX, 2, 3), "b.v: expected 6 values, got 2 x 3 values"),
        ("v", value(SIX, 6, 1), "b.v: expected 6 values, got 6 x 1 values"),
        ("one", value("7"), "b.one: expected 1 values, got a single value, as it has no Dimension"),
        ("s", value("7", 1), "b.s: expected a single value, got 1 values, as its Dimensions say: leave them out"),
        ("words", texts("String", "a", "b", shape=(2, 1)), "b.words: expected 2 values, got 2 x 1 values"),
        ("words", texts("String", "a", "b", "c", shape=(3,)), "b.words: expected 2 values, got 3 values"),
        ("blobs", texts("Binary", "00", "01", shape=(1, 2)), "b.blobs: expected 2 values, got 1 x 2 values"),
        ("blobs", texts("Binary", "00", shape=(1,)), "b.blobs: expected 2 values, got 1 values"),
        ("n", value("1 2 3 4", 4, kind="Int32"), "b.n: expected 2 x 2 values, got 4 values"),
        ("v", '<ssv:Float64 value="1"/><ssc:Dimension/>', "'v' has a Dimension without size or with a sizeConnector"),
        ("v", '<ssv:Float64 value="1"/><ssc:Dimension sizeConnector="s"/>', "without size or with a sizeConnector"),
    ],
)
def test_values_of_other_dimensions_are_refused(package, box, name, given, expected):
    with pytest.raises(AdcsError) as error:
        bound(package, box, **{name: given})
    assert str(error.value).startswith("test.ssp: parameter binding 1 of b: parameter")
    assert expected in str(error.value)


def test_the_same_dimensions_are_refused_from_python_and_from_a_file(package, box):
    wrong = {"M": [[11, 12], [13, 21], [22, 23]], "blobs": [["00", "01"]], "words": [["a"], ["b"]]}
    files = {"M": value(SIX, 3, 2), "blobs": texts("Binary", "00", "01", shape=(1, 2))}
    files["words"] = texts("String", "a", "b", shape=(2, 1))
    for name, given in wrong.items():
        with pytest.raises(AdcsError) as of_python:
            System("s").add("b", box, {name: given})
        with pytest.raises(AdcsError) as of_file:
            bound(package, box, **{name: files[name]})
        assert str(of_python.value) in str(of_file.value)


class TestConnectorsOfSystems:
    """A value may be given to a connector of a system, from where it flows into components."""

    def read(self, package, box, given, connector="parameter p Float64 [2,3]", inner="parameter M Float64 [2,3]"):
        inside = system(
            "s",
            connector,
            elements(component("b", inner, source="resources/b.fmu")) + connections("p -> b.M"),
            bindings(parameters({"p": given}, version="2.0")),
        )
        path = package(ssd(elements(inside), version="2.0"), {"resources/b.fmu": box})
        return read_ssp(path).system.components["s/b"].start

    def test_of_the_same_dimensions(self, package, box):
        assert self.read(package, box, value(SIX, 2, 3)) == {"M": (11.0, 12.0, 13.0, 21.0, 22.0, 23.0)}

    def test_of_others(self, package, box):
        with pytest.raises(AdcsError, match="'p': connector p has 2 x 3, the value has 3 x 2, as its Dimensions say"):
            self.read(package, box, value(SIX, 3, 2))

    def test_left_open(self, package, box):
        assert self.read(package, box, value(SIX, 2, 3), "parameter p Float64 [?,?]")["M"][3] == 21.0
        with pytest.raises(AdcsError, match="'p': connector p has 2 x 3, the value has 3 x 2"):
            self.read(package, box, value(SIX, 3, 2), "parameter p Float64 [?,?]")

    @pytest.mark.parametrize("dimensions", ["[?]", "[3,?]", "[?,2]", "[?,?,?]"])
    def test_left_open_and_others(self, package, box, dimensions):
        said = dimensions[1:-1].replace(",", " x ")
        expected = f"connector s.p has the dimensions {said}, what it is connected to has 2 x 3: correct them"
        with pytest.raises(AdcsError) as error:
            self.read(package, box, value(SIX, 2, 3), f"parameter p Float64 {dimensions}")
        assert expected in str(error.value)

    def test_of_which_nothing_is_known(self, package, box):
        given = bindings(parameters({"p": value("1 2", 2)}, version="2.0"))
        inside = system("s", "parameter p Float64 [?]", elements(component("b")), given)
        path = package(ssd(elements(inside), version="2.0"), {"resources/b.fmu": box})
        assert read_ssp(path).system.components["s/b"].start == {}


@pytest.mark.parametrize(
    ("pins", "expected"),
    [
        (
            "parameter M Float64 [3,2]",
            "connector b.M has the dimensions 3 x 2, the FMU's variable has 2 x 3: correct them",
        ),
        ("parameter M Float64 [6]", "b.M has the dimensions 6, the FMU's variable has 2 x 3"),
        ("parameter M Float64 [2,3,1]", "b.M has the dimensions 2 x 3 x 1, the FMU's variable has 2 x 3"),
        ("parameter M Float64 [?]", "b.M has the dimensions ?, the FMU's variable has 2 x 3"),
        ("parameter s Float64 [1]", "b.s has the dimensions 1, the FMU's variable is a scalar"),
    ],
)
def test_connectors_of_components_with_other_dimensions_are_refused(package, box, pins, expected):
    with pytest.raises(AdcsError) as error:
        read_ssp(package(ssd(elements(component("b", pins)), version="2.0"), {"resources/b.fmu": box}))
    assert expected in str(error.value)


@pytest.mark.parametrize(
    "pins", ["parameter M Float64 [2,3]", "parameter M Float64 [?,3]", "parameter M Float64", "parameter M"]
)
def test_connectors_of_components_may_leave_dimensions_out(package, box, pins):
    path = package(ssd(elements(component("b", pins)), version="2.0"), {"resources/b.fmu": box})
    assert list(read_ssp(path).system.components) == ["b"]


def test_scalars_of_fmi_2_are_given_as_scalars(package):
    inside = elements(component("b", "", bindings(parameters({"J[1,2]": 'Real value="3"'}))))
    assert read_ssp(package(ssd(inside))).system.components["b"].start["J"] == (0.0, 3.0, 0.0, 0.0)
    inside = elements(component("b", "", bindings(parameters({"J[1,2]": value("3", 1)}, version="2.0"))))
    with pytest.raises(AdcsError, match=r"b\.J\[1,2\]: expected a single value, got 1 values, as its Dimensions say"):
        read_ssp(package(ssd(inside, version="2.0")))


def test_values_of_arrays_are_written_with_their_dimensions(box, tmp_path):
    made = System("box")
    made.add("b", box, {"M": [[1, 2, 3], [4, 5, 6]], "blobs": [b"\x01", b""], "words": ["", "x"]})
    write_ssp(made, tmp_path / "box.ssp")
    assert read_ssp(tmp_path / "box.ssp").system.components["b"].start == made.components["b"].start
