"""What SSP says, and what the flat system then is."""

from __future__ import annotations

import zipfile
from math import radians

import pytest
from packages import (
    Variable,
    bindings,
    component,
    connections,
    elements,
    make_fmu,
    mapping,
    note,
    parameters,
    ssd,
    system,
)

from adcs import AdcsError, read_ssp

SENDER = "output y Real m; output far Real km; output angle Real deg; output plain Real; output yes; output n Integer"
RECEIVER = "input u Real m; input angle Real rad; input plain Real; input on Boolean; input n Integer; output z Real m"

THREE = {"resources/a.fmu": "sender3", "resources/b.fmu": "receiver3"}


def read(package, inside, **settings):
    return read_ssp(package(ssd(inside, **settings))).system


def flat(package, *lines, sender=SENDER, receiver=RECEIVER, **settings):
    """A system of a and b with these connections."""
    inside = elements(component("a", sender), component("b", receiver)) + connections(*lines)
    return read(package, inside, **settings)


def wires(built):
    return [(c.source, c.target) for c in built.connections]


def start(package, binding, files=None, *, at="b", connectors="", **settings):
    """Start values of b after a binding at the component or at the root."""
    inside = elements(component("b", connectors, binding if at == "b" else ""))
    text = ssd((binding if at == "root" else "") + inside, **settings)
    return read_ssp(package(text, None, files)).system.components["b"].start


def test_components_and_connections_in_the_order_of_the_document(package):
    built = flat(package, "a.y -> b.u", "a.plain -> b.plain")
    assert list(built.components) == ["a", "b"]
    assert wires(built) == [("a.y", "b.u"), ("a.plain", "b.plain")]
    assert not any(c.given or c.delayed for c in built.connections)


def test_start_and_end_do_not_say_which_way_the_value_flows(package):
    assert wires(flat(package, "b.u -> a.y")) == [("a.y", "b.u")]


def test_inputs_without_value_keep_that_of_the_fmu(package):
    built = flat(package, "a.y -> b.u")
    assert built.components["b"].start == {
        "angle": (0.0,),
        "plain": (0.0,),
        "w": (2.0, 2.0, 2.0),
        "M": (0.0,) * 4,
        "on": (False,),
        "n": (3,),
        "light": (10,),
        "shade": (1,),
    }
    built.check()


class TestUnits:
    def test_are_converted(self, package):
        (connection,) = flat(package, "a.far -> b.u").connections
        assert (connection.factor, connection.offset, connection.given) == (1000.0, 0.0, False)

    def test_are_those_of_the_fmu_where_the_connector_says_nothing(self, package):
        (connection,) = flat(package, "a.angle -> b.angle", sender="output angle", receiver="input angle").connections
        assert connection.factor == pytest.approx(radians(1), rel=1e-15)

    def test_are_not_converted_when_suppressed(self, package):
        (connection,) = flat(package, 'a.far -> b.u | suppressUnitConversion="true"').connections
        assert (connection.factor, connection.offset, connection.given) == (1.0, 0.0, True)

    def test_come_before_a_linear_transformation(self, package):
        line = 'a.far -> b.u | | <ssc:LinearTransformation factor="2" offset="5"/>'
        (connection,) = flat(package, line).connections
        assert (connection.factor, connection.offset, connection.given) == (2000.0, 5.0, True)

    def test_are_replaced_by_a_linear_transformation_when_suppressed(self, package):
        line = 'a.far -> b.u | suppressUnitConversion="1" | <ssc:LinearTransformation factor="2" offset="5"/>'
        (connection,) = flat(package, line).connections
        assert (connection.factor, connection.offset) == (2.0, 5.0)

    def test_of_connectors_count_where_the_fmu_has_none(self, package):
        sender, receiver = "output plain Real deg", "input plain Real rad"
        (connection,) = flat(package, "a.plain -> b.plain", sender=sender, receiver=receiver).connections
        assert connection.factor == pytest.approx(radians(1), rel=1e-15)
        assert connection.given

    def test_may_be_left_to_the_fmus(self, package):
        """Many tools write no definitions, and some an empty name."""
        inside = elements(component("a", "output far Real km; output plain Real"), component("b", "input u Real m"))
        text = ssd(inside.replace("<ssc:Real/>", '<ssc:Real unit=""/>') + connections("a.far -> b.u"), units="")
        (connection,) = read_ssp(package(text)).system.connections
        assert connection.factor == 1000.0


