"""A hidden delay of one step is not harmless: a loop that is stable at 100 ms without it diverges with it."""

import numpy as np

from adcs import Save, run
from adcs.library.velocity_free.systems import stabilisation


def rates(step: float, steps: int) -> np.ndarray:
    """|omega| over 100 s, with the torque so many steps late."""
    system = stabilisation()
    if steps:
        system.delay("plant.torque_B", steps=steps)
    result = run(system, stop_time=100.0, step=step, save=Save(["plant.omega_BN_B"]))
    return np.linalg.norm(result["plant.omega_BN_B"], axis=1)


def test_at_100_ms_the_loop_is_stable_without_delay_and_diverges_with_one_step():
    assert rates(0.1, 0)[-100:].max() < 1e-6
    late = rates(0.1, 1)
    assert late[-100:].min() > 1.0
    assert late.max() > 10 * late[0]


def test_at_50_ms_both_are_stable():
    assert rates(0.05, 0)[-100:].max() < 1e-6
    assert rates(0.05, 1)[-100:].max() < 1e-3


def test_a_delay_in_seconds_is_the_same():
    system = stabilisation()
    system.delay("plant.torque_B", seconds=0.1)
    result = run(system, stop_time=10.0, step=0.1, save=Save(["plant.omega_BN_B"]))
    assert np.array_equal(np.linalg.norm(result["plant.omega_BN_B"], axis=1), rates(0.1, 1)[:101])
