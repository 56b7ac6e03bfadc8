"""An exported system carries its seeds, and what a file says of seeds is what counts."""

import numpy as np
import pytest

from adcs import System, read_ssp, run, write_ssp

SENSORS = {
    "gyro": ("InertialMeasurementUnit", {"gyro_noise": 1.0, "omega_BN_B": (0, 0, 0), "specific_force_B": (0, 0, 0)}),
    "compass": ("Magnetometer", {"noise": 1.0, "q_BN": (1, 0, 0, 0), "magnetic_field_N": (0, 0, 0)}),
}


@pytest.fixture
def sensors():
    system = System("sensors")
    for name, (fmu, start) in SENSORS.items():
        system.add(name, fmu, {**start, "period": 0.1})
    return system


def seeds(system):
    return {name: component.start["seed"] for name, component in system.components.items()}


def test_an_exported_system_has_the_same_noise(sensors, tmp_path):
    """The file gives the seeds, so that any tool draws what is drawn here."""
    write_ssp(sensors, tmp_path / "sensors.ssp")
    again = read_ssp(tmp_path / "sensors.ssp").system
    assert seeds(again) == seeds(sensors)
    ours, theirs = (run(system, stop_time=5, step=0.1) for system in (sensors, again))
    for name in ("gyro.omega_BN_B_meas", "compass.magnetic_field_B_meas"):
        assert np.abs(ours[name]).max() > 1
        np.testing.assert_array_equal(ours[name], theirs[name])


def test_a_file_without_seeds_has_those_of_the_fmus(sensors, tmp_path):
    """As in any other tool that reads it: what a file does not say is for the FMU to say."""
    for component in sensors.components.values():
        del component.start["seed"]
    write_ssp(sensors, tmp_path / "sensors.ssp")
    assert seeds(read_ssp(tmp_path / "sensors.ssp").system) == {"gyro": (1,), "compass": (1,)}


def test_a_variable_of_another_fmu_that_is_called_seed_is_left_alone(fmus):
    system = System("foreign")
    system.add("it", fmus["receiver"])
    assert "seed" in system.components["it"].fmu.ports
    assert system.components["it"].start == {}