class TestTables:
    def test_of_booleans(self, package):
        table = '<ssc:BooleanMappingTransformation><ssc:MapEntry source="true" target="0"/>'
        line = f"a.yes -> b.on | | {table}</ssc:BooleanMappingTransformation>"
        (connection,) = flat(package, line).connections
        assert connection.mapping == ((1.0, 0.0), (0.0, 0.0))  # what a table does not name stays as it is

    def test_of_integers(self, package):
        table = '<ssc:IntegerMappingTransformation><ssc:MapEntry source="1" target="-4"/>'
        table += '<ssc:MapEntry source="2" target="5"/></ssc:IntegerMappingTransformation>'
        (connection,) = flat(package, f"a.n -> b.n | | {table}").connections
        assert connection.mapping == ((1.0, -4.0), (2.0, 5.0))

    def test_of_enumerations_by_the_names_of_their_items(self, package):
        table = '<ssc:EnumerationMappingTransformation><ssc:MapEntry source="blue" target="go"/>'
        line = f"a.colour -> b.light | | {table}</ssc:EnumerationMappingTransformation>"
        (connection,) = flat(package, line, sender="output colour", receiver="input light").connections
        assert connection.mapping == ((7.0, 20.0),)  # the others are no values of the target, and cannot stay

    def test_of_items_that_both_enumerations_have(self, package):
        table = '<ssc:EnumerationMappingTransformation><ssc:MapEntry source="blue" target="green"/>'
        line = f"a.colour -> b.shade | | {table}</ssc:EnumerationMappingTransformation>"
        (connection,) = flat(package, line, sender="output colour", receiver="input shade").connections
        assert connection.mapping == ((7.0, 2.0), (1.0, 1.0), (2.0, 2.0))

    def test_of_enumerations_that_the_document_does_not_define(self, package):
        built = flat(package, "a.colour -> b.light", sender="output colour Enumeration X", receiver="input light")
        assert wires(built) == [("a.colour", "b.light")]


class TestNestedSystems:
    def test_are_flattened_with_their_names(self, package):
        inner = elements(component("c", RECEIVER, source="resources/b.fmu")) + connections("in -> c.u", "c.z -> out")
        inside = elements(component("a", SENDER), system("s", "input in Real m; output out Real m", inner))
        inside += connections("a.y -> s.in")
        built = read(package, inside)
        assert list(built.components) == ["a", "s/c"]
        assert wires(built) == [("a.y", "s/c.u")]

    def test_values_go_through_systems_at_any_depth(self, package):
        b, c = (component(n, RECEIVER, source="resources/b.fmu") for n in "bc")
        deepest = system("t", "input i; output o", elements(b) + connections("i -> b.u", "b.z -> o"))
        deep = system("s", "input i; output o", elements(deepest) + connections("i -> t.i", "t.o -> o"))
        inside = elements(component("a", SENDER), deep, c) + connections("a.y -> s.i", "s.o -> c.u")
        assert set(wires(read(package, inside))) == {("a.y", "s/t/b.u"), ("s/t/b.z", "c.u")}

    def test_transformations_on_the_way_follow_each_other(self, package):
        """km -> m, then times 2 plus 1; m as it is, then times 3 minus 4."""
        inner = elements(component("c", RECEIVER, source="resources/b.fmu"))
        inner += connections('i -> c.u | | <ssc:LinearTransformation factor="3" offset="-4"/>')
        inside = elements(component("a", SENDER), system("s", "input i Real m", inner))
        inside += connections('a.far -> s.i | | <ssc:LinearTransformation factor="2" offset="1"/>')
        (connection,) = read(package, inside).connections
        assert (connection.factor, connection.offset) == (6000.0, -1.0)

    def test_units_of_systems_connectors_leave_the_value_what_it_is(self, package):
        inner = elements(component("c", RECEIVER, source="resources/b.fmu")) + connections("i -> c.u")
        inside = elements(component("a", SENDER), system("s", "input i Real km", inner)) + connections("a.y -> s.i")
        (connection,) = read(package, inside).connections
        assert (connection.factor, connection.given) == (1.0, False)

    def test_tables_on_the_way_follow_each_other(self, package):
        def table(*pairs):
            entries = "".join(f'<ssc:MapEntry source="{a}" target="{b}"/>' for a, b in pairs)
            return f"<ssc:IntegerMappingTransformation>{entries}</ssc:IntegerMappingTransformation>"

        inner = elements(component("c", RECEIVER, source="resources/b.fmu"))
        inner += connections(f"i -> c.n | | {table((2, 3), (5, 6))}")
        inside = elements(component("a", SENDER), system("s", "input i Integer", inner))
        inside += connections(f"a.n -> s.i | | {table((1, 2), (9, 9))}")
        (connection,) = read(package, inside).connections
        assert dict(connection.mapping) == {1.0: 3.0, 2.0: 3.0, 5.0: 6.0, 9.0: 9.0}

    def test_one_value_goes_to_several(self, package):
        b, c = (component(n, RECEIVER, source="resources/b.fmu") for n in "bc")
        inner = elements(b, c) + connections("i -> b.u", "i -> c.u")
        inside = elements(component("a", SENDER), system("s", "input i", inner)) + connections("a.y -> s.i")
        assert wires(read(package, inside)) == [("a.y", "s/b.u"), ("a.y", "s/c.u")]

    def test_dots_and_slashes_in_names_become_underscores(self, package):
        inside = elements(component("x.a", SENDER, source="resources/a.fmu"))
        assert list(read(package, inside).components) == ["x_a"]


