"""The thesis' closed loops of components against the NumPy recomputation, and the properties its proofs promise."""

from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

from adcs import AdcsError, CoSimulation, Result, RunFailed, System, read_ssp, run, write_ssp
from adcs.library.trigo import settings
from adcs.library.trigo.catalogue import Controller, Scenario
from adcs.library.trigo.settings import AS_MADE, AS_PRINTED
from adcs.library.trigo.systems import BUILDERS, ESTIMATE, build, exchange_step, stride
from references import trigo as ref
from references.observer_pd import Array
from references.trigo import Batch, Mode
from tests.one_fmu import Component

SLEW_START, SCAN_START, STOP = 2.0, 5.0, 8.0  # s: early, so that short runs show both
NAMES = {
    "plant.sigma_BO": "sigma",
    "plant.omega_BN_B": "omega",
    "plant.torque_unmodelled_B": "unmodelled",
    "plant.workload": "work",
    "guidance.sigma_RO": "sigma_r",
    "law.sigma_RB": "z_1",
    "law.z_2_B": "z_2",
    "law.omega_c_B": "x_c",
    "law.torque_B": "torque",
    ESTIMATE: "estimate",
    "observer.innovation_B": "innovation",
}
SCALES = {"sigma": 1e-2, "sigma_r": 1e-2, "z_1": 1e-4, "z_2": 1e-4, "unmodelled": 1e-5, "estimate": 1e-5}
"""What 1e-9 is relative to where a signal is a difference of larger ones; else its own largest value."""
SCALES |= {"work": 1e-6, "innovation": 1e-5}
MUTANTS: dict[str, tuple[Mode, dict[str, Any]]] = {
    "sign of chi": (Mode("rbs", "nominal"), {"mutant": "chi sign"}),
    "TF uses, then updates": (Mode("tf", "wheel"), {"update_first": 0}),
    "I&I uses, then updates": (Mode("ii", "wheel"), {"update_first": 0}),
    "NESO with the present torque": (Mode("neso", "wheel"), {"torque_delay": 0}),
    "NESO with J_0 once": (Mode("neso", "mirror"), {"inertia_twice": False}),
    "disturbance not held": (Mode("tf", "mismatch"), {"held": False}),
    "reference not late": (Mode("ii", "nominal"), {"lag": 0}),
    "analytic rate": (Mode("bs", "wheel"), {"by_difference": False}),
    "rate limit of the text": (Mode("bs", "nominal"), {"acceleration_limit": np.radians(0.15)}),
    "spin about its own centre": (Mode("rbs", "wheel"), {"parallel_axis": False}),
}


def all_modes() -> list[Mode]:
    pairs = [(c, s) for s in get_args(Scenario) for c in get_args(Controller)]
    return [Mode(c, s, n=1.070e-3 if s == "nominal" else 1.073e-3) for c, s in pairs]


def fmus(mode: Mode, stop: float = STOP, **options: Any) -> Result:
    """The run of components that belongs to `mode`, in the reading of the tables."""
    system = build(mode.controller, mode.scenario)
    system.set("guidance.slew_start", SLEW_START)
    system.set("guidance.scan_start", SCAN_START)
    return run(system, stop_time=stop, step=0.1, **options)


@pytest.fixture(scope="module")
def recomputed() -> tuple[list[Mode], dict[str, Array]]:
    """All twenty runs and the mutants, side by side."""
    modes = all_modes()
    for mode, change in MUTANTS.values():
        n = 1.070e-3 if mode.scenario == "nominal" else 1.073e-3
        modes.append(replace(mode, n=n, **change))
    modes = [replace(mode, slew_start=SLEW_START) for mode in modes]
    return modes, Batch(modes, scan_start=SCAN_START).run(STOP)


def deviation(result: Result, signals: dict[str, Array], row: int, every: int = 1) -> float:
    """Largest difference of any signal, relative to its scale."""
    worst = 0.0
    for name, signal in NAMES.items():
        if name not in result.names or signal not in signals:
            continue
        ours = result[name][::every]
        expected = signals[signal][:, row].reshape(ours.shape)
        scale = SCALES.get(signal, float(np.abs(expected).max()))
        worst = max(worst, float(np.abs(ours - expected).max()) / scale)
    return worst


@pytest.mark.parametrize("row", range(20), ids=[f"{m.controller}-{m.scenario}" for m in all_modes()])
def test_the_components_follow_the_recomputation(recomputed: tuple[list[Mode], dict[str, Array]], row: int) -> None:
    modes, signals = recomputed
    assert deviation(fmus(modes[row]), signals, row) < 1e-9


