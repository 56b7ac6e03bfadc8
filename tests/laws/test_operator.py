"""The components that an operator moves: the commanded reference and the torque switch."""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from .at_points import Point, opened, quaternion
from .fmu_access import VERSIONS
from .reference import Array, rate_along

POINTS = 20


def reference_point(rng: np.random.Generator) -> Point:
    vectors = {name: rng.normal(size=3) for name in ("omega_RN_R", "omegaDot_RN_R", "omega_CN_C")}
    quaternions = {name: quaternion(rng) for name in ("q_RN", "q_CN", "q_BN")}
    return {**quaternions, "engaged": np.array(rng.integers(2)), **vectors}


def selected(p: Point) -> dict[str, Array]:
    """By a choice, where the component has a sum."""
    if p["engaged"]:
        q_CN = min(p["q_CN"], -p["q_CN"], key=lambda q: np.linalg.norm(q - p["q_BN"]))
        return {"q_SN": q_CN, "omega_SN_S": p["omega_CN_C"], "omegaDot_SN_S": np.zeros(3)}
    return {"q_SN": p["q_RN"], "omega_SN_S": p["omega_RN_R"], "omegaDot_SN_S": p["omegaDot_RN_R"]}


def switch_point(rng: np.random.Generator) -> Point:
    return {"torque_B": rng.normal(size=3), "enabled": np.array(rng.integers(2))}


def switched(p: Point) -> dict[str, Array]:
    return {"torque_applied_B": p["torque_B"] if p["enabled"] else np.zeros(3)}


CASES = {"CommandedReference": (reference_point, selected), "TorqueSwitch": (switch_point, switched)}


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", CASES)
def test_one_of_both_passes_to_the_last_bit(name: str, version: int) -> None:
    draw, law = CASES[name]
    rng = np.random.default_rng(11)
    for _ in range(POINTS):
        point = draw(rng)
        with opened(name, version, point) as component:
            expected = law(point)
            assert set(component.names("output")) == set(expected)
            for variable, value in expected.items():
                # the unit quaternion is normalised as it comes in, by less than a rounding
                np.testing.assert_allclose(component.get(variable), value, rtol=0, atol=1e-15, err_msg=variable)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", CASES)
def test_directional_derivatives(name: str, version: int) -> None:
    draw, _ = CASES[name]
    rng = np.random.default_rng(12)
    for _ in range(4):
        point = draw(rng)
        with opened(name, version, point) as component:
            unknowns = component.names("output")
            for known in component.names("input"):

                def evaluate(_: float, x: Array, known: str = known) -> Array:
                    component.set({known: x})
                    return np.concatenate([component.get(u).ravel() for u in unknowns])  # noqa: B023

                for direction in np.eye(point[known].size):
                    analytic = component.directional(unknowns, known, direction)
                    numeric = rate_along(evaluate, 0.0, point[known], direction, h=2e-4)
                    component.set({known: point[known]})
                    np.testing.assert_allclose(analytic, numeric, rtol=0, atol=1e-8, err_msg=known)


@pytest.mark.parametrize(("name", "parameter"), [("CommandedReference", "engaged"), ("TorqueSwitch", "enabled")])
def test_a_switch_is_on_or_off(name: str, parameter: str) -> None:
    point = CASES[name][0](np.random.default_rng(1)) | {parameter: np.array(2)}
    with pytest.raises(FMICallException, match=r"SetBoolean failed"):
        opened(name, 2, point)  # in FMI 3 nothing else can be said
