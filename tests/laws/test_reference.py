"""The recomputation itself: geometry against printed formulas, Lyapunov identities, and what a wrong sign breaks."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from references import observer_pd as ref
from references.observer_pd import Array, Loop, Settings, error, kinematics, rate_along, rotation, skew

SETTINGS = Settings()
J = SETTINGS.inertia


def random_quaternions(rng: np.random.Generator, n: int) -> Array:
    q = rng.normal(size=(n, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def printed_dcm(q: Array) -> Array:
    return (q[0] ** 2 - q[1:] @ q[1:]) * np.eye(3) + 2 * np.outer(q[1:], q[1:]) - 2 * q[0] * skew(q[1:])


def identity_residual(loop: Loop, run: dict[str, Array], every: int = 10) -> Array:
    """d/dt of V along the loop's own flow, at states of ``run``, less what the proofs say; one row per instant."""
    return np.array(
        [
            rate_along(loop.lyapunov, t, x, loop.rates(t, x)) - loop.lyapunov_rates(loop.signals(t, x))
            for t, x in zip(run["time"][::every], run["x"][::every], strict=True)
        ]
    )


def test_rotation_is_the_printed_matrix_and_turns_with_the_kinematics() -> None:
    rng = np.random.default_rng(1)
    for q, omega in zip(random_quaternions(rng, 50), rng.normal(size=(50, 3)), strict=True):
        c = rotation(q).as_matrix().T
        np.testing.assert_allclose(c, printed_dcm(q), atol=1e-14)
        c_dot = rate_along(lambda _, x: rotation(x).as_matrix().T, 0.0, q, kinematics(q, omega))
        np.testing.assert_allclose(c_dot, -skew(omega) @ c, atol=1e-11)


def test_error_quaternion_is_the_printed_product() -> None:
    rng = np.random.default_rng(2)
    for q, q_hat in zip(random_quaternions(rng, 50), random_quaternions(rng, 50), strict=True):
        c_t, q_t = error(q, q_hat)
        np.testing.assert_allclose(c_t, printed_dcm(q) @ printed_dcm(q_hat).T, atol=1e-14)
        vector = -q[0] * q_hat[1:] - skew(q_hat[1:]) @ q[1:] + q_hat[0] * q[1:]  # (5.8)
        np.testing.assert_allclose(q_t, [q_hat @ q, *vector], atol=1e-14)


def test_error_quaternion_is_continuous_through_180_degrees() -> None:
    angles = np.linspace(0, 4 * np.pi, 401)
    q_r = np.array([0.5, -0.5, 0.5, 0.5])
    q = [SETTINGS.reference.attitude(a / np.sqrt(3)) for a in angles]
    q_e = np.array([error(x, q_r)[1] for x in q])
    assert np.abs(np.diff(q_e, axis=0)).max() < 0.02
    np.testing.assert_allclose(q_e[-1], q_e[0], atol=1e-13)


def test_profile() -> None:
    r = SETTINGS.reference
    assert r.rate(0.0) == 0
    # The value at 10 s by hand: e^-1 = 0.36788, cos 10 = -0.83907, sin 10 = -0.54402.
    assert r.rate(10.0).real == pytest.approx(-0.083907 * 0.632121 + (0.251327 - 0.003264) * 3.678794, abs=1e-5)
    assert r.rate(100.0).real == pytest.approx(0.1 * np.cos(100.0), abs=1e-15), "bounded: the exponent is negative"
    for t in (0.0, 3.0, 10.0, 50.0):
        slope = rate_along(lambda s, _: r.omega(s), t, np.zeros(1), np.zeros(1))
        np.testing.assert_allclose(r.omega_dot(t), slope, atol=1e-11)


def test_reference_attitude_is_the_fixed_axis_rotation(runs: dict[bool, dict[str, Array]]) -> None:
    r, run = SETTINGS.reference, runs[False]
    for k in (0, 100, 500, 1000):
        angle = quad(lambda t: r.rate(t).real, 0, run["time"][k], epsabs=1e-13, epsrel=1e-13, limit=500)[0]
        np.testing.assert_allclose(run["q_r"][k], r.attitude(angle), atol=1e-11)


