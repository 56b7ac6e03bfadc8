"""The components of the thesis' loops, each alone, against a recomputation from the equations."""

import itertools
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.stats import kstest

from adcs import System, run
from orchestration.instances.instance import CallFailed

from . import trigo_reference as ref
from .at_points import (
    Law,
    Point,
    compare,
    directions,
    draw,
    inertia,
    opened,
    quaternion,
    slopes,
)
from .fmu_access import VERSIONS, Component, array_name, unpacked
from .reference import Array, body_acceleration, kinematics, rate_along, rotation

PERIOD = 0.25


def mrp(rng: np.random.Generator, largest: float = 0.55) -> Array:
    """Each component within its bound, and |sigma| < 1."""
    return rng.uniform(-largest, largest, 3)


def orbit_axes(q_BO: Array) -> Array:
    """C_BO, by SciPy, which turns vectors where the thesis turns frames."""
    return rotation(q_BO).as_matrix().T


def gravity(n: float, c_3: Array, j: Array) -> Array:
    return 3 * n**2 * np.cross(c_3, j @ c_3)


def body(p: Mapping[str, Any]) -> dict[str, Array]:
    c = orbit_axes(p["q_BO"])
    omega, n = p["omega_BN_B"], p["orbital_rate"]
    torque = p["torque_B"] + p["torque_disturbance_B"] + gravity(n, c[:, 2], p["J_B"])
    return {
        "relative": omega - c @ np.array([0.0, -n, 0.0]),
        "acceleration": body_acceleration(p["J_B"], omega, torque),
        "c_3": c[:, 2],
    }


def body_outputs(p: Mapping[str, Any]) -> Point:
    found, omega, j_0 = body(p), p["omega_BN_B"], p["J0_B"]
    momentum_rate = j_0 @ found["acceleration"] + np.cross(omega, j_0 @ omega)
    known = gravity(p["orbital_rate"], found["c_3"], j_0) + p["torque_B"]
    return {
        "q_BO": p["q_BO"],
        "omega_BN_B": omega,
        "workload": p["workload"],
        "sigma_BO": rotation(p["q_BO"]).as_mrp(),
        "omega_BO_B": found["relative"],
        "torque_unmodelled_B": momentum_rate - known,
    }


def body_rates(p: Mapping[str, Any]) -> Point:
    found = body(p)
    return {
        "q_BO": kinematics(p["q_BO"], found["relative"]),
        "omega_BN_B": found["acceleration"],
        "workload": np.abs(p["omega_BN_B"] * p["torque_B"]).sum(),
    }


def profile(p: Mapping[str, Any]) -> Point:
    """The low-pass by the numerical solution of its differential equation."""
    t, angle, tau = float(p["time"]), float(p["angle"]), float(p["time_constant"])
    start, rate = float(p["slew_start"]), float(p["slew_rate"])

    def wanted(at: float) -> float:
        return float(np.clip(rate * (at - start), 0, angle))

    knots = sorted({x for x in (start, start + angle / rate) if 0 < x < t} | {0.0, t})
    theta = 0.0
    if start < 0:  # what has passed before t = 0
        knots = sorted({x for x in (start, start + angle / rate) if x < t} | {t})
    for a, b in itertools.pairwise(knots):
        flow = solve_ivp(
            lambda at, y: [(wanted(at) - y[0]) / tau], (a, b), [theta], "DOP853", rtol=1e-13, atol=1e-14, max_step=tau
        )
        theta = float(flow.y[0, -1])
    slope = (wanted(t) - theta) / tau
    if t >= p["scan_start"]:
        w = 2 * np.pi / float(p["scan_period"])
        theta = angle * np.cos(w * (t - p["scan_start"]))
        slope = -w * angle * np.sin(w * (t - p["scan_start"]))
    turn = Rotation.from_rotvec(theta * p["axis"] / np.linalg.norm(p["axis"]))
    omega = slope * p["axis"] / np.linalg.norm(p["axis"])
    sigma = turn.as_mrp()
    return {"theta": np.array(theta), "sigma_RO": sigma, "sigmaDot_RO": ref.rate_of(sigma, omega)}


