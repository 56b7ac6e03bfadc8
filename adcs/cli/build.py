"""`adcs build`: compiles components and packs them as FMUs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from adcs.cli.command import at_work, command
from adcs.cli.printing import OUT, Json, print_json
from adcs.cli.progress import progress
from fmus.build import build
from fmus.built import fmus_of
from fmus.catalog import Component, components, meant
from fmus.toolchain import is_installed

app = command(
    "build", "adcs build", "adcs build RigidBody PdTracking", "adcs build --all-platforms", takes="[NAMES...]"
)


@app.default
def build_command(
    *names: Annotated[str, Parameter(help="Components, headers, or folders of headers; all components if left out.")],
    all_platforms: Annotated[bool, Parameter(help="For Linux, Windows and macOS, not only this machine.")] = False,
    as_json: Json = False,
) -> None:
    """Build FMUs, for FMI 2.0 and 3.0; what is up to date stays."""
    found = [each for name in names for each in meant(name)] or components()
    with at_work():
        built = _built(list(names), all_platforms, as_json) if is_installed() else _ready(found)
    if as_json:
        print_json([{"path": str(path), "bytes": path.stat().st_size} for path in built])
        return
    table = Table("FMU", "Size", title=f"in {built[0].parent}", title_justify="left")
    for path in built:
        table.add_row(path.name, f"{path.stat().st_size / 1e3:.0f} kB")
    OUT.print(table)


def _built(names: list[str], all_platforms: bool, quiet: bool) -> list[Path]:
    columns = (TextColumn("{task.description:<44}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with progress(*columns, quiet=quiet) as bar:
        task = bar.add_task("compiling", total=None)

        def show(done: int, total: int, what: str) -> None:
            bar.update(task, completed=done, total=total, description=what)

        return build(names or None, all_platforms, show)


def _ready(wanted: Sequence[Component]) -> list[Path]:
    """Return the FMUs, as far as no compiler is needed for them: those that are up to date, and those of a wheel."""
    return [fmu for component in wanted for fmu in fmus_of(component)]
