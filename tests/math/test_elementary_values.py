"""Values that are exact: at zero, at infinity, for no number, of what rounds or chooses; sincos beside sin and cos."""

from fractions import Fraction

import numpy as np
import pytest
from elementary import apply
from hard_cases import near_quarter_turns

INF, NAN, TINY = np.inf, np.nan, 5e-324

SPECIAL = {
    "sin": {0.0: 0.0, TINY: TINY, -TINY: -TINY, 1e-310: 1e-310, INF: NAN, -INF: NAN, NAN: NAN},
    "cos": {0.0: 1.0, TINY: 1.0, -1e-9: 1.0, INF: NAN, -INF: NAN, NAN: NAN},
    "exp": {0.0: 1.0, -TINY: 1.0, 709.79: INF, 1e308: INF, INF: INF, -745.14: 0.0, -1e308: 0.0, -INF: 0.0, NAN: NAN},
    "log": {1.0: 0.0, 0.0: -INF, -TINY: NAN, -1.0: NAN, -INF: NAN, INF: INF, NAN: NAN},
}


@pytest.mark.parametrize("function", SPECIAL)
def test_special_values(function: str) -> None:
    pairs = [*SPECIAL[function].items(), (-0.0, {"sin": -0.0, "cos": 1.0, "exp": 1.0, "log": -INF}[function])]
    x, expected = (np.array(column) for column in zip(*pairs, strict=True))
    got = apply(function, x)
    np.testing.assert_array_equal(got, expected)
    number = ~np.isnan(expected)
    np.testing.assert_array_equal(np.signbit(got[number]), np.signbit(expected[number]))


@pytest.fixture(scope="module")
def angles() -> np.ndarray:
    rng = np.random.default_rng(3)
    return np.concatenate((rng.uniform(-100, 100, 100_000), near_quarter_turns(), [0.0, -0.0, TINY, 1e300]))


@pytest.mark.parametrize("function", ["sin", "cos"])
def test_sincos_gives_the_digits_of_each_alone(function: str, angles: np.ndarray) -> None:
    np.testing.assert_array_equal(apply(f"sincos.{function}", angles), apply(function, angles))


@pytest.mark.parametrize("function", ["sin", "cos"])
def test_odd_and_even(function: str, angles: np.ndarray) -> None:
    sign = -1.0 if function == "sin" else 1.0
    np.testing.assert_array_equal(apply(function, -angles), sign * apply(function, angles))


def bits(x: np.ndarray) -> np.ndarray:
    """Zeros have a sign, and there is one NaN."""
    return np.where(np.isnan(x), NAN, x).view(np.int64)


def signed(*x: float) -> np.ndarray:
    """With the numbers their opposites."""
    return np.array([s * number for number in x for s in (1.0, -1.0)])


EVERY = signed(0.0, TINY, 1e-310, 0.3, 0.5, 1.0, 1.5, 2.0, 3.0, 22.3, 4503599627370495.5, 2.0**53, 1e300, INF, NAN)
ONE = {name: name for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "cbrt")} | {
    "asin": "arcsin",
    "acos": "arccos",
    "atan": "arctan",
    "floor": "floor",
    "ceil": "ceil",
    "abs": "abs",
}
TWO = {"atan2": "arctan2", "pow": "power", "hypot": "hypot", "fmod": "fmod", "copysign": "copysign"}
"""What numpy calls them: it takes them from the C library, which has the special values of the standard."""


def assert_close(got: np.ndarray, expected: np.ndarray) -> None:
    """Special values and signs of zeros exactly, others to two units in the last place."""
    np.testing.assert_allclose(got, expected, rtol=4.5e-16, atol=0)
    number = ~np.isnan(expected)
    np.testing.assert_array_equal(np.signbit(got[number]), np.signbit(expected[number]))


@pytest.mark.parametrize("function", ONE)
@np.errstate(all="ignore")
def test_special_values_of_one_number_are_those_of_the_standard(function: str) -> None:
    assert_close(apply(function, EVERY), getattr(np, ONE[function])(EVERY))


@pytest.mark.parametrize("function", TWO)
@np.errstate(all="ignore")
def test_special_values_of_two_numbers_are_those_of_the_standard(function: str) -> None:
    first, second = (x.ravel() for x in np.meshgrid(EVERY, EVERY))
    assert_close(apply(function, first, second), getattr(np, TWO[function])(first, second))


