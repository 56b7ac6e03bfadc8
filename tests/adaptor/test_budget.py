"""Legal values with which a step would take years are refused with what would help; heavy use is not."""

import pytest
from fmpy.fmi1 import FMICallException

from tests.one_fmu import Raw

VERSIONS = (2, 3)
pytestmark = pytest.mark.parametrize("version", VERSIONS)


@pytest.mark.parametrize(
    ("name", "settings", "step", "expected"),
    [
        (
            "RigidBody",
            {"max_internal_step": 1e-18},
            0.001,
            "a step of 0.001 s needs 1e+15 internal steps, at most 1e+08 are taken: take smaller steps, or raise "
            "max_internal_step = 1e-18 to 1e-11",
        ),
        ("RigidBody", {}, 1e9, "a step of 1e+09 s needs 1e+11 internal steps"),
        ("RigidBody", {}, 1e300, "a step of 1e+300 s needs 1e+302 internal steps"),
        ("RigidBody", {"max_internal_step": 5e-324}, 1.0, "a step of 1 s needs inf internal steps"),
        (
            "StarTracker",
            {"half_angle": 0.1, "redraw_period": 1e-12},
            0.001,
            "a step of 0.001 s needs 1e+09 samples, at most 1e+08 are taken: take smaller steps, or raise "
            "redraw_period = 1e-12 to 1e-11",
        ),
        ("StarTracker", {"half_angle": 0.1, "redraw_period": 1e-300}, 0.001, "a step of 0.001 s needs 1e+297 samples"),
        ("StarTracker", {"half_angle": 0.1}, 1e300, "a step of 1e+300 s needs 1e+301 samples"),
    ],
)
def test_a_step_that_would_never_end(
    version: int, name: str, settings: dict[str, float], step: float, expected: str
) -> None:
    with Raw(name, version).initialize(**settings) as raw:
        with pytest.raises(FMICallException):
            raw.step(0.0, step)
        assert expected in raw.messages[-1][2]
        assert raw.get("time") == 0.0


def test_a_start_at_which_samples_can_not_be_told_apart(version: int) -> None:
    with Raw("StarTracker", version) as tracker:
        with pytest.raises(FMICallException):
            tracker.initialize(start=1e20, half_angle=0.1)
        assert (
            "the sampling period of 0.1 s is below the resolution of time, which is 1.6e+04 s there"
            in (tracker.messages[-1][2])
        )


def test_a_step_into_such_a_time(version: int) -> None:
    with Raw("StarTracker", version).initialize(start=4e14, half_angle=0.1, redraw_period=1e8) as tracker:
        tracker.step(4e14, 1e10)
    with Raw("StarTracker", version).initialize(start=4e14, half_angle=0.1, redraw_period=0.13) as tracker:
        with pytest.raises(FMICallException):
            tracker.step(4e14, 1e6 * 1e6)
        assert "samples" in tracker.messages[-1][2]


def test_a_step_below_the_resolution_of_time(version: int) -> None:
    with Raw("PdTracking", version).initialize(start=1e20) as controller:
        with pytest.raises(FMICallException):
            controller.step(1e20, 1.0)
        assert "step size 1 refused: from t = 1e+20 it leads to t = 1e+20" in controller.messages[-1][2]
        controller.step(1e20, 1e5)


def test_a_million_internal_steps_are_legal(version: int) -> None:
    with Raw("RigidBody", version).initialize(omega_BN_B=[0.0, 0.0, 0.01], max_internal_step=1e-4) as body:
        body.step(0.0, 100.0)
        assert body.get("time") == 100.0
    with Raw("StarTracker", version).initialize(half_angle=0.1, redraw_period=1e-4) as tracker:
        tracker.step(0.0, 100.0)
        assert tracker.get("time") == 100.0


def test_without_states_and_samples_no_step_is_too_long(version: int) -> None:
    with Raw("PdTracking", version).initialize() as controller:
        controller.step(0.0, 1e300)
        assert controller.get("time") == 1e300
