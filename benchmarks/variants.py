"""The ways to run the loop. Each makes a function without set-up in it, whose CPU time is the time of the steps."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from functools import partial

import numpy as np

from benchmarks import loop, monolithic
from orchestration.engine import Engine
from orchestration.fmu.file import FmiVersion
from orchestration.instances.instance import Instance
from orchestration.plan.lowering import Floats, make_plan
from orchestration.plan.opening import initialised
from orchestration.plan.schedule import split


@dataclass(frozen=True)
class Sample:
    """CPU time of one run in s per step, and the attitude q_BN at its end, (4,)."""

    cpu: float
    attitude: Floats


Loop = Callable[[], Floats]
"""Takes the steps, returns the final attitude."""


@dataclass(frozen=True)
class Variant:
    """A way to run the loop; it takes `share` of the steps of a round, so that slow ones do not take all the time."""

    key: str
    title: str
    share: float
    prepare: Callable[[int], AbstractContextManager[Loop]]

    def run(self, steps: int) -> Sample:
        """Run from the start for so many steps."""
        with self.prepare(steps) as take_steps:
            began = time.process_time()
            attitude = take_steps()
            return Sample((time.process_time() - began) / steps, np.array(attitude))


@contextmanager
def _monolithic(steps: int) -> Iterator[Loop]:
    yield monolithic.make(steps)


@contextmanager
def compiled(steps: int, version: FmiVersion = "2.0", record: bool = False, step: float = loop.STEP) -> Iterator[Loop]:
    """The compiled stepping loop; `record` keeps every output of every step, else nothing is kept."""
    system = loop.system()
    names = [split(name) for name in system.outputs()] if record else []
    with initialised(system, "co-simulation", 0.0, steps * step, version) as instances:
        plan = make_plan({i.name: i.fmu for i in instances.values()}, system.connections, names)
        engine = Engine(plan, instances)
        # As `run` does it, but for the last step, which leads to a row of its own there.
        rows = np.empty((steps, len(plan.row)))

        def take_steps() -> Floats:
            _, _, failed = engine.steps(0.0, step, 0, steps, steps, None, rows)
            if failed is not None:
                raise failed
            return _attitude(instances["plant"])

        yield take_steps


def _attitude(plant: Instance) -> Floats:
    port = plant.fmu.ports["q_BN"]
    return np.array(plant.get(port.references, port.size, "getting q_BN"))


@contextmanager
def _buffers(steps: int) -> Iterator[Loop]:
    with initialised(loop.system(), "co-simulation", 0.0, steps * loop.STEP) as instances:
        plant, controller = instances["plant"], instances["controller"]

        def references(instance: Instance, *names: str) -> object:
            numbers = [r for name in names for r in instance.fmu.ports[name].references]
            return (ctypes.c_uint32 * len(numbers))(*numbers)

        state_of_plant, torque_of_plant = references(plant, "q_BN", "omega_BN_B"), references(plant, "torque_B")
        state_of_controller = references(controller, "q_BN", "omega_BN_B")
        torque_of_controller = references(controller, "torque_B")
        state, torque = (ctypes.c_double * 7)(), (ctypes.c_double * 3)()
        p, c = plant.handle, controller.handle

        def take_steps() -> Floats:
            for k in range(steps):
                t = k * loop.STEP
                p.fmi2GetReal(p.component, state_of_plant, 7, state)
                c.fmi2SetReal(c.component, state_of_controller, 7, state)
                c.fmi2GetReal(c.component, torque_of_controller, 3, torque)
                p.fmi2SetReal(p.component, torque_of_plant, 3, torque)
                p.fmi2DoStep(p.component, t, loop.STEP, 1)
                c.fmi2DoStep(c.component, t, loop.STEP, 1)
            return _attitude(plant)

        yield take_steps


@contextmanager
def _plain(steps: int) -> Iterator[Loop]:
    with initialised(loop.system(), "co-simulation", 0.0, steps * loop.STEP) as instances:
        plant, controller = instances["plant"], instances["controller"]

        def references(instance: Instance, *names: str) -> list[int]:
            return [r for name in names for r in instance.fmu.ports[name].references]

        state_of_plant, torque_of_plant = references(plant, "q_BN", "omega_BN_B"), references(plant, "torque_B")
        state_of_controller = references(controller, "q_BN", "omega_BN_B")
        torque_of_controller = references(controller, "torque_B")
        p, c = plant.handle, controller.handle

        def take_steps() -> Floats:
            for k in range(steps):
                t = k * loop.STEP
                c.setReal(state_of_controller, p.getReal(state_of_plant))
                p.setReal(torque_of_plant, c.getReal(torque_of_controller))
                p.doStep(t, loop.STEP)
                c.doStep(t, loop.STEP)
            return _attitude(plant)

        yield take_steps


VARIANTS = (
    Variant("monolithic", "hand-written C++ loop", 1.0, _monolithic),
    Variant("compiled", "compiled loop, FMI 2", 1.0, compiled),
    Variant("compiled_recorded", "compiled loop, FMI 2, all outputs recorded", 0.5, partial(compiled, record=True)),
    Variant("compiled_fmi3", "compiled loop, FMI 3", 1.0, partial(compiled, version="3.0")),
    Variant(
        "compiled_fmi3_recorded",
        "compiled loop, FMI 3, all outputs recorded",
        0.5,
        partial(compiled, version="3.0", record=True),
    ),
    Variant("fmpy_buffers", "fmpy from Python, C functions on ctypes buffers", 0.02, _buffers),
    Variant("fmpy", "fmpy from Python, setReal, getReal, doStep", 0.01, _plain),
)
"""The first is what the others are compared with."""
