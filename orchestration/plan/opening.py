"""From a system to initialised instances of its components."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from orchestration.fmu.file import FmiVersion, Kind, extracted
from orchestration.fmu.unpacked import unpacked
from orchestration.instances.instance import Instance
from orchestration.plan.loops import Loops, LoopSolver
from orchestration.plan.lowering import make_plan
from orchestration.plan.propagation import execute
from orchestration.process.guard import Guard
from orchestration.process.where import Where
from orchestration.system import System


@contextmanager
def initialised(
    system: System,
    kind: Kind,
    start_time: float,
    stop_time: float,
    version: FmiVersion = "2.0",
    *,
    external: Sequence[str] = (),
    solver: LoopSolver | None = None,
    where: Where | None = None,
    guard: Guard | None = None,
) -> Iterator[dict[str, Instance]]:
    """Instantiate and initialise all components, values propagated along the connections; frees them at the end.

    Inputs in `external` keep their start values; `solver` solves algebraic loops, which are refused without it.
    `where` is told of every call, and `guard` looks after what the components change of the process.
    """
    system.check(external)
    fmus = {c.name: c.open(version) for c in system.components.values()}
    starts = {c.name: c.start for c in system.components.values()}
    plan = make_plan(fmus, system.connections, initial=True, starts=starts, solve_loops=solver is not None)
    with ExitStack() as stack:
        instances: dict[str, Instance] = {}
        folders: dict[str, tuple[Path, Path]] = {}
        for name, fmu in fmus.items():
            # a second copy of the file is a second library, which an FMU with global data needs
            alone = fmu.interface(kind).canBeInstantiatedOnlyOncePerProcess
            key = f"{fmu.sha256} {name if alone else ''}"
            if key not in folders:
                folders[key] = stack.enter_context(extracted(fmu, kind) if alone else unpacked(fmu, kind))
            instance = Instance(name, fmu, kind, *folders[key], where, guard)
            stack.push(lambda kind_of_error, _, __, instance=instance: instance.close(healthy=kind_of_error is None))
            instances[name] = instance
        for connection in system.connections:
            component_name, port = system.port(connection.target)
            fed = instances[component_name].sources
            fed[port.name] = f"{fed[port.name]}, {connection.source}" if port.name in fed else connection.source
        for component in system.components.values():
            instances[component.name].configure(component.start)
        for instance in instances.values():
            instance.enter_initialization(start_time, stop_time)
        loops = Loops(plan, instances, solver or LoopSolver(), initial=True)
        for call in plan.calls:
            if call.kind == "solve":
                loops.solve(call.loop)
            else:
                execute(call, plan.signals, instances)
        for instance in instances.values():
            instance.exit_initialization()
        yield instances
