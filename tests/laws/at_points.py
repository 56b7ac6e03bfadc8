"""A component alone at random points: outputs, derivatives and directional derivatives beside a recomputation."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from .fmu_access import Component, united, unpacked
from .reference import Array, rate_along

Point = dict[str, Array]
POINTS = 20

Close = Callable[[Any, Any, str], None]
"""Asserts that a value and the expected one agree; takes the variable's name for the message."""


def quaternion(rng: np.random.Generator) -> Array:
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


def inertia(rng: np.random.Generator) -> Array:
    """Of six unequal point masses, hence physical."""
    return np.sum(
        [
            m * (r @ r * np.eye(3) - np.outer(r, r))
            for m, r in zip(rng.uniform(1, 5, 6), rng.normal(size=(6, 3)), strict=True)
        ],
        axis=0,
    )


@dataclass(frozen=True)
class Law:
    """How to draw a point (parameters, states, inputs, time), and what the component must answer there."""

    draw: Callable[[np.random.Generator], Point]
    outputs: Callable[[Mapping[str, Any]], Point]
    rates: Callable[[Mapping[str, Any]], Point] = lambda _: {}


def draw(name: str, law: Law, n: int = POINTS) -> list[Point]:
    """Points of a component, the same in every run."""
    rng = np.random.default_rng(list(name.encode()))
    return [{k: np.asarray(v) for k, v in law.draw(rng).items()} for _ in range(n)]


def opened(name: str, version: int, point: Point) -> Component:
    """An instance at ``point``: its parameters as start values, then time, states and inputs while it runs."""
    component = Component(name, version, {n: v for n, v in point.items() if is_parameter(name, version, n)})
    component.at(float(point.get("time", 0.0)))
    component.set_states(point)
    component.set({n: v for n, v in point.items() if n in component.names("input")})
    return component


def is_parameter(name: str, version: int, variable: str) -> bool:
    array = united(unpacked(name, version)[1]).get(variable)
    return array is not None and array.first.causality == "parameter"


def compare(component: Component, law: Law, point: Point, close: Close, close_rates: Close | None = None) -> None:
    """Outputs and derivatives of a component that stands at ``point``."""
    outputs = law.outputs(point)
    assert set(outputs) == set(component.names("output"))
    for variable, expected in outputs.items():
        close(component.get(variable), expected, variable)
    rates, derivatives = law.rates(point), component.derivatives()
    assert set(derivatives) == set(rates)
    for state, expected in rates.items():
        (close_rates or close)(derivatives[state], expected, state)
        np.testing.assert_array_equal(component.get(f"der({state})"), derivatives[state])


def to_1e_12(ours: Any, expected: Any, variable: str) -> None:
    """Relative, and absolute about zero."""
    np.testing.assert_allclose(ours, expected, rtol=1e-12, atol=1e-12, err_msg=variable)


def same_bits(name: str, law: Law, opened: Callable[[str, int, Point], Component] = opened) -> None:
    """Both FMI versions give the same bits."""
    for point in draw(name, law, 3):
        with opened(name, 2, point) as two, opened(name, 3, point) as three:
            for variable in two.names("output", "local"):
                np.testing.assert_array_equal(two.get(variable), three.get(variable), err_msg=variable)


def directions(name: str, value: Array, inertias: Sequence[str] = ("J_B",)) -> list[Array]:
    """A basis of the admissible changes of a variable: an inertia stays symmetric."""
    basis = np.eye(value.size).reshape(-1, *value.shape)
    if name in inertias:
        return [(b + b.T) / 2 for b in basis if np.argmax(b) % 3 >= np.argmax(b) // 3]
    return list(basis)


Steps = Callable[[str, Array], tuple[float, float] | None]
"""Of a variable and its value: what the directions are multiplied with, and the step of the differences; None: none."""


def unknowns(component: Component) -> list[str]:
    """What is differentiated."""
    return component.names("output") + [f"der({state})" for state in component.states]


def slopes(
    component: Component,
    point: Point,
    directions: Callable[[str, Array], list[Array]] = directions,
    steps: Steps = lambda known, value: (1.0, 2e-4),
) -> Iterator[tuple[str, Array, Array]]:
    """Directional derivatives and central differences of sixth order, by every input, state and tunable parameter."""
    of = unknowns(component)

    def evaluate(known: str, x: Array) -> Array:
        change(component, point, known, x)
        return np.concatenate([np.ravel(component.get(u)) for u in of])

    for known in component.names("input") + component.states + tunable(component):
        value = point[known]
        chosen = steps(known, value)
        if chosen is None:
            continue
        size, h = chosen
        for direction in directions(known, value):
            analytic = component.directional(of, known, direction * size)
            numeric = rate_along(lambda _, x, known=known: evaluate(known, x), 0.0, value, direction * size, h=h)
            change(component, point, known, value)
            yield known, analytic, numeric


def tunable(component: Component) -> list[str]:
    return [n for n in component.names("parameter") if component.variables[n].first.variability == "tunable"]


def change(component: Component, point: Point, known: str, value: Array) -> None:
    if known in component.states:
        component.set_states({**point, known: value})
    elif known in tunable(component):
        with component.event():
            component.set({known: value})
    else:
        component.set({known: value})


def integrates_with_fourth_order(name: str, version: int, law: Law, point: Point) -> None:
    """Constant inputs over 2 s: the error falls 16-fold with half the internal step, and quaternions stay unit."""
    point = {n: v / 3 if n.startswith("omega") else v for n, v in point.items()} | {"time": np.array(0.0)}
    states = list(law.rates(point))
    sizes = np.cumsum([np.size(point[s]) for s in states])[:-1]

    def flow(t: float, x: Array) -> Array:
        at = dict(zip(states, np.split(x, sizes), strict=True))
        rates = law.rates({**point, **at, "time": t})
        return np.concatenate([np.ravel(rates[s]) for s in states])

    start = np.concatenate([np.ravel(point[s]) for s in states])
    exact = solve_ivp(flow, (0, 2), start, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    errors = []
    for step in (0.05, 0.025):
        values = {n: v for n, v in point.items() if n != "time"} | {"max_internal_step": step}
        with Component(name, version, values, co_simulation=True) as component:
            component.fmu.doStep(0.0, 2.0)
            x = {s: component.get(s) for s in states}
            errors.append(np.abs(np.concatenate([np.ravel(x[s]) for s in states]) - exact).max())
            for state in states:
                if state.startswith("q_"):
                    assert np.linalg.norm(x[state]) == pytest.approx(1, abs=1e-15)
    assert 14 < errors[0] / errors[1] < 18
