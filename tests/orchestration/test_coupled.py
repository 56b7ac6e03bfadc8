"""Coupled Model Exchange against exact solutions, and its time events."""

import numpy as np
import pytest

from adcs import AdcsError, CoupledModel, Hook, LoopSolver, ModelExchange, RunFailed, Save, System, run

SOLVERS = {"DOP853": 1e-13, "CVode": 1e-7}
ME = ModelExchange()


@pytest.fixture
def springs(mock):
    """Two oscillators coupled to x1'' = x2 - x1, x2'' = x1 - x2: x1 + x2 drifts, x1 - x2 swings."""

    def build(version: str = "2.0") -> System:
        system = System("springs")
        system.add("a", mock("oscillator", version), {"a": 1.0, "b": 0.0})
        system.add("b", mock("oscillator", version), {"a": 0.5, "b": -0.25})
        system.connect("a.position", "b.u")
        system.connect("b.position", "a.u")
        return system

    return build


def exact(t):
    """The sum of the positions has acceleration 0, their difference d has d'' = -2 d."""
    sum_ = 1.5 - 0.25 * t
    w = np.sqrt(2)
    difference = 0.5 * np.cos(w * t) + 0.25 / w * np.sin(w * t)
    return (sum_ + difference) / 2, (sum_ - difference) / 2


@pytest.mark.parametrize("solver", SOLVERS)
def test_against_the_exact_solution(springs, version, solver):
    # rows between the ends of steps are of an order less than these
    method = ModelExchange(solver, rtol=1e-13 if solver == "DOP853" else 1e-12)
    result = run(springs(version), stop_time=10, step=0.5, method=method)
    first, second = exact(result.time)
    tolerance = 1e-12 if solver == "DOP853" else 1e-8
    assert result["a.position"] == pytest.approx(first, abs=tolerance)
    assert result["b.position"] == pytest.approx(second, abs=tolerance)
    assert result.state_names == ["a.a", "a.b", "b.a", "b.b"]
    assert np.array_equal(result.states[:, 0], result["a.position"])
    assert result.manifest["settings"]["solver"] == solver


@pytest.mark.parametrize("solver", SOLVERS)
def test_rows_do_not_make_steps_shorter(springs, solver):
    method = ModelExchange(solver, rtol=1e-6, max_step=10)
    fine, coarse = (run(springs(), stop_time=10, step=step, method=method) for step in (0.01, 0.5))
    assert fine.manifest["integrator"]["steps"] == coarse.manifest["integrator"]["steps"] < 200
    assert np.array_equal(fine.data[::50], coarse.data)
    assert fine["a.position"] == pytest.approx(exact(fine.time)[0], abs=1e-4)


def test_rows_are_the_same_in_whatever_pieces_they_are_taken(springs):
    whole = run(springs(), stop_time=10, step=0.01, method=ME)

    class Piecewise(Hook):
        def ahead(self, k):
            return 1 + k % 7

    assert whole == run(springs(), stop_time=10, step=0.01, method=ME, hooks=[Piecewise()])


def test_both_versions_agree_to_the_last_bit(springs):
    two, three = (run(springs(v), stop_time=5, step=0.1, method=ME) for v in ("2.0", "3.0"))
    assert np.array_equal(two.data, three.data)


def test_co_simulation_converges_with_first_order(springs):
    truth = run(springs(), stop_time=2, step=0.1, method=ME)["a.position"]
    errors = []
    for step in (0.02, 0.01, 0.005):
        result = run(springs(), stop_time=2, step=step)
        errors.append(np.abs(result["a.position"][:: round(0.1 / step)] - truth).max())
    assert errors[0] / errors[1] == pytest.approx(2, abs=0.05)
    assert errors[1] / errors[2] == pytest.approx(2, abs=0.05)


def test_a_chain_of_feedthrough(chain, version):
    result = run(chain(version), stop_time=1, step=0.25, method=ME)
    t = result.time
    assert result["gain.y"][:, 0] == pytest.approx(2 * (1 + t), abs=1e-14)
    assert result["integrator.y"][:, 2] == pytest.approx(10 + 2 * (3 * t + t**2 / 2), abs=1e-14)


def test_rhs_and_outputs(chain, version):
    with CoupledModel(chain(version), start_time=0.5) as model:
        assert model.state_names == ["integrator.x[1]", "integrator.x[2]", "integrator.x[3]"]
        assert model.x0.tolist() == [0.0, 0.0, 10.0]
        assert model.rhs(0.5, model.x0).tolist() == [3.0, 5.0, 7.0]
        assert model.rhs(2.0, np.zeros(3)).tolist() == [6.0, 8.0, 10.0]
        outputs = model.outputs(1.0, np.array([7.0, 8.0, 9.0]))
        assert outputs["integrator.y"].tolist() == [7.0, 8.0, 9.0]
        assert outputs["gain.doubled"].tolist() == [4.0, 6.0, 8.0]
        assert model.next_event == np.inf