class TestParameters:
    def test_of_all_types(self, package):
        values = {
            "k": 'Real value="2.5"',
            "J[1,1]": 'Real value="1"',
            "J[1,2]": 'Real value="2"',
            "J[2,1]": 'Real value="3"',
            "J[2,2]": 'Real value="4"',
            "seed": 'Integer value="7"',
            "fast": 'Boolean value="true"',
            "label": 'String value="a b &amp; c"',
            "tint": 'Enumeration value="blue"',
        }
        found = start(package, bindings(parameters(values)))
        assert {n: found[n] for n in ("k", "J", "seed", "fast", "label", "tint")} == {
            "k": (2.5,),
            "J": (1.0, 2.0, 3.0, 4.0),
            "seed": (7,),
            "fast": (True,),
            "label": ("a b & c",),
            "tint": (7,),
        }

    def test_keep_every_digit(self, package):
        value = 0.1 + 0.2
        assert start(package, bindings(parameters({"k": f'Real value="{value!r}"'})))["k"] == (value,)

    def test_that_give_some_elements_leave_the_others_as_the_fmu_has_them(self, package):
        assert start(package, bindings(parameters({"w[2]": 'Real value="5"'})))["w"] == (2.0, 5.0, 2.0)

    def test_are_converted_from_their_unit(self, package):
        values = {"turn": 'Real value="180" unit="deg"', "temperature": 'Real value="20" unit="degC"'}
        found = start(package, bindings(parameters(values, ("deg", "degC"))))
        assert found["turn"] == pytest.approx((radians(180),), rel=1e-15)
        assert found["temperature"] == (293.15,)

    def test_whole_numbers_do_for_reals(self, package):
        assert start(package, bindings(parameters({"k": 'Integer value="2"'})))["k"] == (2.0,)

    def test_in_a_file(self, package):
        files = {"resources/my set.ssv": parameters({"k": 'Real value="2.5"'})}
        assert start(package, bindings('source="resources/my%20set.ssv">'), files)["k"] == (2.5,)

    def test_of_systems_have_hierarchical_names(self, package):
        inner = elements(component("c.d", source="resources/b.fmu"))
        inside = bindings(parameters({"s.c.d.k": 'Real value="4"'})) + elements(system("s", "", inner))
        assert read(package, inside).components["s/c_d"].start["k"] == (4.0,)

    def test_with_a_prefix(self, package):
        files = {"resources/x.ssv": parameters({"k": 'Real value="2.5"'})}
        assert start(package, bindings('source="resources/x.ssv" prefix="b.">'), files, at="root")["k"] == (2.5,)

    def test_later_bindings_win(self, package):
        sets = [parameters({"k": f'Real value="{v}"'}) for v in (1, 2, 3)]
        assert start(package, bindings(*sets))["k"] == (3.0,)

    def test_higher_systems_win(self, package):
        low, high = (parameters({n: f'Real value="{v}"'}) for n, v in (("k", 1), ("b.k", 2)))
        inside = bindings(high) + elements(component("b", "", bindings(low)))
        assert read(package, inside).components["b"].start["k"] == (2.0,)

    def test_for_connected_inputs_have_no_effect(self, package):
        inside = elements(
            component("a", SENDER), component("b", RECEIVER, bindings(parameters({"u": 'Real value="9"'})))
        )
        built = read(package, inside + connections("a.y -> b.u"))
        assert "u" not in built.components["b"].start

    def test_for_delayed_inputs_hold_until_the_first_value(self, package):
        inside = elements(
            component("a", SENDER), component("b", RECEIVER, bindings(parameters({"u": 'Real value="9"'})))
        )
        delay = note("Connection", 'delaySteps="2"')
        built = read(package, inside + connections(f"a.y -> b.u | | {delay}"))
        assert built.components["b"].start["u"] == (9.0,)
        assert built.connections[0].delay_steps == 2

    def test_for_a_systems_input_go_on_to_the_components(self, package):
        inner = elements(component("b", RECEIVER)) + connections("i -> b.u")
        inside = bindings(parameters({"i": 'Real value="2" unit="km"'}, ("km",)))
        text = ssd("").replace(
            '<ssd:System name="root">',
            '<ssd:System name="root"><ssd:Connectors><ssd:Connector name="i" kind="input"><ssc:Real unit="km"/>'
            f"</ssd:Connector></ssd:Connectors>{inside}{inner}",
        )
        assert read_ssp(package(text)).system.components["b"].start["u"] == (2000.0,)

    def test_for_a_systems_parameter_go_on_with_transformation(self, package):
        inner = elements(component("b", "parameter k Real; parameter seed Integer"))
        inner += connections('p -> b.k | | <ssc:LinearTransformation factor="10"/>', "q -> b.seed")
        values = parameters({"p": 'Real value="2"', "q": 'Integer value="5"'})
        inside = elements(system("s", "parameter p Real; parameter q Integer", inner, bindings(values)))
        found = read(package, inside).components["s/b"].start
        assert (found["k"], found["seed"]) == ((20.0,), (5,))

    def test_that_one_of_several_users_of_a_file_has_no_use_for(self, package):
        files = {"resources/x.ssv": parameters({"k": 'Real value="2.5"', "bias": 'Real value="3"'})}
        binding = bindings('source="resources/x.ssv">')
        inside = elements(component("a", "", binding), component("b", "", binding))
        built = read_ssp(package(ssd(inside), None, files)).system
        assert built.components["a"].start == {"bias": (3.0,)}
        assert built.components["b"].start["k"] == (2.5,)

    def test_that_nothing_has_a_use_for_can_be_ignored(self, package):
        path = package(ssd(elements(component("b", "", bindings(parameters({"kk": 'Real value="2"'}))))))
        built = read_ssp(path, ignore_unknown_parameters=True).system
        assert "k" not in built.components["b"].start


