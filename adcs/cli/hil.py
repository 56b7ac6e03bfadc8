"""`adcs hil`: wait for an autopilot, let it fly a system, write what happened."""

from __future__ import annotations

from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from adcs.catalogue import find_system
from adcs.cli.showing import REPORT_FILES, as_json, exit_code, progress, show, write_files, write_report
from adcs.cli.words import assign
from fmus.errors import AdcsError
from hil_bridge.frames import FrameName
from hil_bridge.hil.actuators import Actuators
from hil_bridge.hil.flying import check, fly
from hil_bridge.hil.link import PORT, Server
from hil_bridge.hil.lockstep import Flight, Terms
from hil_bridge.hil.wiring import Wiring
from orchestration.process.writing import make_folder
from orchestration.results.result import Result, RunFailed, RunInterrupted

_LINE, _TERMS, _SIGNALS, _RESULTS = "Connection", "Time", "What it sees and moves", "Results"

app = typer.Typer()

_EPILOG = """Examples:

adcs hil hil-spacecraft

adcs hil hil-spacecraft --frame eci --max-torque 0.2,0.2,0.1 --stop 600 --out results/flight

adcs hil hil-spacecraft --free-running --timeout 2
"""


@app.command(epilog=_EPILOG)
def hil(
    system: Annotated[str, typer.Argument(help="Name of a system (`adcs list`), or an .ssp file.")],
    host: Annotated[str, typer.Option(help="Address to listen on.", rich_help_panel=_LINE)] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="TCP port; 0 takes a free one.", rich_help_panel=_LINE)] = PORT,
    remote: Annotated[
        bool, typer.Option("--remote", help="Let --host be reachable from other machines.", rich_help_panel=_LINE)
    ] = False,
    connect_timeout: Annotated[
        float, typer.Option(help="How long to wait for an autopilot [s].", rich_help_panel=_LINE)
    ] = 60.0,
    step: Annotated[
        float | None, typer.Option(help="Time between two sensor messages [s].", rich_help_panel=_TERMS)
    ] = None,
    stop: Annotated[float | None, typer.Option(help="Stop time [s].", rich_help_panel=_TERMS)] = None,
    free_running: Annotated[
        bool,
        typer.Option(
            "--free-running", help="Keep real time instead of waiting for each answer.", rich_help_panel=_TERMS
        ),
    ] = False,
    timeout: Annotated[
        float,
        typer.Option(
            help="How long an answer may take, in lockstep; or be old, free running [s].", rich_help_panel=_TERMS
        ),
    ] = 5.0,
    warm_up: Annotated[
        float,
        typer.Option(
            help="How long an autopilot may boot: until its first answer, time goes on without it [s].",
            rich_help_panel=_TERMS,
        ),
    ] = 60.0,
    speed: Annotated[
        float, typer.Option(help="Pace of a free run, and of the warm-up; 1: real time.", rich_help_panel=_TERMS)
    ] = 1.0,
    frame: Annotated[
        FrameName,
        typer.Option(help="What attitudes are relative to: NED below it, LVLH, or inertial.", rich_help_panel=_SIGNALS),
    ] = "ned",
    epoch: Annotated[
        datetime, typer.Option(help="UTC at t = 0, which turns the Earth.", rich_help_panel=_SIGNALS)
    ] = datetime(2026, 1, 1),
    max_torque: Annotated[
        str,
        typer.Option(
            metavar="X[,Y,Z]", help="Torque about x, y, z of controls 1, 2, 3 at 1 [N m].", rich_help_panel=_SIGNALS
        ),
    ] = "1",
    actuators: Annotated[
        Path | None,
        typer.Option(
            help="CSV of 3 lines instead: torque [N m] about x, y, z of each control at 1.", rich_help_panel=_SIGNALS
        ),
    ] = None,
    torque: Annotated[
        str | None, typer.Option(metavar="NAME", help="Input that takes the torque.", rich_help_panel=_SIGNALS)
    ] = None,
    no_truth: Annotated[
        bool,
        typer.Option("--no-truth", help="Do not send the true state, HIL_STATE_QUATERNION.", rich_help_panel=_SIGNALS),
    ] = False,
    no_star_tracker: Annotated[
        bool,
        typer.Option(
            "--no-star-tracker", help="Do not send the star tracker's attitude, ODOMETRY.", rich_help_panel=_SIGNALS
        ),
    ] = False,
    set_: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="Start value of a COMPONENT.VARIABLE; may be repeated."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the results. [default: results/SYSTEM]", rich_help_panel=_RESULTS)
    ] = None,
    no_report: Annotated[
        bool, typer.Option("--no-report", help="Write no report.html and report.png.", rich_help_panel=_RESULTS)
    ] = False,
    json: Annotated[
        bool, typer.Option("--json", help="Print key numbers, outcome and files as JSON.", rich_help_panel=_RESULTS)
    ] = False,
) -> None:
    """Let an autopilot fly a system over TCP, as PX4's simulators do: sensors out, actuator controls in."""
    entry = find_system(system)
    built = entry.build()
    assign(built, set_ or [])
    wiring = Wiring.find(built, torque)
    effect = Actuators.from_csv(actuators) if actuators else Actuators.by_axis(_numbers(max_torque))
    terms = Terms(not free_running, timeout, warm_up, speed, frame, epoch, not no_truth, not no_star_tracker)
    folder = out or Path("results") / entry.name
    make_folder(folder, f"--out {folder}")
    stop = entry.stop_time if stop is None else stop
    step = entry.step if step is None else step
    check(built, stop_time=stop, step=step)  # before anybody waits for anybody
    server = Server(host, port, remote)
    console = Console(stderr=True)
    console.print(f"waiting for an autopilot on {server.host}:{server.port}", highlight=False, soft_wrap=True)
    stopped: RunFailed | RunInterrupted | None = None
    with server.autopilot(connect_timeout, timeout) as link:
        console.print(f"autopilot at {link.peer} connected", highlight=False, soft_wrap=True)
        flight = Flight(built, link, wiring, effect, terms)
        settings = {
            **asdict(terms),
            "epoch": epoch.isoformat(),
            "wiring": asdict(wiring),
            "effect": effect.effect.tolist(),
        }
        with progress() as bar:
            task = bar.add_task(entry.name, total=1.0)
            try:
                result = fly(
                    built,
                    flight,
                    stop_time=stop,
                    step=step,
                    settings=settings,
                    progress=lambda part: bar.update(task, completed=part),
                )
            except (RunFailed, RunInterrupted) as error:
                stopped, result = error, error.result
    for name in REPORT_FILES:
        (folder / name).unlink(missing_ok=True)
    files = write_files(result, folder, ["csv", "mat"])
    numbers = [] if stopped else list(entry.key_numbers(result))
    if not (stopped or no_report):
        files += write_report(entry, result, numbers, None, folder)
    if json:
        typer.echo(as_json(result, numbers, files))
    else:
        show(result, numbers, None, files)
        for line in _lines(result):
            Console().print(line, highlight=False, soft_wrap=True)
    if stopped is not None:
        raise typer.Exit(exit_code(stopped))


def _numbers(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise AdcsError(f"--max-torque {text}: expected one number or three, as in 0.2,0.2,0.1") from None


def _lines(result: Result) -> list[str]:
    """What there is to say about the autopilot."""
    account: dict[str, Any] = result.manifest["hardware_in_the_loop"]
    lines = [
        f"{account['points_answered']} points answered, in {1e3 * account['answer_median_s']:.3g} ms in the median and "
        f"{1e3 * account['answer_99_percent_s']:.3g} ms at 99 %"
    ]
    odd = {
        "points went on without an answer": account["points_not_waited_for"],
        "answers were late and dropped": account["answers_late"],
        "answers were ahead of time and dropped": account["answers_ahead"],
        "answers were clipped to -1 to 1": account["controls_clipped"],
        "answers were not armed": account["answers_not_armed"],
        "bytes were no messages": account["garbage_bytes"],
    }
    return [*lines, *(f"{n} {what}" for what, n in odd.items() if n)]
