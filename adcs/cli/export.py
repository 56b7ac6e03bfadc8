"""The command `export`: a system as an `.ssp` file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from adcs.cli.command import command
from adcs.cli.options import SystemName, Times, Which
from fmus.errors import AdcsError
from orchestration.from_file import is_file
from orchestration.ssp.names import is_ssp

app = command(
    "export",
    "adcs export observer-pd",
    "adcs export observer-pd out/t5.ssp --fmi 3 --stop 5min",
    "adcs export theirs.ssp ours.ssp --set plant.J_B=[[10,0,0],[0,19,0],[0,0,25]]",
    takes="SYSTEM [FILE]",
)


@app.default
def export(
    system: SystemName,
    file: Annotated[Path | None, Parameter(help="The file to write. [default: SYSTEM.ssp]")] = None,
    /,
    which: Which = Which(),
    times: Times = Times(),
    *,
    out: Annotated[Path | None, Parameter(help="The file, where it is no argument.", show_default=False)] = None,
    force: Annotated[bool, Parameter(help="Replace the file if it is there already.")] = False,
    ssp: Annotated[bool, Parameter(help="The format, and the only one so far.", show_default=False)] = True,
) -> None:
    """Write a system with its FMUs and start values into one file that other tools can read."""
    from orchestration.ssp.write import write_ssp

    if file is not None and out is not None:
        raise AdcsError(f"--out {out}: the file is given as {file} already, leave one out")
    file = out or file
    if is_ssp(system) and file is None:
        raise AdcsError(f"say where to: adcs export {system} FILE.ssp")
    if is_file(system) and which.fmi is not None:
        raise AdcsError(f"--fmi {which.fmi}: the FMUs in {system} stay as they are: leave it out")
    target = file or Path(f"{Path(system).stem}.ssp")
    if target.suffix != ".ssp":
        raise AdcsError(f"{target} does not end in .ssp: write adcs export {system} {target.stem}.ssp")
    if target.is_dir():
        raise AdcsError(f"{target} is a folder: give the name of a file in it")
    if target.is_file() and not force:
        raise AdcsError(f"{target} is there already: give another name, or --force to replace it")
    entry, built = which.built(system)
    write_ssp(
        built,
        target,
        start_time=times.start_of(entry),
        stop_time=None if times.stop is None and "stop_time" in entry.assumed else times.stop_of(entry),
        step=None if times.step is None and "step" in entry.assumed else times.step_of(entry),
        fmi_version=which.fmi_version,
        force=force,
    )
    size = target.stat().st_size / 1e6
    print(f"{target}: {len(built.components)} components, {len(built.connections)} connections, {size:.1f} MB")