def swinging(p: Mapping[str, Any]) -> Point:
    """A body J_0 with a part in it, by the balance of the angular momentum of the whole."""
    q, t = 2 * np.pi / p["swing_period"], p["time"]
    frame = Rotation.from_euler("ZYX", [p["euler"][2], p["euler"][1], p["euler"][0]])

    def part(angle: float) -> Array:
        turn = (frame * Rotation.from_rotvec([0, 0, angle])).as_matrix()
        return np.asarray(turn @ np.diag(p["J_A"]) @ turn.T)

    angle = p["amplitude"] * np.sin(q * t)
    speed, change_ = p["amplitude"] * q * np.cos(q * t), -(q**2) * angle
    a = frame.as_matrix()[:, 2]
    j_dot = rate_along(lambda _, x: part(float(x[0])), 0.0, np.array([angle]), np.array([1.0]), h=2e-3) * speed
    j_0, w, n = p["J0_B"], p["omega_BN_B"], p["orbital_rate"]
    j = j_0 + part(angle) - part(float(p["angle_0"]))
    spin = part(angle) @ a + p["J_offset_B"] @ a
    c_3 = Rotation.from_mrp(p["sigma_BO"]).as_matrix().T[:, 2]
    moment = p["torque_control_B"] + gravity(n, c_3, j) - np.cross(w, j @ w + spin * speed)
    acceleration = np.linalg.solve(j, moment - j_dot @ (w + a * speed) - spin * change_)
    torque = j_0 @ acceleration + np.cross(w, j_0 @ w) - gravity(n, c_3, j_0) - p["torque_control_B"]
    return {"torque_B": torque, "angle": np.array(angle)}


def mismatched(p: Mapping[str, Any]) -> Point:
    c_3 = Rotation.from_mrp(p["sigma_BO"]).as_matrix().T[:, 2]

    def acceleration(j: Array) -> Array:
        return body_acceleration(j, p["omega_BN_B"], p["torque_control_B"] + gravity(p["orbital_rate"], c_3, j))

    return {"torque_B": p["J0_B"] @ (acceleration(p["J_B"]) - acceleration(p["J0_B"]))}


def spinning(p: Mapping[str, Any]) -> Point:
    a = p["axis"] / np.linalg.norm(p["axis"])
    total = p["inertia"] * np.eye(3) + p["J_offset_B"]
    momentum = total @ a * (p["speed"] + p["acceleration"] * p["time"])
    return {"H_B": momentum, "torque_B": np.cross(momentum, p["omega_BN_B"]) - total @ a * p["acceleration"]}


def symmetric(rng: np.random.Generator) -> Array:
    x = rng.normal(size=(3, 3))
    return x + x.T


LAWS = {
    "OrbitingBody": Law(
        draw=lambda rng: {
            "J_B": inertia(rng),
            "J0_B": inertia(rng),
            "orbital_rate": rng.uniform(0, 0.5),
            "q_BO": quaternion(rng),
            "omega_BN_B": rng.normal(size=3),
            "workload": rng.uniform(0, 1),
            "torque_B": rng.normal(size=3),
            "torque_disturbance_B": rng.normal(size=3),
        },
        outputs=body_outputs,
        rates=body_rates,
    ),
    "ScanningReference": Law(
        draw=lambda rng: {
            "axis": rng.normal(size=3),
            "angle": rng.uniform(0.1, 3.0),
            "slew_rate": rng.uniform(0.05, 1),
            "slew_start": rng.uniform(-2, 4),
            "time_constant": rng.uniform(0.5, 4),
            "scan_start": 12.0,
            "scan_period": rng.uniform(1, 9),
            "time": rng.uniform(0, 20),
        },
        outputs=profile,
        rates=lambda _: {},
    ),
    "SpinningWheel": Law(
        draw=lambda rng: {
            "omega_BN_B": rng.normal(size=3),
            "axis": rng.normal(size=3),
            "inertia": rng.uniform(0.1, 1),
            "speed": rng.normal(),
            "acceleration": rng.normal(),
            "J_offset_B": symmetric(rng),
            "time": rng.uniform(0, 5),
        },
        outputs=spinning,
        rates=lambda _: {},
    ),
    "OscillatingPayload": Law(
        draw=lambda rng: {
            "sigma_BO": mrp(rng),
            "omega_BN_B": rng.normal(size=3),
            "torque_control_B": rng.normal(size=3),
            "J0_B": inertia(rng),
            "J_A": rng.uniform(0.1, 1, 3),
            "euler": rng.uniform(-1, 1, 3),
            "amplitude": rng.uniform(0.2, 1),
            "swing_period": rng.uniform(5, 20),
            "angle_0": rng.normal(),
            "J_offset_B": symmetric(rng),
            "orbital_rate": rng.uniform(0, 0.5),
            "time": rng.uniform(0, 20),
        },
        outputs=swinging,
        rates=lambda _: {},
    ),
    "InertiaMismatch": Law(
        draw=lambda rng: {
            "sigma_BO": mrp(rng),
            "omega_BN_B": rng.normal(size=3),
            "torque_control_B": rng.normal(size=3),
            "J_B": inertia(rng),
            "J0_B": inertia(rng),
            "orbital_rate": rng.uniform(0, 0.5),
        },
        outputs=mismatched,
        rates=lambda _: {},
    ),
    "AttitudeRateSensor": Law(
        draw=lambda rng: {"sigma_BO": mrp(rng), "omega_BN_B": rng.normal(size=3)},
        outputs=lambda p: {"sigma_BO_meas": p["sigma_BO"], "omega_BN_B_meas": p["omega_BN_B"]},
        rates=lambda _: {},
    ),
}


