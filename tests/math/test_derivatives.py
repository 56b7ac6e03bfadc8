"""Derivatives that lifted scalars carry: of every function, against mpmath; and at kinks, where one side is taken."""

from collections.abc import Callable

import mpmath as mp
import numpy as np
import pytest
from elementary import Floats, apply

RNG = np.random.default_rng(12)
ANY, UNIT, POSITIVE = RNG.uniform(-4, 4, 300), RNG.uniform(-1, 1, 300), RNG.uniform(1e-3, 20, 300)
BENT: dict[str, tuple[Floats, Callable[[mp.mpf], mp.mpf]]] = {
    "sin": (ANY, mp.cos),
    "cos": (ANY, lambda x: -mp.sin(x)),
    "sincos.sin": (ANY, mp.cos),
    "sincos.cos": (ANY, lambda x: -mp.sin(x)),
    "tan": (ANY, lambda x: 1 / mp.cos(x) ** 2),
    "asin": (UNIT, lambda x: 1 / mp.sqrt(1 - x**2)),
    "acos": (UNIT, lambda x: -1 / mp.sqrt(1 - x**2)),
    "atan": (10 * ANY, lambda x: 1 / (1 + x**2)),
    "sinh": (10 * ANY, mp.cosh),
    "cosh": (10 * ANY, mp.sinh),
    "tanh": (10 * ANY, lambda x: 1 / mp.cosh(x) ** 2),
    "exp": (10 * ANY, mp.exp),
    "log": (POSITIVE, lambda x: 1 / x),
    "sqrt": (POSITIVE, lambda x: 1 / (2 * mp.sqrt(x))),
    "cbrt": (ANY, lambda x: 1 / (3 * mp.cbrt(abs(x)) ** 2)),
}
TWO: dict[str, tuple[Floats, Floats, Callable[..., mp.mpf], Callable[..., mp.mpf]]] = {
    "atan2": (ANY, ANY[::-1], lambda y, x: x / (x**2 + y**2), lambda y, x: -y / (x**2 + y**2)),
    "hypot": (ANY, ANY[::-1], lambda x, y: x / mp.sqrt(x**2 + y**2), lambda x, y: y / mp.sqrt(x**2 + y**2)),
    "pow": (POSITIVE, ANY, lambda x, y: y * x ** (y - 1), lambda x, y: x**y * mp.log(x)),
    "fmod": (ANY, POSITIVE, lambda x, y: mp.mpf(1), lambda x, y: -mp.sign(x) * mp.floor(abs(x) / y)),
}


def in_mpmath(function: Callable[..., mp.mpf], *x: Floats) -> Floats:
    with mp.workprec(200):
        return np.array([float(function(*map(mp.mpf, map(float, numbers)))) for numbers in zip(*x, strict=True)])


@pytest.mark.parametrize("function", BENT)
def test_of_functions_of_one_number(function: str) -> None:
    x, slope = BENT[function]
    np.testing.assert_allclose(apply(f"slope of {function}", x), in_mpmath(slope, x), rtol=1e-15, atol=0)


@pytest.mark.parametrize("function", TWO)
def test_of_functions_of_two_numbers(function: str) -> None:
    x, y, first, second = TWO[function]
    np.testing.assert_allclose(apply(f"slope of {function}", x, y), in_mpmath(first, x, y), rtol=2e-15, atol=0)
    np.testing.assert_allclose(apply(f"second slope of {function}", x, y), in_mpmath(second, x, y), rtol=2e-15, atol=0)


def test_of_lengths_and_angles_of_every_size() -> None:
    for size in (1e-300, 1e300):
        x, y = np.array([3.0]) * size, np.array([4.0]) * size
        np.testing.assert_allclose(apply("slope of hypot", x, y), 0.6, rtol=1e-15)
        np.testing.assert_allclose(apply("slope of atan2", y, x), 0.12 / size, rtol=1e-15)


def slope(function: str, *x: float, which: str = "") -> float:
    return float(apply(f"{which}slope of {function}", *map(np.array, x))[0])


def test_of_whole_powers_of_what_is_not_positive() -> None:
    assert slope("pow", 0.0, 2.0) == 0.0
    assert slope("pow", 0.0, 1.0) == 1.0
    assert slope("pow", 0.0, 0.0) == 0.0
    assert slope("pow", -3.0, 3.0) == 27.0
    assert slope("pow", -3.0, 3.0, which="second ") == 0.0  # the exponent counts as constant
    assert slope("pow", 0.0, 2.0, which="second ") == 0.0


@pytest.mark.parametrize("function", ["floor", "ceil"])
def test_of_rounding_is_zero(function: str) -> None:
    assert slope(function, 0.3) == slope(function, 2.0) == 0.0


def test_at_a_kink_is_that_of_the_side_said() -> None:
    assert [slope("abs", x) for x in (-1.0, -0.0, 0.0, 1.0)] == [-1.0, 1.0, 1.0, 1.0]
    for function in ("min", "max"):
        assert (slope(function, 1.0, 1.0), slope(function, 1.0, 1.0, which="second ")) == (1.0, 0.0)
    assert (slope("min", 1.0, 2.0), slope("min", 1.0, 2.0, which="second ")) == (1.0, 0.0)
    assert (slope("max", 1.0, 2.0), slope("max", 1.0, 2.0, which="second ")) == (0.0, 1.0)
    assert [slope("clamp", x, -1.0, 1.0) for x in (-2.0, -1.0, 0.0, 1.0, 2.0)] == [0.0, 1.0, 1.0, 1.0, 0.0]
    assert [slope("copysign", x, -1.0) for x in (2.0, -2.0, 0.0)] == [-1.0, 1.0, -1.0]
    assert slope("copysign", 2.0, -1.0, which="second ") == 0.0
    assert slope("hypot", 0.0, 0.0) == slope("hypot", 0.0, 0.0, which="second ") == 0.0
    assert (slope("fmod", 2.0, 1.0), slope("fmod", 2.0, 1.0, which="second ")) == (1.0, -2.0)
    assert np.isnan(slope("atan2", 0.0, 0.0))  # there is none
