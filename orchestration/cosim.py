"""Co-simulation: propagate, record, step every component to the next point. Compiled, or the same from Python."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from time import perf_counter
from typing import Any, Literal

import numpy as np

from orchestration.engine import Engine
from orchestration.fmu import FmiVersion
from orchestration.grid import Grid
from orchestration.instance import Instance, failing_at, initialised, propagate
from orchestration.plan import Floats, Plan, make_plan
from orchestration.results import Recording
from orchestration.system import System

Stepping = Literal["compiled", "python"]
Progress = Callable[[float], Any]

_PATIENCE = 0.1  # s, between two looks at progress and Ctrl-C


def cosimulate(
    system: System,
    grid: Grid,
    recording: Recording,
    version: FmiVersion = "2.0",
    stepping: Stepping = "compiled",
    progress: Progress = lambda fraction: None,
    begin: Callable[[], None] = lambda: None,
) -> list[str]:
    """Fill the recording; return the warnings of the FMUs. Raises CallFailed, with the recording filled so far.

    `begin` is called between initialisation and the first row.
    """
    with initialised(system, "co-simulation", grid.start, grid.time(grid.steps), version) as instances:
        plan = make_plan({i.name: i.fmu for i in instances.values()}, system.connections, recording.names)
        engine = Engine(plan, instances) if stepping == "compiled" else None
        begin()
        if engine is not None:
            _compiled(engine, grid, recording, progress)
        else:
            _python(plan, instances, grid, recording, progress)
        return [f"{i.name}: {text}" for i in instances.values() for text in i.warnings]


def steps(
    system: System,
    *,
    stop_time: float,
    step: float,
    start_time: float = 0.0,
    fmi_version: FmiVersion = "2.0",
    record: Sequence[str] | None = None,
) -> Iterator[tuple[float, dict[str, Floats]]]:
    """Co-simulate step by step: yield (t_k, values by name) at every communication point, before stepping on from it.

    The values are those that `run` records, to the last bit. Time goes on only while the caller asks for more.
    """
    grid = Grid.make(start_time, stop_time, step)
    recording = Recording(system, record, 1)
    with initialised(system, "co-simulation", grid.start, grid.time(grid.steps), fmi_version) as instances:
        plan = make_plan({i.name: i.fmu for i in instances.values()}, system.connections, recording.names)
        cuts = np.cumsum([port.size for port in recording.ports.values()])[:-1]
        for k in range(grid.steps + 1):
            _propagate(plan, instances, grid, k)
            parts = np.split(plan.signals[plan.row], cuts)
            yield (
                grid.time(k),
                {
                    name: part.reshape(port.shape)
                    for (name, port), part in zip(recording.ports.items(), parts, strict=True)
                },
            )
            if k < grid.steps:
                _do_steps(instances, grid, k)


def _compiled(engine: Engine, grid: Grid, recording: Recording, progress: Progress) -> None:
    count = 16
    while recording.filled <= grid.steps:
        rows = recording.data[recording.filled : recording.filled + count]
        began = perf_counter()
        written, failed = engine.steps(grid.start, grid.step, recording.filled, grid.steps, rows)
        recording.filled += written
        if failed is not None:
            raise failed
        progress(recording.filled / (grid.steps + 1))
        # signals reach Python only between two calls of the engine
        pace = _PATIENCE / max(perf_counter() - began, 1e-6)
        count = max(1, min(int(count * min(pace, 8.0)), 1_000_000))


def _python(plan: Plan, instances: dict[str, Instance], grid: Grid, recording: Recording, progress: Progress) -> None:
    seen = perf_counter()
    for k in range(grid.steps + 1):
        _propagate(plan, instances, grid, k)
        recording.data[k] = plan.signals[plan.row]
        recording.filled = k + 1
        if k < grid.steps:
            _do_steps(instances, grid, k)
        if perf_counter() - seen > _PATIENCE or k == grid.steps:
            seen = perf_counter()
            progress(recording.filled / (grid.steps + 1))


def _propagate(plan: Plan, instances: dict[str, Instance], grid: Grid, k: int) -> None:
    with failing_at(grid.time(k)):
        propagate(plan, instances)


def _do_steps(instances: dict[str, Instance], grid: Grid, k: int) -> None:
    with failing_at(grid.time(k)):
        for instance in instances.values():
            instance.do_step(grid.time(k), grid.step)