def of_size(ours: Any, expected: Any, variable: str) -> None:
    scale = max(1.0, float(np.abs(expected).max()))
    np.testing.assert_allclose(ours, expected, rtol=0, atol=1e-12 * scale, err_msg=variable)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", LAWS)
def test_outputs_and_derivatives(name: str, version: int) -> None:
    for point in draw(name, LAWS[name]):
        with opened(name, version, point) as component:
            compare(component, LAWS[name], point, of_size)


def symmetric_directions(name: str, value: Array) -> list[Array]:
    return directions(name, value, inertias=("J_B", "J0_B"))


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", LAWS)
def test_directional_derivatives(name: str, version: int) -> None:
    """Against central differences of sixth order, for every input, state and tunable parameter."""
    for point in draw(name, LAWS[name], 2):
        with opened(name, version, point) as component:
            for known, analytic, numeric in slopes(component, point, symmetric_directions):
                np.testing.assert_allclose(analytic, numeric, rtol=1e-8, atol=2e-8, err_msg=f"by {known}")


# --- sampled laws: random inputs at each instant, all outputs against a recursion -------------------------------------

Step = Callable[[Mapping[str, Any], dict[str, Array], Point], Point]
"""Parameters, memory that the step changes, and inputs; returns the outputs."""


def rows(*vectors: Array) -> tuple[Array, ...]:
    return tuple(np.atleast_2d(v) for v in vectors)


def backstepping(p: Mapping[str, Any], memory: dict[str, Array], u: Point) -> Point:
    dt, n, j_0 = p["period"], np.array([[p["orbital_rate"]]]), p["J0_B"]
    sigma, omega, sigma_r, sigma_r_dot, estimate = rows(
        u["sigma_BO"], u["omega_BN_B"], u["sigma_RO"], u["sigmaDot_RO"], u["torque_disturbance_B_est"]
    )
    c = {k: p[k][None] for k in ("c_1", "c_2", "K", "J0_B")}
    chi_1, chi_2, chi_2_dot = (memory.get(k, np.zeros((1, 3))) for k in ("chi_1", "chi_2", "chi_2_dot"))
    z_1 = ref.difference(sigma, sigma_r)
    c_2, c_3 = ref.columns(sigma)
    forward = ref.rate_of(z_1, ref.inverse_rate(sigma_r, sigma_r_dot))
    raw = -n * c_2 - ref.w_inverse(z_1, forward + ref.times(c["c_1"], z_1)) - chi_2
    before = memory.get("x_c", raw if p["start_at_command"] else np.zeros((1, 3)))
    x_dot = ref.shortened((ref.shortened(raw, p["rate_limit"]) - before) / dt, p["acceleration_limit"])
    x_c = before + dt * x_dot
    z_2 = omega - x_c
    z_1_bar, z_2_bar = z_1 - chi_1, z_2 - chi_2
    v = x_dot - ref.times(c["c_2"], z_2) - ref.times(c["K"], z_2_bar) - ref.w_transposed(z_1, z_1_bar)
    expected = v + ref.times(c["c_2"], chi_2) + chi_2_dot
    gyroscopic = np.cross(omega, ref.times(c["J0_B"], omega))
    torque_raw = gyroscopic - ref.gravity(n, c_3, c["J0_B"]) + ref.times(c["J0_B"], v) - estimate
    torque = memory.get("torque", np.zeros((1, 3)))
    wanted = (ref.shortened(torque_raw, p["torque_limit"]) - torque) / dt
    torque = torque + dt * ref.shortened(wanted, p["torque_rate_limit"])
    chi_2_dot = -ref.times(c["c_2"], chi_2) + np.linalg.solve(j_0, (torque - torque_raw)[0])
    memory["chi_1"] = chi_1 + dt * (-ref.times(c["c_1"], chi_1) + ref.w_times(z_1, x_c - raw))
    memory["chi_2"], memory["chi_2_dot"] = chi_2 + dt * chi_2_dot, chi_2_dot
    memory["x_c"], memory["torque"] = x_c, torque
    found = {
        "torque_B": torque,
        "torque_raw_B": torque_raw,
        "omega_c_B": x_c,
        "omega_c_raw_B": raw,
        "omegaDot_c_B": x_dot,
        "sigma_RB": z_1,
        "z_2_B": z_2,
        "z_1_bar_B": z_1_bar,
        "z_2_bar_B": z_2_bar,
        "acceleration_expected_B": expected,
    }
    return {name: value[0] for name, value in found.items()}


