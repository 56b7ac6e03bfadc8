"""Linear state spaces against differences of the coupled model, hand-derived ones, and known transfer functions."""

from __future__ import annotations

import json

import event_fmus
import numpy as np
import pytest
import scipy.io
from scipy.spatial.transform import Rotation

from adcs import AdcsError, CoupledModel, LoopSolver, ModelExchange, System, linearize
from adcs.catalogue import SYSTEMS
from adcs.cli import linearize as linear_cli
from orchestration.instances.instance import Instance
from tests.invoking import invoke

J = np.array([[10.0, 1.2, 0.5], [1.2, 19.0, 1.5], [0.5, 1.5, 25.0]])
NONE = [0.0, 0.0, 0.0]
LEVEL = [1.0, 0.0, 0.0, 0.0]


def pd_at_rest(q=LEVEL):
    """A body that a PD law holds at q."""
    system = System("hold")
    system.add("plant", "RigidBody", {"J_B": J, "q_BN": q, "omega_BN_B": NONE, "torque_disturbance_B": NONE})
    start = {"J_B": J, "k_p": 3.0, "k_v": 8.0, "q_RN": q, "omega_RN_R": NONE, "omegaDot_RN_R": NONE}
    system.add("controller", "PdTracking", start)
    for name in ("q_BN", "omega_BN_B"):
        system.connect(f"plant.{name}", f"controller.{name}")
    system.connect("controller.torque_B", "plant.torque_B")
    return system


def held(K_p, K_v):
    """Small rotations d of the body from where it is held: q_BR = d/2, so J d'' = -k_p d/2 - k_v d'."""
    inverse = np.linalg.inv(J)
    return np.block([[np.zeros((3, 3)), np.eye(3)], [-K_p / 2 * inverse, -K_v * inverse]])


def difference(f, x, h=1e-3):
    """df/dx by central differences, extrapolated twice."""

    def central(i, h):
        e = h * np.eye(len(x))[i]
        return (f(x + e) - f(x - e)) / (2 * h)

    return np.array([(64 * central(i, h / 4) - 20 * central(i, h / 2) + central(i, h)) / 45 for i in range(len(x))]).T


def same_values(a, b, tolerance):
    """Compare eigenvalues, in whatever order."""
    left = list(b)
    for value in a:
        nearest = min(range(len(left)), key=lambda i: abs(left[i] - value))
        assert abs(left.pop(nearest) - value) <= tolerance
    assert not left


@pytest.mark.parametrize("name", ["observer-pd", "full-state-pd"])
@pytest.mark.parametrize(("time", "version"), [(0.0, "2.0"), (20.0, "3.0")])
def test_against_differences_of_the_coupled_model(name, time, version):
    found = linearize(SYSTEMS[name].build(), time, fmi_version=version)
    with CoupledModel(SYSTEMS[name].build(), fmi_version=version) as model:
        assert found.states == tuple(model.state_names)
        names = list(model.ports)

        def rhs(x):
            return model.rhs(time, x)

        def outputs(x):
            values = model.outputs(time, x)
            return np.concatenate([np.ravel(values[n]) for n in names])

        assert found.dx == pytest.approx(rhs(found.x), abs=1e-14)
        assert found.y == pytest.approx(outputs(found.x), abs=1e-14)
        assert np.abs(found.A - difference(rhs, found.x)).max() < 1e-10
        assert np.abs(found.C - difference(outputs, found.x)).max() < 1e-10
        assert np.abs(found.A).max() > 0.1

    assert found.inputs == tuple(f"plant.torque_disturbance_B[{i}]" for i in (1, 2, 3))

    def disturbed(torque):
        system = SYSTEMS[name].build()
        system.set("plant.torque_disturbance_B", torque)
        with CoupledModel(system, fmi_version=version) as model:
            values = model.outputs(time, found.x)
            return np.concatenate([model.rhs(time, found.x), *(np.ravel(values[n]) for n in names)])

    B = np.vstack([found.B, found.D])
    columns = [(disturbed(e) - disturbed(-e)) / 2 for e in np.eye(3)]  # the torque enters linearly
    assert np.abs(B - np.array(columns).T).max() < 1e-12


def test_that_the_comparison_notices_a_wrong_connection():
    found = linearize(SYSTEMS["full-state-pd"].build())
    without = linearize(SYSTEMS["full-state-pd"].build(), open_at=["plant.torque_B"])
    assert np.abs(found.A - without.A).max() > 0.1


