"""What the exchange step costs, said by the program, against what it really costs; and steps chosen by tolerance."""

import numpy as np
import pytest

import adcs
from adcs import AdcsError, CoSimulation, ModelExchange, RunFailed, Save, System, estimate_error, run
from adcs.catalogue import SYSTEMS

T5 = SYSTEMS["observer-pd"]


@pytest.fixture(scope="module")
def truth():
    return run(T5.build(), stop_time=10, step=0.1, method=ModelExchange())


def deviation(result, truth, name):
    return np.abs(result[name] - truth[name]).max()


def test_the_estimate_by_the_coupled_solution_is_the_error(truth):
    result = run(T5.build(), stop_time=10, step=0.1)
    estimate = estimate_error(result, run)
    assert estimate.method == "coupled model exchange"
    found = {d.variable: d for d in estimate.deviations}
    assert list(found) == result.names
    for name in ("plant.q_BN", "controller.torque_B"):
        assert found[name].most == deviation(result, truth, name)
        assert found[name].unit == result.unit(name)
        off = np.abs(result[name] - truth[name]).max(axis=1)
        assert found[name].at == result.time[off.argmax()]
        assert found[name].rms == pytest.approx(np.sqrt(np.mean(off**2)), rel=1e-12)


def test_the_estimate_by_halving_the_step_comes_close(truth):
    system = T5.build()
    # a change that changes nothing takes away the coupled solution
    result = run(system, stop_time=10, step=0.1, hooks=[adcs.at(5.0, {"controller.k_p": 1.5})])
    estimate = estimate_error(result, run)
    assert estimate.method == "step halving"
    assert estimate.note == "twice the difference to half the exchange step, because the run has changes"
    for found in estimate.deviations:
        if found.variable in ("plant.q_BN", "plant.omega_BN_B", "controller.torque_B", "observer.q_EN"):
            assert found.most == pytest.approx(deviation(result, truth, found.variable), rel=0.15)


def test_rates_and_delays_are_kept_when_the_step_is_halved():
    def deviation_of(system):
        found = estimate_error(run(system, stop_time=10, step=0.01), run)
        return {d.variable: d.most for d in found.deviations}["plant.q_BN"]

    def loop():
        return SYSTEMS["full-state-pd"].build()

    slow, late, finer = loop(), loop(), loop()
    slow.components["controller"].every = 10
    late.delay("plant.torque_B", steps=10)
    finer.delay("plant.torque_B", seconds=0.1)
    # all components but the slow one are integrated exactly over a held torque
    assert deviation_of(slow) < 1e-6
    truth = run(finer, stop_time=10, step=0.000625, save=Save(every=16))["plant.q_BN"]
    true = np.abs(run(late, stop_time=10, step=0.01)["plant.q_BN"] - truth).max()
    assert deviation_of(late) == pytest.approx(true, rel=0.2)


def test_only_co_simulation_has_such_an_error(truth):
    with pytest.raises(AdcsError, match=r"^the error of the exchange step is a matter of co-simulation"):
        estimate_error(truth, run)


def test_adaptive_steps_meet_their_tolerance(truth):
    errors = []
    for tolerance in (1e-3, 1e-4):
        result = run(T5.build(), stop_time=10, step=0.1, method=CoSimulation(adaptive=tolerance))
        assert np.array_equal(result.time, truth.time)
        report = result.manifest["adaptive"]
        assert report["tolerance"] == tolerance
        assert sum(report["intervals_by_exchange_step"].values()) == 100
        errors.append(deviation(result, truth, "plant.q_BN"))
    # each of the 100 intervals may add its tolerance; the loop damps most of it
    assert errors[1] < errors[0] < 100 * 1e-3
    assert errors[1] < 100 * 1e-4


def test_an_adaptive_run_takes_the_steps_it_says(truth):
    result = run(
        T5.build(), stop_time=1, step=0.1, method=CoSimulation(adaptive=1.0)
    )  # so loose that one halving is always enough
    assert result.manifest["adaptive"]["intervals_by_exchange_step"] == {"0.05": 10}
    finer = run(T5.build(), stop_time=1, step=0.05, save=Save(every=2))
    assert np.abs(result.data - finer.data).max() < 1e-12


def test_what_cannot_go_back_is_refused(chain):
    with pytest.raises(AdcsError, match=r"^integrator \(integrator\.fmu\) cannot go back to a saved state, or on with"):
        run(chain(), stop_time=1, step=0.5, method=CoSimulation(adaptive=1e-3))


def test_refused_settings():
    with pytest.raises(AdcsError, match=r"^adaptive = 0\.0: expected a positive tolerance$"):
        CoSimulation(adaptive=0.0)
    with pytest.raises(AdcsError, match=r"^checkpoint: not together with adaptive exchange steps, whose choice"):
        run(
            T5.build(),
            stop_time=1,
            step=0.1,
            method=CoSimulation(adaptive=1e-3),
            hooks=[adcs.checkpoint("state.npz")],
        )


def test_an_unreachable_tolerance_is_named():
    with pytest.raises(RunFailed, match=r"the tolerance 1e-17 is not met with 2\^\d+ exchange steps in one interval"):
        run(T5.build(), stop_time=1, step=1e-3, method=CoSimulation(adaptive=1e-17))


def test_delays_and_rates_are_refused_with_adaptive_steps():
    slow = T5.build()
    slow.components["tracker"].every = 2
    with pytest.raises(AdcsError, match=r"^tracker communicates at every 2 steps: not with adaptive steps$"):
        run(slow, stop_time=1, step=0.1, method=CoSimulation(adaptive=1e-3))
    late = T5.build()
    late.delay("plant.torque_B", steps=1)
    with pytest.raises(AdcsError, match=r"^the connection to plant\.torque_B is delayed: not with adaptive"):
        run(late, stop_time=1, step=0.1, method=CoSimulation(adaptive=1e-3))


def test_a_system_without_components_has_no_steps():
    with pytest.raises(AdcsError, match="has no components"):
        run(System("empty"), stop_time=1, step=0.1, method=CoSimulation(adaptive=1e-3))
