"""Functions of one and of two numbers are off by less than 0.9 units in the last place, for every double there is."""

from collections.abc import Callable

import mpmath as mp
import numpy as np
import pytest
from elementary import Floats, apply
from hard_cases import near_quarter_turns

BOUND = 0.9
POINTS = 1_000_000
PERIODIC = ("sin", "cos", "tan")
EXACT: dict[str, Callable[..., mp.mpf]] = {
    **{name: getattr(mp, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh")},
    **{name: getattr(mp, name) for name in ("exp", "log", "atan2", "hypot")},
    "cbrt": lambda x: mp.sign(x) * mp.cbrt(abs(x)),
    "pow": mp.power,
}
IN_NUMPY = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2", "pow": "power"}
"""Where numpy has another name."""


def every_binade(rng: np.random.Generator, positive: bool = False) -> Floats:
    """Random bits: every exponent is as likely as any other, subnormals among them."""
    x = rng.integers(0, 0x7FF0000000000000, POINTS).view(np.float64)
    return x if positive else np.where(rng.random(POINTS) < 0.5, -x, x)


def arguments(function: str) -> tuple[Floats, ...]:
    """Dense where the function is used and where it is hard, and some of every size."""
    rng = np.random.default_rng(8)

    def uniform(low: float, high: float) -> Floats:
        return rng.uniform(low, high, POINTS)

    if function == "pow":
        near_one = 1 + uniform(-1e-3, 1e-3)
        bases = (uniform(0, 4), near_one, every_binade(rng, positive=True), every_binade(rng, positive=True))
        exponents = (uniform(-30, 30), uniform(-7e5, 7e5), uniform(-4, 4), every_binade(rng))
        return tuple(np.concatenate((*x, more)) for x, more in zip((bases, exponents), hard(function), strict=True))
    if function in ("atan2", "hypot"):
        sizes = 10.0 ** uniform(-17, 0)
        pairs = ((uniform(-1, 1), uniform(-1, 1) * sizes, every_binade(rng)) for _ in range(2))
        return tuple(np.concatenate((*x, more)) for x, more in zip(pairs, hard(function), strict=True))
    dense = {
        "sin": (uniform(-1, 1), uniform(-1000, 1000), uniform(-2e6, 2e6)),
        "asin": (uniform(-1, 1), uniform(-0.51, -0.49), 1 - 10 ** uniform(-16, -1)),
        "atan": (uniform(-1, 1), uniform(-4, 4)),
        "cosh": (uniform(-1, 1), uniform(-3, 3), uniform(-24, 24), uniform(-711, 711)),
        "exp": (uniform(-1, 1), uniform(-746, 710), uniform(-746, -708)),
        "log": (1 + uniform(-1e-3, 1e-3), uniform(0.25, 4), uniform(0, 1000)),
        "cbrt": (uniform(-1, 1), uniform(-1000, 1000)),
    }
    alike = {"cos": "sin", "tan": "sin", "acos": "asin", "sinh": "cosh", "tanh": "cosh"}
    any_size = every_binade(rng, positive=function == "log")
    if function in ("asin", "acos"):
        any_size = any_size[np.abs(any_size) <= 1]
    return (np.concatenate((*dense[alike.get(function, function)], any_size, *hard(function))),)


def hard(function: str) -> tuple[Floats, ...]:
    """Few, but all of them are compared with mpmath."""
    rng = np.random.default_rng(9)
    steps = np.arange(-20, 21)
    if function == "exp":
        ends = [709.782712893384, np.nextafter(709.782712893384, 800), -708.3964185322641, -745.1332191019411]
        ends += [-745.1332191019412, 5e-324, -5e-324, 2**-53, -(2**-54), 1e300, -1e300]
        return (np.concatenate((ends, 0.5 * np.log(2) * rng.integers(-2140, 2040, 500))),)
    if function == "log":
        near_one = 1 + np.ldexp(rng.integers(-1000, 1000, 500).astype(float), -52)
        return (np.concatenate((near_one[near_one != 1], 2.0 ** np.arange(-1074, 1024, 7), [5e-324, 1.7e308])),)
    if function in PERIODIC:
        turns = rng.integers(1, 2**50, 500) * (np.pi / 2)
        known = [6381956970095103 * 2.0**797, 5.319372648326541e255, 1e22, 2.0**20, np.nextafter(2.0**20, 2**21)]
        return (np.concatenate((known, turns, near_quarter_turns())),)
    if function in ("asin", "acos"):
        return (np.concatenate((1 + steps[:21] * 2.0**-53, 0.5 + steps * 2.0**-53, -0.5 - steps * 2.0**-53)),)
    if function == "atan":
        return (np.concatenate([x + steps * 2.0**-52 for x in (-1, 0.5, 1, 2)]),)
    if function in ("sinh", "cosh", "tanh"):
        edges = np.array([710.4758600739439, 710.475860073944, 709.782712893384, 22, 0.5 * np.log(2), 1.5 * np.log(2)])
        return (np.concatenate((edges, -edges, 0.5 + steps * 2.0**-53, [5e-324, 1e-320, 1e300])),)
    if function == "cbrt":
        cubes = rng.integers(1, 2**17, 500).astype(float) ** 3
        return (np.concatenate((cubes, -cubes * 2.0**300, [5e-324, 1.7e308], 2.0 ** np.arange(-1074, 1024, 7))),)
    size = 2.0 ** np.tile([-1074, -1022, -450, -400, 0, 400, 500, 990, 1023], 9).reshape(9, 9)
    if function == "pow":
        x = np.concatenate((np.linspace(0.1, 3, 500), 1 + steps * 2.0**-52, 2.0 ** np.arange(-1070, 1020, 7)))
        near_ends = rng.choice([709.7827, -708.3964, -745.13, 300.0], x.size)
        with np.errstate(divide="ignore"):
            y = near_ends / np.log(x)
        return np.where(np.isfinite(y), x, 2.0), np.where(np.isfinite(y), y, 3.0)
    sides = np.concatenate((size.ravel(), size.ravel() * 0.7, 0.5 + steps * 2.0**-53, [3, 20, 0.5, 1, 3e-320]))
    others = np.concatenate((size.T.ravel(), size.T.ravel() * -0.9, np.ones(steps.size), [-4, 21, 0.5, -1, 4e-320]))
    return sides, others


def ulp(exact: Floats) -> Floats:
    """Units in the last place of exact values, at most one step of the doubles around them."""
    return np.ldexp(1.0, np.maximum(np.frexp(np.abs(exact))[1] - 53, -1074))


def errors(function: str, *x: Floats) -> Floats:
    """In ulp, against mpmath."""
    got = apply(function, *x)
    error = np.empty(got.size)
    for i, (value, *numbers) in enumerate(zip(got, *x, strict=True)):
        with mp.workprec(250 + (max(0, int(np.frexp(numbers[0])[1])) if function in PERIODIC else 0)):
            exact = EXACT[function](*(mp.mpf(float(number)) for number in numbers))
            rounded = float(exact)
            if np.isfinite(value) and np.isfinite(rounded):
                error[i] = abs(mp.mpf(float(value)) - exact) / float(ulp(np.float64(rounded)))
            else:
                error[i] = 0.0 if value == rounded else np.inf
    return error


@pytest.mark.parametrize("function", EXACT)
def test_of_millions_of_arguments_none_is_further_off(function: str, record_property) -> None:
    long = np.longdouble
    if np.finfo(long).nmant < 63:
        pytest.skip("long double is no wider than double here: mpmath alone compares, at fewer points")
    x = arguments(function)
    got = apply(function, *x)
    with np.errstate(over="ignore", under="ignore"):
        exact = getattr(np, IN_NUMPY.get(function, function))(*(numbers.astype(long) for numbers in x))
        rounded = exact.astype(float)
        finite = np.isfinite(rounded)
        error = np.abs(got[finite] - exact[finite]) / ulp(rounded[finite])
    np.testing.assert_array_equal(got[~finite], rounded[~finite])
    worst = float(error.max())
    record_property("largest error [ulp]", worst)
    at = [numbers[finite][error.argmax()] for numbers in x]
    print(f"{function}: {got.size} arguments, off by {worst:.4f} ulp at most, at {at!r}")
    assert worst < BOUND
    suspects = np.argsort(error)[-200:]  # what is found exactly below
    assert errors(function, *(numbers[finite][suspects] for numbers in x)).max() < BOUND


@pytest.mark.parametrize("function", EXACT)
def test_against_mpmath(function: str, record_property) -> None:
    rng = np.random.default_rng(10)
    everywhere = arguments(function)
    some = rng.integers(0, everywhere[0].size, 2000)
    x = [np.concatenate((few, many[some])) for few, many in zip(hard(function), everywhere, strict=True)]
    error = errors(function, *x)
    record_property("largest error [ulp]", float(error.max()))
    at = [numbers[error.argmax()] for numbers in x]
    print(f"{function}: {error.size} arguments, off by {error.max():.4f} ulp at most, at {at!r}")
    assert error.max() < BOUND


def test_hard_cases_are_hard() -> None:
    x = near_quarter_turns()
    assert x.size > 3000
    assert 6381956970095103 * 2.0**797 in x  # the double that comes nearest to a multiple of pi/2
    assert np.minimum(np.abs(apply("sin", x)), np.abs(apply("cos", x))).min() < 2**-60
