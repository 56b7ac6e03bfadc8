"""The loop through TCP and a process of its own: what it does to the spacecraft, and that it is always the same."""

import numpy as np
import pytest
from flights import EXACT, flown
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from adcs import Result, System, run
from adcs.library.hardware.systems import INERTIA, PERIOD, hil_spacecraft

K_P, K_V = 1.5, 5.0
RECORDED = ("plant.q_BN", "plant.omega_BN_B", "actuator.torque_B")


@pytest.fixture(scope="module")
def exact() -> Result:
    """Ten seconds with sensors that are exact."""
    return flown(stop_time=10.0, changes=EXACT)


def test_the_loop_over_tcp_is_that_of_the_control_component(exact: Result) -> None:
    """The same law as a component in co-simulation: all that differs is the float32 of MAVLink."""
    system = hil_spacecraft()
    for name, value in EXACT.items():
        system.set(name, value)
    still = [0.0, 0.0, 0.0]
    law = {"J_B": INERTIA, "k_p": K_P, "k_v": K_V, "q_RN": [1.0, 0.0, 0.0, 0.0]}
    del system.components["actuator"].start["torque_command_B"]  # it is to be connected
    system.add("controller", "PdTracking", {**law, "omega_RN_R": still, "omegaDot_RN_R": still})
    system.connect("plant.q_BN", "controller.q_BN")
    system.connect("plant.omega_BN_B", "controller.omega_BN_B")
    system.connect("controller.torque_B", "actuator.torque_command_B")
    inside = run(system, stop_time=10.0, step=PERIOD)
    for name, most in zip(RECORDED, (2e-7, 2e-7, 1e-6), strict=True):
        assert np.abs(exact[name] - inside[name]).max() < most, name
    assert np.abs(exact["plant.q_BN"][-1] - exact["plant.q_BN"][0]).max() > 0.1, "and it has moved"


def test_the_loop_is_that_of_an_integration_from_the_textbook(exact: Result) -> None:
    """Euler's equation and the PD law with its torque held over each step, by SciPy with rotations of its own."""
    inertia = np.array(INERTIA)
    q, w = exact["plant.q_BN"][0], exact["plant.omega_BN_B"][0]
    attitude = Rotation.from_quat(q, scalar_first=True)
    for k in range(500):
        half = attitude.as_rotvec()
        angle = np.linalg.norm(half)
        torque = -K_P * np.sin(angle / 2) * half / angle - K_V * w
        assert np.abs(torque - exact["actuator.torque_B"][k]).max() < 1e-6

        def flow(_: float, x: np.ndarray, torque: np.ndarray = torque) -> np.ndarray:
            s, v = x[:3], x[3:]  # rotation vector since the step began, and rate
            turn = v + np.cross(s, v) / 2 + np.cross(s, np.cross(s, v)) / 12
            return np.concatenate([turn, np.linalg.solve(inertia, torque - np.cross(v, inertia @ v))])

        end = solve_ivp(flow, (0, PERIOD), [0, 0, 0, *w], rtol=1e-11, atol=1e-13).y[:, -1]
        attitude, w = attitude * Rotation.from_rotvec(end[:3]), end[3:]
        np.testing.assert_allclose(exact["plant.omega_BN_B"][k + 1], w, rtol=0, atol=1e-6)


def test_it_holds_the_attitude_with_noise_and_bias_in_the_sensors() -> None:
    """The star tracker's attitude and the gyro's rate, nothing true: it points within what the errors amount to."""
    held = Rotation.from_euler("ZYX", [30, -20, 10], degrees=True).as_quat(scalar_first=True)
    options = ["--star-tracker", "--k-p", "30", "--k-v", "40", "--max-torque", "1", "--attitude", *map(str, held)]
    result = flown(*options, stop_time=20.0, step=0.02, truth=False)
    q = Rotation.from_quat(result["plant.q_BN"], scalar_first=True)
    error = np.degrees((Rotation.from_quat(held, scalar_first=True).inv() * q).magnitude())
    assert error[0] > 20
    assert error[-100:].max() < 0.05
    assert np.degrees(np.linalg.norm(result["plant.omega_BN_B"][-100:], axis=1)).max() < 0.05
    account = result.manifest["hardware_in_the_loop"]
    assert account["controls_clipped"] > 0, "it asks for more than it gets at first"
    assert np.abs(result["actuator.torque_B"]).max() == 1.0


