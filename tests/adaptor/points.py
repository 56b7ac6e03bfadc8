"""Values for any component: near its start values, fit for what it declares, and away from where terms vanish."""

from functools import lru_cache

import numpy as np
from fmpy.model_description import ScalarVariable

from fmus import catalog
from tests.one_fmu import unpacked

NAMES = tuple(c.name for c in catalog.components())
_MATRICES = ("(inertia matrix)", "(positive definite)", "(positive semidefinite)")


@lru_cache
def arrays(name: str) -> dict[str, ScalarVariable]:
    """The variables of a component as FMI 3.0 has them."""
    return {v.name: v for v in unpacked(name, 3)[1].modelVariables}


def start_of(v: ScalarVariable) -> np.ndarray:
    """Its start value; a Boolean is 0 or 1."""
    words = v.start if isinstance(v.start, list) else v.start.split()
    if v.type == "Boolean":
        return np.array([word == "true" for word in words], int)
    return np.array(words, float if v.type == "Float64" else int)


def starts(name: str) -> dict[str, np.ndarray]:
    """Variables that have a start value: inputs, parameters, states."""
    return {v.name: start_of(v) for v in arrays(name).values() if v.start is not None}


def near(rng: np.random.Generator, name: str, variable: str, start: np.ndarray) -> np.ndarray:
    """A value that the component takes; a unit quaternion is off by less than what is taken for rounded."""
    v = arrays(name)[variable]
    if v.type != "Float64":
        return start
    text = v.description or ""
    if text.endswith(_MATRICES):
        return start * (1 + 0.01 * rng.uniform())
    if text.endswith(("(unit quaternion)", "(unit vectors)")):
        return start + rng.uniform(-2e-3, 2e-3, start.shape)
    if v.unit == "s":  # periods and bounds on steps: a hundredth of one would take long
        return np.where((start == 0) & (v.causality == "parameter"), 0.05, start) * (1 + 0.3 * rng.uniform())
    value = start + rng.uniform(0.001, 0.01, start.shape) * (1 + np.abs(start))
    return np.minimum(value, np.inf if v.max is None else float(v.max))


def tunable(name: str) -> list[str]:
    """What may be set during a run."""
    return [
        v.name
        for v in arrays(name).values()
        if v.causality == "input" or (v.causality == "parameter" and v.variability == "tunable")
    ]
