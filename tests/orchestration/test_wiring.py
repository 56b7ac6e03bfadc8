"""What a System refuses, and in which words."""

import numpy as np
import pytest

from adcs import AdcsError, System, run


@pytest.fixture
def system(mock) -> System:
    system = System("pair")
    system.add("gain", mock("gain"))
    system.add("integrator", mock("integrator"))
    system.add("oscillator", mock("oscillator"))
    system.add("typed", mock("typed"))
    return system


@pytest.mark.parametrize(
    ("source", "target", "message"),
    [
        ("gian.y", "integrator.u", "'gian.y': system 'pair' has no component 'gian': did you mean gain?"),
        ("gain.z", "integrator.u", "component 'gain' (gain.fmu) has no variable 'z': it has u, k, y, doubled"),
        ("gain", "integrator.u", "component 'gain' (gain.fmu) has no variable '': it has u, k, y, doubled"),
        ("gain.u", "integrator.u", "gain.u is not an output but has causality 'input'"),
        ("gain.y", "integrator.y", "integrator.y is not an input but has causality 'output'"),
        ("gain.y", "oscillator.u", "cannot connect gain.y to oscillator.u: sizes differ, 3 values and a single value"),
        ("gain.doubled", "integrator.u", "units differ, 'm' and 'm/s', and 'm' is not defined"),
        ("typed.flag", "oscillator.u", "typed.flag is not an output but has causality 'parameter'"),
    ],
)
def test_refused_connections(system, source, target, message):
    with pytest.raises(AdcsError) as error:
        system.connect(source, target)
    assert message in str(error.value)
    assert not system.connections


def test_an_input_has_one_source(system, mock):
    system.add("other", mock("gain"))
    system.connect("gain.y", "integrator.u")
    with pytest.raises(AdcsError, match=r"gain\.y is already connected to it, an input has one source"):
        system.connect("other.y", "integrator.u")


def test_a_port_without_unit_goes_with_any(system):
    system.connect("typed.y", "oscillator.u")
    assert [(c.source, c.target) for c in system.connections] == [("typed.y", "oscillator.u")]


@pytest.mark.parametrize(
    ("model", "start", "message"),
    [
        ("gain", {"gain": 1.0}, "component 'new' (gain.fmu) has no variable 'gain': it has u, k, y, doubled"),
        ("gain", {"k": [1.0, 2.0]}, "new.k: expected a single value, got 2 values"),
        ("gain", {"u": 1.0}, "new.u: expected 3 values, got a single value"),
        ("typed", {"matrix": np.ones(6)}, "new.matrix: expected 2 x 3 values, got 6 values"),
        ("typed", {"matrix": [[1, 2], [3]]}, "new.matrix = [[1, 2], [3]]: expected 2 x 3 values"),
        ("gain", {"k": float("nan")}, "new.k = nan is not finite"),
        ("gain", {"k": "much"}, "new.k = 'much': expected a number"),
        ("gain", {"k": None}, "new.k = None: expected a single value"),
        ("gain", {"y": [1, 2, 3]}, "new.y cannot be given a start value: it is a continuous output"),
        ("typed", {"n": 1.5}, "new.n = 1.5: expected an integer"),
        ("typed", {"n": 2**31}, "new.n = 2147483648 is outside the range of Int32"),
        ("typed", {"flag": 2}, "new.flag = 2: expected True or False"),
    ],
)
def test_refused_start_values(system, mock, model, start, message):
    with pytest.raises(AdcsError) as error:
        system.add("new", mock(model), start)
    assert str(error.value) == message
    assert "new" not in system.components


def test_start_value_and_connection_exclude_each_other(system, mock):
    system.add("fed", mock("integrator"), {"u": [1, 2, 3]})
    with pytest.raises(
        AdcsError, match=r"fed\.u has a start value that the connection would override: drop one of them"
    ):
        system.connect("gain.y", "fed.u")
    system.connect("gain.y", "integrator.u")
    with pytest.raises(AdcsError, match=r"integrator\.u is connected to gain\.y: a start value would have no effect"):
        system.set("integrator.u", [1, 2, 3])


def test_component_names(system, mock):
    with pytest.raises(AdcsError, match="system 'pair' already has a component 'gain'"):
        system.add("gain", mock("gain"))
    with pytest.raises(AdcsError, match=r"component name 'a\.b' is not usable"):
        system.add("a.b", mock("gain"))


def test_an_input_must_be_connected_or_given(mock):
    system = System("open")
    system.add("gain", mock("gain"))
    with pytest.raises(AdcsError, match=r"^input gain\.u is not connected: connect it or give it a start value$"):
        run(system, stop_time=1, step=1)
    system.set("gain.u", [1, 2, 3])
    assert run(system, stop_time=1, step=1)["gain.y"].tolist() == [[1, 2, 3], [1, 2, 3]]


def test_an_empty_system():
    with pytest.raises(AdcsError, match="system 'void' has no components: add one"):
        run(System("void"), stop_time=1, step=1)


def test_start_values_of_every_type(mock, version):
    system = System("typed")
    system.add("typed", mock("typed", version), {"n": 3, "flag": True, "matrix": [[1, 2, 3], [4, 5, 6]]})
    assert run(system, stop_time=0, step=1)["typed.y"].tolist() == [3 + 0.5 + 21]