@pytest.mark.parametrize("mutant", MUTANTS)
def test_mutants_are_seen(recomputed: tuple[list[Mode], dict[str, Array]], mutant: str) -> None:
    """The same comparison with a mistake in the recomputation is off by more than a thousand times its tolerance."""
    modes, signals = recomputed
    row = 20 + list(MUTANTS).index(mutant)
    assert deviation(fmus(modes[row]), signals, row) > 1e-6


def test_the_literal_reading_follows_the_recomputation_too() -> None:
    """Continuous sources exchanged every 0.01 s, analytic rates, use before update."""
    printed = {
        "slew_start": 0.0,
        "lag": 0,
        "by_difference": False,
        "acceleration_limit": np.radians(0.15),
        "held": False,
        "mirror": (0.005, 0.05, 0.05),
        "inertia_twice": False,
        "torque_delay": 0,
        "update_first": 0,
    }
    pairs: list[tuple[Controller, Scenario]] = [("ii", "wheel"), ("neso", "mirror"), ("tf", "mismatch")]
    modes = [Mode(*pair, **printed) for pair in pairs]
    signals = Batch(modes).run(4.0)
    for row, (controller, scenario) in enumerate(pairs):
        step = exchange_step(scenario, AS_PRINTED, 10.0)
        result = run(build(controller, scenario, AS_PRINTED), stop_time=4.0, step=step)
        assert deviation(result, signals, row, stride(step, 10.0)) < 1e-9


def test_runs_at_5_hertz_start_as_theirs_did() -> None:
    modes = [Mode("ii", "wheel", lag=0, n=1.070e-3), Mode("neso", "mirror", lag=0)]
    gains = {"tf": 15.0, "ii": 25.0, "neso": 2.0}
    modes = [replace(mode, slew_start=2.0) for mode in modes]
    signals = Batch(modes, period=0.2, gain=gains, from_first_command=True).run(6.0)
    for row, mode in enumerate(modes):
        system = build(mode.controller, mode.scenario, rate=5.0)
        system.set("guidance.slew_start", 2.0)
        assert deviation(run(system, stop_time=6.0, step=0.2), signals, row) < 1e-9


# --- one system, however it is run ------------------------------------------------------------------------------------


def test_python_stepping_and_fmi_3_give_the_same_bits() -> None:
    mode = Mode("tf", "mirror")
    expected = fmus(mode, stop=5.0)
    for options in ({"method": CoSimulation(stepping="python")}, {"fmi_version": "3.0"}):
        again = fmus(mode, stop=5.0, **options)
        assert again.names == expected.names
        for name in expected.names:
            np.testing.assert_array_equal(again[name], expected[name], err_msg=name)


@pytest.mark.parametrize("name", ["trigo-ii-mirror", "trigo-neso-wheel", "trigo-tf-mismatch"])
def test_an_exported_system_gives_the_same_bits(tmp_path: Path, name: str) -> None:
    build_it = BUILDERS[name]
    expected = run(build_it(), stop_time=5.0, step=0.1)
    write_ssp(build_it(), tmp_path / "system.ssp", stop_time=5.0, step=0.1)
    file = read_ssp(tmp_path / "system.ssp")
    again = run(file.system, stop_time=5.0, step=0.1)
    for signal in expected.names:
        np.testing.assert_array_equal(again[signal], expected[signal], err_msg=signal)


def test_the_exchange_step_does_not_matter_where_all_is_held() -> None:
    """Finer exchange gives the same: plant and law change nothing between control instants that the other sees."""
    coarse, fine = (run(build("ii", "wheel"), stop_time=30.0, step=step) for step in (0.1, 0.01))
    for name in ("plant.sigma_BO", "plant.omega_BN_B", "law.torque_B", ESTIMATE, "plant.workload"):
        a, b = coarse[name], fine[name][::10]
        assert np.abs(a - b).max() <= 1e-12 * np.abs(a).max()


# --- the proofs -------------------------------------------------------------------------------------------------------


def demanding_slew(controller: Controller, rate: float = 10.0) -> System:
    """From 60 deg to 0 with little torque: all four limits act."""
    half = np.radians(30)
    system = build(controller, rate=rate)
    system.set("plant.q_BO", [np.cos(half), *(np.sin(half) * np.array([1, 2, -1]) / np.sqrt(6))])
    for name, value in (
        ("law.torque_limit", 4e-3),
        ("law.torque_rate_limit", 0.01),
        ("law.rate_limit", np.radians(0.8)),
        ("guidance.angle", 0.0),
    ):
        system.set(name, value)
    return system