def tuning(p: Mapping[str, Any], memory: dict[str, Array], u: Point) -> Point:
    state = memory.get("state", np.zeros(3))
    step = p["period"] * ref.projected(state, p["G"] @ u["z_2_bar_B"], p["limit"], p["margin"] * p["limit"] ** 2)
    if p["update_first"]:
        used = state + step if "state" in memory else state
        memory["state"] = used
    else:
        used = state
        memory["state"] = state + step
    return {"torque_disturbance_B_est": used}


def invariance(p: Mapping[str, Any], memory: dict[str, Array], u: Point) -> Point:
    gain = p["gamma"] * np.linalg.inv(p["J0_B"])
    beta = gain @ u["omega_BN_B"]
    state = memory.get("state", -beta)
    step = -p["period"] * gain @ u["acceleration_expected_B"]
    if p["update_first"]:
        state = state + step if "state" in memory else state
        memory["state"] = state
        return {"torque_disturbance_B_est": state + beta}
    memory["state"] = state + step
    return {"torque_disturbance_B_est": state + beta}


def extended(p: Mapping[str, Any], memory: dict[str, Array], u: Point) -> Point:
    omega, dt = u["omega_BN_B"], p["period"]
    hat, xi = memory.get("hat", omega), memory.get("xi", np.zeros(3))
    torque = memory.get("torque", np.zeros(3)) if p["torque_delay"] else u["torque_B"]
    c_3 = Rotation.from_mrp(u["sigma_BO"]).as_matrix().T[:, 2]
    e = hat - omega
    moment = gravity(p["orbital_rate"], c_3, p["J0_B"]) + torque + xi
    acceleration = body_acceleration(p["J0_B"], omega, moment)
    hat_dot = acceleration - p["beta_1"] @ ref.fal(e, p["alpha_1"], p["delta_1"])
    xi_dot = -p["beta_2"] @ ref.fal(e, p["alpha_2"], p["delta_2"])
    limits = [(p[f"{x}_limit"], p[f"{x}_margin"] * p[f"{x}_limit"] ** 2) for x in ("rate", "torque")]
    memory["hat"] = hat + dt * ref.projected(hat, hat_dot, *limits[0])
    memory["xi"] = xi + dt * ref.projected(xi, xi_dot, *limits[1])
    memory["torque"] = u["torque_B"]
    return {"torque_disturbance_B_est": xi, "omega_BN_B_est": hat, "innovation_B": -e}


def definite(rng: np.random.Generator) -> Array:
    x = rng.normal(size=(3, 3))
    return x @ x.T + 0.1 * np.eye(3)


