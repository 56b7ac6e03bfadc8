"""The command `adcs`: a file for each of its commands, which are put together here."""

from __future__ import annotations

import sys

import typer

from adcs.cli import bridge, build, check, export, hil, info, linearize, listing, recover, run, study
from fmus.errors import AdcsError

app = typer.Typer(
    help="Spacecraft attitude control as native FMI components: build them, wire them, run them.",
    no_args_is_help=True,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
)
for _part in (build, listing, info, check, run, recover, export, linearize, hil, study, bridge):
    app.registered_commands += _part.app.registered_commands


def main() -> None:
    """Run the command line; an AdcsError becomes one line and exit code 1."""
    try:
        app(run.at_in_one(sys.argv[1:]), prog_name="adcs")
    except AdcsError as error:
        print(f"adcs: {error}", file=sys.stderr)
        sys.exit(1)
    except OSError as error:  # a folder that is none, a disk that is full
        if error.filename is None:
            raise
        print(f"adcs: {error.filename}: {error.strerror}", file=sys.stderr)
        sys.exit(1)
