import stat

import pytest

from adcs import AdcsError
from fmus.build import describe
from fmus.describe import described


def test_names_of_elements(spinner):
    names = {v.name: v.element_names for v in spinner.variables}
    assert names["M"] == ["M[1,1]", "M[1,2]", "M[1,3]", "M[2,1]", "M[2,2]", "M[2,3]"]
    assert names["der(x)"] == ["der(x[1])", "der(x[2])"]
    assert names["y"] == ["y"]


def test_owner_of_a_value_reference(spinner):
    assert spinner.at(8).name == "M"
    assert spinner.at(9).name == "mode"


def test_what_the_rigid_body_declares():
    body = describe("RigidBody")
    by_name = {v.name: v for v in body.variables}
    assert by_name["J_B"].shape == (3, 3)
    assert by_name["J_B"].unit == "kg.m2"
    assert by_name["der(q_BN)"].derivative_of == by_name["q_BN"].vr
    assert body.states == 7
    torques = {by_name["torque_B"].vr, by_name["torque_disturbance_B"].vr}
    assert torques <= set(by_name["der(omega_BN_B)"].dependencies[0])
    assert not torques & set(by_name["q_BN"].dependencies[0])


@pytest.mark.parametrize(
    ("script", "message"),
    [
        ("echo broken >&2; exit 3", "exit code 3: broken"),
        ("echo '{'", "no valid description"),
        ("echo '{}'", "KeyError"),
    ],
)
def test_a_describe_program_that_fails(tmp_path, script, message):
    program = tmp_path / "program"
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(stat.S_IRWXU)
    with pytest.raises(AdcsError, match=message):
        described(program)
