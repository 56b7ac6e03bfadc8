"""The components of the six-degree-of-freedom loop against the recomputation, the loop against its identity (54)."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from adcs import AdcsError, CoupledModel, ModelExchange, System, run
from adcs.library.six_dof import systems
from adcs.library.six_dof.settings import Start
from orchestration.instances.instance import CallFailed
from references import six_dof as ref
from references import velocity_free as orbit
from references.answers.six_dof import place
from references.law import inertia, quaternion
from references.observer_pd import Array, kinematics, rate_along, rotation, skew
from references.six_dof import Loop, S
from references.velocity_free import E

from .at_points import POINTS, opened


def test_gravity_of_the_extended_body_is_that_of_point_masses() -> None:
    """Force and torque of Eqs. (1), (11) against four point masses of the same inertia, summed without expansion.

    The body is made 100 km large: what the expansion leaves out is then 1 % of the gradient terms, far above rounding.
    """
    rng = np.random.default_rng(3)
    mu, R = 3.986e14, np.array([5e6, -4e6, 3e6])
    for _ in range(5):
        offsets = rng.normal(size=(4, 3)) * 1e5
        masses = rng.uniform(1, 5, 4)
        offsets -= masses @ offsets / masses.sum()
        J = sum(m * (x @ x * np.eye(3) - np.outer(x, x)) for m, x in zip(masses, offsets, strict=True))
        force, torque = ref.point_mass_wrench(mu, R, offsets, masses)
        extra = force + mu * masses.sum() * R / np.linalg.norm(R) ** 3
        p = {"mass": masses.sum(), "J_B": J, "mu": mu, "r_BN_N": R, "v_BN_N": np.zeros(3), "q_BN": np.eye(4)[0]}
        ours = ref.plant_rates(p | {"omega_BN_B": np.zeros(3), "force_B": np.zeros(3), "torque_B": np.zeros(3)})
        np.testing.assert_allclose(ours["f_d"], extra, rtol=0, atol=0.15 * np.linalg.norm(extra))
        np.testing.assert_allclose(ours["tau_g"], torque, rtol=0, atol=0.15 * np.linalg.norm(torque))
        assert ours["f_d"] @ extra > 0.98 * np.linalg.norm(extra) * np.linalg.norm(ours["f_d"])


# --- the closed loop --------------------------------------------------------------------------------------------------

TIMES = np.linspace(0, 5, 26)  # in units of 20 s
STOP = 100.0


@pytest.fixture(scope="module")
def expected() -> Array:
    return Loop().run(TIMES)


@pytest.mark.parametrize("fmi_version", ["2.0", "3.0"])
def test_coupled_loop_follows_the_recomputed_error_dynamics(expected: Array, fmi_version: Any) -> None:
    """To 1e-8 of the sizes of the errors at the start: 27 m, 12 N; attitudes and rates (0.1 rad/s) absolutely."""
    tight: dict[str, Any] = {"fmi_version": fmi_version, "method": ModelExchange(rtol=1e-11, atol=1e-10)}
    result = run(systems.six_dof(), stop_time=STOP, step=4.0, **tight)
    e_R, q_e, omega = expected[:, :3], expected[:, 6:10], expected[:, 10:13]
    assert np.abs(result["controller.r_RB_B"] - e_R).max() < 1e-8 * 27
    assert np.abs(result["controller.q_BR"] - q_e).max() < 1e-8
    turns = [rotation(q).as_matrix().T @ ref.reference_rate(t)[0] for t, q in zip(result.time, q_e, strict=True)]
    assert np.abs(result["plant.omega_BN_B"] - omega / S["time"] - turns).max() < 1e-9
    assert np.abs(np.hstack([result["filter.p_R"], result["filter.p_eps"]]) - expected[:, 13:19]).max() < 1e-8 * 81
    loop = Loop()
    for tau, z, force, torque in zip(
        TIMES, expected, result["controller.force_B"], result["controller.torque_B"], strict=True
    ):
        s, e_f = loop.surroundings(tau, z), loop.auxiliary(z)[0]
        f, t = loop.law.control(s["R"], s["R_d"], z[6:10], s["w"], s["w_dot"], e_f)
        assert np.abs(force - f * S["force"]).max() < 1e-8 * 12
        assert np.abs(torque - t * S["torque"]).max() < 1e-8


def error_state(values: Mapping[str, Array], time: float) -> tuple[Array, Array]:
    """z of the reference's error dynamics, and its rate per unit of scaled time, from the FMUs' states and rates."""
    x, r = {n: v[0] for n, v in values.items()}, {n: v[1] for n, v in values.items()}
    q, q_r = x["plant.q_BN"], x["guidance.q_RN"]
    turn, omega_b = rotation(q).inv(), x["plant.omega_BN_B"]
    R_d, V_d = orbit.kepler(ref.ORBIT | {"time": time})
    e_R, e_V = turn.apply(R_d - x["plant.r_BN_N"]), turn.apply(V_d - x["plant.v_BN_N"])
    pull = -ref.BODY["mu"] * R_d / np.linalg.norm(R_d) ** 3  # type: ignore[operator]
    e_R_dot = e_V - np.cross(omega_b, e_R)
    e_V_dot = turn.apply(pull - r["plant.v_BN_N"]) - np.cross(omega_b, e_V)
    q_e = orbit.G(q_r).T @ q
    q_e_dot = orbit.G(q_r).T @ r["plant.q_BN"] + orbit.G(r["guidance.q_RN"]).T @ q
    omega_d, omega_d_dot = ref.reference_rate(time)
    w = rotation(q_e).as_matrix().T @ omega_d
    omega = omega_b - w
    omega_dot = r["plant.omega_BN_B"] + np.cross(omega, w) - rotation(q_e).as_matrix().T @ omega_d_dot
    T = S["time"]
    p, p_dot = (np.concatenate([y["filter.p_R"], y["filter.p_eps"]]) for y in (x, r))
    z = np.concatenate([e_R, e_V * T, q_e, omega * T, p, q_r])
    rate = T * np.concatenate([e_R_dot, e_V_dot * T, q_e_dot, omega_dot * T, p_dot, r["guidance.q_RN"]])
    return z, rate


def along_the_loop(system: System, times: Array) -> list[tuple[float, Array, Array]]:
    """Scaled time, z and its rate along the FMUs' own trajectory."""
    names = (
        "plant.r_BN_N",
        "plant.v_BN_N",
        "plant.q_BN",
        "plant.omega_BN_B",
        "guidance.q_RN",
        "filter.p_R",
        "filter.p_eps",
    )
    with CoupledModel(system) as model:
        places = {n: [i for i, s in enumerate(model.state_names) if s.split("[")[0] == n] for n in names}
        x = solve_ivp(model.rhs, times[[0, -1]], model.x0, "DOP853", times, rtol=1e-11, atol=1e-10).y.T
        rows = []
        for t, row in zip(times, x, strict=True):
            slope = model.rhs(t, row)
            rows.append((t / S["time"], *error_state({n: (row[i], slope[i]) for n, i in places.items()}, t)))  # type: ignore[misc]
        return rows