class TestParameterMappings:
    VALUES = parameters({"gain": 'Real value="2"', "other": 'Real value="3"', "number": 'Integer value="4"'})

    def bound(self, package, *entries, values=None):
        inside = f"><ssd:ParameterValues>{values or self.VALUES}</ssd:ParameterValues>"
        inside += f"<ssd:ParameterMapping>{mapping(*entries)}</ssd:ParameterMapping>"
        return start(package, bindings(inside))

    def test_give_what_they_name_and_nothing_else(self, package):
        found = self.bound(package, "gain -> k")
        assert found["k"] == (2.0,)

    def test_may_give_one_value_to_several(self, package):
        found = self.bound(package, "gain -> k", "gain -> turn")
        assert (found["k"], found["turn"]) == ((2.0,), (2.0,))

    def test_transform(self, package):
        found = self.bound(package, 'gain -> k | | <ssc:LinearTransformation factor="3" offset="1"/>')
        assert found["k"] == (7.0,)

    def test_transform_after_units_and_suppress_these(self, package):
        values = parameters({"x": 'Real value="180" unit="deg"'}, ("deg",))
        linear = '<ssc:LinearTransformation factor="2"/>'
        assert self.bound(package, f"x -> turn | | {linear}", values=values)["turn"] == pytest.approx((radians(360),))
        entry = f'x -> turn | suppressUnitConversion="true" | {linear}'
        assert self.bound(package, entry, values=values)["turn"] == (360.0,)

    def test_map_integers(self, package):
        table = '<ssc:IntegerMappingTransformation><ssc:MapEntry source="4" target="40"/>'
        entry = f"number -> seed | | {table}</ssc:IntegerMappingTransformation>"
        assert self.bound(package, entry)["seed"] == (40,)

    def test_map_items_of_enumerations(self, package):
        definition = '<ssc:Enumeration name="E"><ssc:Item name="lime" value="1"/></ssc:Enumeration>'
        more = f"<ssv:Enumerations>{definition}</ssv:Enumerations>"
        values = parameters({"x": 'Enumeration value="lime" name="E"'}, more=more)
        table = '<ssc:EnumerationMappingTransformation><ssc:MapEntry source="lime" target="green"/>'
        entry = f"x -> tint | | {table}</ssc:EnumerationMappingTransformation>"
        assert self.bound(package, entry, values=values)["tint"] == (2,)

    def test_in_a_file(self, package):
        files = {"resources/x.ssv": self.VALUES, "resources/x.ssm": mapping("p.gain -> k")}
        binding = 'source="resources/x.ssv" prefix="p."><ssd:ParameterMapping source="resources/x.ssm"/>'
        assert start(package, bindings(binding), files)["k"] == (2.0,)


