"""Runs at several exchange steps, with rows that can be compared."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from adcs.library.exchange import COUPLED, at_steps, distance
from adcs.library.outcome import Claim
from adcs.library.sections import Section, conduct
from adcs.library.velocity_free.systems import stabilisation


def test_a_loop_at_two_steps_is_of_first_order() -> None:
    found: dict[Any, Any] = {}

    def show(runs: dict[Any, Any]) -> list[Claim]:
        found.update(runs)
        return []

    conduct([Section("", "", show, at_steps({"loop": stabilisation}, (0.01, 0.02), 0.1, 5.0))])
    assert list(found) == [("loop", COUPLED), ("loop", 0.01), ("loop", 0.02)]
    assert all(np.allclose(run.time, np.linspace(0, 5, 51)) for run in found.values())
    fine, coarse = (distance(found["loop", step], found["loop", COUPLED], "plant.q_BN") for step in (0.01, 0.02))
    assert 0 < fine < 1e-2
    assert coarse / fine == pytest.approx(2, rel=0.05)


def test_the_distance_is_the_largest_norm() -> None:
    one: Any = {"x": np.array([[0.0, 0.0], [3.0, 4.0], [1.0, 0.0]])}
    other: Any = {"x": np.zeros((3, 2))}
    assert distance(one, other, "x") == 5.0