@pytest.mark.parametrize("q", [LEVEL, [0.5, -0.5, 0.5, 0.5]])
def test_pd_at_rest_by_hand(q, version):
    ends = {"inputs": ["plant.torque_disturbance_B"], "outputs": ["controller.torque_B"]}
    found = linearize(pd_at_rest(q), minimal_coordinates=True, fmi_version=version, **ends)
    assert found.states == (
        *(f"plant.q_BN.angle[{i}]" for i in (1, 2, 3)),
        *(f"plant.omega_BN_B[{i}]" for i in (1, 2, 3)),
    )
    assert pytest.approx(held(3.0, 8.0), abs=1e-14) == found.A
    assert pytest.approx(np.vstack([np.zeros((3, 3)), np.linalg.inv(J)]), abs=1e-14) == found.B
    assert pytest.approx(np.hstack([-1.5 * np.eye(3), -8 * np.eye(3)]), abs=1e-14) == found.C
    assert not found.D.any()
    assert found.dx == pytest.approx(np.zeros(6), abs=1e-14)
    assert found.notes == ()


def test_the_norm_of_a_quaternion_at_rest():
    found = linearize(pd_at_rest([0.5, -0.5, 0.5, 0.5]))
    same_values(found.eigenvalues, [0.0, *np.linalg.eigvals(held(3.0, 8.0))], 1e-12)
    assert [m.note for m in found.modes if m.note] == ["norm of plant.q_BN"]
    assert next(m for m in found.modes if m.note).frequency == pytest.approx(0.0, abs=1e-14)
    assert found.notes == ()


@pytest.mark.parametrize("axis", [2, 0])
def test_a_spinning_body_by_hand(axis):
    """Of a body that spins at w about a principal axis, the others couple: with inertias J1, J2 across and J3 along,
    omega1' = (J2 - J3) w omega2 / J1 and omega2' = (J3 - J1) w omega1 / J2; a small rotation follows
    d' = omega - w x d.
    """
    w, inertia = 0.3, np.array([10.0, 14.0, 20.0])
    across = [i for i in range(3) if i != axis]
    spin = w * np.eye(3)[axis]
    start = {"J_B": np.diag(inertia), "omega_BN_B": spin, "q_BN": [0.5, 0.5, -0.5, 0.5]}
    found = linearize("RigidBody", start=start, minimal_coordinates=True)
    j, (j1, j2) = inertia[axis], inertia[across]
    nutation = w * np.sqrt(complex((j2 - j) * (j - j1) / (j1 * j2)))
    same_values(found.eigenvalues, [0, 0, 1j * w, -1j * w, nutation, -nutation], 1e-7)  # 0 is a double one
    turning = -np.cross(spin, np.eye(3), axisb=0, axisc=0)
    assert pytest.approx(np.hstack([turning, np.eye(3)]), abs=1e-14) == found.A[:3]
    assert found.dx == pytest.approx([*spin, 0, 0, 0], abs=1e-14)
    assert found.notes == ()  # it turns steadily

    with_norm = linearize("RigidBody", start=start)
    assert with_norm.A.shape == (7, 7)
    assert "RigidBody.q_BN turns at |dq/dt| = 0.15 1/s: its norm" in with_norm.notes[0]
    assert not any(mode.note for mode in with_norm.modes)


def test_minimal_coordinates_predict_small_rotations():
    """The turning frame's equations carry a small rotation as far as the nonlinear system does."""
    system = SYSTEMS["full-state-pd"].build()
    found = linearize(system, 5.0, minimal_coordinates=True)
    full = linearize(system, 5.0)
    z = 1e-6 * np.arange(1, len(found.states) + 1)  # guidance angle, small rotation, rate
    q = full.x[1:5]

    def turned(q, d):
        return (Rotation.from_quat(q, scalar_first=True) * Rotation.from_rotvec(d)).as_quat(scalar_first=True)

    def small(q, p):
        return (Rotation.from_quat(q, scalar_first=True).inv() * Rotation.from_quat(p, scalar_first=True)).as_rotvec()

    moved = full.x + np.concatenate([z[:1], np.zeros(4), z[4:]])
    moved[1:5] = turned(q, z[1:4]) * np.sign(q @ turned(q, z[1:4]))
    h = 1e-4
    with CoupledModel(system) as model:
        ahead = full.x + h * model.rhs(5.0, full.x)
        ahead_moved = moved + h * model.rhs(5.0, moved)
    rate = (small(ahead[1:5], ahead_moved[1:5]) - z[1:4]) / h
    assert rate == pytest.approx(found.A[1:4] @ z, abs=5e-9)
    assert np.abs(found.A[1:4] @ z).max() > 1e-6


