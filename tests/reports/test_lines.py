"""`result.csv` has the numbers as `repr` writes them, whoever writes them."""

import numpy as np
import pytest

from orchestration.results.lines import lines

EDGES = [0.0, -0.0, 1.0, 0.1, 1e-4, 9.999999999999999e-05, 1e-5, 1e15, 9999999999999998.0, 1e16, 123456789012345680.0]
EDGES += [5e-324, 2.2250738585072014e-308, 1.7976931348623157e308, 1e22, 1e23, 0.30000000000000004, 2.0**53, 2.0**-1074]


def as_repr_does(rows: np.ndarray, whole: list[bool]) -> str:
    texts = ([repr(int(v) if w else v) for v, w in zip(row, whole, strict=True)] for row in rows.tolist())
    return "".join(",".join(text) + "\n" for text in texts)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_numbers_at_the_edges_of_formats(sign: float) -> None:
    rows = sign * np.array([*EDGES, np.nan, np.inf])[:, None]
    assert lines(rows, np.array([False])).decode() == as_repr_does(rows, [False])


def test_any_double_is_written_with_all_its_digits() -> None:
    rng = np.random.default_rng(5)
    bits = rng.integers(0, 2**64, size=(500, 40), dtype=np.uint64).view(np.float64)
    usual = 10.0 ** rng.uniform(-8, 20, size=(500, 40)) * rng.choice([-1, 1], size=(500, 40))
    for rows in (bits, usual, np.round(usual, 3)):
        assert lines(rows, np.zeros(40, bool)).decode() == as_repr_does(rows, [False] * 40)


def test_whole_columns_are_integers() -> None:
    rows = np.array([[0.5, 1.0, 3.0], [1.0, 0.0, -2e9]])
    assert lines(rows, np.array([False, True, True])) == b"0.5,1,3\n1.0,0,-2000000000\n"