@pytest.mark.parametrize("with_observer", [False, True])
def test_lyapunov_identities_along_the_run(runs: dict[bool, dict[str, Array]], with_observer: bool) -> None:
    loop, run = Loop(with_observer), runs[with_observer]
    residual = identity_residual(loop, run)
    assert np.abs(residual).max() < 1e-11
    values = np.array([loop.lyapunov(t, x) for t, x in zip(run["time"], run["x"], strict=True)])
    np.testing.assert_allclose(values - values[0], run["lyapunov_integrals"], atol=1e-11)


@pytest.mark.parametrize("with_observer", [False, True])
def test_quaternions_stay_unit(runs: dict[bool, dict[str, Array]], with_observer: bool) -> None:
    run = runs[with_observer]
    for name in ("q", "q_r", "q_hat") if with_observer else ("q", "q_r"):
        np.testing.assert_allclose(np.linalg.norm(run[name], axis=1), 1, atol=1e-12)


def test_torque_free_body_keeps_momentum_and_energy() -> None:
    start = np.array([1.0, 0, 0, 0, 0.3, -0.2, 0.5])

    def flow(_: float, x: Array) -> Array:
        return np.concatenate([kinematics(x[:4], x[4:]), ref.body_acceleration(J, x[4:], np.zeros(3))])

    end = solve_ivp(flow, (0, 30), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    np.testing.assert_allclose(rotation(end[:4]).apply(J @ end[4:]), J @ start[4:], atol=1e-9)
    assert end[4:] @ J @ end[4:] == pytest.approx(start[4:] @ J @ start[4:], abs=1e-9)
    assert np.abs(end[4:] - start[4:]).max() > 0.1, "the body must tumble for this to mean something"


def error_dynamics(t: float, z: Array, coriolis_sign: float = 1.0) -> Array:
    """The loop in the error coordinates of the proofs, (2.12)-(2.13) with (5.27), (5.14), (5.18): z = [q_e, omega_e,
    q_t, omega_t]. The torque does not enter the estimation error: the separation property."""
    s = SETTINGS
    q_e, omega_e, q_t, omega_t = z[:4], z[4:7], z[7:11], z[11:14]
    c_e = rotation(q_e).as_matrix().T
    omega_r_b, c_e_wr_dot = c_e @ s.reference.omega(t), c_e @ s.reference.omega_dot(t)
    omega = omega_e + omega_r_b
    omega_b = omega - omega_t
    torque = -s.k_p * q_e[1:] - s.k_v * (omega_b - omega_r_b) + J @ c_e_wr_dot + skew(omega_r_b) @ J @ omega_r_b
    coriolis = J @ (coriolis_sign * skew(omega_e) @ omega_r_b - c_e_wr_dot)
    estimation = J @ skew(omega_t) @ omega_b - s.gamma * q_t[1:] + skew(omega_b) @ J @ omega_b
    return np.concatenate(
        [
            kinematics(q_e, omega_e),
            np.linalg.solve(J, -skew(omega) @ J @ omega + torque + coriolis),
            kinematics(q_t, omega_t - s.lam * q_t[1:]),
            np.linalg.solve(J, -skew(omega) @ J @ omega + estimation),
        ]
    )


@pytest.mark.parametrize(("coriolis_sign", "deviation"), [(1.0, 0.0), (-1.0, 0.1516)])
def test_error_coordinates_tell_the_same_story(
    runs: dict[bool, dict[str, Array]], coriolis_sign: float, deviation: float
) -> None:
    """Two derivations that share no state; with S(omega_e) omega_r flipped in (2.13) they part by ``deviation``."""
    run = {name: runs[True][name][:301] for name in ("time", "q_e", "omega_e", "q_t", "omega_t")}
    times = run.pop("time")
    expected = np.hstack(list(run.values()))
    flow = partial(error_dynamics, coriolis_sign=coriolis_sign)
    z = solve_ivp(flow, (0, 30), expected[0], "DOP853", times, rtol=1e-12, atol=1e-13).y.T
    assert np.abs(z - expected).max() == pytest.approx(deviation, abs=1e-10, rel=0.02)


def wrong_control(
    turned: bool = False,
    frame: Callable[[Array, Array], Array] = lambda c_e, q_r: c_e,
    feed: float = 1,
    gyro: float = 1,
) -> Callable[..., Array]:
    """(5.1) with the error quaternion transposed, C(q_e) replaced, or the two feedforward terms scaled."""

    def law(
        inertia: Array, k_p: float, k_v: float, q: Array, omega: Array, q_r: Array, omega_r: Array, omega_r_dot: Array
    ) -> Array:
        c_e, q_e = error(q, q_r)
        c = frame(c_e, q_r)
        omega_r_b, q_ev = c @ omega_r, -q_e[1:] if turned else q_e[1:]
        feedback = -k_p * q_ev - k_v * (omega - omega_r_b)
        return feedback + feed * inertia @ c @ omega_r_dot + gyro * skew(omega_r_b) @ inertia @ omega_r_b

    return law


def wrong_observer(
    term: float = 1,
    gyro: float = 1,
    push: float = 1,
    turned: bool = False,
    inward: Callable[[Array], Array] = np.asarray,
    outward: Callable[[Array], Array] = np.transpose,
    correction: Callable[[Array], Array] = np.transpose,
) -> Callable[..., tuple[Array, Array]]:
    """(5.11)-(5.12) with the lambda-term, gyroscopic term or torque scaled, the error or a C(q_t) transposed."""

    def law(
        inertia: Array, lam: float, gamma: float, q: Array, torque: Array, q_hat: Array, omega_hat: Array
    ) -> tuple[Array, Array]:
        c_t, q_t = error(q, q_hat)
        q_tv = -q_t[1:] if turned else q_t[1:]
        omega_b = inward(c_t) @ omega_hat
        moment = gamma * q_tv - gyro * skew(omega_b) @ inertia @ omega_b + push * torque
        moment -= term * lam * inertia @ skew(q_tv) @ omega_b
        return (
            kinematics(q_hat, omega_hat + lam * correction(c_t) @ q_tv),
            outward(c_t) @ np.linalg.solve(inertia, moment),
        )

    return law


@pytest.mark.parametrize(
    ("law", "breaks_control"),
    [
        pytest.param(wrong_control(), 0, id="as printed"),
        pytest.param(wrong_control(turned=True), 0.07025, id="error quaternion transposed"),
        pytest.param(wrong_control(frame=lambda _, q_r: rotation(q_r).as_matrix().T), 0.4402, id="C(q_r) for C(q_e)"),
        pytest.param(wrong_control(frame=lambda c_e, _: c_e.T), 0.7752, id="C(q_e) transposed"),
        pytest.param(wrong_control(gyro=-1), 0.7918, id="S(omega_r) J omega_r flipped"),
        pytest.param(wrong_control(feed=0), 0.5077, id="no J C omega_r_dot"),
    ],
)
def test_wrong_controller_breaks_its_identity(
    runs: dict[bool, dict[str, Array]], law: Callable[..., Array], breaks_control: float
) -> None:
    control, observer = np.abs(identity_residual(Loop(True, control=law), runs[True], 25)).max(axis=0)
    assert control == pytest.approx(breaks_control, rel=0.01, abs=1e-11)
    assert observer < 1e-11, "separation: the observer's identity holds under any torque"


@pytest.mark.parametrize(
    ("law", "breaks_observer"),
    [
        pytest.param(wrong_observer(), 0, id="as printed"),
        pytest.param(
            wrong_observer(correction=np.asarray), 0, id="C(q_t) for its transpose in (5.11): q_tv is its axis"
        ),
        pytest.param(wrong_observer(term=0), 0.00999, id="lambda-term missing in (5.12)"),
        pytest.param(wrong_observer(term=-1), 0.01998, id="lambda-term flipped in (5.12)"),
        pytest.param(wrong_observer(turned=True), 0.00635, id="error quaternion transposed"),
        pytest.param(wrong_observer(gyro=-1), 0.4103, id="gyroscopic term flipped"),
        pytest.param(wrong_observer(push=-1), 0.5808, id="torque flipped"),
        pytest.param(wrong_observer(inward=np.transpose), 0.04435, id="C(q_t) transposed in omega_B"),
        pytest.param(wrong_observer(outward=np.asarray), 0.00447, id="C(q_t) for its transpose in (5.12)"),
    ],
)
def test_wrong_observer_breaks_its_identity(
    runs: dict[bool, dict[str, Array]], law: Callable[..., tuple[Array, Array]], breaks_observer: float
) -> None:
    control, observer = np.abs(identity_residual(Loop(True, observe=law), runs[True], 25)).max(axis=0)
    assert observer == pytest.approx(breaks_observer, rel=0.01, abs=1e-11)
    assert control < 1e-11, "the controller's identity holds for any estimate"