SAMPLED: dict[str, tuple[Step, Callable[[np.random.Generator], Point], Callable[[np.random.Generator], Point]]] = {
    "BacksteppingControl": (
        backstepping,
        lambda rng: {
            "J0_B": inertia(rng),
            "c_1": definite(rng),
            "c_2": definite(rng),
            "K": definite(rng),
            "orbital_rate": rng.uniform(0, 0.5),
            "rate_limit": rng.uniform(1, 20),
            "acceleration_limit": rng.uniform(5, 50),
            "torque_limit": rng.uniform(20, 2000),
            "torque_rate_limit": rng.uniform(100, 10000),
            "period": PERIOD,
            "start_at_command": int(rng.integers(2)),
        },
        lambda rng: {
            "sigma_BO": mrp(rng),
            "sigma_RO": mrp(rng),
            "sigmaDot_RO": rng.normal(size=3),
            "omega_BN_B": rng.normal(size=3),
            "torque_disturbance_B_est": rng.normal(size=3),
        },
    ),
    "TuningFunctionObserver": (
        tuning,
        lambda rng: {
            "G": definite(rng),
            "limit": rng.uniform(0.2, 2),
            "margin": rng.uniform(0.1, 1),
            "period": PERIOD,
            "update_first": int(rng.integers(2)),
        },
        lambda rng: {"z_2_bar_B": rng.normal(size=3)},
    ),
    "ImmersionInvarianceObserver": (
        invariance,
        lambda rng: {
            "J0_B": inertia(rng),
            "gamma": rng.uniform(1, 50),
            "period": PERIOD,
            "update_first": int(rng.integers(2)),
        },
        lambda rng: {"omega_BN_B": rng.normal(size=3), "acceleration_expected_B": rng.normal(size=3)},
    ),
    "NonlinearExtendedStateObserver": (
        extended,
        lambda rng: {
            "J0_B": inertia(rng),
            "beta_1": definite(rng),
            "beta_2": definite(rng),
            "alpha_1": rng.uniform(0.1, 1),
            "alpha_2": rng.uniform(0.1, 1),
            "delta_1": rng.uniform(0.1, 1),
            "delta_2": rng.uniform(0.1, 1),
            "orbital_rate": rng.uniform(0, 0.5),
            "rate_limit": rng.uniform(0.5, 3),
            "rate_margin": rng.uniform(0.1, 1),
            "torque_limit": rng.uniform(0.5, 3),
            "torque_margin": rng.uniform(0.1, 1),
            "period": PERIOD,
            "torque_delay": int(rng.integers(2)),
        },
        lambda rng: {
            "sigma_BO": mrp(rng),
            "omega_BN_B": rng.normal(size=3),
            "torque_B": rng.normal(size=3),
        },
    ),
}


ORDER: dict[str, dict[str, int]] = {
    "TuningFunctionObserver": {"update_first": 1},
    "ImmersionInvarianceObserver": {"update_first": 1},
}


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", SAMPLED)
def test_sampled_laws_follow_their_recursion(name: str, version: int) -> None:
    """Five sets of parameters, six instants each: inputs set at an instant count, those set between do not."""
    step, draw, inputs = SAMPLED[name]
    rng = np.random.default_rng(list(name.encode()))
    for _ in range(5):
        p, memory = draw(rng), {}
        with Component(name, version, p, co_simulation=True) as component:
            for k in range(6):
                component.set(inputs(rng))  # tentative: what is set last at an instant counts
                component.get(component.names("output")[0])
                u = inputs(rng)
                component.set(u)
                expected = step(p, memory, u)
                assert set(expected) == set(component.names("output"))
                for when in ("at", "after"):
                    for variable, value in expected.items():
                        scale = max(1.0, float(np.abs(value).max()))
                        np.testing.assert_allclose(
                            component.get(variable), value, rtol=0, atol=2e-12 * scale, err_msg=f"{variable} {when} {k}"
                        )
                    if when == "at":
                        component.fmu.doStep(k * PERIOD, 0.5 * PERIOD)
                        component.set(inputs(rng))
                component.fmu.doStep((k + 0.5) * PERIOD, 0.5 * PERIOD)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", SAMPLED)
def test_directional_derivatives_of_a_sample(name: str, version: int) -> None:
    """At the third instant, where all memory is in use, by every input."""
    _, draw, inputs = SAMPLED[name]
    rng = np.random.default_rng(5)
    with Component(name, version, draw(rng), co_simulation=True) as component:
        for k in range(2):
            component.set(inputs(rng))
            component.fmu.doStep(k * PERIOD, PERIOD)
        point = inputs(rng)
        component.set(point)
        unknowns = component.names("output")
        for known, value in point.items():

            def evaluate(_: float, x: Array, known: str = known) -> Array:
                component.set({known: x})
                return np.concatenate([component.get(u).ravel() for u in unknowns])

            for direction in np.eye(3):
                analytic = component.directional(unknowns, known, direction)
                numeric = rate_along(evaluate, 0.0, np.asarray(value), direction, h=2e-4)
                component.set(point)
                scale = max(1.0, float(np.abs(numeric).max()))
                np.testing.assert_allclose(analytic / scale, numeric / scale, atol=2e-8, err_msg=f"by {known}")


