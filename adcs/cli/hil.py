"""`adcs hil`: wait for an autopilot, let it fly a system, write what happened."""

from __future__ import annotations

import sys
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter
from rich.console import Console

from adcs.cli.command import Epoch, Speed, Time, Whole, at_work, command, group
from adcs.cli.options import Report, Steps, SystemName, Which
from adcs.cli.showing import as_json, exit_code, run_progress, show, write_files, write_report
from fmus.errors import AdcsError
from hil_bridge.frames import FrameName
from hil_bridge.hil.actuators import Actuators
from hil_bridge.hil.flying import check, fly
from hil_bridge.hil.link import PORT, Server
from hil_bridge.hil.lockstep import Flight, Terms
from hil_bridge.hil.wiring import Wiring
from orchestration.results.result import Result, RunFailed, RunInterrupted

app = command(
    "hil",
    "adcs hil hil-spacecraft",
    "adcs hil hil-spacecraft --frame eci --max-torque 0.2 --stop 10min --out flight",
    "adcs hil hil-spacecraft --free-running --answer-timeout 2s",
)


@group("Connection")
class Connection:
    """Where the autopilot is, and how long anybody waits for it."""

    host: str = "127.0.0.1"
    """Address to listen on."""
    port: Whole = PORT
    """TCP port; 0 takes a free one."""
    remote: bool = False
    """Let --host be reachable from other machines."""
    wait: Time = 60.0
    """Wait for an autopilot to come, so long at most."""
    answer_timeout: Time = 5.0
    """How long an answer may take, in lockstep; or be old, free running."""
    warm_up: Time = 60.0
    """How long an autopilot may boot: until its first answer, time goes on without it."""
    free_running: bool = False
    """Keep real time instead of waiting for each answer."""
    real_time: Speed = 1.0
    """Keep pace with the clock, SPEED times as fast: a free run, and the warm-up."""


@group("What it sees and moves")
class Signals:
    """What the autopilot is told, and what its controls do."""

    frame: FrameName = "ned"
    """What attitudes are relative to: NED below it, LVLH, or inertial."""
    epoch: Epoch = datetime(2026, 1, 1)
    """UTC at t = 0, for the turning Earth."""
    max_torque: Annotated[str, Parameter(metavar="X[,Y,Z]", allow_leading_hyphen=True)] = "1"
    """Torque about x, y, z of controls 1, 2, 3 at 1 [N m]."""
    actuators: Path | None = None
    """CSV of 3 lines instead: torque [N m] about x, y, z of each control at 1."""
    torque: Annotated[str | None, Parameter(metavar="NAME")] = None
    """Input that takes the torque."""
    no_truth: bool = False
    """Do not send the true state, HIL_STATE_QUATERNION."""
    no_star_tracker: bool = False
    """Do not send the star tracker's attitude, ODOMETRY."""


@app.default
def hil(
    system: SystemName,
    /,
    which: Which = Which(),
    steps: Steps = Steps(),
    connection: Connection = Connection(),
    signals: Signals = Signals(),
    report: Report = Report(),
) -> None:
    """Let an autopilot fly a system over TCP, as PX4's simulators do: sensors out, actuator controls in."""
    entry, built = which.built(system)
    wiring = Wiring.find(built, signals.torque)
    effect = (
        Actuators.from_csv(signals.actuators) if signals.actuators else Actuators.by_axis(_numbers(signals.max_torque))
    )
    terms = Terms(
        lockstep=not connection.free_running,
        timeout=connection.answer_timeout,
        warm_up=connection.warm_up,
        speed=connection.real_time,
        frame=signals.frame,
        epoch=signals.epoch,
        truth=not signals.no_truth,
        star_tracker=not signals.no_star_tracker,
    )
    step, stop = steps.step_of(entry), steps.stop_of(entry)
    check(built, stop_time=stop, step=step, fmi_version=which.fmi_version)  # before anybody waits for anybody
    stopped: RunFailed | RunInterrupted | None = None
    with report.folder(entry) as folder:
        server = Server(connection.host, connection.port, connection.remote)
        console = Console(stderr=True)
        console.print(f"waiting for an autopilot on {server.host}:{server.port}", highlight=False, soft_wrap=True)
        with at_work(), server.autopilot(connection.wait, connection.answer_timeout) as link:
            console.print(f"autopilot at {link.peer} connected", highlight=False, soft_wrap=True)
            flight = Flight(built, link, wiring, effect, terms)
            settings = {
                **asdict(terms),
                "epoch": signals.epoch.isoformat(),
                "wiring": asdict(wiring),
                "effect": effect.effect.tolist(),
            }
            with run_progress() as bar:
                task = bar.add_task(entry.name, total=1.0)
                try:
                    result = fly(
                        built,
                        flight,
                        stop_time=stop,
                        step=step,
                        fmi_version=which.fmi_version,
                        settings=settings,
                        progress=lambda part: bar.update(task, completed=part),
                    )
                except (RunFailed, RunInterrupted) as error:
                    stopped, result = error, error.result
        folder.clear()
        files = write_files(result, folder.given, ["csv", "mat"])
        numbers = [] if stopped else list(entry.key_numbers(result))
        if not (stopped or report.no_report):
            files += write_report(entry, result, numbers, None, folder.given, png=report.png)
        if not stopped:
            folder.forget()
    if report.json:
        print(as_json(result, numbers, files))
    else:
        show(result, numbers, None, files)
        for line in _lines(result):
            Console().print(line, highlight=False, soft_wrap=True)
    if stopped is not None:
        sys.exit(exit_code(stopped))


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
