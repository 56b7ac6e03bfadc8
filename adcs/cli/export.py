"""The command `export`: a system as an `.ssp` file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from fmus.errors import AdcsError
from orchestration.ssp.names import is_ssp

app = typer.Typer(no_args_is_help=True, rich_markup_mode="markdown", help="Exports systems.")


@app.command("export")
def export_command(
    system: Annotated[str, typer.Argument(help="A system as in `adcs list`, or an .ssp file (or FILE.ssp#NAME.ssd).")],
    file: Annotated[Path | None, typer.Argument(help="The file to write. [default: SYSTEM.ssp]")] = None,
    ssp: Annotated[bool, typer.Option("--ssp", help="The format, and the only one so far.", show_default=False)] = True,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The file, where it is no argument.", show_default=False)
    ] = None,
    fmi: Annotated[
        Literal["2", "3"] | None, typer.Option(help="FMI version of the components. [default: 2]", show_default=False)
    ] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="Start value of a COMPONENT.VARIABLE, as in `adcs run`."),
    ] = None,
    step: Annotated[float | None, typer.Option(help="Exchange step to note in the file [s].")] = None,
    stop: Annotated[float | None, typer.Option(help="Stop time to note in the file [s].")] = None,
) -> None:
    """Write a system with its FMUs and start values into one file that other tools can read.

    Examples: `adcs export observer-pd --ssp` · `adcs export observer-pd --ssp out/t5.ssp --fmi 3` ·
    `adcs export a.ssp --ssp b.ssp --set plant.J_B=...`
    """
    from adcs.catalogue import SYSTEMS
    from adcs.cli.words import assign
    from orchestration.ssp.read import read_ssp
    from orchestration.ssp.write import write_ssp

    start_time = 0.0
    if is_ssp(system):
        if file is None and out is None:
            raise AdcsError(f"say where to: adcs export {system} --ssp FILE.ssp")
        if fmi is not None:
            raise AdcsError(f"--fmi {fmi}: the FMUs in {system} stay as they are: leave it out")
        read = read_ssp(system)
        built, stop_time, exchange = read.system, read.stop_time, read.step
        start_time = read.start_time or 0.0
    elif system in SYSTEMS:
        entry = SYSTEMS[system]
        built, stop_time, exchange = entry.build(), entry.stop_time, entry.step
    else:
        raise AdcsError(f"no system {system!r}: choose one of {', '.join(SYSTEMS)}, or give an .ssp file")
    if file is not None and out is not None:
        raise AdcsError(f"--out {out}: the file is given as {file} already, leave one out")
    target = out or file or Path(f"{system}.ssp")
    if target.suffix != ".ssp":
        raise AdcsError(f"{target} does not end in .ssp: write adcs export SYSTEM --ssp FILE.ssp")
    if target.is_dir():
        raise AdcsError(f"{target} is a folder: give the name of a file in it")
    assign(built, set_ or [])
    write_ssp(
        built,
        target,
        start_time=start_time,
        stop_time=stop_time if stop is None else stop,
        step=exchange if step is None else step,
        fmi_version="3.0" if fmi == "3" else "2.0",
    )
    size = target.stat().st_size / 1e6
    print(f"{target}: {len(built.components)} components, {len(built.connections)} connections, {size:.1f} MB")
