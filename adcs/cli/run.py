"""`adcs run`: from words on the command line to a run, its files and what people see of it."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from typing import Any

from adcs.cli import ground_tools as ground
from adcs.cli.command import command, given
from adcs.cli.options import During, Results, Solving, Streaming, SystemName, Times, Which
from adcs.cli.run_files import RunFiles
from adcs.cli.showing import Format, as_json, command_line, exit_code, run_progress, show, write_report
from fmus.errors import AdcsError
from orchestration.from_file import from_anywhere
from orchestration.isolation import supervised
from orchestration.isolation.folder import MANIFEST
from orchestration.process import endings
from orchestration.results.result import RunFailed, RunInterrupted
from orchestration.running.accuracy import Estimate, estimate_error
from orchestration.running.hooks.pace import Pace
from orchestration.running.run import run as run_system
from orchestration.running.save import Save
from orchestration.system import System

_LARGE = 20_000_000  # values; more are written, but not read again for key numbers and report

app = command(
    "run",
    "adcs run observer-pd --step 1ms --set tracker.half_angle=0.05deg --out noisy",
    "adcs run observer-pd --at 20s controller.k_p=3 --stop 5min",
    'adcs run observer-pd --until "norm(controller.omega_BR_B) < 1e-3"',
    "adcs run system.ssp --estimate-error --format hdf5",
)


@app.default
def run(
    system: SystemName,
    /,
    which: Which = Which(),
    times: Times = Times(),
    solving: Solving = Solving(),
    during: During = During(),
    tools: Streaming = Streaming(),
    results: Results = Results(),
) -> None:
    """Run a system: write the result, manifest.json, report.html, and print the key numbers."""
    entry, built = which.built(system)
    start, stop, step = times.start_of(entry), times.stop_of(entry), times.step_of(entry)
    method, hooks = solving.made(), during.hooks(built)
    record = list(results.record) or None
    formats: list[Format] = list(dict.fromkeys(results.format or ("csv", "mat")))
    no_report = results.no_report or (record is not None and formats == ["hdf5"])  # whose file holds what is recorded
    wanted = record if no_report else _with_outputs(built, record)  # the report needs more than what is written
    if stop == start:
        raise AdcsError(f"stop = {start:g} s is the start time: give a later one")
    errors: Estimate | None = None
    attached: AbstractContextManager[Any] = nullcontext()
    if tools.mavlink or tools.tlog is not None:
        if solving.estimate_error:
            raise AdcsError("--estimate-error repeats the run, which --mavlink and --tlog would show: leave one out")
        if tools.mavlink and during.real_time is None:
            hooks.append(Pace())
        if tools.tlog is not None:
            tools = replace(tools, tlog=tools.tlog.absolute())
        speed = during.real_time or 1.0
        watcher = ground.attached(built, tools, step=step, start=start, speed=speed, network=tools.mavlink)
        attached = watcher
        hooks.append(watcher)
        wanted = _with_outputs(built, wanted)
    elif options := given(tools):
        raise AdcsError(f"{', '.join(options)}: for ground tools, add --mavlink")
    about = {
        "system": from_anywhere(system),
        "record": record,
        "report": not no_report,
        "png": results.png,
        "json": results.json,
    }
    with (
        endings.heard(),
        results.folder(entry) as folder,  # refused now, rather than after the run
        RunFiles(
            folder, formats, {**about, "command": command_line()}, solving.timeout, supervised.printed
        ) as run_files,
        attached,
        run_progress() as bar,
    ):
        task = bar.add_task(entry.name, total=1.0)
        stopped: RunFailed | RunInterrupted | None = None

        def update(part: float) -> None:
            bar.update(task, completed=part)

        try:
            result = run_system(
                built,
                start_time=start,
                stop_time=stop,
                step=times.step,
                method=method,
                save=Save(wanted, every=results.record_every, rows=results.rows, to=run_files.journal),
                hooks=hooks,
                resume=during.resume,
                fmi_version=which.fmi_version,
                progress=update,
            )
        except (RunFailed, RunInterrupted) as error:
            stopped, result = error, error.result
        bar.update(task, completed=1.0, description="writing the results")
        written = result if record in (None, result.names) else result.select(record)
        files = run_files.write(written, stopped is not None)
        if solving.estimate_error and stopped is None:
            bar.update(task, completed=0.0, description="estimating the error")
            errors = estimate_error(result, run_system, update)
            result.manifest["error_estimate"] = written.manifest["error_estimate"] = errors.as_dict()
            written.write_manifest(folder.path / MANIFEST)
        large = len(result.time) * sum(port.size for port in result.ports.values()) > _LARGE
        whole = (record is None or not no_report) and not large  # key numbers need all outputs
        numbers = list(entry.key_numbers(result)) if whole and not stopped else []
        if not (stopped or no_report or large):
            files += write_report(entry, result, numbers, errors, folder.path, png=results.png)
    files = [folder.given / file.name for file in files]
    if results.json:
        print(as_json(result, numbers, files))
    else:
        show(result, numbers, errors, files)
    if stopped is not None:
        sys.exit(exit_code(stopped))
    if endings.noted:
        sys.exit(128 + endings.last)


def at_in_one(arguments: Sequence[str]) -> list[str]:
    """Join the two words after each `--at` of `run`, since an option that may be repeated takes one."""
    joined: list[str] = []
    if arguments[:1] != ["run"]:
        return list(arguments)
    for word in arguments:
        time_alone = joined[-2:-1] == ["--at"] or any(last.startswith("--at=") for last in joined[-1:])
        if time_alone and " " not in joined[-1] and not word.startswith("-"):
            joined[-1] += f" {word}"
        else:
            joined.append(word)
    return joined


def _with_outputs(system: System, record: Sequence[str] | None) -> list[str] | None:
    return None if record is None else list(dict.fromkeys([*system.outputs(), *record]))
