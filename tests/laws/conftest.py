"""The recomputed runs, made once."""

import numpy as np
import pytest

from references.observer_pd import Array, Loop


@pytest.fixture(scope="session")
def runs() -> dict[bool, dict[str, Array]]:
    """The closed loops of sec. 5.4.1 over 100 s, every 0.1 s: full state (False) and observer (True)."""
    times = np.linspace(0, 100, 1001)
    return {with_observer: Loop(with_observer).run(times) for with_observer in (False, True)}