def rate_of_v(result: Result, sign: float = 1.0) -> tuple[Array, Array]:
    """dV/dt by the plant's own derivatives at the control instants, and what (8.13) says it is.

    `sign` -1 is the mistake of adding what the filters took away instead of subtracting it.
    """
    z_1, z_2 = result["law.sigma_RB"], result["law.z_2_B"]
    chi_1, chi_2 = z_1 - result["law.z_1_bar_B"], z_2 - result["law.z_2_bar_B"]
    reference = ref.rate_of(z_1, ref.inverse_rate(result["guidance.sigma_RO"], result["guidance.sigmaDot_RO"]))
    z_1_dot = ref.w_times(z_1, result["plant.omega_BO_B"]) + reference
    taken = ref.w_times(z_1, result["law.omega_c_B"] - result["law.omega_c_raw_B"])
    chi_1_dot = -0.1 * chi_1 + taken
    short = result["law.torque_B"] - result["law.torque_raw_B"]
    chi_2_dot = -chi_2 + short @ np.linalg.inv(ref.J)
    acceleration = []
    parameters = {"J_B": ref.J, "J0_B": ref.J, "orbital_rate": 1.070e-3}
    with Component("OrbitingBody", 2, parameters) as plant:
        for k in range(len(result.time)):
            plant.set_states({n: result[f"plant.{n}"][k] for n in ("q_BO", "omega_BN_B", "workload")})
            plant.set({"torque_B": result["law.torque_B"][k], "torque_disturbance_B": np.zeros(3)})
            acceleration.append(plant.derivatives()["omega_BN_B"])
    z_1_bar, z_2_bar = z_1 - sign * chi_1, z_2 - sign * chi_2
    z_2_dot = np.array(acceleration) - result["law.omegaDot_c_B"]
    actual = np.sum(z_1_bar * (z_1_dot - sign * chi_1_dot) + z_2_bar * (z_2_dot - sign * chi_2_dot), axis=1)
    damping = 2.0  # c_2 + K, both 1 times the identity
    promised = -0.1 * np.sum(z_1_bar**2, axis=1) - damping * np.sum(z_2_bar**2, axis=1)
    return actual, promised


def lyapunov(result: Result) -> Array:
    """V of (8.13)."""
    return np.asarray((result["law.z_1_bar_B"] ** 2 + result["law.z_2_bar_B"] ** 2).sum(axis=1) / 2)


def test_v_falls_as_8_13_says_even_while_all_limits_act() -> None:
    """At each control instant, to 1e-12 of the largest rate; with the sign of chi flipped it is off by a tenth."""
    result = run(demanding_slew("rbs"), stop_time=120.0, step=0.1)
    length = {n: np.linalg.norm(result[f"law.{n}"], axis=1) for n in ("torque_B", "omega_c_B", "omegaDot_c_B")}
    acting = {
        "torque": length["torque_B"] > 4e-3 * (1 - 1e-9),
        "rate": length["omega_c_B"] > np.radians(0.8) * (1 - 1e-9),
        "acceleration": length["omegaDot_c_B"] > np.radians(0.10) * (1 - 1e-9),
        "torque rate": np.linalg.norm(np.diff(result["law.torque_B"], axis=0), axis=1) > 1e-3 * (1 - 1e-9),
    }
    assert {name: bool(those.sum() > 3) for name, those in acting.items()} == dict.fromkeys(acting, True)
    actual, promised = rate_of_v(result)
    scale = np.abs(promised).max()
    assert np.abs(actual - promised).max() < 1e-12 * scale
    actual, promised = rate_of_v(result, sign=-1.0)
    assert np.abs(actual - promised).max() > 0.1 * scale


def test_v_decreases_to_nothing() -> None:
    """Sampled at 50 Hz, undisturbed, with the limits acting at first: V falls from each sample to the next.

    Below a millionth of its first value the steps of the sampled law show when a limit lets go; it still vanishes.
    """
    result = run(demanding_slew("rbs", rate=50.0), stop_time=150.0, step=0.02)
    v = lyapunov(result)
    large = v[:-1] > 1e-6 * v[0]
    assert np.all(np.diff(v)[large] < 0)
    assert large.sum() > 1000
    assert v[0] > 1e-2
    assert v[-1] < 1e-12 * v[0]


# --- saturation -------------------------------------------------------------------------------------------------------


