"""Algebraic loops that are solved: by Newton's method and by repetition, against solutions known otherwise."""

import numpy as np
import pytest
from scipy.optimize import root
from scipy.spatial.transform import Rotation

from adcs import AdcsError, CoSimulation, LoopSolver, Save, System, run

STEPPINGS = ["compiled", "python"]
METHODS = ["newton", "fixed-point"]


@pytest.fixture
def ring(mock):
    """a.u = b.y / 4, b.u = a.y / 4 + source.y, y = 2 u: contracts, a.u = (b.u) / 2, b.u = 4/3 source.y."""

    def build(version="2.0", factor=0.25):
        system = System("ring")
        for name in "ab":
            system.add(name, mock("gain", version), {"k": 2.0})
        system.connect("b.y", "a.u", factor=factor)
        system.connect("a.y", "b.u", factor=factor, offset=1.0)
        return system

    return build


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("method", METHODS)
def test_a_linear_loop(ring, version, stepping, method):
    solver = LoopSolver(method)
    result = run(
        ring(version), stop_time=1, step=0.5, method=CoSimulation(loops=solver, stepping=stepping), fmi_version=version
    )
    assert np.allclose(result["b.y"], 8 / 3, rtol=0, atol=1e-9)
    assert np.allclose(result["a.y"], 4 / 3, rtol=0, atol=1e-9)
    (loop,) = result.manifest["algebraic_loops"] if version == "3.0" else result.manifest["algebraic_loops"][:1]
    assert loop["method"] == method
    assert loop["solved"] == 3
    assert loop["residual"] <= 1e-10


def test_both_steppings_solve_alike(ring):
    one, other = (
        run(ring(), stop_time=1, step=0.1, method=CoSimulation(loops=LoopSolver(), stepping=s)) for s in STEPPINGS
    )
    assert np.array_equal(one.data, other.data)


def test_a_loop_without_a_unique_solution_is_named(ring):
    with pytest.raises(AdcsError, match=r"the algebraic loop of .*a\.u.* has no unique solution: its Jacobian is sing"):
        run(ring(factor=0.5), stop_time=1, step=0.5, method=CoSimulation(loops=LoopSolver()))


def test_repetition_that_does_not_contract_is_named(ring):
    with pytest.raises(
        AdcsError, match=r"is not solved after 50 iterations of fixed-point, relative residual \S+: try"
    ):
        run(ring(factor=-0.6), stop_time=1, step=0.5, method=CoSimulation(loops=LoopSolver("fixed-point")))


def test_a_controller_that_feeds_on_its_own_torque():
    # omega = c * torque(omega) + omega_0, through the directional derivatives of the FMU, and by scipy
    system = System("loop")
    q_BN = np.array([0.5, 0.5, -0.5, 0.5])
    rate, acceleration = np.array([0.3, -0.2, 0.1]), np.array([0.01, 0.02, -0.03])
    inertia = np.array([[10.0, 1.2, 0.5], [1.2, 19.0, 1.5], [0.5, 1.5, 25.0]])
    start = {"q_BN": q_BN, "q_RN": [1.0, 0, 0, 0], "omega_RN_R": rate, "omegaDot_RN_R": acceleration}
    system.add("controller", "PdTracking", {"J_B": inertia, "k_p": 1.5, "k_v": 5.0, **start})
    system.connect("controller.torque_B", "controller.omega_BN_B", factor=0.7, offset=0.1)
    result = run(
        system, stop_time=0.1, step=0.1, save=Save(["controller.torque_B"]), method=CoSimulation(loops=LoopSolver())
    )
    dcm = Rotation.from_quat(q_BN, scalar_first=True).as_matrix().T
    omega_RN_B = dcm @ rate

    def residual(torque):
        omega = 0.7 * torque + 0.1
        law = -1.5 * q_BN[1:] - 5.0 * (omega - omega_RN_B) + inertia @ dcm @ acceleration
        return law + np.cross(omega_RN_B, inertia @ omega_RN_B) - torque

    expected = root(residual, np.zeros(3), tol=1e-14).x
    assert np.allclose(result["controller.torque_B"], expected, rtol=0, atol=1e-9)
    # no component of the torque depends on another one of omega, the law is linear and the derivatives are exact
    loops = result.manifest["algebraic_loops"]
    assert [loop["path"] for loop in loops] == [f"controller.omega_BN_B[{i}]" for i in (1, 2, 3)]
    assert all(loop["most_iterations"] <= 1 for loop in loops)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"method": "magic"}, "loop method 'magic' is unknown: use 'newton' or 'fixed-point'"),
        ({"tolerance": 0.0}, "loop tolerance = 0.0: expected a number from 1.8e-15 to 1"),
    ],
)
def test_refused_settings(settings, message):
    with pytest.raises(AdcsError) as error:
        LoopSolver(**settings)
    assert str(error.value) == message
