"""The command `adcs`: what each part brings, as one."""

from __future__ import annotations

import sys

import typer

import fmus.cli
import hil_bridge.cli
import hil_bridge.hil.cli
import orchestration.check_cli
import orchestration.info_cli
import orchestration.linear_cli
import orchestration.recover_cli
import orchestration.run_cli
import orchestration.ssp.cli
import studies.cli
from fmus.errors import AdcsError

app = typer.Typer(
    help="Spacecraft attitude control as native FMI components: build them, wire them, run them.",
    no_args_is_help=True,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
)
for _part in (
    fmus.cli.app,
    orchestration.check_cli.app,  # its `check` runs them as well
    orchestration.info_cli.app,  # its `info` takes files as well
    orchestration.run_cli.app,
    orchestration.recover_cli.app,
    orchestration.ssp.cli.app,
    orchestration.linear_cli.app,
    hil_bridge.hil.cli.app,
    studies.cli.app,
    hil_bridge.cli.app,
):
    app.registered_commands += _part.registered_commands


def main() -> None:
    """Run the command line; an AdcsError becomes one line and exit code 1."""
    try:
        app(orchestration.run_cli.at_in_one(sys.argv[1:]), prog_name="adcs")
    except AdcsError as error:
        print(f"adcs: {error}", file=sys.stderr)
        sys.exit(1)
    except OSError as error:  # a folder that is none, a disk that is full
        if error.filename is None:
            raise
        print(f"adcs: {error.filename}: {error.strerror}", file=sys.stderr)
        sys.exit(1)
