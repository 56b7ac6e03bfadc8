"""Components that are systems: another `.ssd` of the archive, an `.ssp` inside it, a system of the document."""

from __future__ import annotations

import io
import zipfile

import pytest
from packages import bindings, component, connections, elements, parameters, ssd, system

from adcs import AdcsError, read_ssp

SENDER = component("a", "output y Real m; output far Real km")
PINS = "input i Real m; output o Real m; parameter p Real"
INSIDE = elements(component("b", "input u Real m; output z Real m; parameter k Real")) + connections(
    "i -> b.u", "b.z -> o", "p -> b.k"
)
SUB = ssd("").replace('<ssd:System name="root">', system("inner", PINS, INSIDE)[: -len("</ssd:System>")])
PACKAGE, DEFINITION = "application/x-ssp-package", "application/x-ssp-definition"


def referring(source, kind, more="", pins="input i; output o"):
    sub = component("s", pins, more, source).replace('name="s"', f'name="s" type="{kind}"')
    return ssd(elements(SENDER, sub) + connections("a.far -> s.i"))


def packed(fmus, structures, other="resources/b.fmu"):
    """The content of an `.ssp`."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as zipped:
        for name, text in structures.items():
            zipped.writestr(name, text)
        zipped.writestr(other, fmus["receiver"].read_bytes())
    return buffer.getvalue()


def check(built):
    assert list(built.components) == ["a", "s/b"]
    (connection,) = built.connections
    assert (connection.source, connection.target, connection.factor) == ("a.far", "s/b.u", 1000.0)


def test_a_structure_in_the_same_archive(package):
    path = package(referring("Sub.ssd", DEFINITION), None, {"Sub.ssd": SUB})
    check(read_ssp(path).system)


def test_a_structure_in_a_folder_finds_its_files_there(package):
    files = {"parts/Sub.ssd": SUB.replace("resources/b.fmu", "../resources/b.fmu")}
    check(read_ssp(package(referring("parts/Sub.ssd", DEFINITION), None, files)).system)


@pytest.mark.parametrize("source", ["resources/sub.ssp", "resources/sub.ssp#Variant.ssd"])
def test_a_package_in_the_package(package, fmus, source):
    name = "Variant.ssd" if "#" in source else "SystemStructure.ssd"
    content = packed(fmus, {"SystemStructure.ssd": ssd(""), name: SUB})
    path = package(referring(source, PACKAGE), {"resources/a.fmu": "sender"}, {"resources/sub.ssp": content})
    check(read_ssp(path).system)


def test_a_system_of_the_document_used_twice(package):
    inner = system("s", PINS, INSIDE).replace('name="s"', 'name="s" id="it"')
    again = component("t", "input i", "", "#it").replace('name="t"', f'name="t" type="{DEFINITION}"')
    text = ssd(elements(SENDER, inner, again) + connections("a.y -> s.i", "a.far -> t.i"))
    built = read_ssp(package(text)).system
    assert list(built.components) == ["a", "s/b", "t/b"]
    assert [(c.target, c.factor) for c in built.connections] == [("s/b.u", 1.0), ("t/b.u", 1000.0)]


def test_bindings_of_the_component_win_over_those_of_the_system(package):
    own = bindings(parameters({"p": 'Real value="2"', "b.turn": 'Real value="3"'}))
    sub = SUB.replace("<ssd:Elements>", f"{own}<ssd:Elements>")
    outer = bindings('source="resources/outer.ssv">')
    files = {"Sub.ssd": sub, "resources/outer.ssv": parameters({"b.turn": 'Real value="4"'})}
    found = read_ssp(package(referring("Sub.ssd", DEFINITION, outer), None, files)).system.components["s/b"].start
    assert (found["k"], found["turn"]) == ((2.0,), (4.0,))


def test_files_of_bindings_are_looked_for_where_the_binding_stands(package, fmus):
    own = bindings('source="resources/x.ssv">')
    sub = SUB.replace("<ssd:Elements>", f"{own}<ssd:Elements>")
    buffer = io.BytesIO(packed(fmus, {"SystemStructure.ssd": sub}))
    with zipfile.ZipFile(buffer, "a") as zipped:
        zipped.writestr("resources/x.ssv", parameters({"p": 'Real value="5"'}))
    path = package(referring("s.ssp", PACKAGE), {"resources/a.fmu": "sender"}, {"s.ssp": buffer.getvalue()})
    assert read_ssp(path).system.components["s/b"].start["k"] == (5.0,)


@pytest.mark.parametrize(
    ("source", "kind", "files", "message"),
    [
        ("x.ssd", DEFINITION, {}, "the system of component s is missing: the archive has no file 'x.ssd'"),
        ("#x", DEFINITION, {}, "SystemStructure.ssd has no system with the id 'x'"),
        ("x.ssp", PACKAGE, {"x.ssp": "no zip"}, "x.ssp is not a readable zip archive"),
        ("Sub.ssd", DEFINITION, {"Sub.ssd": ssd("")}, "connector s.i: Sub.ssd has none such of kind input"),
        ("SystemStructure.ssd", DEFINITION, {}, "component s refers to a system in which it is itself"),
        ("../x.ssd", DEFINITION, {}, "only files inside the .ssp are read"),
    ],
)
def test_bad_references_are_refused(package, source, kind, files, message):
    with pytest.raises(AdcsError) as caught:
        read_ssp(package(referring(source, kind), None, files))
    assert message in str(caught.value)


def test_systems_that_double_are_refused(package):
    """Forty files, each of which uses the next one twice."""

    def doubling(i):
        twice = (component(n, "", "", f"S{i + 1}.ssd") for n in "ab")
        return ssd(elements(*(text.replace(" source=", f' type="{DEFINITION}" source=') for text in twice)))

    files = {f"S{i}.ssd": doubling(i) for i in range(1, 40)} | {"S40.ssd": ssd("")}
    with pytest.raises(AdcsError, match="the reference to a system number 1001: refused"):
        read_ssp(package(doubling(0), None, files))


def test_a_system_inside_itself_by_its_id_is_refused(package):
    inner = component("t", "", "", "#it").replace(" source=", f' type="{DEFINITION}" source=')
    text = ssd(elements(system("s", "", elements(inner)).replace('name="s"', 'name="s" id="it"')))
    with pytest.raises(AdcsError, match="refers to a system in which it is itself"):
        read_ssp(package(text))
