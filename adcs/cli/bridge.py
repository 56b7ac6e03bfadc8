"""`adcs bridge` and `adcs replay`."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from adcs.catalogue import find_system
from adcs.cli.ground_tools import Options, attached
from fmus.errors import AdcsError
from hil_bridge.frames import FrameName
from hil_bridge.ground.attach import Bridge
from hil_bridge.ground.endpoints import DEFAULTS, Place
from hil_bridge.ground.mapping import ROLES, find
from hil_bridge.ground.parameters import parameters
from hil_bridge.ground.replay import replay as replay_log
from orchestration.grid import Grid
from orchestration.instances.instance import EndRequested
from orchestration.running.live import Pace
from orchestration.running.session import ENDLESS, Session
from orchestration.system import System

app = typer.Typer()

_WHERE, _WHAT, _WHO = "Where to", "What is shown", "Who may do what"

To = Annotated[
    list[str] | None,
    typer.Option(
        "--out",
        "--to",
        metavar="KIND:HOST:PORT",
        help="Where ground tools are: udpout:, udpin: or tcpin:; may be repeated. "
        "[default: udpout:127.0.0.1:14550 and :14540]",
        rich_help_panel=_WHERE,
    ),
]
Expose = Annotated[
    bool,
    typer.Option(
        "--expose", help="Let endpoints reach beyond this machine; read `docs/mavlink.md` first.", rich_help_panel=_WHO
    ),
]
Peers = Annotated[
    list[str] | None,
    typer.Option(
        "--peer",
        metavar="ADDRESS",
        help="Hear this address only (udpin, tcpin); may be repeated.",
        rich_help_panel=_WHO,
    ),
]


@app.command()
def bridge(
    system: Annotated[str, typer.Argument(help="Name of a system (`adcs list`), or an .ssp or .fmu file.")],
    out: To = None,
    step: Annotated[float | None, typer.Option(help="Time between two points [s].")] = None,
    stop: Annotated[float | None, typer.Option(help="Stop time [s]. [default: never]")] = None,
    speed: Annotated[float, typer.Option(help="Simulated seconds per second.")] = 1.0,
    allow: Annotated[
        str,
        typer.Option(metavar="WHAT,...", help="Let ground tools: arm, param, attitude.", rich_help_panel=_WHO),
    ] = "",
    frame: Annotated[FrameName, typer.Option(help="Frame of the attitude.", rich_help_panel=_WHAT)] = "ned",
    epoch: Annotated[
        str, typer.Option(help="UTC at t = 0, for the turning Earth.", rich_help_panel=_WHAT)
    ] = "2026-01-01T00:00:00",
    position: Annotated[
        str,
        typer.Option(
            metavar="LAT,LON,HEIGHT", help="Where a system without orbit is shown [deg, m].", rich_help_panel=_WHAT
        ),
    ] = "0,0,500km",
    map_: Annotated[
        list[str] | None,
        typer.Option(
            "--map",
            metavar="ROLE=NAME",
            help="Variable of a role, or a TOML file; may be repeated.",
            rich_help_panel=_WHAT,
        ),
    ] = None,
    show: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Show this output besides; may be repeated.", rich_help_panel=_WHAT),
    ] = None,
    rate: Annotated[
        list[str] | None,
        typer.Option(metavar="MESSAGE=HZ", help="Rate of a message; may be repeated.", rich_help_panel=_WHAT),
    ] = None,
    wheel_limit: Annotated[
        float | None, typer.Option(help="Speed at which a wheel is saturated [rad/s].", rich_help_panel=_WHAT)
    ] = None,
    expose: Expose = False,
    peer: Peers = None,
    key: Annotated[
        Path | None,
        typer.Option(help="Sign messages, and take signed ones only, with the key in this file.", rich_help_panel=_WHO),
    ] = None,
    fifo: Annotated[
        bool, typer.Option("--fifo", help="Ask the system for real-time priority (SCHED_FIFO); needs the right to it.")
    ] = False,
    tlog: Annotated[Path | None, typer.Option(help="Write a telemetry log.", rich_help_panel=_WHERE)] = None,
    list_: Annotated[
        bool, typer.Option("--list", help="Say what is shown and which parameters there are, and do no more.")
    ] = False,
) -> None:
    """Run a system in real time for ground tools to watch, until Ctrl-C; nothing else is recorded."""
    entry = find_system(system)
    built = entry.build()
    if list_:
        _list(built, map_ or [], show or [])
        return
    exchange = entry.step if step is None else step
    if exchange > 0:
        entry.check_step(exchange)
    options = Options(
        out or (), allow, frame, epoch, position, map_ or (), show or (), rate or (), expose, peer or (), key, tlog,
        wheel_limit,
    )  # fmt: skip
    start = entry.start_time
    watcher = attached(built, options, step=exchange, start=start, speed=speed)
    assert isinstance(watcher, Bridge)
    steps = ENDLESS if stop is None else Grid.make(start, stop, exchange).steps
    if fifo:
        _prioritise()
    pace = Pace(Grid(0.0, exchange, 0), speed)
    console = Console(stderr=True)
    with Session(built, step=exchange, start_time=start, steps=steps) as simulation, watcher:
        console.print(f"{entry.name} at {speed:g} times real time, for {', '.join(watcher.endpoints)}; Ctrl-C ends it")
        pace.start(0)
        try:
            _go(simulation, watcher, pace)
        except KeyboardInterrupt:
            console.print(f"ended at t = {simulation.time:g} s")
        if simulation.ended is not None:
            console.print(str(simulation.ended), markup=False)
        report = watcher.report()
    _show(console, report, pace)


def _go(simulation: Session, watcher: Bridge, pace: Pace) -> None:
    while True:
        pace.wait(simulation.k)
        simulation.propagate()
        row = simulation.k
        if row < simulation.last and simulation.ended is None:
            with suppress(EndRequested):
                simulation.move_on()
        else:
            simulation.k += 1
        for change in watcher(simulation):
            change.apply(simulation)
        if row >= simulation.last or simulation.ended is not None:
            return


def _prioritise() -> None:
    """Run before all ordinary work of the machine. The bridge's own process was not started yet, and stays ordinary."""
    if not hasattr(os, "sched_setscheduler"):
        raise AdcsError("--fifo: this platform has no SCHED_FIFO")
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(10))
    except PermissionError:
        raise AdcsError("--fifo: not permitted; see `ulimit -r`, or grant CAP_SYS_NICE") from None


