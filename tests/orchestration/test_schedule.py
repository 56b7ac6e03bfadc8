"""The order of calls: nothing is fetched before what it depends on was set, in as few calls as possible."""

from time import process_time

import pytest

from adcs import AdcsError
from orchestration.plan.schedule import Name, schedule, split


def order(connections: dict[str, str], depends: dict[str, list[str]], record: list[str] = []) -> list[str]:  # noqa: B006
    """Schedule source -> target; return `set c.a,b` and `get c.a,b`."""
    operations = schedule(
        {split(target): [split(source)] for source, target in connections.items()},
        lambda name: depends.get(".".join(name), []),
        [split(name) for name in record],
    )
    return [f"{o.kind} {o.component}.{','.join(o.variables)}" for o in operations]


def test_a_chain_is_followed_from_its_source():
    assert order({"b.y": "c.u", "a.y": "b.u"}, {"b.y": ["u"]}) == ["get a.y", "set b.u", "get b.y", "set c.u"]


def test_a_loop_through_a_state_is_no_algebraic_loop():
    calls = order({"plant.q": "controller.q", "controller.torque": "plant.torque"}, {"controller.torque": ["q"]})
    assert calls == ["get plant.q", "set controller.q", "get controller.torque", "set plant.torque"]


def test_an_algebraic_loop_is_named():
    with pytest.raises(AdcsError) as error:
        order({"a.y": "b.u", "b.y": "c.u", "c.y": "a.u", "x.y": "a.v"}, {f"{c}.y": ["u"] for c in "abc"})
    message = str(error.value)
    assert message.startswith("algebraic loop: ")
    path = message.removeprefix("algebraic loop: ").partition(";")[0].split(" -> ")
    assert path[0] == path[-1]
    following = {"a.y": "b.u", "b.u": "b.y", "b.y": "c.u", "c.u": "c.y", "c.y": "a.u", "a.u": "a.y"}
    assert [following[name] for name in path[:-1]] == path[1:]


def test_one_call_gets_all_that_is_ready():
    calls = order({"a.p": "b.p", "a.q": "b.q"}, {"b.y": ["p", "q"]}, ["a.extra", "b.y"])
    assert calls == ["get a.p,q,extra", "set b.p,q", "get b.y"]


def test_a_component_can_wait_until_all_its_inputs_are_there():
    # the controller is served once, although c.a alone would be ready earlier
    calls = order(
        {"plant.q": "c.q", "guide.r": "c.r", "sensor.m": "c.m", "plant.w": "sensor.w", "c.y": "plant.u"},
        {"c.y": ["q", "r", "m"], "sensor.m": ["w"]},
    )
    assert calls == [
        "get guide.r",
        "get plant.q,w",
        "set sensor.w",
        "get sensor.m",
        "set c.q,r,m",
        "get c.y",
        "set plant.u",
    ]


def test_outputs_that_depend_on_each_other_crosswise_take_two_calls():
    calls = order({"a.p": "b.p", "b.p": "a.u", "a.y": "b.v"}, {"b.p": ["p"], "a.y": ["u"]})
    assert calls == ["get a.p", "set b.p", "get b.p", "set a.u", "get a.y", "set b.v"]


def test_recorded_outputs_come_after_their_inputs():
    calls = order({"a.y": "b.u", "b.state": "c.u"}, {"b.through": ["u"]}, ["b.through"])
    assert calls.index("get b.through") > calls.index("set b.u")


def test_a_component_that_feeds_nothing_is_read_before_it_is_set():
    assert order({"a.y": "b.u"}, {}, ["b.x", "a.y"]) == ["get a.y", "get b.x", "set b.u"]


def test_reading_first_takes_no_further_call():
    assert order({"a.y": "b.u"}, {"b.through": ["u"]}, ["b.x", "b.through"]) == [
        "get a.y",
        "set b.u",
        "get b.x,through",
    ]


def test_one_output_feeds_several_inputs():
    assert order({"a.y": "b.u"}, {}) == ["get a.y", "set b.u"]
    operations = schedule({("b", "u"): [("a", "y")], ("c", "u"): [("a", "y")]}, lambda name: [])
    assert [(o.kind, o.component) for o in operations] == [("get", "a"), ("set", "b"), ("set", "c")]


def test_an_array_put_together_from_several_outputs_waits_for_all_of_them():
    sources = {("c", "u"): [("a", "y"), ("b", "y")], ("b", "v"): [("a", "y")]}
    operations = schedule(sources, lambda name: ["v"] if name == ("b", "y") else [])
    assert [(o.kind, o.component) for o in operations] == [
        ("get", "a"),
        ("set", "b"),
        ("get", "b"),
        ("set", "c"),
    ]


def test_a_loop_to_be_solved_comes_after_what_it_needs_and_before_what_needs_it():
    through: dict[Name, list[str]] = {("a", "y"): ["u", "r"], ("b", "y"): ["u"], ("d", "y"): ["u"]}
    sources = {
        ("a", "u"): [("b", "y")],
        ("b", "u"): [("a", "y")],
        ("a", "r"): [("guide", "r")],
        ("d", "u"): [("b", "y")],
        ("e", "u"): [("d", "y")],
    }
    operations = schedule(sources, lambda name: through.get(name, []), solve_loops=True)
    kinds = [(o.kind, o.component, o.variables) for o in operations]
    assert kinds == [
        ("get", "guide", ("r",)),
        ("set", "a", ("r",)),
        ("solve", "", ()),
        ("set", "d", ("u",)),
        ("get", "d", ("y",)),
        ("set", "e", ("u",)),
    ]
    inside = [(o.kind, o.component, o.variables) for o in operations[2].inside]
    assert inside == [("set", "b", ("u",)), ("set", "a", ("u",)), ("get", "b", ("y",)), ("get", "a", ("y",))]


def test_the_time_to_schedule_a_long_ring_grows_with_its_length():
    def seconds(n: int) -> float:
        ring: dict[Name, list[Name]] = {(f"c{i}", "u"): [(f"c{(i + 1) % n}", "y")] for i in range(n)}
        began = process_time()
        operations = schedule(ring, lambda name: [] if name == ("c0", "y") else ["u"])
        assert len(operations) == 2 * n
        return process_time() - began

    seconds(1000)
    assert min(seconds(8000) for _ in range(3)) < 20 * min(seconds(1000) for _ in range(3))
