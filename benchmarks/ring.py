"""A ring of N rigid bodies, each turned by the rate of the one before it: what a step costs as N grows."""

from __future__ import annotations

import time
from dataclasses import dataclass

from orchestration import System
from orchestration.session import CoSimulation

SIZES = (10, 100, 1000)
_STEP = 0.01  # s


@dataclass(frozen=True)
class Cost:
    """CPU time in s: of one step of the whole ring, and of opening it."""

    size: int
    step: float
    opening: float


def system(n: int) -> System:
    """Return the ring of n bodies."""
    made = System(f"ring of {n}")
    for i in range(n):
        rate = [0.01 * (i % 7), 0.02, -0.01]
        made.add(f"body{i}", "RigidBody", {"omega_BN_B": rate, "torque_B": [0.0] * 3, "max_internal_step": _STEP})
    for i in range(n):
        made.connect(f"body{i - 1 if i else n - 1}.omega_BN_B", f"body{i}.torque_disturbance_B", factor=1e-9)
    return made


def measure(n: int, component_steps: int) -> Cost:
    """Take so many steps of single components, all in all."""
    ring = system(n)
    steps = max(1, component_steps // n)
    began = time.process_time()
    with CoSimulation(ring, step=_STEP, steps=steps, record=[]) as simulation:
        opened = time.process_time()
        _, _, failed = simulation.loop.steps(0.0, _STEP, 0, steps, steps, None, simulation.recording.room(0))
        ended = time.process_time()
    if failed is not None:
        raise failed
    return Cost(n, (ended - opened) / steps, opened - began)