def test_two_flights_are_the_same_to_the_last_bit() -> None:
    first, second = (flown("--star-tracker", stop_time=1.0) for _ in range(2))
    assert first.data.shape == (251, first.data.shape[1])
    np.testing.assert_array_equal(first.data, second.data)
    assert first.manifest["hardware_in_the_loop"]["points_answered"] == 251


def test_garbage_and_late_answers_change_nothing() -> None:
    """Between its messages: random bytes, beginnings of frames, half a frame, and an answer to the sensors before."""
    plain, disturbed = flown(stop_time=0.4), flown("--noise", "--stale", stop_time=0.4)
    np.testing.assert_array_equal(plain.data, disturbed.data)
    account = disturbed.manifest["hardware_in_the_loop"]
    assert account["garbage_bytes"] > 101 * 10
    assert 90 <= account["answers_late"] <= 101
    assert plain.manifest["hardware_in_the_loop"]["garbage_bytes"] == 0


def test_no_torque_before_it_is_armed() -> None:
    result = flown("--disarmed", stop_time=0.2)
    assert not result["actuator.torque_B"].any()
    assert result.manifest["hardware_in_the_loop"]["answers_not_armed"] == 51


def test_both_fmi_versions_fly_the_same() -> None:
    two, three = (flown(stop_time=0.2, fmi_version=version) for version in ("2.0", "3.0"))
    np.testing.assert_array_equal(two.data, three.data)


def test_a_wrong_sign_would_be_seen(exact: Result) -> None:
    """The gain of the rate with the wrong sign drives the loop away from the other one at once."""
    wrong = flown("--k-v", "-5", stop_time=1.0, changes=EXACT)
    for name, most in zip(RECORDED, (2e-7, 2e-7, 1e-6), strict=True):
        assert np.abs(wrong[name] - exact[name][:251]).max() > 1000 * most


def test_a_system_of_ones_own_is_flown_by_its_names() -> None:
    system = System("bare")
    system.add(
        "body", "RigidBody", {"torque_B": [0, 0, 0], "torque_disturbance_B": [0, 0, 0], "omega_BN_B": [0, 0, 0.1]}
    )
    system.add("gyro", "InertialMeasurementUnit", {"specific_force_B": [0, 0, 0]})
    system.connect("body.omega_BN_B", "gyro.omega_BN_B")
    from flights import connected, fly, prepared

    with connected("--k-p", "0", "--k-v", "5") as (link, _):
        _, flight = prepared(link, system)
        result = fly(system, flight, stop_time=1.0, step=0.02)
    decay = np.diff(result["body.omega_BN_B"][:, 2]) / result["body.omega_BN_B"][:-1, 2]
    J = system.components["body"].fmu.ports["J_B"].start
    assert J is not None
    assert decay[0] == pytest.approx(-5 * 0.02 * np.linalg.inv(np.reshape(J, (3, 3)))[2, 2], rel=0.02)


def test_relative_to_north_east_down_it_looks_at_the_earth() -> None:
    """Held at NED, the body's z axis follows the nadir, but for the lag of a law that knows nothing of the orbit."""
    options = ["--k-p", "30", "--k-v", "40"]
    result = flown(*options, stop_time=24.0, step=0.02, frame="ned", changes=EXACT)
    r_N = result["orbit.r_ON_N"]
    z_N = Rotation.from_quat(result["plant.q_BN"], scalar_first=True).apply([0, 0, 1])
    angle = np.degrees(np.arccos(-np.sum(z_N * r_N, axis=1) / np.linalg.norm(r_N, axis=1)))
    assert angle[0] > 30
    lag = np.degrees(2 * 40 / 30 * np.linalg.norm(result["plant.omega_BN_B"][-1]))
    ellipsoid = 0.2  # largest angle between geodetic and geocentric down
    assert angle[-1] < lag + ellipsoid < 0.6
    np.testing.assert_allclose(np.linalg.norm(result["plant.omega_BN_B"][-1]), 1.11e-3, rtol=0.2)