class TestArrays:
    def test_of_fmi_2_are_united(self, package):
        sender = "; ".join(f"output v[{i}] Real rad/s" for i in (1, 2, 3))
        receiver = "; ".join(f"input w[{i}] Real rad/s" for i in (1, 2, 3))
        lines = [f"a.v[{i}] -> b.w[{i}]" for i in (2, 1, 3)]
        assert wires(flat(package, *lines, sender=sender, receiver=receiver)) == [("a.v", "b.w")]

    def test_of_fmi_2_stay_elements_where_they_are_mixed_up_or_some_are_missing(self, package):
        sender = "; ".join(f"output v[{i}] Real rad/s" for i in (1, 2, 3))
        receiver = "; ".join(f"input w[{i}] Real rad/s" for i in (1, 2, 3))
        lines = [f"a.v[{i}] -> b.w[{j}]" for i, j in ((1, 2), (2, 1), (3, 3))]
        expected = [("a.v[1]", "b.w[2]"), ("a.v[2]", "b.w[1]"), ("a.v[3]", "b.w[3]")]
        assert wires(flat(package, *lines, sender=sender, receiver=receiver)) == expected
        built = flat(package, "a.v[1] -> b.w[1]", sender=sender, receiver=receiver)
        assert wires(built) == [("a.v[1]", "b.w[1]")]
        assert built.components["b"].start["w"] == (2.0, 2.0, 2.0)
        built.check()

    def test_of_fmi_2_stay_elements_where_one_is_transformed(self, package):
        sender = "; ".join(f"output v[{i}] Real rad/s" for i in (1, 2, 3))
        receiver = "; ".join(f"input w[{i}] Real rad/s" for i in (1, 2, 3))
        lines = [f"a.v[{i}] -> b.w[{i}]" for i in (1, 2, 3)]
        lines[1] += ' | | <ssc:LinearTransformation factor="-1"/>'
        built = flat(package, *lines, sender=sender, receiver=receiver)
        assert [c.factor for c in built.connections] == [1.0, -1.0, 1.0]

    def of_three(self, package, *lines, sender="output v Float64 rad/s [3]", receiver="input w Float64 rad/s [3]"):
        inside = elements(component("a", sender), component("b", receiver)) + connections(*lines)
        return read_ssp(package(ssd(inside, version="2.0"), THREE)).system

    def test_of_fmi_3_are_one_connector(self, package):
        assert wires(self.of_three(package, "a.v -> b.w")) == [("a.v", "b.w")]

    def test_of_fmi_3_can_be_connected_by_indices(self, package):
        built = self.of_three(
            package,
            'a.v -> b.plain | startIndices="2"',
            'a.plain -> b.M | endIndices="2 1"',
            sender="output v Float64 [3]; output plain",
            receiver="input plain; input M Float64 [2,2]",
        )
        assert wires(built) == [("a.v[2]", "b.plain"), ("a.plain", "b.M[2,1]")]

    def test_go_through_systems_whose_sizes_are_left_open(self, package):
        inner = elements(component("b", "input w")) + connections("i -> b.w")
        inside = elements(component("a", "output v"), system("s", "input i Float64 [?]", inner))
        inside += connections("a.v -> s.i")
        assert wires(read_ssp(package(ssd(inside, version="2.0"), THREE)).system) == [("a.v", "s/b.w")]

    def test_are_put_together_in_a_system(self, package):
        inner = elements(component("b", "input w")) + connections("i -> b.w")
        inside = elements(component("a", "output v; output plain"), system("s", "input i Float64 [3]", inner))
        inside += connections(
            'a.plain -> s.i | endIndices="1"',
            'a.v -> s.i | startIndices="1" endIndices="2"',
            'a.v -> s.i | startIndices="2" endIndices="3"',
        )
        built = read_ssp(package(ssd(inside, version="2.0"), THREE)).system
        assert wires(built) == [("a.plain", "s/b.w[1]"), ("a.v[1]", "s/b.w[2]"), ("a.v[2]", "s/b.w[3]")]

    def test_of_fmi_2_and_3_go_together(self, package):
        sender = "; ".join(f"output v[{i}] Real rad/s" for i in (1, 2, 3))
        inside = elements(component("a", sender), component("b", "input w Float64 rad/s [3]"))
        inside += connections(*(f'a.v[{i}] -> b.w | endIndices="{i}"' for i in (1, 2, 3)))
        parts = {"resources/a.fmu": "sender", "resources/b.fmu": "receiver3"}
        assert wires(read_ssp(package(ssd(inside, version="2.0"), parts)).system) == [("a.v", "b.w")]

    def test_as_parameters(self, package):
        value = '<ssv:Float64 value="1 2 3 4"/><ssc:Dimension size="2"/><ssc:Dimension size="2"/>'
        inside = elements(component("b", "", bindings(parameters({"J": value}, version="2.0"))))
        built = read_ssp(package(ssd(inside, version="2.0"), THREE)).system
        assert built.components["b"].start["J"] == (1.0, 2.0, 3.0, 4.0)

    def test_types_of_ssp_2(self, package):
        values = {"seed": 'Int32 value="5"', "fast": 'Boolean value="1"', "tint": 'Enumeration value="green"'}
        values |= {"label": '<ssv:String><ssv:Value value="x"/></ssv:String>', "k": 'Float64 value="1e-3"'}
        inside = elements(component("b", "", bindings(parameters(values, version="2.0"))))
        found = read_ssp(package(ssd(inside, version="2.0"), THREE)).system.components["b"].start
        assert [found[n] for n in values] == [(5,), (True,), (2,), ("x",), (0.001,)]


