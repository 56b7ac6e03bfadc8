"""A saved state is the whole instance: what is restored continues to the bit and is as strict as before.

What is damaged is refused.
"""

import struct
from collections.abc import Callable

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from tests.one_fmu import Raw

from .points import NAMES, near, starts, tunable

VERSIONS = (2, 3)
CHECKSUM, TIME, CLOCK, MODE, FLAGS, VALUES = 8, 64, 88, 216, 228, 240
"""Offsets in a saved state, src/fmi/saved_state.hpp."""
TILTED = {
    "directions_B": [[0.0, 0.0, 1.0], [0.8, 0.6, 0.0], [0.6, 0.8, 0.0]],
    "omega_BN_B": [0.1, 0.2, 0.3],
}


def through_memory(raw: Raw) -> None:
    raw.restore(raw.save())


def through_bytes(raw: Raw) -> None:
    raw.restore(raw.from_bytes(raw.to_bytes(raw.save())))


ROUTES = (through_memory, through_bytes)


@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("cosim", [True, False])
@pytest.mark.parametrize("version", VERSIONS)
def test_what_was_refused_before_is_refused_after(version: int, cosim: bool, route: Callable[[Raw], None]) -> None:
    with Raw("RigidBody", version, cosim).initialize(omega_BN_B=[0.1, 0.2, 0.3]) as body:
        body.set({"J_B": np.diag([1.0, 1.0, -30.0])})
        for _ in range(2):
            with pytest.raises(FMICallException):
                body.get("kinetic_energy")
            assert "is not positive definite" in body.messages[-1][2]
            route(body)
        with pytest.raises(FMICallException):
            body.step(0.0, 0.1) if cosim else body.event_update()
        body.set({"J_B": np.eye(3)})
        assert body.get("kinetic_energy") == pytest.approx(0.07)


@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("version", VERSIONS)
def test_a_quaternion_set_before_is_normalised_after(version: int, route: Callable[[Raw], None]) -> None:
    """Left as it is, a reference attitude of norm 1.009 changes the torque of VectorPd by 1.8 %."""
    reference = 1.009 * np.array([0.8, 0.0, 0.6, 0.0])
    torques = []
    for save in (False, True):
        with Raw("VectorPd", version).initialize(**TILTED) as controller:
            controller.set({"q_RN": reference})
            if save:
                route(controller)
            torques.append(controller.get("torque_B"))
            assert controller.get("q_RN").tolist() == (reference / np.linalg.norm(reference)).tolist()
    assert torques[0].tolist() == torques[1].tolist()


@pytest.mark.parametrize("version", VERSIONS)
def test_inputs_set_before_are_checked_after(version: int) -> None:
    with Raw("PdTracking", version).initialize() as controller:
        controller.set({"q_BN": [0.5, 0.0, 0.0, 0.0]})
        through_bytes(controller)
        with pytest.raises(FMICallException):
            controller.get("torque_B")
        assert "input q_BN has norm 0.5" in controller.messages[-1][2]


def values(raw: Raw) -> bytes:
    return np.concatenate([raw.get(n) for n in sorted(raw.references) if n not in raw.integers]).tobytes()


@pytest.mark.parametrize("cosim", [True, False])
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", NAMES)
def test_any_sequence_continues_to_the_bit(name: str, version: int, cosim: bool) -> None:
    """Of two equal instances one is saved and restored, or continued by a third, after every call."""
    rng = np.random.default_rng([NAMES.index(name), version, cosim])
    start = {n: near(rng, name, n, x) for n, x in starts(name).items()}
    plain, saved = Raw(name, version, cosim), Raw(name, version, cosim)

    def both(call: Callable[[Raw], object]) -> None:
        nonlocal saved
        one, two = call(plain), call(saved)
        assert one == two
        if rng.integers(3) == 0:
            data = saved.to_bytes(saved.save())
            other = Raw(name, version, cosim)
            if rng.integers(2):
                other.initialize()
            other.restore(other.from_bytes(data))
            saved.fmu.freeInstance()
            saved = other
        else:
            through_memory(saved)

    def set_both(variable: str, value: np.ndarray) -> None:
        both(lambda raw: raw.set({variable: value}))

    for variable, value in start.items():
        set_both(variable, value)
    both(lambda raw: raw.enter(0.7))
    if rng.integers(2):
        both(values)
    both(lambda raw: raw.fmu.exitInitializationMode())
    time, free = 0.7, [n for n in tunable(name) if n not in plain.integers]
    for _ in range(12):
        for variable in rng.permutation(free)[:2]:
            set_both(variable, near(rng, name, variable, starts(name)[variable]))
        if rng.integers(2):
            both(values)
        size = float(rng.choice([0.01, 0.03, 0.1]))
        if cosim:
            both(lambda raw, time=time, size=size: raw.step(time, size))
        else:
            both(lambda raw: raw.event_update())
            both(lambda raw, time=time, size=size: raw.fmu.setTime(time + size))
            both(lambda raw: raw.fmu.enterEventMode())
        time += size
    both(values)
    plain.fmu.freeInstance()
    saved.fmu.freeInstance()


