"""Bad input is refused with one line that names the thing; nothing crashes, and the instance stays usable."""

from ctypes import c_double, c_size_t, c_void_p
from math import inf, nan

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from tests.one_fmu import Raw

VERSIONS = (2, 3)
pytestmark = pytest.mark.parametrize("version", VERSIONS)


def refused(raw: Raw, expected: str) -> None:
    assert raw.messages, "refused without a message"
    status, category, text = raw.messages[-1]
    assert (status, category) == (3, "logStatusError")
    assert expected in text


@pytest.mark.parametrize("size", [0.0, -0.01, nan, inf])
def test_step_size(version: int, size: float) -> None:
    with Raw("RigidBody", version).initialize(omega_BN_B=[0.1, 0, 0]) as body:
        with pytest.raises(FMICallException):
            body.step(0.0, size)
        refused(body, "a positive finite number is expected")
        body.step(0.0, 0.01)
        assert body.get("omega_BN_B")[0] == pytest.approx(0.1, abs=1e-3)


def test_step_from_another_time_or_past_the_stop(version: int) -> None:
    with Raw("RigidBody", version).initialize(stop=1.0) as body:
        with pytest.raises(FMICallException):
            body.step(0.5, 0.1)
        refused(body, "step from t = 0.5 refused: this instance is at t = 0")
        with pytest.raises(FMICallException):
            body.step(0.0, 1.1)
        refused(body, "the stop time is 1")


@pytest.mark.parametrize(
    ("inertia", "expected"),
    [
        ([[10, 1, 0], [0, 10, 0], [0, 0, 10]], "is not symmetric"),
        ([[10, 0, 0], [0, -10, 0], [0, 0, 10]], "is not positive definite"),
        ([[1, 2, 0], [2, 1, 0], [0, 0, 1]], "is not positive definite"),
        ([[1, 0, 0], [0, 1, 0], [0, 0, 2.1]], "violates the triangle inequality"),
    ],
)
@pytest.mark.parametrize("name", ["RigidBody", "SmoothRateObserver", "PdTracking"])
def test_inertia(version: int, name: str, inertia: list[list[float]], expected: str) -> None:
    with Raw(name, version) as component:
        with pytest.raises(FMICallException):
            component.initialize(J_B=inertia)
        refused(component, "J_B = [")
        refused(component, expected)


def test_a_thin_disc_is_a_body(version: int) -> None:
    """The bound of the triangle inequality itself is physical."""
    with Raw("RigidBody", version).initialize(J_B=np.diag([1.0, 1.0, 2.0])) as body:
        body.step(0.0, 0.1)


def test_zero_quaternion(version: int) -> None:
    with Raw("RigidBody", version) as body:
        with pytest.raises(FMICallException):
            body.initialize(q_BN=[0, 0, 0, 0])
        refused(body, "q_BN has norm 0: a unit quaternion is expected")
    with Raw("PdTracking", version).initialize() as controller:
        controller.set({"q_BN": [0, 0, 0, 0]})
        with pytest.raises(FMICallException):
            controller.get("torque_B")
        refused(controller, "input q_BN has norm 0")
        controller.set({"q_BN": [1, 0, 0, 0]})
        assert controller.get("torque_B") == pytest.approx(0.0)


def test_start_quaternion_is_normalised(version: int) -> None:
    with Raw("RigidBody", version).initialize(q_BN=[1.001, 0, 0, 0]) as body:
        assert body.get("q_BN").tolist() == [1, 0, 0, 0]


def test_a_state_is_there_without_what_is_computed_of_it(version: int) -> None:
    """Before initialization is over it is normalised as it is read; afterwards no output need be possible."""
    with Raw("SmoothRateObserver", version) as observer:
        observer.set({"q_EN": [1.001, 0, 0, 0]})
        observer.enter()
        assert observer.get("q_EN").tolist() == [1, 0, 0, 0]
        observer.fmu.exitInitializationMode()
        observer.set({"q_BN": [0, 0, 0, 0]})
        assert observer.get("q_EN").tolist() == [1, 0, 0, 0]
        with pytest.raises(FMICallException):
            observer.get("omega_BN_B_est")
        refused(observer, "input q_BN has norm 0")


