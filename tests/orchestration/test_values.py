"""Start values written as text."""

import numpy as np
import pytest

from adcs import AdcsError
from orchestration.fmu.file import locate, open_fmu
from orchestration.fmu.values import parse_value


@pytest.mark.parametrize(
    ("fmu", "variable", "text", "value"),
    [
        ("StarTracker", "half_angle", "0.05deg", np.radians(0.05)),
        ("StarTracker", "half_angle", "5e-2 deg", np.radians(0.05)),
        ("StarTracker", "half_angle", "1e-3", 1e-3),
        ("StarTracker", "half_angle", "1e-3rad", 1e-3),
        ("StarTracker", "seed", "7", 7),
        ("RigidBody", "omega_BN_B", "0.1, 0, -0.2", [0.1, 0, -0.2]),
        ("RigidBody", "torque_disturbance_B", "[1,2,3]N.m", [1, 2, 3]),
        ("RigidBody", "J_B", "[[1,0,0],[0,1,0],[0,0,1]]", np.eye(3)),
    ],
)
def test_read(fmu, variable, text, value):
    description = open_fmu(locate(fmu))
    assert np.asarray(parse_value(description, description.ports[variable], text)) == pytest.approx(np.asarray(value))


@pytest.mark.parametrize("text", ["", "deg", "1,,2", "1deg,2deg"])
def test_refused(text):
    description = open_fmu(locate("StarTracker"))
    with pytest.raises(AdcsError, match=r"half_angle = .* cannot be read: write a number, .* in rad or deg"):
        parse_value(description, description.ports["half_angle"], text)


@pytest.mark.parametrize(
    ("component", "name", "text", "message"),
    [
        ("StarTracker", "half_angle", "5parsec", "'parsec' is no unit of it: use rad or deg"),
        ("StarTracker", "half_angle", "1e5 m/s2", "'m/s2' is no unit of it: use rad or deg"),
        ("StarTracker", "half_angle", "1 furlong", "'furlong' is no unit of it: use rad or deg"),
        ("StarTracker", "half_angle", "0.05 degrees", "'degrees' is no unit of it: use rad or deg"),
        ("StarTracker", "half_angle", "5eV", "'eV' is no unit of it: use rad or deg"),
        ("StarTracker", "seed", "3rad", "'rad' is taken for a unit, and it has none: leave that out"),
        ("RigidBody", "J_B", "[[1,0,0],[0,1,0],[0,0,1]]g", "'g' is no unit of it: use kg.m2"),
    ],
)
def test_a_unit_that_is_none_of_its_is_what_is_wrong(component, name, text, message):
    fmu = open_fmu(locate(component))
    with pytest.raises(AdcsError) as error:
        parse_value(fmu, fmu.ports[name], text)
    assert str(error.value) == f"{name} = {text!r}: {message}"
