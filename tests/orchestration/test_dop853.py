"""The compiled DOP853 against SciPy's, and its continuous extension."""

from math import inf

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import DOP853

from adcs import AdcsError, CoupledModel, ModelExchange, RunFailed, Save, System, run, systems
from orchestration.coupled.dop853 import Dop853
from orchestration.coupled.integrators import Terms
from orchestration.coupled.solution import Solution
from orchestration.engine.walk import no_rows
from orchestration.instances.instance import CallFailed

Floats = NDArray[np.float64]


@pytest.fixture(params=["2.0", "3.0"])
def pendulums(request, mock) -> System:
    """Two oscillators, one driven by the other."""
    system = System("pendulums")
    system.add("a", mock("oscillator", request.param), {"a": 1.0, "b": 0.0, "u": 0.0})
    system.add("b", mock("oscillator", request.param), {"a": 0.5, "b": -0.25})
    system.connect("a.position", "b.u")
    return system


def terms(rtol: float, longest: float = inf) -> Terms:
    return Terms(rtol, 0.01 * rtol, longest, 0.0, inf, 5, inf, np.empty(0))


def steps_of(model: CoupledModel, rtol: float, stop: float, longest: float = inf) -> tuple[Dop853, list[float]]:
    """Return the ends of all steps. The mocks want to know of each, or else bounds are raised bit by bit."""
    walk = Dop853(model, terms(rtol, longest))
    walk.restart(0.0, model.x0)
    times = []
    while walk.time < stop:
        walk.go(np.nextafter(walk.time, inf), stop, no_rows(len(model.x0)))
        times.append(walk.time)
    return walk, times


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_it_takes_the_steps_that_scipys_takes(pendulums, rtol):
    with CoupledModel(pendulums) as model:
        walk, times = steps_of(model, rtol, 10.0)
        solver = DOP853(model.rhs, 0.0, model.x0, 10.0, rtol=rtol, atol=0.01 * rtol)
        expected = []
        while solver.status == "running":
            solver.step()
            expected.append(solver.t)
        assert times == pytest.approx(expected, rel=1e-6)
        assert walk.x == pytest.approx(solver.y, rel=1e-9, abs=1e-9)
        dense = solver.dense_output()
        for t in np.linspace(solver.t_old, solver.t, 9):
            assert walk.sketch(t) == pytest.approx(dense(t), rel=1e-9, abs=1e-9)


def errors_of(model: CoupledModel, step: float) -> tuple[float, float]:
    """Return the errors at the end of one step of this length, and in its middle."""
    walk = Dop853(model, terms(1.0, step))
    walk.restart(0.0, model.x0)
    walk._walk._raw.length = step  # as if it had been found
    walk.go(step, step, no_rows(4))
    exact = DOP853(model.rhs, 0.0, model.x0, step, rtol=1e-13, atol=1e-15, max_step=step / 20)
    middle = None
    while exact.status == "running":
        exact.step()
        if middle is None and exact.t >= step / 2:
            middle = exact.dense_output()(step / 2)
    return float(np.abs(walk.x - exact.y).max()), float(np.abs(walk.sketch(step / 2) - middle).max())


def test_its_orders_are_eight_and_seven(pendulums):
    with CoupledModel(pendulums) as model:
        (end, middle), (end_of_half, middle_of_half) = errors_of(model, 1.0), errors_of(model, 0.5)
    assert 8.5 < np.log2(end / end_of_half) < 10.5  # of a single step: one more
    assert 7.5 < np.log2(middle / middle_of_half) < 9.5


def test_a_step_made_again_shorter_is_as_accurate_as_any(pendulums):
    with CoupledModel(pendulums) as model:
        walk, _ = steps_of(model, 1e-10, 5.0)
        t = walk.began + 0.3 * (walk.time - walk.began)
        exact = DOP853(model.rhs, 0.0, model.x0, t, rtol=1e-13, atol=1e-15)
        while exact.status == "running":
            exact.step()
        assert walk.at(t) == pytest.approx(exact.y, abs=2e-9)
        end, x = walk.time, walk.x.copy()
        assert walk.time == end and np.array_equal(walk.x, x)
        walk.back(t)
        assert walk.time == t
        assert walk.x == pytest.approx(exact.y, abs=2e-9)


def test_no_step_is_longer_than_the_longest(pendulums):
    result = run(pendulums, stop_time=10, step=1.0, method=ModelExchange(max_step="0.1s"))
    assert result.manifest["integrator"]["longest [s]"] == pytest.approx(0.1)
    assert result.manifest["settings"]["max_step"] == 0.1
    assert 100 <= result.manifest["integrator"]["steps"] < 120
    with pytest.raises(AdcsError, match=r"^max_step = -1.0: expected a positive number"):
        ModelExchange(max_step=-1)


@pytest.mark.parametrize("name", ["observer-pd", "adaptive-baseline", "gyro-free"])
def test_a_system_follows_scipy(name):
    """The state after 20 s, from derivatives through Python and SciPy's steps, at tolerances of equal size."""
    system = systems()[name].build()
    with CoupledModel(system) as model:
        solution = Solution(model, 0.0, 1e-9, "DOP853", rtol=1e-12, atol=1e-14)
        solution.reach(20.0)
        solver = DOP853(model.rhs, 0.0, model.x0, 20.0, rtol=1e-12, atol=1e-14 * model.nominals)
        while solver.status == "running":
            solver.step()
        assert solution.time == solver.t == 20.0
        assert solution.x == pytest.approx(solver.y, rel=1e-10, abs=1e-10)


def test_a_state_that_leaves_all_bounds_ends_the_run(mock):
    system = System("overflow")
    system.add("c", mock("oscillator"), {"a": 1e308, "b": 1e308, "u": 1e308})
    with pytest.raises(RunFailed, match=r"^c failed at .* the derivative of b is not finite"):
        run(system, stop_time=100.0, step=10, method=ModelExchange(), save=Save(["c.position"]))


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_state_at_which_a_law_has_no_values_is_discarded_and_one_nearer_is_not(version):
    system = System("alone")
    system.add("body", "RigidBody", {"torque_B": [0, 0, 0], "torque_disturbance_B": [0, 0, 0]})
    with CoupledModel(system, fmi_version=version) as model:
        before = model.rhs(0.0, model.x0)
        for wild in (1e200, np.inf, np.nan):
            state = model.x0.copy()
            state[-3:] = [wild, -wild, 0.5 * wild]
            with pytest.raises(CallFailed, match=r"returned discard: .* (is|=) -?(nan|inf)"):
                model.rhs(0.0, state)
        assert np.array_equal(model.rhs(0.0, model.x0), before)


def test_a_step_into_what_is_no_state_is_tried_again_shorter():
    """The stages of a step that is too long for the stiff body with fuel loss are not finite."""
    rough, fine = (run("adaptive-fuel", stop_time=5, method=ModelExchange(rtol=rtol)) for rtol in (1e-8, 1e-12))
    assert rough.manifest["integrator"]["rejected"] > 0
    assert rough["plant.q_BN"] == pytest.approx(fine["plant.q_BN"], abs=1e-6)


def test_tolerances_below_roundings_do_not_shorten_steps():
    """Positions of 7e6 m, whose difference goes to zero, have roundings of 1e-9 m: it took three million steps once."""
    result, other = (run("six-dof", method=method) for method in (ModelExchange(), ModelExchange("CVode")))
    assert result.manifest["integrator"]["steps"] < 400
    for name in result.names:
        size = np.abs(result[name]).max()
        assert np.abs(result[name] - other[name]).max() < 1e-6 * max(size, 1e-3), name