class TestExperiment:
    def test_is_none_where_the_file_is_silent(self, package):
        file = read_ssp(package(ssd(elements(component("b")))))
        assert (file.start_time, file.stop_time, file.step, file.version) == (None, None, None, "1.0")

    def test_times_and_our_step(self, package):
        step = note("Experiment", 'step="0.25"')
        more = f'<ssd:DefaultExperiment startTime="1.5" stopTime="9">{step}'
        file = read_ssp(package(ssd(elements(component("b")), more=f"{more}</ssd:DefaultExperiment>")))
        assert (file.start_time, file.stop_time, file.step) == (1.5, 9.0, 0.25)

    @pytest.mark.parametrize(
        "information",
        [
            '<oms:SimulationInformation><oms:FixedStepMaster stepSize="0.5"/></oms:SimulationInformation>',
            '<oms:SimulationInformation name="x" fixedStepSize="0.5"/>',
        ],
    )
    def test_step_of_omsimulator(self, package, information):
        annotation = f'<ssc:Annotation type="org.openmodelica"><oms:Annotations>{information}</oms:Annotations>'
        inside = elements(component("b")) + f"<ssd:Annotations>{annotation}</ssc:Annotation></ssd:Annotations>"
        assert read_ssp(package(ssd(inside))).step == 0.5

    def test_names_and_description(self, package):
        text = ssd(elements(component("b"))).replace('name="root"', 'name="root" description="what it is"')
        built = read_ssp(package(text)).system
        assert (built.name, built.description) == ("test", "what it is")