def test_the_transfer_functions_of_single_components(mock, version):
    swing = linearize(mock("oscillator", version))  # a'' = u - a
    assert swing.notes[0] == "oscillator has no directional derivatives: central differences were taken"
    assert swing.transfer(0.5j)[0, 0] == pytest.approx(1 / (1 - 0.25), abs=1e-12)
    assert (swing.modes[0].frequency, swing.modes[0].damping) == (pytest.approx(1.0), pytest.approx(0.0, abs=1e-12))

    gain = linearize(mock("gain", version), start={"k": 4.0})
    assert gain.states == ()
    assert gain.outputs[3] == "gain.doubled[1]"
    assert pytest.approx(np.vstack([4 * np.eye(3), 2 * np.eye(3)]), abs=1e-11) == gain.D

    body = linearize("RigidBody", fmi_version=version, start={"J_B": J}, inputs=["RigidBody.torque_B"])
    rate = body.select(outputs=["RigidBody.omega_BN_B[1]"])
    assert rate.transfer(2.0)[0] == pytest.approx(np.linalg.inv(J)[0] / 2, abs=1e-15)
    attitude = body.select(["RigidBody.torque_B[2]"], ["RigidBody.q_BN[3]"])
    assert attitude.transfer(2.0)[0, 0] == pytest.approx(np.linalg.inv(J)[1, 1] / 2 / 4, abs=1e-15)
    assert attitude.to_scipy().D.shape == (1, 1)

    law = linearize("PdTracking", fmi_version=version, start={"k_v": 7.0}, inputs=["PdTracking.omega_BN_B"])
    assert pytest.approx(-7 * np.eye(3), abs=1e-15) == law.select(outputs=law.outputs[:3]).D


@pytest.mark.parametrize("name", ["observer-pd", "full-state-pd"])
def test_differences_come_close_to_directional_derivatives(name, monkeypatch):
    exact = linearize(SYSTEMS[name].build(), 3.0)
    monkeypatch.setattr(Instance, "has_directional_derivatives", False)
    found = linearize(SYSTEMS[name].build(), 3.0)
    for matrix in "ABCD":
        assert np.abs(getattr(found, matrix) - getattr(exact, matrix)).max() < 1e-10
    assert "plant has no directional derivatives: central differences were taken" in found.notes


def test_factors_of_connections(mock, version):
    """a'' = c b - a, b'' = c a - b: the sum swings with 1 - c, the difference with 1 + c."""
    c = -0.4
    system = System("springs")
    for name in "ab":
        system.add(name, mock("oscillator", version))
    system.connect("a.position", "b.u", factor=c, offset=3.0)
    system.connect("b.position", "a.u", factor=c)
    found = linearize(system, 0.5)
    frequencies = np.sqrt([1 - c, 1 + c])
    same_values(found.eigenvalues, [*(1j * frequencies), *(-1j * frequencies)], 1e-10)
    assert found.inputs == ()
    assert found.u.shape == (0,)


def test_connections_of_elements(mock, version):
    system = System("parts")
    system.add("swing", mock("oscillator", version), {"u": 0.0})
    system.add("integrator", mock("integrator", version), {"u": NONE})
    system.connect("swing.position", "integrator.u[2]", factor=4.0)
    found = linearize(system)
    assert found.inputs == ("swing.u", "integrator.u[1]", "integrator.u[3]")
    s = 2.0
    assert found.select(["swing.u"], ["integrator.y[2]"]).transfer(s)[0, 0] == pytest.approx(4 / (s**2 + 1) / s)
    some = linearize(system, inputs=["integrator.u[3]"], outputs=["integrator.y[3]", "swing.position"])
    assert some.transfer(s) == pytest.approx(np.array([[1 / s], [0.0]]), abs=1e-12)


def test_loop_gain_where_a_loop_is_opened():
    """Around the body the torque comes back as -(k_v s + k_p/2) J^-1 / s^2."""
    torque = "plant.torque_B"
    found = linearize(pd_at_rest(), open_at=[torque], inputs=[torque], outputs=["controller.torque_B"])
    s = 0.3j
    assert found.transfer(s) == pytest.approx(-(8 * s + 1.5) / s**2 * np.linalg.inv(J), rel=1e-12)
    assert linearize(pd_at_rest(), open_at=[torque]).inputs[:3] == tuple(f"{torque}[{i}]" for i in (1, 2, 3))