def _show(console: Console, report: dict[str, object], pace: Pace) -> None:
    late = pace.report()
    console.print(
        f"{late['points']} points, late by {1e3 * late['late_median_s']:.3g} ms in the median, "
        f"{1e3 * late['late_99_percent_s']:.3g} ms at 99 %, {1e3 * late['late_most_s']:.3g} ms at most",
        highlight=False,
    )
    mavlink = report["mavlink"]
    assert isinstance(mavlink, dict)
    for each in mavlink["endpoints"]:
        if isinstance(each, dict):
            console.print(
                f"{each['endpoint']}: {each['sent']} messages sent, {each['not_sent']} not; "
                f"{each['received']} received, {each['bad']} bad, {each['limited']} too many, "
                f"{each['strangers']} from strangers",
                highlight=False,
            )
    commands = report["commands"]
    assert isinstance(commands, list)
    for time, name, value, source in commands:
        console.print(f"t = {time:g} s: {name} = {value} by {source}", highlight=False)


def _list(system: System, maps: list[str], shows: list[str]) -> None:
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


@app.command()
def replay(
    file: Annotated[Path, typer.Argument(help="A telemetry log (.tlog).")],
    out: To = None,
    speed: Annotated[float, typer.Option(help="How many times as fast as it was written.")] = 1.0,
    wait: Annotated[float, typer.Option(help="Wait for a ground tool to come, so long at most [s].")] = 0.0,
    expose: Expose = False,
    peer: Peers = None,
) -> None:
    """Send a telemetry log to ground tools again."""
    places = [Place.parse(text, expose) for text in out or DEFAULTS]
    console = Console(stderr=True)
    try:
        report = replay_log(file, places, speed, peer or (), wait)
    except KeyboardInterrupt:
        raise AdcsError("interrupted") from None
    console.print(f"{report['frames']} frames of {report['seconds']:g} s sent to {', '.join(map(str, places))}")
