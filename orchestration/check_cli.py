"""`adcs check`: what is wrong with FMUs, and what a run refuses of them."""

from __future__ import annotations

from typing import Annotated

import typer

from fmus.cli import Json, show_findings
from orchestration.checking import check

app = typer.Typer()


@app.command("check")
def check_command(
    fmus: Annotated[
        list[str] | None,
        typer.Argument(help="Components or paths of FMUs; all built components if left out.", show_default=False),
    ] = None,
    as_json: Json = False,
) -> None:
    """Check FMUs: standard, layout, binaries, what validators miss, and what a run refuses. Exit code 1 for faults.

    A note is about what no standard forbids, but what some machine or tool cannot do with.

    Examples: `adcs check` · `adcs check RigidBody` · `adcs check path/to/some.fmu`
    """
    show_findings(fmus or [], as_json, check)