def test_a_row_takes_the_calls_only_that_something_in_it_needs(chain):
    """The same values, whatever else is recorded; of the source alone neither of the others is asked."""
    whole = run(chain("2.0"), stop_time=1, step=0.25, method=ME)
    for name in ("source.y", "gain.doubled", "integrator.y"):
        with CoupledModel(chain("2.0"), record=[name]) as model:
            row = model._outputs._plan.calls
            asked = {call.component for call in row}
            assert asked == ({"source", "gain"} if name == "gain.doubled" else {name.partition(".")[0]})
        alone = run(chain("2.0"), stop_time=1, step=0.25, method=ME, save=Save([name]))
        assert np.array_equal(alone[name], whole[name])


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("period", [0.5, 0.3, 0.1, 1 / 3])
def test_time_events(mock, version, solver, period):
    """count steps at multiples of the period, whether or not these are on the grid; x' = count."""
    system = System("ticker")
    system.add("ticker", mock("ticker", version), {"period": period})
    system.add("other", mock("oscillator", version), {"u": 0.0})
    result = run(system, stop_time=2, step=0.1, method=ModelExchange(solver))
    count = np.floor(result.time / period + 1e-6)
    assert result["ticker.count"].tolist() == count.tolist()  # the row at an event holds the value after it
    area = [sum(t - k * period for k in range(1, int(n) + 1)) for t, n in zip(result.time, count, strict=True)]
    assert result["ticker.area"] == pytest.approx(area, abs=1e-13 if solver == "DOP853" else 1e-8)
    assert result["other.position"] == pytest.approx(np.cos(result.time), abs=1e-8)


def test_a_system_without_states(mock, version):
    system = System("source")
    system.add("source", mock("source", version))
    result = run(system, stop_time=1, step=0.25, method=ME)
    assert result["source.y"][:, 0].tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert result.states.shape == (5, 0)


def test_an_element_is_connected_and_the_others_keep_their_start_values(mock, version):
    system = System("parts")
    system.add("swing", mock("oscillator", version), {"u": 0.0})
    system.add("integrator", mock("integrator", version), {"u": [1.0, 2.0, 3.0]})
    system.connect("swing.position", "integrator.u[2]", factor=2.0)
    result = run(system, stop_time=2, step=0.5, method=ME)
    t = result.time
    assert result["integrator.y"] == pytest.approx(np.array([t, 2 * np.sin(t), 3 * t]).T, abs=1e-10)


def test_an_algebraic_loop_is_solved_at_every_evaluation(mock, version):
    """y = 0.5 (0.3 y + 1), integrated."""
    system = System("loop")
    for name, k in (("one", 0.5), ("two", 0.3)):
        system.add(name, mock("gain", version), {"k": k})
    system.add("integrator", mock("integrator", version))
    system.connect("one.y", "two.u", factor=1.0)
    system.connect("two.y", "one.u", factor=1.0, offset=1.0)
    system.connect("one.y", "integrator.u")
    with pytest.raises(AdcsError, match="algebraic loop"):
        CoupledModel(system)
    with CoupledModel(system, loops=LoopSolver()) as model:
        assert model.rhs(0.0, model.x0) == pytest.approx(np.full(3, 0.5 / 0.85), rel=1e-9)
        assert model.outputs(0.0, model.x0)["two.y"] == pytest.approx(np.full(3, 0.15 / 0.85), rel=1e-9)
        assert model.loop_reports[0]["solved"] > 0


def test_delays_are_refused_by_name(springs):
    system = springs()
    system.delay("b.u", steps=1)
    with pytest.raises(
        AdcsError, match=r"^b\.u gets a\.position with a delay, which coupled Model Exchange does not sup"
    ):
        CoupledModel(system)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(
    ("mode", "message"),
    [
        (2, "the derivative of x is not finite|y is not finite"),
        (5, "getting y|getDerivatives returned error: nothing to get"),
    ],
)
def test_a_failing_component_stops_the_run(faulty, version, solver, mode, message):
    with pytest.raises(RunFailed, match=message) as error:
        run(faulty(version, mode, at=0.6), stop_time=1, step=0.25, method=ModelExchange(solver))
    result = error.value.result
    # steps are tried again, shorter, after values that are not finite, and not after an error
    rows = 3 if mode == 2 else 2
    assert result.time.tolist() == [0.0, 0.25, 0.5][:rows]
    assert result["wheel.y"].tolist() == [1.0, 1.0, 1.0][:rows]
    outcome = result.manifest["outcome"]
    assert (outcome["status"], outcome["component"], outcome["rows"]) == ("failed", "wheel", rows)
    assert outcome["time"] >= 0.6


def test_a_component_may_ask_to_end(faulty, version):
    result = run(faulty(version, 6, at=0.0), stop_time=1, step=0.25, method=ME)
    assert result.time.tolist() == [0.0]
    ended = {"component": "wheel", "time": 0.0, "message": "it gave no reason"}
    assert result.manifest["outcome"] == {"status": "complete", "ended": ended, "rows": 1}


def test_an_event_that_does_not_move_on(mock):
    system = System("stuck")
    system.add("ticker", mock("ticker"), {"period": 1e-20})
    with pytest.raises(
        RunFailed, match=r"ticker failed at t = 1000000 s: its next event, at t = 1000000\.0 s, does not lie"
    ):
        run(system, start_time=1e6, stop_time=1e6 + 1, step=0.5, method=ME)


def test_a_diverging_state_ends_with_its_time(mock):
    system = System("diverging")
    system.add("gain", mock("gain"), {"k": 1e3})
    system.add("integrator", mock("integrator"), {"x": [1.0, 1.0, 1.0]})
    system.connect("integrator.y", "gain.u")
    system.connect("gain.y", "integrator.u")
    with pytest.raises(RunFailed) as error:
        run(system, stop_time=10, step=0.1, method=ME)
    assert "\n" not in str(error.value)
    assert 0.0 < len(error.value.result.time) < 100


def test_a_row_sets_only_what_it_reads_and_derivatives_set_all(chain):
    def sets_and_gets(engine):
        return [(call.kind, call.component) for call in engine._plan.calls]

    with CoupledModel(chain(), record=["gain.y"]) as model:
        assert ("set", "integrator") in sets_and_gets(model._derivatives)
        assert sets_and_gets(model._outputs) == [("get", "source"), ("set", "gain"), ("get", "gain")]
        assert model.outputs(0.5, model.x0)["gain.y"][0] == 3.0  # 2 (1 + t)