def test_the_identity_54_holds_along_the_trajectory() -> None:
    """V' by the FMUs' own derivatives less the right-hand side of (54), both in scaled units.

    V' starts at -8900 and ends at -0.02: to 1e-8 of |V'|, and of 1 where it is smaller.
    """
    loop = Loop()
    for tau, z, slope in along_the_loop(systems.six_dof(), np.linspace(0, STOP, 26)):
        rate = float(rate_along(lambda _, y: np.array(loop.lyapunov(y)), tau, z, slope, h=1e-3))
        exact = loop.lyapunov_rate(tau, z)
        assert abs(rate - exact) < 1e-8 * max(1.0, abs(exact))


def test_V_falls_to_nothing(expected: Array) -> None:
    """(50) from 2582 to 0.0092 in five units of time."""
    values = [Loop().lyapunov(z) for z in expected]
    assert values[0] == pytest.approx(2581.768, rel=1e-6)
    assert values[-1] < 1e-2
    assert all(later < earlier for earlier, later in pairwise(values))


MUTANTS: dict[str, dict[str, Any]] = {
    "force f instead of -f": {"force_sign": 1.0},
    "P from the determinant e_zeta": {"inverse_of_T": lambda q: np.linalg.inv(ref.T_of(q)) / 8},
    "skew matrix transposed": {"inverse_of_T": lambda q: np.linalg.inv(ref.T_of(q).T)},
    "Omega_2 with the other sign": {"omega_2_sign": -1.0},
    "Omega_2 left out": {"omega_2_sign": 0.0},
    "filter without Gamma": {"filter_gamma": 0.0},
    "gyroscopic term with the other sign": {"gyro_sign": 1.0},
    "e_f for 2 e_f": {"damping": 1.0},
    "P for its transpose in front of the torque": {"transposed": False},
    "k 0.1 % off": {"k": 3.003},
    "k_0 0.1 % off": {"k_0": 2.002},
    "k_1 0.1 % off": {"k_1": 1.5015},
    "mass 0.1 % off": {"m": 100.1 / 20},
}


