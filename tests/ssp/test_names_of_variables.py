"""A connector may be named by any of the names that a variable of an FMU has (alias names in FMI 3.0)."""

from __future__ import annotations

import pytest
from packages import Variable, bindings, component, connections, elements, make_fmu, parameters, ssd

from adcs import AdcsError, read_ssp, write_ssp


@pytest.fixture
def read(package, tmp_path_factory):
    """read(structure) -> system of a, whose output y is also called yy, and b, whose input u is also called uu."""
    folder = tmp_path_factory.mktemp("aliases")
    variables = [Variable("y", "output", unit="m", aliases=("yy",)), Variable("z", "output", unit="m")]
    giver = make_fmu(folder / "giver.fmu", variables, "3.0")
    taker = [
        Variable("u", "input", unit="m", start="1.25", aliases=("uu",)),
        Variable("k", "parameter", start="1", aliases=("kk",)),
    ]
    taker = make_fmu(folder / "taker.fmu", taker, "3.0")

    def make(inside):
        return read_ssp(
            package(ssd(inside, version="2.0"), {"resources/a.fmu": giver, "resources/b.fmu": taker})
        ).system

    return make


def test_a_connection_by_aliases_is_one_of_the_variables(read):
    found = read(
        elements(component("a", "output yy"), component("b", "input uu Float64 m")) + connections("a.yy -> b.uu")
    )
    assert [(c.source, c.target) for c in found.connections] == [("a.yy", "b.u")]
    assert "u" not in found.components["b"].start


def test_a_value_by_an_alias_is_one_of_the_variable(read):
    given = bindings(parameters({"kk": 'Float64 value="3"', "uu": 'Float64 value="2"'}, version="2.0"))
    found = read(elements(component("b", "input uu", given)))
    assert found.components["b"].start == {"k": (3.0,), "u": (2.0,)}


def test_two_values_by_two_names_contradict_each_other(read):
    def given(*values):
        return elements(component("b", "", bindings(*(parameters(v, version="2.0") for v in values))))

    two, three = 'Float64 value="2"', 'Float64 value="3"'
    expected = r"parameter 'kk': b\.kk is another name of what 'k' gives a different value: leave one of them out"
    with pytest.raises(AdcsError, match=expected):
        read(given({"k": two, "kk": three}))
    assert read(given({"k": two, "kk": two})).components["b"].start["k"] == (2.0,)
    assert read(given({"k": two}, {"kk": three})).components["b"].start["k"] == (3.0,)  # the later binding wins


def test_two_sources_by_two_names_are_two_sources(read):
    inside = elements(component("a", "output y; output z"), component("b", "input u; input uu"))
    with pytest.raises(
        AdcsError, match=r"connection a\.z -> b\.uu: b\.u has another source already, connection a\.y -> b\.u"
    ):
        read(inside + connections("a.y -> b.u", "a.z -> b.uu"))


def test_the_unit_of_a_connector_counts_by_every_name(read):
    with pytest.raises(AdcsError, match=r"connector b\.uu has the unit 's', the FMU's variable 'm': correct it"):
        read(elements(component("b", "input uu Float64 s")))


def test_no_name_is_left_unconnected(read):
    found = read(elements(component("a", "output yy"), component("b", "input uu")) + connections("a.yy -> b.uu"))
    assert found.components["b"].start == {}
    found.check()


def test_written_and_read_again(read, tmp_path):
    found = read(elements(component("a", "output yy"), component("b", "input uu")) + connections("a.yy -> b.uu"))
    write_ssp(found, tmp_path / "one.ssp")
    assert read_ssp(tmp_path / "one.ssp").system.connections == found.connections