def saturated(source: str) -> Result:
    """A wheel's torque that takes all but little of the available torque, and a slew too fast for the limits.

    The tuning-function observer sees `source` of the law.
    """
    system = build("rbs", "wheel")
    del system.components["law"].start["torque_disturbance_B_est"]
    system.add("observer", "TuningFunctionObserver", {"G": 15 * np.eye(3), "period": 0.1})
    system.connect(f"law.{source}", "observer.z_2_bar_B")
    system.connect(ESTIMATE, "law.torque_disturbance_B_est")
    system.set("law.torque_limit", 0.008)
    slew = {"slew_start": 60.0, "slew_rate": np.radians(2), "time_constant": 2.0, "angle": np.radians(60)}
    for name, value in slew.items():
        system.set(f"guidance.{name}", value)
    return run(system, stop_time=260.0, step=0.1)


def turns(torque: Array) -> int:
    """How often the torque turns from rising to falling or back, all axes."""
    change = np.diff(torque, axis=0)
    return int((np.diff(np.sign(change), axis=0) != 0).sum())


def test_the_compensated_error_keeps_the_observer_from_winding_up() -> None:
    compensated, plain = saturated("z_2_bar_B"), saturated("z_2_B")
    late = compensated.time > 60
    figures = []
    for result in (compensated, plain):
        error = np.linalg.norm(result[ESTIMATE] - result["plant.torque_unmodelled_B"], axis=1)[late]
        short = np.linalg.norm(result["law.torque_raw_B"] - result["law.torque_B"], axis=1)[late] > 1e-9
        angle = 4 * np.degrees(np.arctan(np.linalg.norm(result["law.sigma_RB"][-1])))
        figures.append((error.max(), short.sum(), turns(result["law.torque_B"][late]), angle))
    (error, short, chatter, angle), (wound_up, _, limit_cycle, off) = figures
    assert short > 500  # 50 s of saturation
    assert error < 1.2e-3  # N.m, of 10e-3 that act
    assert chatter < 60  # in 2000 samples
    assert angle < 1e-3  # deg
    # without compensation the observer takes the missing torque for a disturbance and runs into its projection
    assert wound_up > 0.1
    assert limit_cycle > 1000
    assert off > 0.5


# --- bad input, and what diverges -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("controller", "until"), [("neso", 20.0), ("ii", 200.0)])
@pytest.mark.parametrize("scenario", ["wheel", "mirror"])
def test_at_5_hertz_the_gains_of_10_hertz_diverge(controller: Controller, scenario: Scenario, until: float) -> None:
    """As the text says; with the reduced gains the same run is quiet."""
    with pytest.raises(RunFailed) as failed:
        run(build(controller, scenario, rate=5.0, reduced_gains=False), stop_time=until, step=0.2)
    assert failed.value.result.time[-1] < until
    quiet = run(build(controller, scenario, rate=5.0), stop_time=until, step=0.2)
    assert np.linalg.norm(quiet["law.sigma_RB"], axis=1).max() < 1e-3


def test_what_cannot_be_a_system_is_refused_in_one_line() -> None:
    cases: list[tuple[Any, str]] = [
        (lambda: build("pid"), "no controller 'pid': choose one of bs, rbs, tf, neso, ii"),
        (lambda: build("bs", "storm"), "no scenario 'storm': choose one of nominal"),
        (lambda: build("bs", rate=0.0), "control rate 0 Hz: expected a positive number"),
        (lambda: stride(0.03, 10.0), "the control period, 1/10 s, is not a whole number of exchange steps of 0.03 s"),
        (lambda: stride(0.2, 10.0), "the control period, 1/10 s, is not a whole number of exchange steps of 0.2 s"),
        (lambda: run(build("bs"), stop_time=0.0, step=-0.1), "step = -0.1 s: expected a positive time"),
        (lambda: settings.Choices(stop_time=0.0), "choice stop_time = 0: expected more than 505 s"),
        (lambda: settings.Choices(agreement=0.0), "choice agreement = 0: expected a relative error between 0 and 1"),
    ]
    for attempt, message in cases:
        with pytest.raises(AdcsError) as error:
            attempt()
        assert str(error.value).startswith(message)
        assert "\n" not in str(error.value)


def test_every_reading_can_be_built_and_run() -> None:
    pairs: list[tuple[Scenario, Controller]] = [("mismatch", "bs"), ("wheel", "neso"), ("mirror", "ii")]
    for reading in settings.READINGS.values():
        for scenario, controller in pairs:
            step = exchange_step(scenario, reading, 10.0)
            result = run(build(controller, scenario, reading), stop_time=0.2, step=step)
            assert np.isfinite(result["law.torque_B"]).all()
    assert settings.READINGS[AS_MADE.name] is AS_MADE
