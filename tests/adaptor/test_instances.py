"""Saved states, reset, many instances at once."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from tests.one_fmu import Raw

VERSIONS = (2, 3)
NAMES = ("FixedAxisReference", "RigidBody", "StarTracker", "SmoothRateObserver", "PdTracking")
STARTS = {
    "RigidBody": {"q_BN": [0.5, 0.5, -0.5, 0.5], "omega_BN_B": [0.3, -0.2, 0.1], "torque_B": [0.1, 0.2, -0.3]},
    "StarTracker": {"q_BN": [0.5, 0.5, -0.5, 0.5], "half_angle": 0.1, "redraw_period": 0.03, "seed": 7},
    "SmoothRateObserver": {"q_BN": [0.5, 0.5, -0.5, 0.5], "omega_EN_E": [0.1, 0.2, 0.3]},
    "PdTracking": {"q_BN": [0.5, 0.5, -0.5, 0.5], "omega_BN_B": [0.1, 0.2, 0.3]},
    "FixedAxisReference": {"axis": [1, 2, 3]},
}


def outputs(raw: Raw) -> bytes:
    """Every float variable, to the bit."""
    names = [n for n in raw.references if n not in raw.integers]
    return np.concatenate([raw.get(n) for n in names]).tobytes()


def advance(raw: Raw, first: int, last: int, step: float = 0.02) -> bytes:
    for k in range(first, last):
        raw.step(k * step, step)
    return outputs(raw)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", NAMES)
def test_restored_and_deserialised_continue_to_the_bit(name: str, version: int) -> None:
    with Raw(name, version).initialize(**STARTS[name]) as one, Raw(name, version).initialize() as other:
        advance(one, 0, 7)
        state = one.save()
        data = one.to_bytes(state)
        expected = advance(one, 7, 40)
        one.restore(state)
        assert advance(one, 7, 40) == expected
        other.restore(other.from_bytes(data))
        assert advance(other, 7, 40) == expected


@pytest.mark.parametrize("version", VERSIONS)
def test_model_exchange_state_is_saved_with_its_mode_and_time(version: int) -> None:
    with Raw("RigidBody", version, cosim=False).initialize() as body:
        body.event_update()
        body.fmu.setTime(1.5)
        body.set_state_vector([0.5, 0.5, -0.5, 0.5, 0.1, 0.2, 0.3])
        before = body.rates(7).tobytes()
        state = body.save()
        body.fmu.setTime(2.0)
        body.set_state_vector([1, 0, 0, 0, 0, 0, 0])
        assert body.rates(7).tobytes() != before
        body.restore(state)
        assert body.rates(7).tobytes() == before
        assert body.get("time").tolist() == [1.5]


@pytest.mark.parametrize("version", VERSIONS)
def test_a_state_of_another_component_is_refused(version: int) -> None:
    with Raw("RigidBody", version).initialize() as body, Raw("PdTracking", version).initialize() as controller:
        data = body.to_bytes(body.save())
        with pytest.raises(FMICallException):
            controller.from_bytes(data)
        assert f"{len(data)} bytes given" in controller.messages[-1][2]
        own = controller.to_bytes(controller.save())
        with pytest.raises(FMICallException):
            controller.from_bytes(bytes(len(own)))
        assert "this is not a saved state" in controller.messages[-1][2]
    with Raw("PdTracking", version, cosim=False).initialize() as other:
        with pytest.raises(FMICallException):
            other.from_bytes(own)
        assert "not from this kind of component" in other.messages[-1][2]


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", NAMES)
def test_reset_is_a_new_instance(name: str, version: int) -> None:
    with Raw(name, version).initialize(**STARTS[name]) as used, Raw(name, version).initialize() as new:
        advance(used, 0, 10)
        used.fmu.reset()
        used.initialize()
        assert outputs(used) == outputs(new)
        assert advance(used, 0, 10) == advance(new, 0, 10)


def one_run(seed: int, version: int) -> bytes:
    rng = np.random.default_rng(seed)
    omega, torque = rng.uniform(-0.5, 0.5, 3), rng.uniform(-1, 1, 3)
    with Raw("RigidBody", version).initialize(omega_BN_B=omega, torque_B=torque) as body:
        return advance(body, 0, 50)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_hundred_instances_in_four_threads_do_not_disturb_each_other(version: int) -> None:
    alone = [one_run(seed, version) for seed in range(100)]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda seed: one_run(seed, version), range(100)))
    assert together == alone
    assert len(set(alone)) == 100


@pytest.mark.parametrize("version", VERSIONS)
def test_instances_alive_at_the_same_time_interleaved(version: int) -> None:
    bodies = [Raw("RigidBody", version).initialize(omega_BN_B=[0.01 * i, 0.2, -0.1]) for i in range(20)]
    for k in range(30):
        for body in bodies:
            body.step(k * 0.02, 0.02)
    for i, body in enumerate(bodies):
        with Raw("RigidBody", version).initialize(omega_BN_B=[0.01 * i, 0.2, -0.1]) as alone:
            assert outputs(body) == advance(alone, 0, 30)
        body.fmu.freeInstance()
