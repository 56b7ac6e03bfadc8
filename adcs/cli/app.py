"""The command `adcs`: a file for each of its commands, which are put together here."""

from __future__ import annotations

import sys
from importlib import metadata

from cyclopts import CycloptsError

from adcs.cli import (
    bridge,
    build,
    check,
    export,
    hil,
    info,
    linearize,
    listing,
    recover,
    replay,
    rerun,
    run,
    slips,
    study,
)
from adcs.cli.command import command
from fmus.errors import AdcsError

app = command("adcs")
app.help = "Spacecraft attitude control as native FMI components: build them, wire them, run them."
app.version = metadata.version("adcs-fmus")
for _part in (build, listing, info, check, run, rerun, recover, export, linearize, hil, study, bridge, replay):
    app.command(_part.app)
COMMANDS = [name for name in app if not name.startswith("-")]
app.register_install_completion_command(name="--install-completion")


def main() -> None:
    """Run the command line; what is refused becomes one line and exit code 2, what fails one line and exit code 1."""
    arguments = run.at_in_one(sys.argv[1:])
    try:
        app(arguments)
    except CycloptsError as error:
        print(f"adcs: {slips.told(error, arguments, COMMANDS)}", file=sys.stderr)
        sys.exit(2)
    except AdcsError as error:
        print(f"adcs: {error}", file=sys.stderr)
        sys.exit(1 if error.failed else 2)
    except OSError as error:  # a folder that is none, a disk that is full
        if error.filename is None:
            raise
        print(f"adcs: {error.filename}: {error.strerror}", file=sys.stderr)
        sys.exit(2 if isinstance(error, FileNotFoundError) else 1)
