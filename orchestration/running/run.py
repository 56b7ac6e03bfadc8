"""Run a system: method, what is saved, and hooks, put together and driven to the end."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from functools import partial
from pathlib import Path

from orchestration.engine import ThreadControl
from orchestration.expected import choice
from orchestration.fmu.file import FmiVersion, found_once
from orchestration.grid import Grid
from orchestration.instances.life import watched_life
from orchestration.isolation.apart import run_apart
from orchestration.named import as_system
from orchestration.process.guard import Guard
from orchestration.process.watch import Unwatched, Watched
from orchestration.results.result import Result
from orchestration.running import arguments
from orchestration.running.account import Account
from orchestration.running.asking import ask
from orchestration.running.driver import Driver, Progress
from orchestration.running.fitting import Fitting
from orchestration.running.hook import Hook
from orchestration.running.method import Method
from orchestration.running.outline import Outline
from orchestration.running.save import Save
from orchestration.running.simulation import Simulation
from orchestration.system import System
from orchestration.times import Seconds


@found_once()
def run(
    system: System | str | Path,
    *,
    stop_time: Seconds | None = None,
    step: Seconds | None = None,
    start_time: Seconds | None = None,
    method: Method = Fitting(),
    save: Save = Save(),
    hooks: Sequence[Hook] = (),
    resume: str | Path | None = None,
    fmi_version: FmiVersion = "2.0",
    isolated: bool = False,
    progress: Progress | None = None,
) -> Result:
    """Run a system from start_time to stop_time and record at t_k = start_time + k*step: N steps, N+1 rows.

        adcs.run("observer-pd", stop_time="2min", hooks=[adcs.at("20s", {"controller.k_p": 3})])

    `system` may be a name or the path of a file where `adcs` is imported. Times are numbers of seconds, or texts as
    "10ms". Those that are not given are the system's own; start_time is 0 if it has none. If they are no whole number
    of steps apart, the last step is shorter, where all components can take one.

    `method` is `adcs.CoSimulation(...)` or `adcs.ModelExchange(...)`. Where none is given, it is the latter if nothing
    is sampled, delayed, from elsewhere, or watched from outside, and no step is asked for; the manifest says which was
    taken, and why. `save` is what is kept, and where: `adcs.Save(...)`.
    `hooks` take part in the run: `adcs.at`, `adcs.inputs`, `adcs.until`, `adcs.pace`, `adcs.checkpoint`, and hooks of
    your own (`adcs.Hook`). `resume` names a file that `adcs.checkpoint` has written: the run goes on from there.
    `fmi_version` says which file of a component known by name is taken. `progress` is called with the fraction done.

    `isolated` runs the components in a process of their own: one that crashes or ends its process becomes RunFailed,
    with the rows until then; hooks of your own cannot cross to it.

    A component may end the simulation: the manifest's outcome says which, when and why. Raises AdcsError when the
    run cannot start, RunFailed when a component fails on the way, RunInterrupted on Ctrl-C; the last two carry what
    was recorded as `.result`.
    """
    system = as_system(system, step)
    asked = dict(locals())
    arguments.check(run, asked, **_OBJECTS)
    choice("fmi_version", fmi_version, FmiVersion)
    if isolated:
        return run_apart(asked)
    because = None
    if isinstance(method, Fitting):
        method, because = method.choose(system, fmi_version, hooks, stepped=step is not None, resume=resume)
    start, stop, step = system.run_times(start_time, stop_time, step)
    step, save = save.spaced(step, method.kind == "co-simulation")
    grid = Grid.make(start, stop, step, partial(method.rigid, system, fmi_version))
    outline = Outline.of(system, grid, method, save, fmi_version, resume)
    if because is not None:
        outline.about["chosen"] = {"method": method.kind, "because": because}
    method.refuse(system, fmi_version)
    for hook in hooks:
        ask(hook, "prepare", outline)
    outline.check()
    account = Account(outline, hooks)
    guard = Guard(ThreadControl(), outline.recording.printed)
    with closing(guard), account.told():
        make = partial(method.simulation, outline, guard)
        with watched_life(make, outline.recording.where, method.patience, account.manifest) as (simulation, watched):
            watched.stop = simulation.stop
            if outline.saved is not None:
                watched(partial(outline.saved.apply, simulation, method))
            drive(simulation, hooks, watched, account, progress)
        outline.recording.flush()
    return account.complete()


def drive(
    simulation: Simulation,
    hooks: Sequence[Hook],
    watched: Watched | Unwatched,
    account: Account,
    progress: Progress | None = None,
) -> None:
    """Take a simulation from its present point to the end of the run, and note in its account what everyone reports."""
    outline = account.outline
    driver = Driver(
        simulation,
        outline.recording,
        hooks,
        watched,
        record_every=outline.save.every,
        timeout=outline.method.patience,
        progress=progress or (lambda fraction: None),
    )
    driver.prepare()
    account.begin(driver)
    try:
        driver.run()
    finally:
        account.end()


_OBJECTS = {
    "method": arguments.made(Method, 'adcs.CoSimulation() or adcs.ModelExchange("DOP853")'),
    "save": arguments.made(Save, 'adcs.Save(["plant.q_BN"])'),
}