@pytest.mark.parametrize("name", ["Quest", "VectorPd", "GyroFreeStabilization"])
def test_measured_directions_are_unit_vectors(version: int, name: str) -> None:
    """With the tolerance of a quaternion: the square of the norm within 2 % of 1."""
    good = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.6, 0.8, 0.0]])
    with Raw(name, version).initialize(directions_B=good * [[1.009], [1.0], [0.991]]) as component:
        output = "q_BN_est" if name == "Quest" else "torque_B"
        component.get(output)
        for row, factor in ((0, 1.011), (1, 0.989), (2, 2.0), (2, 0.0)):
            scaled = good.copy()
            scaled[row] *= factor
            component.set({"directions_B": scaled})
            with pytest.raises(FMICallException):
                component.get(output)
            refused(component, f"input row {row + 1} of directions_B has norm {factor:g}: a unit vector is expected")
        component.set({"directions_B": good})
        component.get(output)


@pytest.mark.parametrize("name", ["Quest", "VectorPd", "GyroFreeStabilization", "UnitVectorSensor"])
def test_known_directions_may_have_any_length_but_zero(version: int, name: str) -> None:
    known = np.array([[0.0, 0.0, 3.0], [1e-3, 0.0, 0.0], [1.0, 1.0, 0.0]])
    Raw(name, version).initialize(directions_N=known).fmu.freeInstance()
    with Raw(name, version) as component:
        with pytest.raises(FMICallException):
            component.initialize(directions_N=known * [[1.0], [0.0], [1.0]])
        refused(component, "row 2 of directions_N is [0, 0, 0], but a direction is expected")


@pytest.mark.parametrize("value", [nan, inf, -inf])
@pytest.mark.parametrize(
    ("name", "inputs"),
    [
        ("RigidBody", ["torque_B", "torque_disturbance_B"]),
        ("StarTracker", ["q_BN"]),
        ("SmoothRateObserver", ["q_BN", "torque_B"]),
        ("PdTracking", ["q_BN", "omega_BN_B", "q_RN", "omega_RN_R", "omegaDot_RN_R"]),
    ],
)
def test_every_input_refuses_what_is_not_finite(version: int, name: str, inputs: list[str], value: float) -> None:
    with Raw(name, version).initialize() as component:
        for variable in inputs:
            good = component.get(variable)
            with pytest.raises(FMICallException):
                component.set({variable: [*good[:-1], value]})
            refused(component, f"{variable}[{good.size}] = {value:g} refused: a finite number is expected")
            assert component.get(variable).tolist() == good.tolist()


def test_bounds_of_parameters(version: int) -> None:
    with Raw("PdTracking", version) as controller:
        with pytest.raises(FMICallException):
            controller.set({"k_p": -1.0})
        refused(controller, "k_p = -1 refused: must be above 0")
    with Raw("StarTracker", version) as tracker:
        with pytest.raises(FMICallException):
            tracker.set({"half_angle": 2.0})
        refused(tracker, "half_angle = 2 refused: must be at most 1.5708")
        with pytest.raises(FMICallException):
            tracker.set({"seed": -1})
        refused(tracker, "seed = -1 refused: must be at least 0")
    with Raw("FixedAxisReference", version) as guidance:
        with pytest.raises(FMICallException):
            guidance.initialize(axis=[0, 0, 0])
        refused(guidance, "axis is [0, 0, 0]")


