"""Values that are exact: at zero, at infinity, for no number; and sincos beside sin and cos."""

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


@pytest.mark.parametrize("function", ["sin", "cos", "exp", "log"])
def test_lifted_scalars_have_the_values_of_plain_ones(function: str, angles: np.ndarray) -> None:
    x = np.abs(angles) if function == "log" else angles
    np.testing.assert_array_equal(apply(f"lifted {function}", x), apply(function, x))


def test_derivatives_that_lifted_scalars_carry(angles: np.ndarray) -> None:
    for prefix in ("", "sincos."):
        np.testing.assert_array_equal(apply(f"slope of {prefix}sin", angles), apply("cos", angles))
        np.testing.assert_array_equal(apply(f"slope of {prefix}cos", angles), -apply("sin", angles))
    np.testing.assert_array_equal(apply("slope of exp", angles), apply("exp", angles))
    positive = np.abs(angles[angles != 0.0])
    np.testing.assert_array_equal(apply("slope of log", positive), 1.0 / positive)
