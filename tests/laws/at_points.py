"""A component alone beside its independent answer, at random points and from instant to instant."""

from collections.abc import Iterator
from itertools import product

import numpy as np
from scipy.integrate import solve_ivp

from references.answers import LAWS, SAMPLED
from references.law import Law, Point, of_the_whole
from references.observer_pd import Array, rate_along
from tests.one_fmu import Component, array_name, unpacked

POINTS = 24
INSTANTS = 6
SYMMETRIC = ("(inertia matrix)", "(positive definite)", "(positive semidefinite)")
"""How the descriptions of matrices end that stay symmetric."""


def rng_of(name: str) -> np.random.Generator:
    """The same in every run."""
    return np.random.default_rng(list(name.encode()))


def draw(name: str, n: int = POINTS) -> list[Point]:
    """Points of a component."""
    rng = rng_of(name)
    return [{k: np.asarray(v) for k, v in LAWS[name].draw(rng).items()} for _ in range(n)]


def opened(name: str, version: int, point: Point, co_simulation: bool = False) -> Component:
    """An instance at ``point``, where it started; time, states and inputs are set once more while it runs."""
    component = Component(name, version, {n: v for n, v in point.items() if n != "time"}, co_simulation)
    if not co_simulation:
        component.at(float(point.get("time", 0.0)))
        component.set_states(point)
        component.set({n: v for n, v in point.items() if n in component.names("input")})
    return component


def compare(component: Component, law: Law, point: Point) -> None:
    """Outputs and derivatives of a component that stands at ``point``."""
    outputs, rates, derivatives = law.outputs(point), law.rates(point), component.derivatives()
    assert set(outputs) == set(component.names("output"))
    assert set(derivatives) == set(rates)
    ours = {n: component.get(n) for n in outputs} | {f"der({n})": v for n, v in derivatives.items()}
    for name, expected in (outputs | {f"der({n})": v for n, v in rates.items()}).items():
        off = np.abs(ours[name] - expected)
        assert (off <= law.rounding(name, np.asarray(expected), point)).all(), f"{name}: {ours[name]} for {expected}"
    for state, value in derivatives.items():
        np.testing.assert_array_equal(component.get(f"der({state})"), value)


def check_points(name: str, version: int, n: int = POINTS) -> None:
    for point in draw(name, n):
        with opened(name, version, point) as component:
            compare(component, LAWS[name], point)


def check_instants(name: str, version: int, runs: int = 5) -> None:
    """Inputs that are set at an instant count, the last ones; those set between do not."""
    law, rng = SAMPLED[name], rng_of(name)
    for _ in range(runs):
        p, memory = law.draw(rng), {}
        period = float(p["period"])
        with Component(name, version, p, co_simulation=True) as component:
            for k in range(INSTANTS):
                component.set(law.inputs(rng))
                component.get(component.names("output")[0])
                u = law.inputs(rng)
                component.set(u)
                expected = law.step(p, memory, u)
                assert set(expected) == set(component.names("output"))
                for when in ("at", "after"):
                    for variable, value in expected.items():
                        bound = 2 * float(of_the_whole(variable, value, p))
                        seen, where = component.get(variable), f"{variable} {when} {k}"
                        np.testing.assert_allclose(seen, value, rtol=0, atol=bound, err_msg=where)
                    if when == "at":
                        component.fmu.doStep(k * period, 0.5 * period)
                        component.set(law.inputs(rng))
                component.fmu.doStep((k + 0.5) * period, 0.5 * period)


# --- directional derivatives ------------------------------------------------------------------------------------------


def unknowns(component: Component) -> list[str]:
    """What is differentiated."""
    return component.names("output") + [f"der({state})" for state in component.states]


def tunable(component: Component) -> list[str]:
    return [n for n in component.names("parameter") if component.variables[n].first.variability == "tunable"]