def test_every_stands_in_an_annotation(package):
    built = read(package, elements(component("b", "", note("Component", 'every="5"'))))
    assert built.components["b"].every == 5


def test_other_structures_in_the_archive(package):
    other = ssd(elements(component("x", source="resources/b.fmu")))
    path = package(ssd(elements(component("b"))), None, {"Variant.ssd": other})
    assert list(read_ssp(path).system.components) == ["b"]
    assert list(read_ssp(path, structure="Variant.ssd").system.components) == ["x"]


def test_structures_to_choose_from_are_those_that_can_be_read(package):
    other = ssd(elements(component("x", source="../resources/b.fmu")))
    files = {"sub/Deep one.ssd": other, "broken.ssd": "<ssd:System"}
    path = package(ssd(elements(component("b"))), None, files)
    assert list(read_ssp(path, structure="sub/Deep one.ssd").system.components) == ["x"]
    for name in ("resources/b.fmu", "x.ssd"):
        with pytest.raises(AdcsError) as error:
            read_ssp(path, structure=name)
        text = str(error.value).partition(": ")[2]
        assert text.startswith(f"it has no system structure '{name}': choose one of ")
        assert set(text.rpartition(" one of ")[2].split(", ")) == {"SystemStructure.ssd", "sub/Deep one.ssd"}


def test_comments_and_instructions_do_no_harm(package):
    text = ssd(
        elements(component("a", SENDER), component("b", RECEIVER, bindings(parameters({"k": 'Real value="2"'}))))
    )
    text = text.replace("</ssd:System>", f"{connections('a.far -> b.u')}</ssd:System>")
    spread = text.replace("><", "><!-- > --><?x y?><")
    assert wires(read_ssp(package(spread)).system) == [("a.far", "b.u")]


def test_aliases_of_fmi_3(tmp_path, fmus):
    variables = [Variable("y", "output", shape=(2,), aliases=("same",)), Variable("u", "input", shape=(2,), start="0")]
    path = tmp_path / "test.ssp"
    inside = elements(component("a", "output same; input u")) + connections("a.same -> a.u")
    with zipfile.ZipFile(path, "w") as zipped:
        zipped.writestr("SystemStructure.ssd", ssd(inside, version="2.0"))
        zipped.write(make_fmu(tmp_path / "a.fmu", variables, "3.0"), "resources/a.fmu")
    assert wires(read_ssp(path).system) == [("a.same", "a.u")]


def test_a_byte_order_mark_does_no_harm(package):
    path = package(b"\xef\xbb\xbf" + ssd(elements(component("b"))).encode())
    assert list(read_ssp(path).system.components) == ["b"]


def test_fmus_are_kept_once_by_their_content(package, own_cache):
    path = package(ssd(elements(component("a"), component("b"))))
    first = read_ssp(path).system
    second = read_ssp(path).system
    sources = {str(c.source) for built in (first, second) for c in built.components.values()}
    assert len(sources) == 2
    assert len(list(own_cache.rglob("*.fmu"))) == 2
    path.unlink()
    assert first.components["b"].open("2.0").ports["u"].unit == "m"


def test_a_damaged_copy_is_replaced(package, own_cache):
    path = package(ssd(elements(component("b"))))
    kept = read_ssp(path).system.components["b"].source
    content = kept.read_bytes()
    kept.write_bytes(b"broken")
    read_ssp(path)
    assert kept.read_bytes() == content
