"""Components that communicate at every n-th step, connections that take time, converted values, single elements."""

import numpy as np
import pytest

from adcs import AdcsError, CoSimulation, LoopSolver, ModelExchange, Save, System, run

STEPPINGS = ["compiled", "python"]


@pytest.fixture
def pair(mock):
    """source -> gain, y = offset + t."""

    def build(version="2.0", every=1, **connection):
        system = System("pair")
        system.add("source", mock("source", version), {"offset": [1.0, 2.0, 3.0]})
        system.add("gain", mock("gain", version), {"k": 2.0}, every=every)
        system.connect("source.y", "gain.u", **connection)
        return system

    return build


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_slow_component_sees_and_shows_values_of_its_own_points_only(pair, version, stepping):
    result = run(
        pair(version, every=3), stop_time=2, step=0.25, method=CoSimulation(stepping=stepping), fmi_version=version
    )
    expected = 2 * (1 + 0.25 * np.array([0, 0, 0, 3, 3, 3, 6, 6, 6]))
    assert np.array_equal(result["gain.y"][:, 0], expected)
    assert np.array_equal(result["source.y"][:, 0], 1 + result.time)


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_slow_integrator_takes_long_steps_and_its_state_is_seen_at_their_end(mock, version, stepping):
    system = System("slow")
    system.add("source", mock("source", version), {"offset": [1.0, 0.0, 0.0]})
    system.add("integrator", mock("integrator", version), every=4)
    system.connect("source.y", "integrator.u", factor=1.0)
    result = run(system, stop_time=2.5, step=0.25, method=CoSimulation(stepping=stepping), fmi_version=version)
    # x(1) = x(0) + 1 s * u(0), x(2) = x(1) + 1 s * u(1), where u = 1 + t; held in between
    assert result["integrator.y"][:, 0].tolist() == [0, 0, 0, 0, 1, 1, 1, 1, 3, 3, 3]


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("connection", [{"delay_steps": 3}, {"delay": 0.75}])
def test_a_delayed_value_arrives_later_and_the_start_value_until_then(pair, version, stepping, connection):
    system = pair(version, **connection)
    system.set("gain.u", [7.0, 8.0, 9.0])
    result = run(system, stop_time=2, step=0.25, method=CoSimulation(stepping=stepping), fmi_version=version)
    for i, start in enumerate((7.0, 8.0, 9.0)):
        expected = [2 * start] * 3 + [2 * (1 + i + 0.25 * (k - 3)) for k in range(3, 9)]
        assert result["gain.y"][:, i].tolist() == expected


def test_a_delayed_connection_of_a_slow_component_counts_exchange_steps(pair):
    result = run(pair(every=2, delay_steps=1), stop_time=2, step=0.25)
    expected = [0.0, 0.0, *(2 * (1 + 0.25 * (k - k % 2 - 1)) for k in range(2, 9))]
    assert result["gain.y"][:, 0].tolist() == expected


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_delay_makes_a_sequence_of_an_algebraic_loop(mock, version, stepping):
    system = System("doubling")
    system.add("gain", mock("gain", version))
    system.connect("gain.doubled", "gain.u", delay_steps=1)
    system.set("gain.u", [1.0, 2.0, -1.0])
    result = run(system, stop_time=5, step=1, method=CoSimulation(stepping=stepping), fmi_version=version)
    assert np.array_equal(result["gain.doubled"], 2.0 ** np.arange(1, 7)[:, None] * [1.0, 2.0, -1.0])


def test_a_delay_that_is_no_whole_number_of_steps_is_refused(pair):
    with pytest.raises(AdcsError) as error:
        run(pair(delay=0.3), stop_time=1, step=0.25)
    assert str(error.value) == (
        "the delay of gain.u, 0.3 s, is not a whole number of exchange steps of 0.25 s: use 0.25 or 0.5 s, or another "
        "step"
    )