@pytest.mark.parametrize("name", SAMPLED)
def test_declared_dependencies_are_those_of_a_sample(name: str) -> None:
    """What an output depends on at an instant, and nothing else: the order of one control step follows from it."""
    _, draw, inputs = SAMPLED[name]
    rng = np.random.default_rng(8)
    seen: dict[tuple[str, str], float] = {}
    for _ in range(3):
        with Component(name, 2, {**draw(rng), **ORDER.get(name, {})}, co_simulation=True) as component:
            for k in range(2):  # the first sample starts the memory, the second uses it
                component.set(inputs(rng))
                for output in component.names("output"):
                    for known in component.names("input"):
                        slopes = [component.directional([output], known, direction) for direction in np.eye(3)]
                        pair = (output, known)
                        seen[pair] = max(seen.get(pair, 0.0), float(np.abs(slopes).max()))
                component.fmu.doStep(k * PERIOD, PERIOD)
    declared = {
        (array_name(u.variable.name)[0], array_name(d.name)[0])
        for u in unpacked(name, 2)[1].outputs
        for d in u.dependencies
        if d.causality == "input"
    }
    assert {pair for pair, slope in seen.items() if slope > 1e-12} == declared
    if name == "BacksteppingControl":  # what an observer needs does not wait for its estimate
        assert ("torque_B", "torque_disturbance_B_est") in declared
        assert ("z_2_bar_B", "torque_disturbance_B_est") not in declared
        assert ("acceleration_expected_B", "torque_disturbance_B_est") not in declared
    if name == "NonlinearExtendedStateObserver":
        assert not any(output == "torque_disturbance_B_est" for output, _ in declared)


# --- the rest ---------------------------------------------------------------------------------------------------------


def test_beyond_180_degrees_the_plant_shows_the_shadow() -> None:
    """A body that turns about one axis: sigma = tan(theta/4) up to 180 degrees, then from -1 back up to 0."""
    system = System("turning")
    turning = {"J_B": np.eye(3), "J0_B": np.eye(3), "orbital_rate": 0.0, "omega_BN_B": [0, 0, 0.5]}
    system.add("plant", "OrbitingBody", {**turning, "torque_B": [0, 0, 0], "torque_disturbance_B": [0, 0, 0]})
    result = run(system, stop_time=14.0, step=0.1)
    theta = 0.5 * result.time
    expected = np.tan(np.where(theta > np.pi, theta - 2 * np.pi, theta) / 4)
    np.testing.assert_allclose(result["plant.sigma_BO"], np.column_stack([0 * theta, 0 * theta, expected]), atol=1e-12)
    assert theta[-1] > 2 * np.pi


@pytest.mark.parametrize(
    ("sigma_BO", "sigma_RO"),
    [([0.0, 0.0, 0.9], [0.0, 0.0, -0.9]), ([0.8, 0.3, -0.2], [-0.5, -0.6, 0.4]), ([0.7, 0.7, 0.0], [-0.7, -0.7, 0.1])],
)
def test_the_law_takes_the_shorter_way(sigma_BO: list[float], sigma_RO: list[float]) -> None:
    """The error is that of the relative rotation within 180 degrees, whichever MRP is given."""
    between = Rotation.from_mrp(sigma_BO).inv() * Rotation.from_mrp(sigma_RO)
    with Component("BacksteppingControl", 2, co_simulation=True) as law:
        law.set({"sigma_BO": sigma_BO, "sigma_RO": sigma_RO})
        np.testing.assert_allclose(law.get("sigma_RB"), between.as_mrp(), atol=1e-13)