def test_what_is_added_at_a_connected_input():
    found = linearize(pd_at_rest(), inputs=["plant.torque_B", "plant.torque_disturbance_B"])
    assert np.array_equal(found.B[:, :3], found.B[:, 3:])
    noise = linearize(pd_at_rest(), inputs=["controller.omega_BN_B"], outputs=["controller.torque_B"])
    assert pytest.approx(-8 * np.eye(3), abs=1e-14) == noise.D


def test_an_algebraic_loop(mock):
    """y = k1 (k2 y + w), so y = k1 / (1 - k1 k2) w."""
    system = System("loop")
    system.add("one", mock("gain"), {"k": 0.5})
    system.add("two", mock("gain"), {"k": 0.3})
    system.connect("one.y", "two.u", factor=1.0)
    system.connect("two.y", "one.u", factor=1.0)
    with pytest.raises(AdcsError, match="algebraic loop"):
        linearize(system)
    found = linearize(system, inputs=["one.u"], outputs=["one.y"], method=ModelExchange(loops=LoopSolver()))
    assert pytest.approx(0.5 / (1 - 0.15) * np.eye(3), abs=1e-10) == found.D


@pytest.fixture(scope="session")
def event_folder(tmp_path_factory):
    return tmp_path_factory.mktemp("events")


def test_events_on_the_way(event_folder, version):
    ball = event_fmus.build("bouncing_ball", event_folder, version)
    found = linearize(ball, 1.0)
    assert found.x[0] == pytest.approx(found.y[0], abs=1e-15)
    assert 0 < found.x[0] < 0.5  # after the first bounce
    assert pytest.approx(np.array([[0, 1], [0, 0]]), abs=1e-12) == found.A
    tally = event_fmus.build("tally", event_folder, version)
    system = System("events")
    system.add("ball", ball)
    system.add("tally", tally, {"enable": True, "level": 0.0, "u": 0.0})
    system.connect("ball.bounces", "tally.n")
    found = linearize(system)
    assert "tally.n gets ball.bounces at events only: it is held in the linear system" in found.notes
    assert found.inputs == ("tally.u",)
    with pytest.raises(AdcsError, match=r"^tally\.level is a discrete Float64: only Float variables that vary contin"):
        linearize(system, inputs=["tally.level"])
    with pytest.raises(AdcsError, match=r"^tally\.odd is a discrete Boolean"):
        linearize(system, outputs=["tally.odd"])


def test_time_events_are_noted(mock):
    found = linearize(mock("ticker"), 1.5)
    assert "ticker has a time event at 2 s: this holds until then" in found.notes
    assert any("this is no equilibrium, ticker.x changes by 1 per second" in note for note in found.notes)


def test_what_cannot_be_linearised_is_refused_by_name(mock):
    system = System("springs")
    for name in "ab":
        system.add(name, mock("oscillator"))
    system.connect("a.position", "b.u", delay_steps=1)
    system.connect("b.position", "a.u")
    with pytest.raises(AdcsError, match=r"^the connection from a\.position to b\.u is delayed: a delay has no state"):
        linearize(system)
    with pytest.raises(AdcsError, match=r"^a\.position is no input but has causality 'output'"):
        linearize(_plain(mock), inputs=["a.position"])
    with pytest.raises(AdcsError, match=r"^a\.u is no output but has causality 'input'"):
        linearize(_plain(mock), outputs=["a.u"])
    with pytest.raises(AdcsError, match=r"^a\.u is not connected: there is nothing to open"):
        linearize(_plain(mock), open_at=["a.u"])
    with pytest.raises(AdcsError, match=r"has no variable 'v'"):
        linearize(_plain(mock), inputs=["a.v"])
    with pytest.raises(AdcsError, match=r"^time = -1\.0 s: expected a time from the start time 0\.0 s on"):
        linearize(_plain(mock), -1)
    with pytest.raises(AdcsError, match=r"^start values of a system are set in the system"):
        linearize(_plain(mock), start={"a.u": 1.0})


def _plain(mock):
    system = System("plain")
    system.add("a", mock("oscillator"), {"u": 0.0})
    return system


def test_files(tmp_path):
    found = linearize(pd_at_rest())
    found.write(tmp_path / "new" / "hold.mat")
    loaded = scipy.io.loadmat(tmp_path / "new" / "hold.mat", squeeze_me=True)
    for name in "ABCD":
        assert np.array_equal(loaded[name], getattr(found, name))
    assert loaded["states"].tolist() == list(found.states)
    assert loaded["inputs"].tolist() == list(found.inputs)
    assert np.array_equal(loaded["eigenvalues"], found.eigenvalues)
    found.write(tmp_path / "hold.json")
    content = json.loads((tmp_path / "hold.json").read_text())
    assert content["A"] == found.A.tolist()
    assert content["outputs"] == list(found.outputs)
    assert content["modes"][0]["note"] == "norm of plant.q_BN"
    with pytest.raises(AdcsError, match=r"hold\.csv: give a name that ends in \.mat or \.json"):
        found.write(tmp_path / "hold.csv")


