"""A spin that the internal step can not follow is reported once, with a step that can."""

import re

import numpy as np
import pytest

from tests.one_fmu import Raw

VERSIONS = (2, 3)
pytestmark = pytest.mark.parametrize("version", VERSIONS)


def spin(version: int, rate: float, internal: float, seconds: float = 10.0) -> tuple[float, list[str]]:
    """Angle in degrees by which a spin about a principal axis is off, and the warnings."""
    settings = {"J_B": np.diag([10.0, 10.0, 15.0]), "omega_BN_B": [0.0, 0.0, rate], "max_internal_step": internal}
    with Raw("RigidBody", version, log=True).initialize(**settings) as body:
        for k in range(round(seconds / 0.1)):
            body.step(k * 0.1, 0.1)
        q = body.get("q_BN")
        exact = np.array([np.cos(rate * seconds / 2), 0, 0, np.sin(rate * seconds / 2)])
        angle = 2 * np.degrees(np.arccos(min(1.0, abs(q @ exact))))
        warnings = [text for status, category, text in body.messages if (status, category) == (1, "logStatusWarning")]
        return angle, warnings


@pytest.mark.parametrize(("rate", "off"), [(50.0, 0.93), (100.0, 27.0)])
def test_a_fast_spin_is_reported_with_the_way_out(version: int, rate: float, off: float) -> None:
    angle, warnings = spin(version, rate, 0.01)
    assert angle == pytest.approx(off, rel=0.05)
    (text,) = warnings
    found = re.search(
        r"q_BN turns by ([\d.]+) deg in an internal step of 0.01 s, which loses about ([\d.]+) deg/s: set "
        r"max_internal_step to ([\d.]+) or less",
        text,
    )
    assert found is not None
    turned, lost, smaller = map(float, found.groups())
    assert turned == pytest.approx(np.degrees(rate * 0.01), rel=0.01)
    assert 10 * lost == pytest.approx(off, rel=0.15)
    angle, warnings = spin(version, rate, smaller)
    assert angle < 0.2
    assert warnings == []


@pytest.mark.parametrize("rate", [0.0, 6.3, 20.0, 30.0])
def test_a_spin_that_is_followed_is_not(version: int, rate: float) -> None:
    angle, warnings = spin(version, rate, 0.01)
    assert angle < 0.1
    assert warnings == []


def test_a_reset_instance_warns_again(version: int) -> None:
    with Raw("RigidBody", version).initialize(omega_BN_B=[0.0, 0.0, 100.0]) as body:
        for _ in range(2):
            body.messages.clear()
            body.step(0.0, 0.1)
            body.step(0.1, 0.1)
            assert [status for status, _, _ in body.messages] == [1]
            body.fmu.reset()
            body.initialize(omega_BN_B=[0.0, 0.0, 100.0])