def test_sampled_sources_hold_what_they_computed() -> None:
    """With a period the torque is that of the last instant; without, that of now."""
    rng = np.random.default_rng(9)
    for name in ("SpinningWheel", "OscillatingPayload", "InertiaMismatch"):
        start = {"J_B": inertia(rng)} if name == "InertiaMismatch" else {}
        values = [{"omega_BN_B": rng.normal(size=3)} for _ in range(2)]
        with (
            Component(name, 2, {**start, "period": 0.5}, co_simulation=True) as held,
            Component(name, 2, start, co_simulation=True) as now,
        ):
            for component in (held, now):
                component.set(values[0])
            first = now.get("torque_B")
            np.testing.assert_array_equal(held.get("torque_B"), first)
            for component in (held, now):
                component.fmu.doStep(0.0, 0.3)
                component.set(values[1])
            np.testing.assert_array_equal(held.get("torque_B"), first)
            assert np.abs(now.get("torque_B") - first).max() > 1e-3 * np.abs(first).max()
            for component in (held, now):
                component.fmu.doStep(0.3, 0.2)
            np.testing.assert_array_equal(held.get("torque_B"), now.get("torque_B"))


def test_sampled_guidance_lags_and_differentiates_as_asked() -> None:
    """(D.6) by hand: the filter at each sample, the reference of `lag` periods ago, and either rate."""
    start = {"slew_start": 0.3, "slew_rate": 0.4, "angle": 0.5, "time_constant": 0.7, "scan_start": 2.0}
    for lag in (0, 1):
        system = System("guidance")
        for name, difference in (("difference", 1), ("analytic", 0)):
            sampled = {"period": 0.1, "lag": lag, "difference": difference, "scan_period": 3.0}
            system.add(name, "ScanningReference", {**start, **sampled})
        result = run(system, stop_time=3.0, step=0.1)
        theta, expected, slope = 0.0, [], []
        for k in range(31):
            t = 0.1 * (k - lag)
            u = float(np.clip(0.4 * (t - 0.3), 0, 0.5))
            theta = (0.7 * theta + 0.1 * u) / 0.8
            expected.append(0.5 * np.cos(2 * np.pi / 3 * (t - 2)) if t > 1.9999 else theta)
            slope.append(-np.pi / 3 * np.sin(2 * np.pi / 3 * (t - 2)) if t > 1.9999 else (u - theta) / 0.7)
        for name in ("difference", "analytic"):
            np.testing.assert_allclose(result[f"{name}.theta"], expected, atol=1e-13)
        sigma = result["difference.sigma_RO"]
        np.testing.assert_allclose(np.linalg.norm(sigma, axis=1), np.tan(np.abs(expected) / 4), atol=1e-13)
        rate = np.vstack([np.zeros(3), np.diff(sigma, axis=0) / 0.1])
        np.testing.assert_allclose(result["difference.sigmaDot_RO"], rate, atol=1e-12)
        along = result["analytic.sigmaDot_RO"] @ (np.array([-1, 1, 0.5]) / 1.5)
        np.testing.assert_allclose(along, np.array(slope) / np.cos(np.array(expected) / 4) ** 2 / 4, atol=1e-12)


def measured(seed: int, version: int = 2) -> tuple[Array, Array]:
    """Attitude errors [rad] and rate errors [rad/s] of 2000 samples, a draw each."""
    true = np.array([0.3, -0.2, 0.5])
    system = System("sensor")
    noise = {"attitude_noise": 2e-3, "rate_noise": 5e-4, "period": 0.1, "seed": seed}
    system.add("sensor", "AttitudeRateSensor", {**noise, "sigma_BO": true, "omega_BN_B": [0.1, 0.2, 0.3]})
    result = run(system, stop_time=199.9, step=0.1, fmi_version=f"{version}.0")
    turn = Rotation.from_mrp(true).inv() * Rotation.from_mrp(result["sensor.sigma_BO_meas"])
    return turn.as_rotvec(), result["sensor.omega_BN_B_meas"] - [0.1, 0.2, 0.3]


def test_sensor_noise_is_gaussian_of_the_size_asked_for() -> None:
    attitude, rate = measured(1)
    for values, size in ((attitude, 2e-3), (rate, 5e-4)):
        for axis in range(3):
            assert kstest(values[:, axis] / size, "norm").pvalue > 0.01
    together = np.column_stack([attitude, rate])
    correlation = np.corrcoef(together.T) - np.eye(6)
    assert np.abs(correlation).max() < 4 / np.sqrt(len(together))
    for column in together.T:
        assert abs(np.corrcoef(column[:-1], column[1:])[0, 1]) < 4 / np.sqrt(len(together))


