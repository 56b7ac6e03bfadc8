"""What is not finite is an error wherever it arises; a step that fails ends where everything was still sound."""

import ctypes
from math import isfinite

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from tests.one_fmu import Raw

from .points import NAMES, arrays, near, starts

VERSIONS = (2, 3)


def fmi3_step(raw: Raw, time: float, size: float) -> tuple[int, float]:
    """Status and last successful time; fmpy gives none after an error."""
    flags, reached = [ctypes.c_bool() for _ in range(3)], ctypes.c_double(-1.0)
    status = raw.fmu.dll.fmi3DoStep(
        ctypes.c_void_p(raw.fmu.component),
        ctypes.c_double(time),
        ctypes.c_double(size),
        ctypes.c_bool(True),
        *map(ctypes.byref, flags),
        ctypes.byref(reached),
    )
    return status, reached.value


def last_successful_time(raw: Raw) -> float:
    value = ctypes.c_double(-1.0)
    assert raw.fmu.dll.fmi2GetRealStatus(ctypes.c_void_p(raw.fmu.component), 2, ctypes.byref(value)) == 0
    return value.value


@pytest.mark.parametrize("version", VERSIONS)
def test_a_failed_step_ends_at_the_last_sound_internal_step(version: int) -> None:
    """Spun so fast, and turned about a wrong axis, the body leaves the numbers within a step."""
    start = {"omega_BN_B": [3000.0, 2000.0, 1000.0], "J_B": np.diag([10.0, 19.0, 25.0]), "torque_B": [1.0, 0.0, 0.0]}
    with Raw("RigidBody", version).initialize(**start) as body, Raw("RigidBody", version).initialize(**start) as other:
        if version == 3:
            status, reached = fmi3_step(body, 0.0, 1.0)
            assert status == 3
        else:
            with pytest.raises(FMICallException):
                body.step(0.0, 1.0)
            reached = last_successful_time(body)
        text = body.messages[-1][2]
        assert "is -nan" in text or "is nan" in text or "is inf" in text or "is -inf" in text
        assert "after an internal step of 0.01 s; max_internal_step makes it smaller" in text
        assert 0.0 < reached < 1.0
        assert body.get("time") == reached
        steps = round(reached / 0.01)
        assert reached == pytest.approx(0.01 * steps, abs=1e-12)
        other.step(0.0, reached)  # so far another instance comes without an error
        assert other.to_bytes(other.save())[64:72] == body.to_bytes(body.save())[64:72]
        with pytest.raises(FMICallException):
            other.step(reached, 0.01)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_sample_that_is_not_finite_stays_untaken(version: int) -> None:
    settings = {"period": 0.1, "omega_BN_B": [1.0, 2.0, 3.0]}
    with Raw("InertiaMismatch", version).initialize(**settings) as mismatch:
        before = mismatch.get("torque_B").tolist()
        assert isfinite(before[0])
        mismatch.set({"omega_BN_B": [1e200, 1e200, -1e200]})
        with pytest.raises(FMICallException):
            mismatch.step(0.0, 0.35)
        text = mismatch.messages[-1][2]
        assert "at t = 0: output torque_B[" in text
        assert mismatch.get("time") == 0.0
        mismatch.restore(mismatch.save())
        mismatch.set({"omega_BN_B": [1.0, 2.0, 3.0]})
        assert mismatch.get("torque_B").tolist() == before
        mismatch.step(0.0, 0.35)


def test_a_directional_derivative_that_is_not_finite() -> None:
    with Raw("RigidBody", 2).initialize(omega_BN_B=[0.0, 0.0, 100.0]) as body:
        with pytest.raises(FMICallException):
            body.fmu.getDirectionalDerivative(
                body.references["der(omega_BN_B)"], body.references["omega_BN_B"], [0.0, 1e308, 0.0]
            )
        assert "the directional derivative of the derivative of omega_BN_B[" in body.messages[-1][2]


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", NAMES)
def test_what_is_answered_is_finite(name: str, version: int) -> None:
    """Inputs of all sizes: a value, or an error."""
    rng = np.random.default_rng(NAMES.index(name))
    inputs = [v for v in starts(name) if v in unbounded(name)]
    for size in (1.0, 1e80, 1e160, 1e300):
        with Raw(name, version) as raw:
            raw.enter()
            try:
                for variable in inputs:
                    raw.set({variable: size * near(rng, name, variable, starts(name)[variable])})
                raw.fmu.exitInitializationMode()
                raw.step(0.0, 0.02)
            except FMICallException:
                assert raw.messages[-1][0] == 3
            for variable in raw.references:
                if variable in raw.integers:
                    continue
                try:
                    assert np.isfinite(raw.get(variable)).all()
                except FMICallException:
                    assert " is " in raw.messages[-1][2]


def unbounded(name: str) -> set[str]:
    """Inputs that may have any size."""
    return {
        v.name
        for v in arrays(name).values()
        if v.causality == "input" and v.max is None and not (v.description or "").endswith(")")
    }
