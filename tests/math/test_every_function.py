"""A component that calls every function builds; values and derivatives are those of mpmath, dependencies its text's."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from fmpy import extract
from fmpy.fmi3 import FMU3Model

from fmus.build import build, describe
from fmus.checks.functions import offered
from tests.platforms.digest_program import EVERY_FUNCTION

Numbers = list[mp.mpf]
KNOWNS = 8
"""x, y, v and w have the value references 1 to 8."""
POINTS = (
    [0.4, 0.7, 0.1, -0.2, 0.3, 0.5, 0.6, -0.7],
    [0.8, 0.3, 1.1, -0.8, 0.2, 0.2, -0.9, 0.4],
    [-0.6, 0.4, -0.3, 0.4, 0.6, -0.1, 0.7, 0.5],
    [-1.7, -1.2, 0.3, 0.1, -0.2, 0.5, -0.6, 0.7],
)


def clamped(x: Any, low: Any, high: Any) -> Any:
    return min(max(x, low), high)


def remainder(x: mp.mpf, y: mp.mpf) -> mp.mpf:
    return x - y * mp.sign(x / y) * mp.floor(abs(x / y))


def law(x: mp.mpf, y: mp.mpf, *elements: mp.mpf) -> dict[str, Numbers]:
    """The outputs, in another language."""
    v, w = list(elements[:3]), list(elements[3:])
    sine = clamped(x, -1, 1)
    far = x > y
    length = mp.sqrt(mp.fsum(e**2 for e in v))
    return {
        "of_one": [
            *(mp.sin(x), mp.cos(x), mp.tan(x), mp.asin(sine), mp.acos(sine), mp.atan(x)),
            *(mp.sinh(x), mp.cosh(x), mp.tanh(x), mp.exp(x), mp.log(mp.sqrt(x**2 + mp.mpf(1) / 4))),
            *(mp.sqrt(abs(x)), mp.sign(x) * mp.cbrt(abs(x)), mp.floor(3 * x), mp.ceil(3 * x), abs(x)),
        ],
        "of_two": [
            *(mp.atan2(y, x), abs(x) ** y, mp.hypot(x, y), remainder(3 * x, y)),
            *(min(x, y), max(x, y), mp.sign(y) * abs(x)),
        ],
        "mixed": [
            *(max(mp.mpf(0), x), min(x, mp.mpf(0)), x**2, 2**x, clamped(x, -1, y), clamped(mp.mpf("0.5"), x, 0.9)),
            *(mp.atan2(x, 1), mp.atan2(1, x), mp.hypot(x, 1), remainder(x, mp.mpf("0.25")), mp.sign(x)),
            *(max(v[0], w[1]), (v[0] + w[0]) ** 3),
        ],
        "chosen": [
            v[0] if far else w[0],
            mp.mpf(1 if x < y < 1 else -1),
            x if x <= 0 else mp.mpf(0),
            x,
            2 * x if x > 0.5 or length > 1 else y,
        ],
        "vector": [a + b if far else b for a, b in zip(v, w, strict=True)],
        "matrix": [a * b if x < y else mp.mpf(i == j) for i, a in enumerate(v) for j, b in enumerate(w)],
    }


def slopes(numbers: Numbers, i: int) -> dict[str, list[float]]:
    """The derivatives of all outputs by the number of this index: of 60 digits, differences leave 40."""
    step = mp.mpf(10) ** -20
    after, before = (law(*numbers[:i], numbers[i] + s * step, *numbers[i + 1 :]) for s in (1, -1))
    return {
        name: [float((a - b) / (2 * step)) for a, b in zip(after[name], before[name], strict=True)] for name in after
    }


@pytest.fixture(scope="module")
def header(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy, for FMUs are written beside it."""
    path = tmp_path_factory.mktemp("laws") / EVERY_FUNCTION.name
    path.write_bytes(EVERY_FUNCTION.read_bytes())
    return path


@pytest.fixture(scope="module")
def instance(header: Path) -> Iterator[FMU3Model]:
    unpacked = header.parent / "unpacked"
    fmu = next(path for path in build([str(header)]) if path.name.endswith(".fmi3.fmu"))
    extract(str(fmu), str(unpacked))
    model = FMU3Model(
        guid=describe(str(header)).token,
        unzipDirectory=str(unpacked),
        modelIdentifier="EveryFunction",
        instanceName="it",
    )
    model.instantiate()
    model.enterInitializationMode()
    model.exitInitializationMode()
    model.enterContinuousTimeMode()
    yield model
    model.freeInstance()


def set_inputs(instance: FMU3Model, point: list[float]) -> None:
    for vr, values in ((1, point[:1]), (2, point[1:2]), (3, point[2:5]), (6, point[5:])):
        instance.setFloat64([vr], values)


def test_no_function_is_forgotten() -> None:
    text = EVERY_FUNCTION.read_text(encoding="utf-8")
    assert [name for name in offered() if f"{name}(" not in text] == ["sincos"]  # which the library calls


@pytest.mark.parametrize("point", POINTS)
def test_values_and_derivatives(point: list[float], header: Path, instance: FMU3Model) -> None:
    variables = {v.name: v for v in describe(str(header)).variables}
    set_inputs(instance, point)

    knowns = {v.vr: int(np.prod(v.shape)) for v in variables.values() if v.causality == "input"}
    with mp.workdps(60):
        numbers = [mp.mpf(number) for number in point]
        slopes_of = [slopes(numbers, i) for i in range(KNOWNS)]
        for name, expected in law(*numbers).items():
            size, vr = len(expected), variables[name].vr
            got = instance.getFloat64([vr], size)
            np.testing.assert_allclose(got, [float(e) for e in expected], rtol=1e-14, atol=1e-15, err_msg=name)
            for first, n in knowns.items():
                for e in range(n):
                    seed = [float(i == e) for i in range(n)]
                    got = instance.getDirectionalDerivative([vr], [first], seed, size)
                    exact = slopes_of[first - 1 + e][name]
                    np.testing.assert_allclose(got, exact, rtol=1e-12, atol=1e-13, err_msg=f"{name} by {first + e}")


def test_dependencies_join_all_that_a_value_may_come_from(header: Path) -> None:
    x, y, v, w = 1, 2, 3, 6
    found = {each.name: each.dependencies for each in describe(str(header)).variables}
    assert found["of_one"] == 16 * ((x,),)
    assert found["of_two"] == 7 * ((x, y),)
    assert found["mixed"] == (*4 * ((x,),), (x, y), *6 * ((x,),), (v, w + 1), (v, w))
    assert found["chosen"] == ((x, y, v, w), (x, y), (x,), (x, y), (x, y, v, v + 1, v + 2))
    assert found["vector"] == tuple((x, y, v + i, w + i) for i in range(3))
    assert found["matrix"] == tuple((x, y, v + i, w + j) for i in range(3) for j in range(3))
