"""Connectors that are clocks (SSP 2.0): those that tick by themselves stand alone, those of a trigger are connected."""

from __future__ import annotations

import pytest
from packages import Variable, bindings, component, connections, elements, make_fmu, parameters, ssd, system

from adcs import AdcsError, System, read_ssp, run, write_ssp

SLOW = '"constant" intervalDecimal="0.25" shiftDecimal="0.1"'
VARIABLES = [
    Variable("slow", "input", "Clock", interval=SLOW),
    Variable(
        "third", "input", "Clock", interval='"fixed" resolution="3" intervalCounter="1" intervalDecimal="0.3333333"'
    ),
    Variable("asked", "input", "Clock", interval='"fixed"'),
    Variable("varied", "input", "Clock", interval='"tunable"'),
    Variable("alarm", "input", "Clock", interval='"countdown"'),
    Variable("heard", "input", "Clock", interval='"triggered"'),
    Variable("tick", "output", "Clock", interval='"triggered"'),
    Variable("n", "output", "Int32", clock="slow"),
    Variable("yes", "output", "Boolean"),
]


@pytest.fixture(scope="module")
def clocks(tmp_path_factory):
    return make_fmu(tmp_path_factory.mktemp("clocks") / "clocks.fmu", VARIABLES, "3.0")


@pytest.fixture
def read(package, clocks):
    """read(structure) -> system of a and b, which have all kinds of clocks."""

    def make(inside, parts=None):
        parts = parts or {f"resources/{name}.fmu": clocks for name in "ab"}
        return read_ssp(package(ssd(inside, version="2.0"), parts)).system

    return make


def refusal(read, inside):
    with pytest.raises(AdcsError) as error:
        read(inside)
    assert "\n" not in str(error.value)
    return str(error.value)


def pin(kind, name, attributes="", more=""):
    """A connector that is a clock, to take the place of one without type."""
    clock = f"<ssc:Clock {attributes}/>" if attributes is not None else ""
    return f'<ssd:Connector name="{name}" kind="{kind}">{clock}{more}</ssd:Connector>'


def clocked(name, *pins):
    return component(name).replace(
        "</ssd:Component>", f"<ssd:Connectors>{''.join(pins)}</ssd:Connectors></ssd:Component>"
    )


ACCEPTED = {
    "as the FMU has it": pin("input", "slow", f"intervalVariability={SLOW}"),
    "without a word of it": pin("input", "slow"),
    "without a type": pin("input", "slow", None),
    "of any kind": pin("unspecified", "slow"),
    "as fraction": pin(
        "input", "slow", 'intervalVariability="constant" resolution="20" intervalCounter="5" shiftCounter="2"'
    ),
    "as decimal where the FMU has a fraction": pin(
        "input", "third", 'intervalDecimal="0.33333333" supportsFraction="true"'
    ),
    "where only the FMU knows the interval": pin("input", "asked", 'intervalVariability="fixed" intervalDecimal="0.2"'),
    "which has no interval": pin("input", "alarm", 'intervalVariability="countdown" priority="3"'),
    "to be triggered": pin("input", "heard", 'intervalVariability="triggered"'),
    "that triggers": pin("output", "tick", 'intervalVariability="triggered"'),
    "a value that belongs to one": pin("input", "slow")
    + pin("output", "n", None, '<ssc:Int32/><ssd:Clock name="slow"/>'),
}


@pytest.mark.parametrize("case", ACCEPTED)
def test_clocks_that_nothing_is_connected_to(case, read):
    found = read(elements(clocked("a", ACCEPTED[case])))
    assert found.components["a"].start == {"heard": (False,)}
    assert not found.connections


def test_that_a_clock_does_not_tick_may_be_said(read):
    no = bindings(parameters({"heard": 'Boolean value="false"'}, version="2.0"))
    assert read(elements(component("a", "", no))).components["a"].start == {"heard": (False,)}


def two(line, here="slow", there="slow", more=None):
    attributes = {"slow": SLOW, "third": '"fixed"', "asked": '"fixed"', "heard": '"triggered"', "tick": '"triggered"'}

    def pins(name):
        kind = "output" if name == "tick" else "input"
        return pin(kind, name, f"intervalVariability={attributes[name]}" if name in attributes else "")

    return elements(clocked("a", pins(here)), clocked("b", more or pins(there))) + connections(line)