def test_a_delay_of_less_than_a_step_may_be_left_out(pair):
    with pytest.raises(AdcsError, match=r"exchange steps of 0.25 s: use 0 or 0.25 s, or another step$"):
        run(pair(delay=0.1), stop_time=1, step=0.25)


def test_a_connection_can_be_delayed_afterwards(pair):
    system = pair()
    system.delay("gain.u", steps=3)
    assert [(c.source, c.target, c.delay_steps) for c in system.connections] == [("source.y", "gain.u", 3)]
    with pytest.raises(AdcsError, match=r"^nothing is connected to gain\.k$"):
        system.delay("gain.k", steps=1)


def test_delays_are_refused_in_coupled_model_exchange(pair):
    with pytest.raises(AdcsError, match=r"^gain\.u gets source\.y with a delay, which coupled Model Exchange does not"):
        run(pair(delay_steps=1), stop_time=1, step=0.25, method=ModelExchange())


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_factor_and_offset(pair, version, stepping):
    result = run(
        pair(version, factor=0.1, offset=-3.0),
        stop_time=2,
        step=0.25,
        method=CoSimulation(stepping=stepping),
        fmi_version=version,
    )
    assert np.array_equal(result["gain.y"], 2.0 * (0.1 * result["source.y"] + -3.0))


def test_an_initial_value_before_a_delay_with_a_factor_is_that_of_the_input(pair):
    system = pair(factor=4.0, offset=1.0, delay_steps=1)
    system.set("gain.u", [9.0, 0.0, 0.0])
    assert run(system, stop_time=1, step=1)["gain.y"].tolist() == [[18.0, 0.0, 0.0], [10.0, 18.0, 26.0]]


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_single_elements(mock, version, stepping):
    system = System("elements")
    system.add("source", mock("source", version), {"offset": [1.0, 2.0, 3.0]})
    system.add("oscillator", mock("oscillator", version))
    system.add("gain", mock("gain", version), {"u": [0.0, 5.0, 0.0], "k": 3.0})
    system.connect("source.y[3]", "oscillator.u")
    system.connect("source.y[2]", "gain.u[1]")
    system.connect("source.y[1]", "gain.u[ 3 ]")
    result = run(
        system,
        stop_time=1,
        step=0.5,
        method=CoSimulation(stepping=stepping),
        fmi_version=version,
        save=Save(["gain.u", "gain.y"]),
    )
    assert result["gain.u"].tolist() == [[2.0, 5.0, 1.0], [2.5, 5.0, 1.5], [3.0, 5.0, 2.0]]
    assert np.array_equal(result["gain.y"], 3 * result["gain.u"])


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_crosswise_elements_are_no_loop_where_elements_have_dependencies_of_their_own(mock, stepping):
    # in FMI 2 y[1] depends on u[1] alone; as arrays the two would make a loop
    system = System("crosswise")
    system.add("gain", mock("gain"), {"k": 2.0, "u": [1.0, 0.0, 0.0]})
    system.connect("gain.y[1]", "gain.u[2]", factor=1.0)
    system.connect("gain.y[2]", "gain.u[3]", factor=1.0)
    assert (
        run(system, stop_time=1, step=1, method=CoSimulation(stepping=stepping))["gain.y"].tolist()
        == [[2.0, 4.0, 8.0]] * 2
    )


