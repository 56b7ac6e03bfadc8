"""`adcs bridge`: a system in real time, for ground tools to watch."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from math import inf
from typing import Any

from rich.console import Console
from rich.table import Table

from adcs.cli.command import Speed, at_work, command
from adcs.cli.ground_tools import attached
from adcs.cli.options import GroundTools, SystemName, Times, Which
from fmus.errors import AdcsError
from hil_bridge.ground.attach import Bridge
from hil_bridge.ground.mapping import ROLES, find
from hil_bridge.ground.parameters import parameters
from orchestration.grid import Grid
from orchestration.process.watch import Unwatched
from orchestration.results.result import Unrecorded
from orchestration.running.driver import Driver
from orchestration.running.hook import Hook
from orchestration.running.hooks.pace import Pace
from orchestration.running.method import CoSimulation
from orchestration.running.outline import Outline
from orchestration.running.save import Save
from orchestration.running.session import ENDLESS, Session
from orchestration.system import System

app = command(
    "bridge",
    "adcs bridge observer-pd",
    "adcs bridge observer-pd --real-time 4 --allow arm,param --set controller.k_p=3",
    "adcs bridge observer-pd --to udpin:0.0.0.0:14550 --remote --key key.txt",
)


@app.default
def bridge(
    system: SystemName,
    /,
    which: Which = Which(),
    times: Times = Times(),
    tools: GroundTools = GroundTools(),
    *,
    real_time: Speed = 1.0,
    fifo: bool = False,
    list: bool = False,
) -> None:
    """Run a system in real time for ground tools to watch, until Ctrl-C; nothing else is recorded.

    Args:
        real_time: Keep pace with the clock, SPEED times as fast.
        fifo: Ask the system for real-time priority (SCHED_FIFO); needs the right to it.
        list: Say what is shown and which parameters there are, and do no more.
    """
    entry, built = which.built(system)
    if list:
        _list(built, tools.map, tools.show)
        return
    step, start = times.step_of(entry), times.start_of(entry)
    watcher = attached(built, tools, step=step, start=start, speed=real_time)
    assert isinstance(watcher, Bridge)
    steps = ENDLESS if times.stop is None else Grid.make(start, times.stop, step).steps
    if fifo:
        _prioritise()
    grid, recording = Grid(start, step, steps), Unrecorded(built, None)
    hooks: Sequence[Hook] = (Pace(real_time), watcher)
    for hook in hooks:
        hook.prepare(Outline(built, grid, recording, CoSimulation(), Save(), which.fmi_version))
    console = Console(stderr=True)
    with (
        at_work(),
        Session(built, step=step, start_time=start, steps=steps, fmi_version=which.fmi_version) as simulation,
        watcher,
    ):
        places = ", ".join(watcher.endpoints)
        console.print(f"{entry.name} at {real_time:g} times real time, for {places}; Ctrl-C ends it")
        driver = Driver(simulation, recording, hooks, Unwatched(), timeout=inf)
        driver.prepare()
        try:
            driver.run()
        except KeyboardInterrupt:
            console.print(f"ended at t = {simulation.time:g} s")
        if simulation.ended is not None:
            console.print(str(simulation.ended), markup=False)
        report = driver.report()
    _show(console, report)


def _prioritise() -> None:
    """Run before all ordinary work of the machine. The bridge's own process was not started yet, and stays ordinary."""
    if sys.platform != "linux":
        raise AdcsError("--fifo: this platform has no SCHED_FIFO")
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(10))
    except PermissionError:
        raise AdcsError("--fifo: not permitted; see `ulimit -r`, or grant CAP_SYS_NICE") from None


def _show(console: Console, report: dict[str, Any]) -> None:
    late = report["real_time"]
    console.print(
        f"{late['points']} points, late by {1e3 * late['late_median_s']:.3g} ms in the median, "
        f"{1e3 * late['late_99_percent_s']:.3g} ms at 99 %, {1e3 * late['late_most_s']:.3g} ms at most",
        highlight=False,
    )
    for each in report["mavlink"]["endpoints"]:
        if isinstance(each, dict):
            console.print(
                f"{each['endpoint']}: {each['sent']} messages sent, {each['not_sent']} not; "
                f"{each['received']} received, {each['bad']} bad, {each['limited']} too many, "
                f"{each['strangers']} from strangers",
                highlight=False,
            )
    for time, name, value, source in report["commands"]:
        console.print(f"t = {time:g} s: {name} = {value} by {source}", highlight=False)


def _list(system: System, maps: Sequence[str], shows: Sequence[str]) -> None:
    console = Console()
    signals = find(system, maps, shows)
    table = Table("role", "variable", "meaning", title="What is shown", title_justify="left")
    for role, about in ROLES.items():
        table.add_row(role, signals.roles.get(role, "-"), about.meaning)
    for name, variable in signals.shown.items():
        table.add_row(name[:10], variable, "asked for")
    console.print(table)
    table = Table("parameter", "variable", "value", "unit", "range", title="Parameters", title_justify="left")
    for p in parameters(system):
        range_ = "" if (p.low, p.high) == (float("-inf"), float("inf")) else f"{p.low:g} .. {p.high:g}"
        table.add_row(p.id, p.element, f"{p.value:g}", p.unit, range_)
    console.print(table)
