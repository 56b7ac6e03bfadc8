"""Adjoint derivatives of FMI 3.0 are the transpose of the directional ones, and refused where those are."""

from __future__ import annotations

import re

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from tests.one_fmu import Raw, unpacked

from .points import NAMES, arrays, near, starts

STARTS, STEP = (0.0, 1.234, 1.234), 0.05  # s; the first is an instant of every sampling clock, the others of none
ROUNDING = 64 * np.finfo(float).eps


def knowns_and_unknowns(name: str) -> tuple[list[str], list[str]]:
    """Arrays of real numbers: inputs, states and tunable parameters; outputs and derivatives of states."""
    variables = [v for v in arrays(name).values() if v.type == "Float64"]
    structure = unpacked(name, 3)[1]
    states = {u.variable.derivative.name for u in structure.derivatives}
    knowns = [v.name for v in variables if v.causality in ("input", "parameter") or v.name in states]
    unknowns = [u.variable.name for u in [*structure.outputs, *structure.derivatives] if u.variable.type == "Float64"]
    return knowns, unknowns


def references(raw: Raw, names: list[str]) -> tuple[list[int], int]:
    """Their value references, and how many numbers they are."""
    return [raw.references[n][0] for n in names], sum(raw.sizes[n] for n in names)


def differentiable(raw: Raw, knowns: list[str], unknowns: list[str]) -> tuple[list[str], list[str]]:
    """Those that have derivatives: what is held since a sample has none."""

    def has(known: str, unknown: str) -> bool:
        try:
            seed = [0.0] * raw.sizes[known]
            raw.fmu.getDirectionalDerivative(
                [raw.references[unknown][0]], [raw.references[known][0]], seed, raw.sizes[unknown]
            )
        except FMICallException:
            assert re.search(" has no derivative$| is not an ", raw.messages[-1][2]), raw.messages[-1][2]
            return False
        return True

    left = [u for u in unknowns if any(has(k, u) for k in knowns)]
    return [k for k in knowns if any(has(k, u) for u in left)], left


@pytest.mark.parametrize("name", NAMES)
def test_they_are_the_transpose_of_the_directional_ones(name: str) -> None:
    rng = np.random.default_rng(NAMES.index(name))
    compared = 0
    with Raw(name, 3) as raw:
        for start_time in STARTS:
            raw.fmu.reset()
            values = {n: near(rng, name, n, start) for n, start in starts(name).items()}
            raw.initialize(start_time, **values)
            for stepped in (False, True):
                if stepped:
                    sampled = start_time == 0.0 and "period" in values  # at the end, too: some are zero at the first
                    raw.step(start_time, values["period"].item() if sampled else STEP)
                knowns, unknowns = differentiable(raw, *knowns_and_unknowns(name))
                (k, n_k), (u, n_u) = references(raw, knowns), references(raw, unknowns)
                if not u:
                    continue
                columns = [raw.fmu.getDirectionalDerivative(u, k, list(e), n_u) for e in np.eye(n_k)]
                jacobian = np.array(columns).T
                v, direction = rng.normal(size=n_u), rng.normal(size=n_k)
                adjoint = np.array(raw.fmu.getAdjointDerivative(u, k, v.tolist(), n_k))
                size = np.abs(v) @ np.abs(jacobian)
                assert (np.abs(adjoint - v @ jacobian) <= ROUNDING * size).all()
                along = np.array(raw.fmu.getDirectionalDerivative(u, k, direction.tolist(), n_u))
                both = size @ np.abs(direction)  # what cancels inside the component is larger, and not seen here
                assert abs(v @ along - adjoint @ direction) <= 1e3 * ROUNDING * max(both, np.abs(v) @ np.abs(along))
                compared += int(np.count_nonzero(adjoint))
    assert compared > 0


def test_a_known_or_unknown_given_twice_counts_twice() -> None:
    with Raw("RigidBody", 3).initialize(omega_BN_B=[0.1, 0.2, 0.3]) as body:
        rate, torque = body.references["der(omega_BN_B)"], body.references["torque_B"]
        once = body.fmu.getAdjointDerivative(rate, torque, [1.0, 2.0, 3.0], 3)
        assert body.fmu.getAdjointDerivative(rate, torque * 2, [1.0, 2.0, 3.0], 6) == [*once, *once]
        twice = body.fmu.getAdjointDerivative(rate * 2, torque, [1.0, 2.0, 3.0] * 2, 3)
        assert twice == [2 * value for value in once]
        assert body.fmu.getAdjointDerivative(rate, [], [1.0, 2.0, 3.0], 0) == []
        assert body.fmu.getAdjointDerivative([], torque, [], 3) == [0.0, 0.0, 0.0]


