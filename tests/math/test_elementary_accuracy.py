"""sin, cos, exp and log are off by less than 0.9 units in the last place, for every double there is."""

import mpmath as mp
import numpy as np
import pytest
from elementary import Floats, apply
from hard_cases import near_quarter_turns

BOUND = 0.9
POINTS = 1_000_000
EXACT = {"sin": mp.sin, "cos": mp.cos, "exp": mp.exp, "log": mp.log}


def every_binade(rng: np.random.Generator, positive: bool = False) -> Floats:
    """Random bits: every exponent is as likely as any other, subnormals among them."""
    x = rng.integers(0, 0x7FF0000000000000, POINTS).view(np.float64)
    return x if positive else np.where(rng.random(POINTS) < 0.5, -x, x)


def arguments(function: str) -> Floats:
    """Dense where the function is used and where it is hard, and some of every size."""
    rng = np.random.default_rng(8)
    dense = {
        "sin": (rng.uniform(-1, 1, POINTS), rng.uniform(-1000, 1000, POINTS), rng.uniform(-2e6, 2e6, POINTS)),
        "exp": (rng.uniform(-1, 1, POINTS), rng.uniform(-746, 710, POINTS), rng.uniform(-746, -708, POINTS)),
        "log": (1 + rng.uniform(-1e-3, 1e-3, POINTS), rng.uniform(0.25, 4, POINTS), rng.uniform(0, 1000, POINTS)),
    }
    dense["cos"] = dense["sin"]
    return np.concatenate((*dense[function], every_binade(rng, positive=function == "log"), hard(function)))


def hard(function: str) -> Floats:
    """Few, but all of them are compared with mpmath."""
    rng = np.random.default_rng(9)
    if function == "exp":
        ends = [709.782712893384, np.nextafter(709.782712893384, 800), -708.3964185322641, -745.1332191019411]
        ends += [-745.1332191019412, 5e-324, -5e-324, 2**-53, -(2**-54), 1e300, -1e300]
        return np.concatenate((ends, 0.5 * np.log(2) * rng.integers(-2140, 2040, 500)))
    if function == "log":
        near_one = 1 + np.ldexp(rng.integers(-1000, 1000, 500).astype(float), -52)
        return np.concatenate((near_one[near_one != 1], 2.0 ** np.arange(-1074, 1024, 7), [5e-324, 1.7e308]))
    turns = rng.integers(1, 2**50, 500) * (np.pi / 2)
    known = [6381956970095103 * 2.0**797, 5.319372648326541e255, 1e22, 2.0**20, np.nextafter(2.0**20, 2**21)]
    return np.concatenate((known, turns, near_quarter_turns()))


def ulp(exact: Floats) -> Floats:
    """Units in the last place of exact values, at most one step of the doubles around them."""
    return np.ldexp(1.0, np.maximum(np.frexp(np.abs(exact))[1] - 53, -1074))


def errors(function: str, x: Floats) -> Floats:
    """In ulp, against mpmath."""
    error = np.empty(x.size)
    for i, (argument, got) in enumerate(zip(x, apply(function, x), strict=True)):
        with mp.workprec(250 + max(0, int(np.frexp(argument)[1]))):
            exact = EXACT[function](mp.mpf(float(argument)))
            rounded = float(exact)
            if np.isfinite(got) and np.isfinite(rounded):
                error[i] = abs(mp.mpf(float(got)) - exact) / float(ulp(np.float64(rounded)))
            else:
                error[i] = 0.0 if got == rounded else np.inf
    return error


@pytest.mark.parametrize("function", EXACT)
def test_of_millions_of_arguments_none_is_further_off(function: str, record_property) -> None:
    long = np.longdouble
    if np.finfo(long).nmant < 63:
        pytest.skip("long double is no wider than double here: mpmath alone compares, at fewer points")
    x = arguments(function)
    got = apply(function, x)
    with np.errstate(over="ignore", under="ignore"):
        exact = getattr(np, function)(x.astype(long))
        rounded = exact.astype(float)
        finite = np.isfinite(rounded)
        error = np.abs(got[finite] - exact[finite]) / ulp(rounded[finite])
    np.testing.assert_array_equal(got[~finite], rounded[~finite])
    worst = float(error.max())
    record_property("largest error [ulp]", float(worst))
    print(f"{function}: {x.size} arguments, off by {worst:.4f} ulp at most, at {x[finite][error.argmax()]!r}")
    assert worst < BOUND
    suspects = x[finite][np.argsort(error)[-200:]]  # what is found exactly below
    assert errors(function, suspects).max() < BOUND


@pytest.mark.parametrize("function", EXACT)
def test_against_mpmath(function: str, record_property) -> None:
    rng = np.random.default_rng(10)
    x = np.concatenate((hard(function), rng.choice(arguments(function), 2000)))
    error = errors(function, x)
    record_property("largest error [ulp]", float(error.max()))
    print(f"{function}: {x.size} arguments, off by {error.max():.4f} ulp at most, at {x[error.argmax()]!r}")
    assert error.max() < BOUND


def test_hard_cases_are_hard() -> None:
    x = near_quarter_turns()
    assert x.size > 3000
    assert 6381956970095103 * 2.0**797 in x  # the double that comes nearest to a multiple of pi/2
    assert np.minimum(np.abs(apply("sin", x)), np.abs(apply("cos", x))).min() < 2**-60
