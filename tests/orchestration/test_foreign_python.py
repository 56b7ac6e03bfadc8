"""FMUs made by other exporters: PythonFMU (FMI 2.0) and PythonFMU3 (FMI 3.0), and our controller swapped for theirs."""

from pathlib import Path

import numpy as np
import pytest

from adcs import CoSimulation, RunFailed, System, run
from adcs.library.thakur.observer.systems import full_state_pd, observer_pd
from orchestration.fmu.file import open_fmu

pythonfmu = pytest.importorskip("pythonfmu.builder")
pythonfmu3 = pytest.importorskip("pythonfmu3.builder")

SLAVES = Path(__file__).parent / "slaves"
TOLERANCE = 1e-12  # of the largest value: the law is computed in another order, and 1000 steps carry that on


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("python")


@pytest.fixture(scope="module", params=["PythonFMU", "PythonFMU3"])
def pd_slave(request, folder):
    exporter, slave = (pythonfmu, "pd_slave") if request.param == "PythonFMU" else (pythonfmu3, "pd_slave3")
    exporter.FmuBuilder.build_FMU(SLAVES / f"{slave}.py", dest=folder, project_files=[SLAVES / "pd_law.py"])
    return folder / ("PdSlave.fmu" if request.param == "PythonFMU" else "PdSlave3.fmu")


@pytest.fixture(scope="module")
def late_slave(folder):
    pythonfmu.FmuBuilder.build_FMU(SLAVES / "late_slave.py", dest=folder)
    return folder / "LateSlave.fmu"


def swapped(system, fmu):
    """Return the system with another FMU as its controller."""
    copy = System(system.name)
    for c in system.components.values():
        start = {name: np.reshape(values, c.fmu.ports[name].shape) for name, values in c.start.items()}
        copy.add(c.name, fmu if c.name == "controller" else c.source, start)
    for connection in system.connections:
        copy.connect(connection.source, connection.target)
    return copy


def test_scalars_of_an_exporter_without_arrays_are_united(pd_slave):
    ports = open_fmu(pd_slave).ports
    assert {n: p.shape for n, p in ports.items() if p.causality in ("input", "parameter")} == {
        "q_BN": (4,),
        "omega_BN_B": (3,),
        "q_RN": (4,),
        "omega_RN_R": (3,),
        "omegaDot_RN_R": (3,),
        "J_B": (3, 3),
        "k_p": (),
        "k_v": (),
    }


@pytest.mark.parametrize("build", [full_state_pd, observer_pd])
@pytest.mark.parametrize("fmi_version", ["2.0", "3.0"])
def test_the_loop_with_their_controller_is_the_loop_with_ours(pd_slave, build, fmi_version):
    settings = {"stop_time": 10.0, "step": 0.01, "fmi_version": fmi_version}
    ours = run(build(), **settings)
    theirs = run(swapped(build(), pd_slave), **settings)
    for name in ours.names:
        scale = np.abs(ours[name]).max()
        assert np.abs(theirs[name] - ours[name]).max() <= TOLERANCE * scale, name
    assert np.ptp(ours["controller.torque_B"]) > 1.0


def test_a_wrong_sign_in_their_law_would_be_seen(pd_slave):
    system = swapped(full_state_pd(), pd_slave)
    system.set("controller.k_v", 5.0 * (1 + 1e-6))
    ours, theirs = (run(s, stop_time=1.0, step=0.01) for s in (full_state_pd(), system))
    difference = np.abs(theirs["controller.torque_B"] - ours["controller.torque_B"]).max()
    assert difference > 100 * TOLERANCE * np.abs(ours["controller.torque_B"]).max()


@pytest.mark.parametrize("stepping", ["compiled", "python"])
def test_outputs_that_are_computed_in_do_step_are_one_step_late(late_slave, mock, stepping):
    system = System("late")
    system.add("source", mock("oscillator"), {"u": 0.0})
    system.add("slave", late_slave)
    system.connect("source.position", "slave.u")
    result = run(system, stop_time=1.0, step=0.1, method=CoSimulation(stepping=stepping))
    assert result["slave.y"][0] == 0.0
    assert np.array_equal(result["slave.y"][1:], 2 * result["source.position"][:-1])
    assert result["slave.count"].tolist() == list(range(11))
    assert result["slave.odd"].tolist() == [k % 2 for k in range(11)]
    assert "slave.text" not in result.names


def test_a_slave_that_raises_is_named_with_what_it_raised(late_slave):
    system = System("fuel")
    system.add("slave", late_slave, {"u": 1.0, "fails_at": 0.5})
    with pytest.raises(RunFailed, match=r"^slave failed at t = 0\.5 s: doStep returned fatal: .*out of fuel") as error:
        run(system, stop_time=1.0, step=0.25)
    assert error.value.result.time.tolist() == [0.0, 0.25, 0.5]