def test_what_may_not_be_set(version: int) -> None:
    with Raw("RigidBody", version).initialize() as body:
        with pytest.raises(FMICallException):
            body.set({"H_N": [1, 2, 3]})
        refused(body, "H_N can not be set because the component computes it")
        with pytest.raises(FMICallException):
            body.set({"q_BN": [1, 0, 0, 0]})
        refused(body, "q_BN can not be set after initialization")
    with Raw("PdTracking", version).initialize() as controller:
        controller.set({"k_p": 2.0})  # tunable
        with pytest.raises(FMICallException):
            controller.set({"J_B": np.diag([1.0, 1.0, 3.0])})
            controller.get("torque_B")
        refused(controller, "violates the triangle inequality")


def test_unknown_value_reference(version: int) -> None:
    with Raw("PdTracking", version).initialize() as controller:
        read, write = ("getReal", "setReal") if version == 2 else ("getFloat64", "setFloat64")
        with pytest.raises(FMICallException):
            getattr(controller.fmu, read)([4711])
        refused(controller, "value reference 4711 is not known")
        with pytest.raises(FMICallException):
            getattr(controller.fmu, write)([4711], [0.0])
        refused(controller, "value reference 4711 is not known")
        if version == 3:  # the second element of an array has no reference of its own
            with pytest.raises(FMICallException):
                controller.fmu.getFloat64([controller.references["q_BN"][0] + 1])
            refused(controller, "is not known")
            with pytest.raises(FMICallException):
                controller.fmu.setFloat64(controller.references["q_BN"], [1.0, 0.0])
            refused(controller, "2 values given, more expected")


def test_wrong_type(version: int) -> None:
    with Raw("StarTracker", version) as tracker:
        read = tracker.fmu.getReal if version == 2 else tracker.fmu.getFloat64
        with pytest.raises(FMICallException):
            read(tracker.references["seed"])
        refused(tracker, "seed has another type")
        with pytest.raises(FMICallException):
            tracker.fmu.getBoolean(tracker.references["q_BN"])
        refused(tracker, "has another type")


def test_calls_out_of_order(version: int) -> None:
    with Raw("RigidBody", version) as body:
        for call in (lambda: body.step(0.0, 0.1), body.fmu.exitInitializationMode, body.fmu.terminate):
            with pytest.raises(FMICallException):
                call()
            refused(body, "may not be called before initialization")
        body.initialize()
        with pytest.raises(FMICallException):
            body.enter()
        refused(body, "may not be called in step mode")
        body.step(0.0, 0.1)
        body.fmu.terminate()
        with pytest.raises(FMICallException):
            body.step(0.1, 0.1)
        refused(body, "may not be called after terminate")
    with Raw("RigidBody", version, cosim=False).initialize() as body:
        with pytest.raises(FMICallException):
            body.fmu.completedIntegratorStep()
        refused(body, "may not be called in event mode")


def test_interface_types_do_not_mix(version: int) -> None:
    with Raw("RigidBody", version).initialize() as body:
        function = body.fmu.dll.fmi2GetDerivatives if version == 2 else body.fmu.dll.fmi3GetContinuousStateDerivatives
        assert function(c_void_p(body.fmu.component), (c_double * 7)(), c_size_t(7)) == 3
        refused(body, "does not belong to the interface type of this instance")


def test_wrong_token(version: int) -> None:
    with pytest.raises(Exception, match="Failed to instantiate"):
        Raw("RigidBody", version, token="{not-mine}")


def test_unknown_log_category(version: int) -> None:
    with Raw("RigidBody", version) as body:
        with pytest.raises(FMICallException):
            body.fmu.setDebugLogging(True, ["logNonsense"])
        refused(body, "log category 'logNonsense' is not known")


def test_events_are_logged_on_request(version: int) -> None:
    with Raw("StarTracker", version, log=True).initialize(half_angle=0.01) as tracker:
        tracker.step(0.0, 0.25)
        samples = [text for _, category, text in tracker.messages if category == "logEvents" and "sample" in text]
        assert [s.split("'it': ")[1] for s in samples] == [
            "sample 0 at t = 0",
            "sample 1 at t = 0.1",
            "sample 2 at t = 0.2",
        ]