def test_values_and_states_are_as_they_were() -> None:
    with Raw("StarTracker", 3).initialize() as tracker:
        tracker.step(0.0, 0.05)
        before = {name: tracker.get(name).tolist() for name in tracker.references if name not in tracker.integers}
        knowns, unknowns = differentiable(tracker, *knowns_and_unknowns("StarTracker"))
        (k, n_k), (u, n_u) = references(tracker, knowns), references(tracker, unknowns)
        if u:
            tracker.fmu.getAdjointDerivative(u, k, [1.0] * n_u, n_k)
        assert {name: tracker.get(name).tolist() for name in before} == before


@pytest.mark.parametrize(
    ("unknown", "known", "seeds", "results", "message"),
    [
        ("der(omega_BN_B)", "torque_B", 2, 3, "fmi3GetAdjointDerivative: 2 values given, more expected"),
        ("der(omega_BN_B)", "torque_B", 4, 3, "fmi3GetAdjointDerivative: 4 values given, 3 expected"),
        ("der(omega_BN_B)", "torque_B", 3, 2, "fmi3GetAdjointDerivative: 2 values given, more expected"),
        ("der(omega_BN_B)", "torque_B", 3, 4, "fmi3GetAdjointDerivative: 4 values given, 3 expected"),
        ("torque_B", "torque_B", 3, 3, "fmi3GetAdjointDerivative: torque_B is not an output or derivative"),
        ("q_BN", "der(omega_BN_B)", 4, 3, "fmi3GetAdjointDerivative: omega_BN_B is not an input, state or parameter"),
        ("q_BN", "time", 4, 1, "fmi3GetAdjointDerivative: time has no derivative"),
    ],
)
def test_wrong_calls_are_refused(unknown: str, known: str, seeds: int, results: int, message: str) -> None:
    with Raw("RigidBody", 3).initialize() as body:
        with pytest.raises(FMICallException):
            body.fmu.getAdjointDerivative(body.references[unknown], body.references[known], [1.0] * seeds, results)
        assert message in body.messages[-1][2]


def test_they_are_refused_before_initialisation() -> None:
    with Raw("RigidBody", 3) as body:
        with pytest.raises(FMICallException):
            body.fmu.getAdjointDerivative(body.references["q_BN"], body.references["q_BN"], [1.0] * 4, 4)
        assert "fmi3GetAdjointDerivative" in body.messages[-1][2]


def test_a_reference_that_is_no_variable_and_a_null_pointer() -> None:
    with Raw("RigidBody", 3).initialize() as body:
        with pytest.raises(FMICallException):
            body.fmu.getAdjointDerivative([9999], body.references["torque_B"], [1.0], 3)
        assert "9999" in body.messages[-1][2]
        function = body.fmu._functions["fmi3GetAdjointDerivative"]
        assert function(body.fmu.component, None, 1, None, 1, None, 1, None, 1) == 3
        assert body.messages[-1][2] == "RigidBody 'it': fmi3GetAdjointDerivative: a pointer is NULL"
        assert function(body.fmu.component, None, 0, None, 0, None, 0, None, 0) == 0


@pytest.mark.parametrize(("weight", "text"), [(1e308, "inf"), (float("nan"), "nan")])
def test_what_is_not_finite_is_refused(weight: float, text: str) -> None:
    with Raw("RigidBody", 3).initialize(omega_BN_B=[0.0, 0.0, 100.0]) as body:
        rate, omega = body.references["der(omega_BN_B)"], body.references["omega_BN_B"]
        with pytest.raises(FMICallException):
            body.fmu.getAdjointDerivative(rate, omega, [weight, 0.0, 0.0], 3)
        message = body.messages[-1][2]
        assert "the adjoint derivative by omega_BN_B[" in message
        assert message.endswith(text)