def test_sensor_draws_depend_on_the_seed_alone() -> None:
    first, other = measured(1), measured(2)
    for a, b in zip(first, measured(1, 3), strict=True):
        np.testing.assert_array_equal(a, b)
    assert abs(np.corrcoef(first[0][:, 0], other[0][:, 0])[0, 1]) < 4 / np.sqrt(2000)


BAD = [
    ("BacksteppingControl", {"c_1": np.diag([0.1, -0.1, 0.1])}, "is not positive definite: a symmetric matrix"),
    (
        "BacksteppingControl",
        {"c_2": np.array([[1, 0.5, 0], [0, 1, 0], [0, 0, 1]])},
        "c_2 = [1 0.5 0; 0 1 0; 0 0 1] is not positive definite",
    ),
    ("BacksteppingControl", {"K": -np.eye(3)}, "K = [-1 -0 -0; -0 -1 -0; -0 -0 -1] is not positive semidefinite"),
    ("BacksteppingControl", {"torque_limit": 0.0}, "torque_limit"),
    ("BacksteppingControl", {"rate_limit": -1.0}, "rate_limit"),
    ("BacksteppingControl", {"acceleration_limit": 0.0}, "acceleration_limit"),
    ("BacksteppingControl", {"period": 0.0}, "period"),
    ("BacksteppingControl", {"sigma_BO": [0.0, 1.4, 0.0]}, "sigma_BO"),
    ("BacksteppingControl", {"sigma_RO": [0.0, 0.0, -1.2]}, "sigma_RO"),
    ("BacksteppingControl", {"J0_B": np.diag([1.0, 1.0, 3.0])}, "J0_B"),
    ("TuningFunctionObserver", {"G": np.zeros((3, 3))}, "G = [0 0 0; 0 0 0; 0 0 0] is not positive definite"),
    (
        "NonlinearExtendedStateObserver",
        {"beta_1": -np.eye(3)},
        "beta_1 = [-1 -0 -0; -0 -1 -0; -0 -0 -1] is not positive definite",
    ),
    ("NonlinearExtendedStateObserver", {"beta_2": np.zeros((3, 3))}, "beta_2 has no positive determinant"),
    ("ImmersionInvarianceObserver", {"gamma": 0.0}, "gamma"),
    ("ScanningReference", {"lag": 1}, "lag and difference belong to a sampled reference"),
    ("ScanningReference", {"angle": 3.5}, "angle"),
    ("ScanningReference", {"axis": [0.0, 0.0, 0.0]}, "axis is"),
    ("SpinningWheel", {"axis": [0.0, 0.0, 0.0]}, "axis is"),
    ("OscillatingPayload", {"J_A": [1e-5, 0.0, 1e-5]}, "J_A[2] = 0 refused: must be above 0"),
    ("AttitudeRateSensor", {"attitude_noise": 1e-3}, "attitude_noise or rate_noise is above 0, but period is 0"),
    ("AttitudeRateSensor", {"sigma_BO": [1.1, 0.0, 0.0]}, "sigma_BO"),
    ("OrbitingBody", {"q_BO": [0.0, 0.0, 0.0, 0.0]}, "q_BO"),
]


@pytest.mark.parametrize(("name", "start", "message"), BAD)
def test_what_makes_no_sense_is_refused_by_name(name: str, start: dict[str, Any], message: str) -> None:
    system = System("bad")
    inputs = {
        "BacksteppingControl": ("sigma_BO", "sigma_RO", "sigmaDot_RO", "omega_BN_B", "torque_disturbance_B_est"),
        "TuningFunctionObserver": ("z_2_bar_B",),
        "NonlinearExtendedStateObserver": ("sigma_BO", "omega_BN_B", "torque_B"),
        "ImmersionInvarianceObserver": ("omega_BN_B", "acceleration_expected_B"),
        "SpinningWheel": ("omega_BN_B",),
        "OscillatingPayload": ("sigma_BO", "omega_BN_B", "torque_control_B"),
        "AttitudeRateSensor": ("sigma_BO", "omega_BN_B"),
        "OrbitingBody": ("torque_B", "torque_disturbance_B"),
    }.get(name, ())
    system.add("it", name, {**{i: [0, 0, 0] for i in inputs}, **start})
    with pytest.raises(CallFailed) as error:
        run(system, stop_time=1.0, step=0.1)
    assert message in str(error.value)
    assert "\n" not in str(error.value)