def test_modes(mock):
    """x'' + 2 d x' + x = 0 by a swing that feels its own speed."""
    system = System("damped")
    system.add("plant", "RigidBody", {"J_B": np.eye(3), "omega_BN_B": NONE, "torque_disturbance_B": NONE})
    system.add(
        "controller", "PdTracking", {"k_p": 2.0, "k_v": 0.4, "omegaDot_RN_R": NONE, "omega_RN_R": NONE, "q_RN": LEVEL}
    )
    system.connect("plant.q_BN", "controller.q_BN")
    system.connect("plant.omega_BN_B", "controller.omega_BN_B")
    system.connect("controller.torque_B", "plant.torque_B")
    modes = linearize(system, minimal_coordinates=True).modes
    assert [(m.frequency, m.damping, m.time_constant) for m in modes] == [pytest.approx((1.0, 0.2, 5.0), rel=1e-9)] * 3


def adcs(*arguments):
    return invoke(linear_cli.app, list(arguments))


def test_command_line(tmp_path, mock):
    shown = adcs("PdTracking", "--set", "k_v=5", "--outputs", "torque_B[1]")
    assert shown.exit_code == 0, shown.output
    assert "PdTracking at t = 0 s: 0 states, 17 inputs, 1 outputs" in shown.output
    assert (
        "torque_B[1] = -1.5 q_BN[2] - 5 omega_BN_B[1] + 1.5 q_RN[2] + 5 omega_RN_R[1] + 10 omegaDot_RN_R[1]"
        in shown.output
    )

    shown = adcs("full-state-pd", "--at", "5000ms", "--minimal", "--out", str(tmp_path / "loop.mat"))
    assert "full-state-pd at t = 5 s: 7 states, 3 inputs, 36 outputs" in shown.output
    assert "this is no equilibrium" in shown.output
    assert scipy.io.loadmat(tmp_path / "loop.mat")["A"].shape == (7, 7)

    printed = adcs(str(mock("oscillator")), "--json", "--inputs", "u", "--outputs", "oscillator.position")
    content = json.loads(printed.output)
    assert np.allclose(content["A"], [[0, 1], [-1, 0]], atol=1e-11)
    assert content["inputs"] == ["oscillator.u"]

    printed = adcs("full-state-pd", "--inputs", "plant.torque_B,plant.torque_disturbance_B[2]", "--json")
    assert len(json.loads(printed.output)["inputs"]) == 4
    for arguments, message in (
        (("nothing",), "no system 'nothing'"),
        (("RigidBody", "--out", "x.csv"), "--out x.csv: give a name that ends in .mat or .json"),
        (("RigidBody", "--set", "k"), "--set k: expected COMPONENT.VARIABLE=VALUE"),
        (("missing.fmu",), "cannot open missing.fmu"),
    ):
        failed = adcs(*arguments)
        assert isinstance(failed.exception, AdcsError)
        assert message in str(failed.exception)


def test_a_file_that_is_there_is_replaced_only_by_force(tmp_path):
    file = tmp_path / "pd.json"
    file.write_text("mine")
    refused = adcs("PdTracking", "--out", str(file))
    assert str(refused.exception) == f"--out {file} is there already: give another name, or --force to replace it"
    assert file.read_text() == "mine"
    assert adcs("PdTracking", "--out", str(file), "--force").exit_code == 0
    assert json.loads(file.read_text())["states"] == []


def test_an_ssp_file_is_linearised_like_its_system(tmp_path):
    from adcs import write_ssp

    write_ssp(pd_at_rest(), tmp_path / "hold.ssp")
    printed = adcs(str(tmp_path / "hold.ssp"), "--json")
    assert printed.exit_code == 0, printed.exception
    content = json.loads(printed.output)
    found = linearize(pd_at_rest())
    order = [content["states"].index(name) for name in found.states]
    assert np.abs(np.array(content["A"])[np.ix_(order, order)] - found.A).max() < 1e-14


def test_an_fmu_for_co_simulation_only_has_no_derivatives(foreign):
    with pytest.raises(
        AdcsError, match=r"^names \(names.*\.fmu\) is for co-simulation only, .*: export it for Model Ex"
    ):
        linearize(foreign("names"))
