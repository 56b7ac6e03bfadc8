"""The attitude tracking loop of the components built here: both methods, both FMI versions, both loops."""

import numpy as np
import pytest

from adcs import CoSimulation, ModelExchange, Save, run, steps
from adcs.library.thakur.observer import settings
from adcs.library.thakur.observer.systems import full_state_pd, observer_pd
from orchestration.running.method import method_of

STATES = ("plant.q_BN", "plant.omega_BN_B", "observer.q_EN", "observer.omega_EN_E")


INERTIA = np.array(settings.INERTIA)


def C_(q):
    """Direction cosine matrix C_BR of q_BR."""
    x, y, z = q[1:]
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return (q[0] ** 2 - q[1:] @ q[1:]) * np.eye(3) + 2 * np.outer(q[1:], q[1:]) - 2 * q[0] * cross


@pytest.fixture(scope="module")
def truth():
    return run(observer_pd(), stop_time=10, step=0.1, method=ModelExchange(rtol=1e-13))


def test_compiled_and_python_and_both_versions_agree_to_the_last_bit():
    noise = {"half_angle": 0.01, "redraw_period": 0.05}
    results = [
        run(observer_pd(**noise), stop_time=2, step=0.01, method=CoSimulation(stepping=stepping), fmi_version=version)
        for stepping in ("compiled", "python")
        for version in ("2.0", "3.0")
    ]
    assert all(np.array_equal(result.data, results[0].data) for result in results[1:])
    live = [values["plant.q_BN"] for _, values in steps(observer_pd(**noise), stop_time=2, step=0.01)]
    assert np.array_equal(live, results[0]["plant.q_BN"])


def test_coupled_versions_agree_to_the_last_bit(truth):
    other = run(observer_pd(), stop_time=10, step=0.1, method=ModelExchange(rtol=1e-13), fmi_version="3.0")
    assert np.array_equal(other.data, truth.data)


def test_coupled_is_converged(truth):
    for rtol, error in ((1e-9, 1e-6), (1e-12, 1e-10), (3e-14, 1e-11)):
        other = run(observer_pd(), stop_time=10, step=0.1, method=ModelExchange(rtol=rtol))
        assert np.abs(other.data - truth.data).max() < error
    cvode = run(observer_pd(), stop_time=10, step=0.1, method=ModelExchange("CVode"))
    assert np.abs(cvode.data - truth.data).max() < 1e-5


def test_co_simulation_converges_with_first_order(truth):
    errors = {name: [] for name in STATES}
    for step in (0.002, 0.001):
        result = run(observer_pd(), stop_time=10, step=step)
        for name in STATES:
            errors[name].append(np.abs(result[name][:: round(0.1 / step)] - truth[name]).max())
    for name, (coarse, fine) in errors.items():
        assert coarse / fine == pytest.approx(2, abs=0.06), name


def test_values_are_propagated_before_they_are_recorded():
    result = run(full_state_pd(), stop_time=1, step=0.1)
    assert np.array_equal(result["tracker.q_BN_meas"], result["plant.q_BN"])
    names = ("torque_B", "q_BR", "omega_BR_B")
    torque, q_BR, omega_BR = (result[f"controller.{name}"] for name in names)
    for k, q in enumerate(q_BR):  # the PD law (5.1) with the values of one row
        C = C_(q)
        omega = C @ result["guidance.omega_RN_R"][k]
        expected = -1.5 * q[1:] - 5.0 * omega_BR[k] + INERTIA @ C @ result["guidance.omegaDot_RN_R"][k]
        expected += np.cross(omega, INERTIA @ omega)
        assert torque[k] == pytest.approx(expected, abs=1e-12)
        assert omega_BR[k] == pytest.approx(result["plant.omega_BN_B"][k] - omega, abs=1e-15)
    assert result.time.tolist() == [k * 0.1 for k in range(11)]


def test_units_come_with_the_values(truth):
    assert truth.unit("plant.omega_BN_B") == "rad/s"
    assert truth.unit("controller.torque_B") == "N.m"
    assert truth.manifest["seeds"] == {"tracker.seed": 1}


@pytest.mark.parametrize("step", [0.05, 0.1, 0.03])
def test_noise_is_drawn_at_the_same_instants_by_both_methods(step):
    noise = {"half_angle": 0.01, "redraw_period": 0.1}
    settings = {"stop_time": round(3 / step) * step, "step": step, "save": Save(["tracker.tilt_versine"])}
    one, other = (
        run(
            observer_pd(**noise),
            method=method_of(m),
            **settings,
        )
        for m in ("co-simulation", "model-exchange")
    )
    assert np.array_equal(one["tracker.tilt_versine"], other["tracker.tilt_versine"])
    assert len(np.unique(one["tracker.tilt_versine"])) == 31
