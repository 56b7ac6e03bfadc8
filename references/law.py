"""What an independent answer is, and what points of many components are drawn of."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .observer_pd import Array

Point = dict[str, Any]
"""Numbers and arrays by name."""
Values = Mapping[str, Any]
"""Of parameters, inputs and states, by name, and the time."""


def elementwise(name: str, expected: Array, point: Values) -> Array:
    """1e-12 relative, and absolute about zero."""
    return np.asarray(1e-12 + 1e-12 * np.abs(expected))


def of_the_whole(name: str, expected: Array, point: Values) -> Array:
    """1e-12 of the largest element, and absolute about zero."""
    return np.asarray(1e-12 * max(1.0, float(np.abs(expected).max())))


@dataclass(frozen=True)
class Law:
    """How to draw a point (parameters, states, inputs, time), and what the component must answer there."""

    draw: Callable[[np.random.Generator], Point]
    outputs: Callable[[Values], Point]
    rates: Callable[[Values], Point] = lambda _: {}
    rounding: Callable[[str, Array, Values], Array] = elementwise
    """How far a variable, by its name and expected value, may be off."""
    lengths: Mapping[str, float] = field(default_factory=dict)
    """What the change of a known is measured by, unless by its size; 0: it is a switch, which has no derivative."""
    revealing: Mapping[str, Any] = field(default_factory=dict)
    """Values under which all that an output depends on shows."""
    choosing: frozenset[tuple[str, str]] = frozenset()
    """Unknowns and knowns that choose them: such dependencies jump, and need not show in a derivative."""
    smooth: Mapping[str, Any] = field(default_factory=dict)
    """Values under which the law has the derivatives that an integrator of fourth order asks for."""


@dataclass(frozen=True)
class Sampled:
    """A law of instants: how to draw parameters, then inputs at each instant, and what the outputs are from then on.

    `step` is given the parameters, a memory that it keeps from instant to instant, and the inputs.
    """

    draw: Callable[[np.random.Generator], Point]
    inputs: Callable[[np.random.Generator], Point]
    step: Callable[[Values, dict[str, Any], Values], Point]
    revealing: Mapping[str, Any] = field(default_factory=dict)


def quaternion(rng: np.random.Generator) -> Array:
    q = rng.normal(size=4)
    return np.asarray(q / np.linalg.norm(q))


def inertia(rng: np.random.Generator) -> Array:
    """Of six unequal point masses, hence physical."""
    masses, places = rng.uniform(1, 5, 6), rng.normal(size=(6, 3))
    return np.sum([m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(masses, places, strict=True)], axis=0)


def definite(rng: np.random.Generator) -> Array:
    x = rng.normal(size=(3, 3))
    return np.asarray(x @ x.T + 0.1 * np.eye(3))