@pytest.mark.parametrize("function", [*ONE, *TWO, "min", "max"])
def test_lifted_scalars_have_the_values_of_plain_ones(function: str, angles: np.ndarray) -> None:
    x = np.concatenate((angles, angles / 100, EVERY))
    numbers = (x,) if function in ONE else (x, x[::-1])
    np.testing.assert_array_equal(bits(apply(f"lifted {function}", *numbers)), bits(apply(function, *numbers)))


@pytest.mark.parametrize("function", ["floor", "ceil"])
def test_rounding_is_exact(function: str) -> None:
    rng = np.random.default_rng(4)
    near_whole = rng.integers(-1000, 1000, 1000) + np.ldexp(rng.integers(-3, 4, 1000).astype(float), -50)
    sizes = rng.uniform(-1, 1, 100_000) * 2.0 ** rng.integers(-60, 60, 100_000)
    x = np.concatenate((near_whole, sizes, EVERY))
    np.testing.assert_array_equal(bits(apply(function, x)), bits(getattr(np, function)(x)))


def test_remainders_are_exact() -> None:
    rng = np.random.default_rng(5)
    x, y = rng.integers(0, 0x7FF0000000000000, (2, 2000)).view(np.float64)
    x[:500] = rng.uniform(0, 100, 500)
    y[:500] = rng.uniform(0, 1, 500)
    y[500:1000] = x[500:1000] / rng.integers(1, 2**40, 500)
    for a, b, got in zip(x, y, apply("fmod", x, y), strict=True):
        assert Fraction(float(got)) == Fraction(float(a)) % Fraction(float(b))
    np.testing.assert_array_equal(apply("fmod", -x, y), -apply("fmod", x, -y))


def test_nothing_hides_behind_a_limit_that_is_no_number() -> None:
    for function in ("min", "max"):
        for pair in ((NAN, 1.0), (1.0, NAN), (NAN, INF), (-INF, NAN)):
            assert np.isnan(apply(function, *map(np.array, pair)))
    for three in ((NAN, -1.0, 1.0), (0.0, NAN, 1.0), (0.0, -1.0, NAN)):
        assert np.isnan(apply("clamp", *map(np.array, three)))


def test_minus_zero_is_below_zero_in_either_order() -> None:
    for x, y in ((-0.0, 0.0), (0.0, -0.0)):
        assert np.signbit(apply("min", np.array(x), np.array(y)))
        assert not np.signbit(apply("max", np.array(x), np.array(y)))


def test_smaller_larger_and_clamped() -> None:
    rng = np.random.default_rng(6)
    x, low, high = rng.normal(size=(3, 10_000))
    np.testing.assert_array_equal(apply("min", x, low), np.minimum(x, low))
    np.testing.assert_array_equal(apply("max", x, low), np.maximum(x, low))
    np.testing.assert_array_equal(apply("clamp", x, low, high), np.minimum(np.maximum(x, low), high))
    np.testing.assert_array_equal(apply("lifted clamp", x, low, high), apply("clamp", x, low, high))


@pytest.mark.parametrize("function", ["tan", "asin", "atan", "sinh", "tanh", "cbrt"])
def test_odd(function: str, angles: np.ndarray) -> None:
    x = angles / 100
    np.testing.assert_array_equal(bits(apply(function, -x)), bits(-apply(function, x)))


def test_roots_of_cubes_and_lengths_of_triples_are_exact() -> None:
    n = np.arange(1.0, 2.0**17, 7)
    np.testing.assert_array_equal(apply("cbrt", n**3), n)
    for size in (1.0, 2.0**-1060, 2.0**1000):
        np.testing.assert_array_equal(
            apply("hypot", np.array([3, 5, 8]) * size, np.array([4, 12, -15]) * size), np.array([5, 13, 17]) * size
        )


def test_powers_of_whole_exponents() -> None:
    x = np.array([3.0, -3.0, -3.0, 0.5, -2.0, 10.0])
    y = np.array([4.0, 3.0, -1.0, 10.0, 1023.0, 22.0])
    np.testing.assert_array_equal(apply("pow", x, y), [81.0, -27.0, -1 / 3, 2.0**-10, -(2.0**1023), 1e22])