@pytest.mark.parametrize("name", MUTANTS)
def test_mutants_break_the_identity(expected: Array, name: str) -> None:
    """With one mistake in the law and the body as it is, far beyond 1e-8.

    On states of the trajectory, and on the same with the translation a thousand times smaller: (54) holds for any
    state, and there the attitude counts.
    """
    right = Loop()
    wrong = Loop(replace(right.law, **MUTANTS[name]))
    largest = 0.0
    smaller = np.ones(23)
    smaller[:6] = smaller[13:16] = 1e-3
    states = [
        (tau, z * factor) for tau, z in zip(TIMES[:10:3], expected[:10:3], strict=True) for factor in (1, smaller)
    ]
    for tau, z in states:
        slope = wrong.rates(tau, z, right.law)
        rate = float(rate_along(lambda _, y: np.array(right.lyapunov(y)), tau, z, slope, h=1e-3))
        exact = right.lyapunov_rate(tau, z)
        largest = max(largest, abs(rate - exact) / max(1.0, abs(exact)))
    assert largest > 1e-6, f"{name}: {largest:.1e}"


def test_the_law_feeds_forward_what_gravity_does_to_the_extended_body() -> None:
    """Without any error its command is the opposite of the plant's own output: lost in the loop, but not here."""
    rng = np.random.default_rng(12)
    for _ in range(5):
        r, q, J = place(rng), quaternion(rng), inertia(rng)
        still = {"omega_RN_R": np.zeros(3), "omegaDot_RN_R": np.zeros(3), "e_f_R": np.zeros(3), "e_f_eps": np.zeros(3)}
        same = {"r_BN_N": r, "r_RN_N": r, "q_BN": q, "q_RN": q, "J_B": J, "mu": np.array(3.986e14)}
        body = {
            "J_B": J,
            "mu": np.array(3.986e14),
            "r_BN_N": r,
            "v_BN_N": np.zeros(3),
            "q_BN": q,
            "omega_BN_B": np.zeros(3),
        }
        with opened("SixDofOutputFeedback", 2, same | still) as law, opened("SixDofBody", 2, body) as plant:
            for command, effect in (("force_B", "gravity_gradient_force_B"), ("torque_B", "gravity_gradient_torque_B")):
                felt = plant.get(effect)
                np.testing.assert_allclose(law.get(command), -felt, rtol=0, atol=1e-11 * np.linalg.norm(felt))


# --- what is wrong in print -------------------------------------------------------------------------------------------


def test_the_determinant_of_T_is_an_eighth_of_e_zeta_and_its_inverse_is_what_the_header_says() -> None:
    """In print det T = e_zeta."""
    rng = np.random.default_rng(9)
    for _ in range(POINTS):
        q = quaternion(rng)
        T = ref.T_of(q)
        assert np.linalg.det(T) == pytest.approx(q[0] / 8, rel=1e-12)
        inverse = 2 / q[0] * (q[0] ** 2 * np.eye(3) + np.outer(q[1:], q[1:]) - q[0] * skew(q[1:]))
        np.testing.assert_allclose(T @ inverse, np.eye(3), atol=1e-12 / abs(q[0]))
        omega = rng.normal(size=3)
        np.testing.assert_allclose(T @ omega, (E(q) @ omega / 2)[1:], atol=1e-15)  # (30)
        np.testing.assert_allclose(kinematics(q, omega)[1:], T @ omega, atol=1e-15)


