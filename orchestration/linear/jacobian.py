"""The Jacobian of one component in Model Exchange, where it stands: derivatives and outputs by states and inputs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from ctypes import POINTER, c_double
from dataclasses import dataclass
from itertools import accumulate, pairwise

import numpy as np

from orchestration.fmu.file import Fmu, Port
from orchestration.instances.instance import Instance
from orchestration.plan.lowering import Floats

_RELATIVE_STEP = 1e-3  # of differences, whose error is of the sixth order in it


@dataclass(frozen=True)
class Jacobian:
    """dx' = A dx + B du, dy = C dx + D du. `exact`: from directional derivatives rather than differences."""

    A: Floats
    B: Floats
    C: Floats
    D: Floats
    exact: bool


def jacobian(instance: Instance, inputs: Sequence[Port], outputs: Sequence[Port], x: Floats, scale: Floats) -> Jacobian:
    """Differentiate an instance in continuous-time mode; x (n,) is its state, `scale` (n,) the states' nominal values.

    Elements of inputs and outputs are in the order of the ports given. Directional derivatives are taken where the FMU
    says that it has them, else central differences.
    """
    n, m = len(x), sum(port.size for port in inputs)
    exact = instance.has_directional_derivatives
    columns = _directional(instance, inputs, outputs) if exact else _differences(instance, inputs, outputs, x, scale)
    rows = n + sum(port.size for port in outputs)
    matrix = np.array(columns).reshape(n + m, rows).T
    return Jacobian(matrix[:n, :n], matrix[:n, n:], matrix[n:, :n], matrix[n:, n:], exact)


def _directional(instance: Instance, inputs: Sequence[Port], outputs: Sequence[Port]) -> list[list[float]]:
    described = instance.fmu.model.derivatives
    unknowns = [unknown.variable.valueReference for unknown in described]
    unknowns += [reference for port in outputs for reference in port.references]
    size = len(instance.fmu.states) + sum(port.size for port in outputs)
    states = [u.variable.derivative for u in described]
    lengths = [instance.fmu.ports[u.variable.name].size if instance.major == 3 else 1 for u in described]
    knowns = [(state.valueReference, length) for state, length in zip(states, lengths, strict=True)]
    for port in inputs:  # one reference per element in FMI 2, per array in FMI 3
        knowns += [(reference, port.size // len(port.references)) for reference in port.references]
    columns = []
    for reference, length in knowns:
        for i in range(length):
            seed = [float(i == j) for j in range(length)]
            columns.append(instance.directional_derivative(unknowns, [reference], seed, size))
    return columns


def _differences(
    instance: Instance, inputs: Sequence[Port], outputs: Sequence[Port], x: Floats, scale: Floats
) -> list[Floats]:
    nominals = _nominals(instance.fmu)
    u = np.concatenate([np.empty(0), *(instance.get(p.references, p.size, type=p.type) for p in inputs)])
    steps = [*np.maximum(np.abs(x), scale), *(_size(v, nominals.get(r)) for v, r in zip(u, _each(inputs), strict=True))]
    cuts = list(pairwise(accumulate((port.size for port in inputs), initial=len(x))))

    def evaluate(point: Floats) -> Floats:
        if len(x):
            states = np.ascontiguousarray(point[: len(x)])
            pointer = states.ctypes.data_as(POINTER(c_double))
            instance.call("setContinuousStates", "setContinuousStates", pointer, len(x))
        for port, (first, last) in zip(inputs, cuts, strict=True):
            instance.set(port.references, point[first:last].tolist(), type=port.type)
        values = np.empty(len(x))
        if len(x):
            method = "getDerivatives" if instance.major == 2 else "getContinuousStateDerivatives"
            instance.call(method, method, values.ctypes.data_as(POINTER(c_double)), len(x))
        return np.concatenate([values, *(instance.get(p.references, p.size, type=p.type) for p in outputs)])

    here = np.concatenate([x, u])
    coarse = any(p.type == "Float32" for p in (*inputs, *outputs))
    columns = [_difference(evaluate, here, i, (0.1 if coarse else _RELATIVE_STEP) * s) for i, s in enumerate(steps)]
    evaluate(here)
    return columns


def _difference(f: Callable[[Floats], Floats], x: Floats, i: int, h: float) -> Floats:
    """Return df/dx_i from central differences over h, h/2 and h/4, extrapolated twice (Richardson)."""

    def central(h: float) -> Floats:
        ahead, behind = x.copy(), x.copy()
        ahead[i] += h
        behind[i] -= h
        slope: Floats = (f(ahead) - f(behind)) / (ahead[i] - behind[i])
        return slope

    result: Floats = (64 * central(h / 4) - 20 * central(h / 2) + central(h)) / 45
    return result


def _nominals(fmu: Fmu) -> dict[int, float]:
    return {v.valueReference: abs(float(v.nominal)) for v in fmu.model.modelVariables if v.nominal}


def _each(ports: Sequence[Port]) -> list[int]:
    """Return the value reference that each element belongs to."""
    return [r for port in ports for r in port.references for _ in range(port.size // len(port.references))]


def _size(value: float, nominal: float | None) -> float:
    """Return the size of the changes to be made to an input."""
    return max(abs(value), nominal) if nominal else abs(value) or 1.0
