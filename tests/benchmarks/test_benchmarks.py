"""All variants of the benchmark compute the same; how long they take is not tested."""

import numpy as np
import pytest

from benchmarks import loop, report
from benchmarks.variants import VARIANTS, Variant, compiled

STEPS = 300


@pytest.fixture(scope="module")
def expected() -> np.ndarray:
    return VARIANTS[0].run(STEPS).attitude


def test_the_loop_moves(expected: np.ndarray) -> None:
    assert np.linalg.norm(expected) == pytest.approx(1.0, abs=1e-14)
    assert np.abs(expected - loop.START_Q_BN).max() > 0.01


@pytest.mark.parametrize("variant", VARIANTS[1:], ids=lambda v: v.key)
def test_same_final_attitude(variant: Variant, expected: np.ndarray) -> None:
    np.testing.assert_allclose(variant.run(STEPS).attitude, expected, rtol=0, atol=1e-12)


def test_slower_control_is_another_loop(expected: np.ndarray) -> None:
    """With the torque held for ten integrator steps the attitude differs, by little."""
    with compiled(STEPS // 10, step=10 * loop.STEP) as take_steps:
        difference = np.abs(take_steps() - expected).max()
    assert 1e-6 < difference < 1e-2


def test_ratios_are_medians_of_ratios_within_a_round() -> None:
    rounds = [{v.key: (i + 1.0) * 1e-9 for i, v in enumerate(VARIANTS)} for _ in range(2)]
    rounds.append({key: 7.0 * value for key, value in rounds[0].items()})  # a slow round changes no ratio
    assert [row.ratio for row in report.rows(rounds)] == pytest.approx([i + 1.0 for i in range(len(VARIANTS))])