def test_the_skew_matrix_of_the_vectrices() -> None:
    """Sec. II has F x F^T = [0 k -j; -k 0 i; j -i 0], hence A^x = [0 -a3 a2; a3 0 -a1; -a2 a1 0], as (29) uses it."""
    rng = np.random.default_rng(10)
    a, b = rng.normal(size=(2, 3))
    i, j, k = np.eye(3)
    products = [[0 * i, k, -j], [-k, 0 * i, i], [j, -i, 0 * i]]
    cross = sum(a[m] * b[n] * products[m][n] for m in range(3) for n in range(3))
    np.testing.assert_allclose(cross, skew(a) @ b, atol=1e-15)
    np.testing.assert_allclose(2 * ref.T_of(np.append(0, a)), [[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def test_the_gain_condition_needs_the_smaller_of_the_two_gains() -> None:
    """After (56): V' <= -(1 - rho_1^2/(4 k_y) - rho_2^2/(4 k_eR)) |x|^2. With the maximum of the two, as printed, the
    condition k_max >= (rho_1^2 + rho_2^2)/4 holds where the bracket is negative; with the minimum it never does."""
    rng = np.random.default_rng(11)
    spoilt = 0
    for _ in range(2000):
        rho_1, rho_2, k_y, k_eR = rng.uniform(0.1, 3, 4)
        bracket = 1 - rho_1**2 / (4 * k_y) - rho_2**2 / (4 * k_eR)
        need = (rho_1**2 + rho_2**2) / 4
        spoilt += max(k_y, k_eR) >= need and bracket < 0
        if min(k_y, k_eR) >= need:
            assert bracket >= 0
    assert spoilt > 100


def test_the_force_on_the_spacecraft_is_minus_f() -> None:
    """(1): m V' = f_e + f_d - f; (10): e_V' = ... + f/m. A craft behind its reference is pushed forward."""
    system = systems.six_dof(Start(offset_N=(0.0, -10.0, 0.0), drift_N=(0, 0, 0), angle=0.0, omega_BN_B=(0, 0, 0)))
    result = run(system, stop_time=1.0, step=1.0)
    np.testing.assert_allclose(result["controller.r_RB_B"][0], [0, 10, 0], atol=1e-8)
    assert result["controller.force_B"][0] @ [0, 1, 0] > 1.0


# --- bad input --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ({"angle": np.pi}, r"attitude error of 180 deg: e_zeta\(0\) = 0, where the law does not exist"),
        ({"offset_N": (-6.0e6, 0.0, 0.0)}, "the spacecraft would start inside the Earth"),
        ({"mass": 0.0}, "mass = 0 kg: expected a positive number"),
        ({"mass": -5.0}, "mass = -5 kg: expected a positive number"),
        ({"axis": (0.0, 0.0, 0.0)}, "expected a direction"),
    ],
)
def test_a_start_that_makes_no_sense_is_refused_in_one_line(start: dict[str, Any], message: str) -> None:
    with pytest.raises(AdcsError, match=message) as error:
        Start(**start)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("variable", "value", "message"),
    [
        ("plant.mass", 0.0, "mass"),
        ("controller.mass", -1.0, "mass"),
        ("plant.r_BN_N", [6.0e6, 0.0, 0.0], "r_BN_N lies inside the Earth, within earth_radius"),
        ("filter.p_eps", [0.0, 3.0, 0.0], r"e_zeta\(0\) = 0, where the law does not exist"),
        ("filter.k_1", 1.0, "k_1"),
        ("orbit.eccentricity", 0.2, "the orbit meets the Earth"),
        ("actuator.max_force", -1.0, "max_force"),
    ],
)
def test_the_components_refuse_by_name(variable: str, value: Any, message: str) -> None:
    system = systems.six_dof()
    system.set(variable, value)
    with pytest.raises(CallFailed, match=message) as failure:
        run(system, stop_time=1.0, step=0.1)
    assert "\n" not in str(failure.value)


def test_a_body_that_falls_into_the_earth_stops_the_run_by_name() -> None:
    system = System("falling")
    start = {"r_BN_N": [6.38e6, 0, 0], "v_BN_N": [-1e3, 0, 0], "force_B": [0, 0, 0], "torque_B": [0, 0, 0]}
    system.add("plant", "SixDofBody", start)
    with pytest.raises(AdcsError, match=r"output altitude is -?nan"):
        run(system, stop_time=10.0, step=0.1)
