"""The components wired and integrated as one ODE, against the recomputed closed loops and the Lyapunov identities."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from adcs import CoupledModel, ModelExchange, System, run
from adcs.catalogue import SYSTEMS
from orchestration.running.method import method_of
from references.observer_pd import Array, Loop, rate_along

NAMES = {"full-state-pd": False, "observer-pd": True}

# Recorded variable -> signal of the recomputed loop.
SIGNALS = {
    "plant.q_BN": "q",
    "plant.omega_BN_B": "omega",
    "guidance.q_RN": "q_r",
    "guidance.omega_RN_R": "omega_r",
    "guidance.omegaDot_RN_R": "omega_r_dot",
    "controller.torque_B": "torque",
    "controller.q_BR": "q_e",
    "controller.omega_BR_B": "omega_e",
}
OBSERVER_SIGNALS = {
    "observer.q_EN": "q_hat",
    "observer.omega_EN_E": "omega_hat",
    "observer.omega_BN_B_est": "omega_est",
    "observer.q_BE": "q_t",
}


@pytest.mark.parametrize("fmi_version", ["2.0", "3.0"])
@pytest.mark.parametrize("name", NAMES)
def test_coupled_model_exchange_follows_the_recomputed_loop(
    runs: dict[bool, dict[str, Array]], name: str, fmi_version: str
) -> None:
    expected = runs[NAMES[name]]
    system = SYSTEMS[name].build()
    tolerances = {"method": ModelExchange(rtol=1e-12, atol=1e-13)}
    result = run(system, stop_time=100.0, step=0.1, fmi_version=fmi_version, **tolerances)
    np.testing.assert_allclose(result.time, expected["time"], rtol=0, atol=1e-13)
    signals = {**SIGNALS, **(OBSERVER_SIGNALS if NAMES[name] else {})}
    if NAMES[name]:
        signals["controller.omega_BR_B"] = "omega_e_est"
        expected = {**expected, "omega_e_est": expected["omega_e"] - expected["omega_t"]}
    for variable, signal in signals.items():
        deviation = np.abs(result[variable] - expected[signal]).max()
        assert deviation < 1e-9, f"{variable}: {deviation:.1e}"


def translate(model: CoupledModel, loop: Loop) -> Callable[[Array], Array]:
    """From the coupled model's state vector to that of the recomputed loop."""
    index = {name: i for i, name in enumerate(model.state_names)}

    def part(name: str, n: int) -> list[int]:
        return [index[f"{name}[{i + 1}]"] for i in range(n)]

    plant = part("plant.q_BN", 4) + part("plant.omega_BN_B", 3)
    observer = part("observer.q_EN", 4) + part("observer.omega_EN_E", 3) if loop.with_observer else []
    angle = index["guidance.angle"]
    attitude = loop.settings.reference.attitude
    return lambda x: np.concatenate([x[plant], attitude(x[angle]), x[observer]])


def identity_residual(system: System, loop: Loop, every: int = 10, stop: float = 100.0) -> tuple[Array, Array]:
    """Along the FMUs' trajectory: d/dt of V by the FMUs' own derivatives less what the proofs say; and V itself."""
    times = np.arange(0, stop + 1e-9, 0.1 * every)
    with CoupledModel(system) as model:
        to_loop = translate(model, loop)
        x = solve_ivp(model.rhs, (0, stop), model.x0, "DOP853", times, rtol=1e-12, atol=1e-13).y.T

        def lyapunov(t: float, state: Array) -> Array:
            return loop.lyapunov(t, to_loop(state))

        residual = [
            rate_along(lyapunov, t, row, model.rhs(t, row)) - loop.lyapunov_rates(loop.signals(t, to_loop(row)))
            for t, row in zip(times, x, strict=True)
        ]
        return np.array(residual), np.array([lyapunov(t, row) for t, row in zip(times, x, strict=True)])


@pytest.mark.parametrize("name", NAMES)
def test_lyapunov_identities_along_the_trajectory_of_the_components(
    runs: dict[bool, dict[str, Array]], name: str
) -> None:
    residual, values = identity_residual(SYSTEMS[name].build(), Loop(NAMES[name]))
    assert np.abs(residual).max() < 1e-8
    np.testing.assert_allclose(values - values[0], runs[NAMES[name]]["lyapunov_integrals"][::10], atol=1e-8)


def rewired(sources: dict[str, str | None], start: dict[str, Any] | None = None) -> System:
    """The observer system with other sources of some inputs (None: a constant zero) and other start values."""
    system = SYSTEMS["observer-pd"].build()
    for target in sources:
        system.disconnect(target)
    for target, source in sources.items():
        if source is None:
            system.set(target, np.zeros(3))
        else:
            system.connect(source, target)
    for name, value in (start or {}).items():
        system.set(name, value)
    return system


@pytest.mark.parametrize(
    ("sources", "start", "breaks"),
    [
        pytest.param({"observer.torque_B": None}, {}, (0, 28.806), id="observer without torque"),
        pytest.param(
            {"controller.q_BN": "guidance.q_RN", "controller.q_RN": "tracker.q_BN_meas"},
            {},
            (9.029, 0),
            id="attitude and reference swapped",
        ),
        pytest.param({}, {"observer.lambda": 1.01}, (0, 1.6089e-5), id="lambda 1 % off"),
        pytest.param({}, {"controller.k_p": 1.5015}, (3.5626e-5, 0), id="k_p 0.1 % off"),
    ],
)
def test_a_wrong_loop_breaks_an_identity(
    sources: dict[str, str | None], start: dict[str, Any], breaks: tuple[float, float]
) -> None:
    """The check above can fail, and by how much."""
    residual, _ = identity_residual(rewired(sources, start), Loop(True), every=5, stop=10.0)
    largest = np.abs(residual).max(axis=0)
    np.testing.assert_allclose(largest, breaks, rtol=0.01, atol=1e-8)


def test_noise_is_drawn_alike_by_both_methods_and_held_between_redraws() -> None:
    """Tilt of the measured eigenaxis, row by row: constant over each period of the tracker, new at its multiples."""
    half_angle, tilts = np.deg2rad(0.5), []
    for method in ("co-simulation", "model-exchange"):
        system = SYSTEMS["observer-pd"].build()
        system.set("tracker.half_angle", half_angle)
        system.set("tracker.redraw_period", 0.1)
        result = run(
            system,
            stop_time=2.0,
            step=0.01,
            method=method_of(method),
        )
        true, measured = result["plant.q_BN"], result["tracker.q_BN_meas"]
        np.testing.assert_array_equal(measured[:, 0], true[:, 0])
        tilt = np.sum((measured - true) ** 2, axis=1) / np.sum(true[:, 1:] ** 2, axis=1) / 2  # 1 - cos
        assert tilt.max() <= (1 - np.cos(half_angle)) * (1 + 1e-9)
        tilts.append(tilt)
    np.testing.assert_allclose(tilts[0], tilts[1], rtol=1e-9)
    periods = tilts[1][:200].reshape(20, 10)
    np.testing.assert_allclose(periods, periods[:, :1].repeat(10, axis=1), rtol=1e-9)
    assert np.abs(np.diff(periods[:, 0])).min() > 1e-3 * (1 - np.cos(half_angle))
