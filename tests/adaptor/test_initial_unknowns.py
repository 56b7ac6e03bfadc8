"""Initial unknowns say all that they depend on: whatever start value is changed, only those that list it change."""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from tests.one_fmu import Raw, unpacked

from .points import NAMES, arrays, near, starts

START = 1.234  # no instant of any sampling clock


def initialized(raw: Raw, values: dict[str, np.ndarray]) -> dict[str, np.ndarray] | None:
    """All floats after initialization; None where the component refuses the values."""
    raw.fmu.reset()
    try:
        raw.initialize(START, **values)
        return {name: raw.get(name) for name in raw.references if name not in raw.integers}
    except FMICallException:
        return None


def declared(name: str, version: int) -> dict[str, set[str]]:
    """Known names by the name of the unknown."""
    structure = unpacked(name, version)[1].initialUnknowns
    return {u.variable.name: {d.name for d in u.dependencies} for u in structure}


def element(name: str, variable: str, index: int, version: int) -> str:
    """Its name in the model description: of the element in FMI 2.0, of the array in FMI 3.0."""
    if version == 3:
        return variable
    if variable.startswith("der(") and not variable.endswith(")"):
        variable += ")"  # Raw cuts the name of der(x[1]) at the bracket
    shape = [int(d.start) for d in arrays(name)[variable].dimensions]
    if not shape:
        return variable
    position = ",".join(str(i + 1) for i in np.unravel_index(index, shape))
    return f"der({variable[4:-1]}[{position}])" if variable.startswith("der(") else f"{variable}[{position}]"


def changes(raw: Raw, name: str, variable: str, index: int, base: dict[str, np.ndarray]) -> list[dict[str, np.ndarray]]:
    """What comes of the base with one element changed by little, so that no threshold is crossed."""
    v = arrays(name)[variable]
    found = []
    if v.type != "Float64":
        amounts: tuple[float, ...] = (1, -1)
    elif (v.description or "").endswith(")") and v.dimensions:
        amounts = (3e-3, 1e-10)
    else:
        amounts = (1e-5,)
    for amount in amounts:
        changed = base[variable].copy()
        changed.flat[index] += amount
        result = initialized(raw, base | {variable: changed})
        if result is not None:
            found.append(result)
    return found


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", NAMES)
def test_no_dependency_is_missing(name: str, version: int) -> None:
    rng = np.random.default_rng(NAMES.index(name))
    unknowns = declared(name, version)
    tried = 0
    with Raw(name, version) as raw:
        near_start = {n: near(rng, name, n, x) for n, x in starts(name).items()}
        base = near_start if initialized(raw, near_start) is not None else starts(name)
        before = initialized(raw, base)
        assert before is not None
        for variable in base:
            for index in range(base[variable].size):
                known = element(name, variable, index, version)
                for after in changes(raw, name, variable, index, base):
                    tried += 1
                    for unknown, value in after.items():
                        for at in np.flatnonzero(value != before[unknown]):
                            listed = unknowns.get(element(name, unknown, int(at), version))
                            assert listed is None or known in listed, f"{unknown}[{at}] depends on {known}"
    assert tried > 0
    assert unknowns


@pytest.mark.parametrize(
    ("name", "unknown", "known"),
    [
        ("StarTracker", "q_BN_meas[2]", {"seed", "redraw_period", "half_angle", "q_BN[2]"}),
        ("GyroFreeStabilization", "torque_B[1]", {"filter_at_rest", "q_RN[1]", "q_RN[4]"}),
        ("RigidBody", "der(q_BN[1])", {"q_BN[1]", "q_BN[2]", "q_BN[3]", "q_BN[4]"}),
        ("CommandedReference", "q_SN[1]", {"engaged", "q_CN[1]", "q_RN[1]", "q_BN[3]"}),
        ("Quest", "q_BN_est[1]", {"q_BN_first[1]", "q_BN_first[2]"}),
    ],
)
def test_integers_and_what_normalisation_couples_are_listed(name: str, unknown: str, known: set[str]) -> None:
    assert known <= declared(name, 2)[unknown]
    assert {k.split("[")[0] for k in known} <= declared(name, 3)[unknown.split("[")[0].replace("der(q_BN", "der(q_BN)")]


def test_what_is_not_coupled_is_not_listed() -> None:
    """A run does not normalise, and has no parameters among its knowns."""
    running = {u.variable.name: {d.name for d in u.dependencies} for u in unpacked("RigidBody", 2)[1].derivatives}
    assert running["der(q_BN[1])"] == {
        "q_BN[2]",
        "q_BN[3]",
        "q_BN[4]",
        "omega_BN_B[1]",
        "omega_BN_B[2]",
        "omega_BN_B[3]",
    }