OWN = " is a clock that ticks by its own interval, it triggers nothing and nothing triggers it"
REFUSED = {
    "another kind": (
        elements(clocked("a", pin("input", "slow", 'intervalVariability="fixed"'))),
        "connector a.slow is a clock of kind 'fixed', the FMU's is 'constant': correct it",
    ),
    "a trigger": (
        elements(clocked("a", pin("input", "slow", 'intervalVariability="triggered"'))),
        "connector a.slow is a clock of kind 'triggered', the FMU's is 'constant': correct it",
    ),
    "another interval": (
        elements(clocked("a", pin("input", "slow", 'intervalDecimal="0.5"'))),
        "connector a.slow is a clock whose interval is 0.5 s, that of the FMU's 0.25 s: correct it",
    ),
    "an interval that changes as it runs": (
        elements(clocked("a", pin("input", "varied", 'intervalVariability="tunable" intervalDecimal="0.5"'))),
        "connector a.varied is a clock whose interval is 0.5 s, and the FMU's is tunable, which it says only while it "
        "runs: leave the interval out",
    ),
    "another shift": (
        elements(clocked("a", pin("input", "slow", 'shiftDecimal="0"'))),
        "connector a.slow is a clock whose shift is 0 s, that of the FMU's 0.1 s: correct it",
    ),
    "no resolution": (
        elements(clocked("a", pin("input", "slow", 'resolution="0" intervalCounter="1"'))),
        "connector a.slow is a clock with a resolution of 0: expected a number of parts of a second from 1",
    ),
    "the other direction": (
        elements(clocked("a", pin("output", "slow"))),
        "connector a.slow is of kind 'output', the FMU's variable is of causality 'input': correct it",
    ),
    "a number": (
        elements(component("a", "input slow Float64")),
        "connector a.slow is of type Float64, the FMU's variable is Clock: correct it",
    ),
    "no clock": (
        elements(clocked("a", pin("output", "yes"))),
        "connector a.yes is of type Clock, the FMU's variable is Boolean: correct it",
    ),
    "a value": (
        elements(component("a", "", bindings(parameters({"heard": 'Boolean value="true"'}, version="2.0")))),
        "parameter 'heard': a.heard is a clock, which has no value: connect it, or take the parameter out",
    ),
    "a value of another clock": (
        elements(
            clocked("a", pin("input", "third"), pin("output", "n", None, '<ssc:Int32/><ssd:Clock name="third"/>'))
        ),
        "connector a.n belongs to the clock 'third', the FMU's variable does not: correct it",
    ),
    "a value of an unknown clock": (
        elements(clocked("a", pin("output", "n", None, '<ssc:Int32/><ssd:Clock name="x"/>'))),
        "connector a.n belongs to the clock 'x', the FMU's variable does not: correct it",
    ),
    "different intervals connected": (
        two("a.slow -> b.third", there="third"),
        "connection a.slow -> b.third: both clocks tick by their own intervals, which are not known to be the same "
        "(constant, each 0.25 s from 0.1 s on; fixed, each 0.333333 s): drop the connection",
    ),
    "unknown intervals connected": (
        two("a.asked -> b.asked", "asked", "asked"),
        "both clocks tick by their own intervals, which are not known to be the same (fixed; fixed): drop the connecti",
    ),
    "a trigger from one that ticks by itself": (
        two("a.slow -> b.heard", there="heard"),
        f"connection a.slow -> b.heard: a.slow{OWN}",
    ),
    "one that ticks by itself from a trigger": (
        two("a.tick -> b.slow", "tick"),
        f"connection a.tick -> b.slow: b.slow{OWN}",
    ),
    "a Boolean": (
        two("a.slow -> b.yes", more=pin("output", "yes", None)),
        f"connection a.slow -> b.yes: a.slow{OWN}",
    ),
    "a connector of a system without a word": (
        elements(
            system("s", "input all", elements(clocked("a", pin("input", "slow"))) + connections("all -> a.slow")),
        ),
        f"connection all -> a.slow in s: s/a.slow{OWN}",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case, read):
    inside, expected = REFUSED[case]
    assert expected in refusal(read, inside)


def test_clocks_of_the_same_interval_may_be_connected_for_they_tick_together_anyway(read):
    found = read(two("a.slow -> b.slow"))
    assert list(found.components) == ["a", "b"]
    assert not found.connections


def test_so_may_they_through_a_system(read):
    own = f"<ssd:Connectors>{pin('input', 'all', f'intervalVariability={SLOW}')}</ssd:Connectors>"
    inside = elements(clocked("a", pin("input", "slow")), clocked("b", pin("input", "slow")))
    text = system("s", "", inside + connections("all -> a.slow", "all -> b.slow")).replace(
        'name="s">', f'name="s">{own}'
    )
    assert list(read(elements(text)).components) == ["s/a", "s/b"]


@pytest.mark.parametrize("kind", ["Clock", "Boolean"])
def test_an_output_clock_triggers_another_component(kind, package, foreign):
    """The clock of the first ticks each 0.1 s; each third tick triggers the second, which counts."""
    counter = clocked("a", pin("input", "tick", 'intervalVariability="constant" intervalDecimal="0.1"'))
    counter = counter.replace(
        "</ssd:Connectors>", f"{pin('output', 'every_third', None, f'<ssc:{kind}/>')}</ssd:Connectors>"
    )
    listener = component("b", f"input heard {kind}", bindings(parameters({"u": 'Float64 value="1"'}, version="2.0")))
    text = ssd(elements(counter, listener) + connections("a.every_third -> b.heard"), version="2.0")
    parts = {"resources/a.fmu": foreign("counter"), "resources/b.fmu": foreign("listener")}
    found = read_ssp(package(text, parts)).system
    result = run(found, stop_time=1.0, step=0.1)
    assert result["a.count"].tolist() == list(range(1, 12))
    assert result["b.times"].tolist() == [(k + 1) // 3 for k in range(11)]


def test_clocks_come_back(foreign, tmp_path):
    made = System("clocks")
    made.add("a", foreign("counter"))
    made.add("b", foreign("listener"), {"u": 1.0})
    made.add("alone", foreign("listener"), {"u": 2.0, "heard": False})
    made.connect("a.every_third", "b.heard")
    write_ssp(made, tmp_path / "one.ssp", step=0.1)
    file = read_ssp(tmp_path / "one.ssp")
    assert file.system.connections == made.connections
    assert file.system.components["alone"].start == {"u": (2.0,), "heard": (False,)}
    write_ssp(file.system, tmp_path / "two.ssp", step=0.1)
    assert (tmp_path / "two.ssp").read_bytes() == (tmp_path / "one.ssp").read_bytes()
    ours, theirs = (run(s, stop_time=1.0, step=0.1) for s in (made, file.system))
    assert (ours.data == theirs.data).all()
    assert theirs["b.times"][-1] == 3
    assert theirs["alone.times"][-1] == 0