def checksum(data: bytes) -> int:
    total = 0xCBF29CE484222325
    for (word,) in struct.iter_unpack("<Q", data):
        total = ((total ^ word) * 0x100000001B3) % 2**64
        total ^= total >> 32
    return total


def forged(data: bytes, offset: int, value: bytes) -> bytes:
    """With other bytes at an offset, and the checksum that belongs to them."""
    changed = data[:offset] + value + data[offset + len(value) :]
    return changed[:CHECKSUM] + struct.pack("<Q", checksum(changed[16:])) + changed[16:]


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", ["RigidBody", "StarTracker"])
def test_every_damaged_byte_is_seen(name: str, version: int) -> None:
    with Raw(name, version).initialize() as raw:
        data = raw.to_bytes(raw.save())
        assert forged(data, TIME, data[TIME : TIME + 8]) == data
        before = values(raw)
        for at in range(len(data)):
            with pytest.raises(FMICallException):
                raw.from_bytes(data[:at] + bytes([data[at] ^ 0x80]) + data[at + 1 :])
        assert "the saved state is damaged, its checksum does not fit" in raw.messages[-1][2]
        two_signs = bytearray(data)
        two_signs[-1] ^= 0x80
        two_signs[-9] ^= 0x80
        for wrong in (bytes(two_signs), data[:-8], data + bytes(8), b""):
            with pytest.raises(FMICallException):
                raw.from_bytes(wrong)
        assert values(raw) == before


@pytest.mark.parametrize(
    ("name", "offset", "value", "expected"),
    [
        ("RigidBody", 4, struct.pack("<I", 1), "has format 1, expected 3"),
        ("RigidBody", TIME, struct.pack("<d", np.nan), "has the times nan"),
        ("RigidBody", TIME, struct.pack("<d", 3.0), "has the times 3"),
        ("RigidBody", MODE, struct.pack("<I", 8), "has no mode of this interface: 8"),
        ("RigidBody", MODE, struct.pack("<I", 3), "has no mode of this interface: 3"),
        ("RigidBody", FLAGS, b"\0", "not from this kind of component"),
        ("RigidBody", FLAGS + 1, b"\2", "a flag that is neither 0 nor 1"),
        ("RigidBody", VALUES + 8 * 7, struct.pack("<d", -1.0), "J_B = [-1 1.2 0.5"),
        ("RigidBody", VALUES + 8 * 16, struct.pack("<d", np.inf), "q_BN[1] = inf"),
        ("RigidBody", MODE + 4, struct.pack("<I", 1), "has events of no event function"),
        ("RigidBody", MODE + 8, struct.pack("<I", 2), "has events of no event function"),
        ("RigidBody", FLAGS + 8, b"\1", "has events of no event function"),
        ("RigidBody", TIME + 16, struct.pack("<d", np.nan), "the latest event of the saved state was at t = nan"),
        ("StarTracker", CLOCK, struct.pack("<d", 1e-12), "the clock of the saved state does not fit"),
        (
            "StarTracker",
            CLOCK + 16,
            struct.pack("<q", 10**6),
            "the clock of the saved state does not fit: sample 1000000",
        ),
        ("StarTracker", VALUES + 8 * 7, struct.pack("<d", np.nan), "seed = nan in the saved state, but an integer"),
        ("StarTracker", VALUES + 8 * 6, struct.pack("<d", -0.1), "redraw_period = -0.1 in the saved state"),
    ],
)
@pytest.mark.parametrize("version", VERSIONS)
def test_fields_that_no_instance_can_have_are_named(
    version: int, name: str, offset: int, value: bytes, expected: str
) -> None:
    settings = {"half_angle": 0.1} if name == "StarTracker" else {}
    with Raw(name, version).initialize(**settings) as raw:
        raw.step(0.0, 0.01)
        before = values(raw)
        data = raw.to_bytes(raw.save())
        with pytest.raises(FMICallException):
            raw.restore(raw.from_bytes(forged(data, offset, value)))
        assert expected in raw.messages[-1][2]
        assert values(raw) == before
        raw.step(0.01, 0.01)


@pytest.mark.parametrize("version", VERSIONS)
def test_reset_takes_everything_back(version: int) -> None:
    """Also what is known: an inertia that was checked is not taken for checked after a reset."""
    with Raw("StarTracker", version).initialize(start=3.0, half_angle=0.1) as used, Raw("StarTracker", version) as new:
        used.step(3.0, 0.25)
        used.fmu.reset()
        assert used.to_bytes(used.save()) == new.to_bytes(new.save())