@pytest.mark.parametrize(
    ("source", "target", "more", "message"),
    [
        ("source.y[4]", "oscillator.u", {}, "source.y[4] does not exist: source.y has 3 values, counted from 1"),
        ("source.y[0]", "oscillator.u", {}, "source.y[0] does not exist: source.y has 3 values, counted from 1"),
        ("source.y", "oscillator.u", {}, "sizes differ, 3 values and a single value"),
        ("source.y[1]", "gain.u[2]", {}, "source.y is already connected to it, an input has one source"),
        ("source.y[1]", "oscillator.u", {"factor": 0.0}, "factor = 0.0, offset = None: expected finite numbers"),
        ("source.y[1]", "oscillator.u", {"offset": float("inf")}, "offset = inf: expected finite numbers"),
        ("source.y[1]", "oscillator.u", {"delay_steps": -1}, "delay_steps = -1, delay = 0.0 s: expected a whole"),
        ("source.y[1]", "oscillator.u", {"delay_steps": 1, "delay": 1.0}, "a delay in steps and one in seconds"),
        ("source.y[1]", "oscillator.u", {"factor": 1, "mapping": [(0, 1)]}, "a mapping as well as a factor"),
    ],
)
def test_refused_connections(mock, source, target, more, message):
    system = System("refused")
    system.add("source", mock("source"))
    system.add("gain", mock("gain"))
    system.add("oscillator", mock("oscillator"))
    system.connect("source.y", "gain.u", factor=1)
    with pytest.raises(AdcsError) as error:
        system.connect(source, target, **more)
    assert message in str(error.value)


def test_a_partly_connected_input_needs_values_for_the_rest(mock):
    system = System("partly")
    system.add("source", mock("source"))
    system.add("gain", mock("gain"))
    system.connect("source.y[1]", "gain.u[1]")
    with pytest.raises(AdcsError) as error:
        run(system, stop_time=1, step=1)
    assert str(error.value) == "input gain.u[2] is not connected: connect it or give gain.u a start value"


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_mapping_says_what_arrives_for_each_value(mock, version, stepping):
    def system(n):
        made = System("mapping")
        made.add("typed", mock("typed", version), {"n": n})
        made.add("oscillator", mock("oscillator", version))
        made.connect("typed.whole", "oscillator.u", mapping=[(0, 2.5), (4, -1.0)])
        return made

    record = ["typed.whole", "oscillator.u"]
    for n, arrives in ((0, 2.5), (4, -1.0)):
        result = run(
            system(n),
            stop_time=1,
            step=1,
            method=CoSimulation(stepping=stepping),
            fmi_version=version,
            save=Save(record),
        )
        assert result["typed.whole"].dtype == np.int64
        assert result["typed.whole"].tolist() == [n, n]
        assert result["oscillator.u"].tolist() == [arrives, arrives]
    with pytest.raises(
        AdcsError, match=r"u gets a value for which its connection has no mapping, it comes from typed.whole$"
    ):
        run(system(3), stop_time=1, step=1, method=CoSimulation(stepping=stepping), fmi_version=version)


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_fraction_does_not_fit_an_integer(mock, version, stepping, tmp_path):
    system = System("fraction")
    system.add("types", mock("typed", version))
    with pytest.raises(AdcsError, match="the mapping leads from 8 to nan, which is no Float64"):
        system.add("oscillator", mock("oscillator", version))
        system.connect("types.whole", "oscillator.u", mapping=[(8, float("nan"))])


def test_a_loop_of_components_with_different_rates_is_refused(mock):
    system = System("rates")
    system.add("a", mock("gain"), every=4)
    system.add("b", mock("gain"))
    system.connect("b.y", "a.u", factor=0.25)
    system.connect("a.y", "b.u", factor=0.25)
    with pytest.raises(AdcsError, match="are in one algebraic loop, but communicate at every"):
        run(system, stop_time=1, step=0.25, method=CoSimulation(loops=LoopSolver()))


def test_rates_are_refused_in_coupled_model_exchange(pair):
    with pytest.raises(AdcsError, match=r"^gain communicates at some exchange steps only \(every = 3\)"):
        run(pair(every=3), stop_time=3, step=0.25, method=ModelExchange())


def test_a_refused_delay_leaves_the_connection(pair):
    system = pair()
    before = system.connections
    with pytest.raises(AdcsError):
        system.delay("gain.u", steps=-1)
    assert system.connections == before


@pytest.mark.parametrize("every", [0, -1, 1.5])
def test_every_counts_steps(mock, every):
    with pytest.raises(AdcsError, match=r"expected a whole number of exchange steps from 1$"):
        System("bad").add("gain", mock("gain"), every=every)