def directions(component: Component, name: str, value: Array) -> list[Array]:
    """A basis of the admissible changes: symmetric matrices stay so; a quaternion that is normalised, a unit one."""
    basis = list(np.eye(value.size).reshape(-1, *value.shape))
    text = component.variables[name].first.description or ""
    if text.endswith(SYMMETRIC):
        return [(b + b.T) / 2 for b in basis if np.argmax(b) % 3 >= np.argmax(b) // 3]
    if text.endswith("(unit quaternion)") and name in component.names("parameter"):
        return [b - (b @ value) * value for b in basis]
    return basis


def change(component: Component, point: Point, known: str, value: Array) -> None:
    if known in component.states:
        component.set_states({**point, known: value})
    elif known in tunable(component):
        with component.event():
            component.set({known: value})
    else:
        component.set({known: value})


def slopes(component: Component, point: Point, lengths: dict[str, float]) -> Iterator[tuple[str, Array, Array, Array]]:
    """By every input, state and tunable parameter: its name, directional derivatives, central differences of sixth
    order, and the size of what is differentiated; all for a change of the known by its own size."""
    of = unknowns(component)

    def evaluate(known: str, x: Array) -> list[Array]:
        change(component, point, known, x)
        return [np.ravel(component.get(u)) for u in of]

    for known in component.names("input") + component.states + tunable(component):
        value = point[known]
        length = lengths.get(known, float(np.abs(value).max()) or 1.0)
        if not length:
            continue
        values = evaluate(known, value)
        for direction in (length * d for d in directions(component, known, value)):
            analytic = component.directional(of, known, direction)
            numeric = rate_along(
                lambda _, x, known=known: np.concatenate(evaluate(known, x)), 0.0, value, direction, h=STEP
            )
            change(component, point, known, value)
            parts = np.split(numeric, np.cumsum([v.size for v in values])[:-1])
            sizes = [max(np.abs(v).max(), np.abs(p).max()) for v, p in zip(values, parts, strict=True)]
            yield (
                known,
                analytic,
                numeric,
                np.concatenate([np.full(v.size, s) for v, s in zip(values, sizes, strict=True)]),
            )


STEP = 5e-4


def check_slopes(name: str, version: int, n: int = 3) -> None:
    law = LAWS[name]
    for point in draw(name, n):
        with opened(name, version, point) as component:
            for known, analytic, numeric, size in slopes(component, point, dict(law.lengths)):
                off = np.abs(analytic - numeric)
                assert (off <= 1e-8 * np.maximum(size, 1e-6)).all(), f"by {known}: {analytic} for {numeric}"


def check_slopes_of_an_instant(name: str, version: int) -> None:
    """At the third instant, where all memory is in use, by every input."""
    law, rng = SAMPLED[name], np.random.default_rng(5)
    p = law.draw(rng)
    with Component(name, version, p, co_simulation=True) as component:
        for k in range(2):
            component.set(law.inputs(rng))
            component.fmu.doStep(k * float(p["period"]), float(p["period"]))
        point = law.inputs(rng)
        component.set(point)
        of = component.names("output")
        for known, value in point.items():

            def evaluate(_: float, x: Array, known: str = known) -> Array:
                component.set({known: x})
                return np.concatenate([component.get(u).ravel() for u in of])

            for direction in np.eye(value.size):
                analytic = component.directional(of, known, direction)
                numeric = rate_along(evaluate, 0.0, np.asarray(value), direction, h=2e-4)
                component.set(point)
                scale = max(1.0, float(np.abs(numeric).max()))
                np.testing.assert_allclose(analytic / scale, numeric / scale, atol=2e-8, err_msg=f"by {known}")


# --- dependencies -----------------------------------------------------------------------------------------------------


def standing(name: str, n: int = 6) -> Iterator[Component]:
    """The component where its dependencies show: at points, at their start, and at first and second instants."""
    if name in LAWS:
        for point, at_start in product(draw(name, n), (False, True)):
            with opened(name, 2, point | dict(LAWS[name].revealing), co_simulation=at_start) as component:
                yield component
    if name in SAMPLED:
        law, rng = SAMPLED[name], np.random.default_rng(8)
        for _ in range(n):
            p = law.draw(rng) | dict(law.revealing)
            with Component(name, 2, p, co_simulation=True) as component:
                for k in range(2):  # the first sample starts the memory, the second uses it
                    component.set(law.inputs(rng))
                    yield component
                    component.fmu.doStep(k * float(p["period"]), float(p["period"]))


def check_dependencies(name: str) -> None:
    """Element by element: none missing, none made up."""
    description = unpacked(name, 2)[1]
    of = [*description.outputs, *description.derivatives]
    knowns = [v for v in description.modelVariables if v.causality == "input"]
    knowns += [d.variable.derivative for d in description.derivatives]
    seen = np.zeros((len(knowns), len(of)))
    for component in standing(name):
        for i, known in enumerate(knowns):
            references = [u.variable.valueReference for u in of]
            slope = component.fmu.getDirectionalDerivative(references, [known.valueReference], [1.0])
            assert np.isfinite(slope).all()
            seen[i] = np.maximum(seen[i], np.abs(slope))
    found = {(u.variable.name, k.name) for i, k in enumerate(knowns) for j, u in enumerate(of) if seen[i, j] > 0}
    declared = {(u.variable.name, d.name) for u in of for d in u.dependencies if d.causality != "independent"}
    assert found <= declared
    unseen = {(array_name(unknown)[0], array_name(known)[0]) for unknown, known in declared - found}
    assert unseen <= (LAWS[name].choosing if name in LAWS else set())


# --- integration ------------------------------------------------------------------------------------------------------


def check_order(name: str, version: int) -> None:
    """Constant inputs over 2 s: the error falls 16-fold with half the internal step, and quaternions stay unit."""
    law = LAWS[name]
    (point,) = draw(name, 1)
    point = {n: v / 3 if n.startswith("omega") else v for n, v in point.items()} | dict(law.smooth)
    point |= {"time": np.array(0.0)}
    states = list(law.rates(point))
    sizes = np.cumsum([np.size(point[s]) for s in states])[:-1]
    shapes = [np.shape(point[s]) for s in states]

    def flow(t: float, x: Array) -> Array:
        at = {s: v.reshape(shape) for s, v, shape in zip(states, np.split(x, sizes), shapes, strict=True)}
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
        found = np.concatenate([np.ravel(x[s]) for s in states])
        errors.append(float((np.abs(found - exact) / np.maximum(1.0, np.abs(exact))).max()))
        for state in states:
            if state.startswith("q_"):
                assert abs(np.linalg.norm(x[state]) - 1) < 1e-15
    assert max(errors) < 1e-11 or 14 < errors[0] / errors[1] < 18, errors
