"""The order of calls: nothing is fetched before what it depends on was set, in as few calls as possible."""

import pytest

from fmus.errors import AdcsError
from orchestration.schedule import schedule
from orchestration.system import Connection


def order(connections: dict[str, str], depends: dict[str, list[str]], record: list[str] = []) -> list[str]:  # noqa: B006
    """Schedule source -> target; return `set c.a,b` and `get c.a,b`."""
    operations = schedule(
        [Connection(*pair) for pair in connections.items()],
        lambda name: depends.get(".".join(name), []),
        [tuple(name.split(".")) for name in record],  # type: ignore[misc]
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
        "get plant.q,w",
        "get guide.r",
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


def test_one_output_feeds_several_inputs():
    assert order({"a.y": "b.u"}, {}) == ["get a.y", "set b.u"]
    operations = schedule([Connection("a.y", "b.u"), Connection("a.y", "c.u")], lambda name: [])
    assert [(o.kind, o.component) for o in operations] == [("get", "a"), ("set", "b"), ("set", "c")]
