"""The command `adcs`: a file for each of its commands, which are put together here."""

from __future__ import annotations

import logging
import sys
from collections.abc import Sequence
from importlib import metadata

from cyclopts import CycloptsError, UnknownOptionError

from adcs.cli import (
    bridge,
    build,
    check,
    export,
    hil,
    info,
    linearize,
    listing,
    opening,
    recover,
    replay,
    rerun,
    run,
    study,
)
from adcs.cli.command import command
from fmus.errors import AdcsError

RENAMED = {
    "run": {"--inputs": "--input-table"},
    "bridge": {"--out": "--to", "--expose": "--remote", "--speed": "--real-time"},
    "replay": {"--out": "--to", "--expose": "--remote", "--speed": "--real-time"},
    "hil": {"--connect-timeout": "--wait", "--timeout": "--answer-timeout", "--speed": "--real-time"},
}
"""Options of one version ago, and the names that they have now: whoever writes the old one is told."""

app = command("adcs")
app.help = "Spacecraft attitude control as native FMI components: build them, wire them, run them."
app.version = metadata.version("adcs-fmus")
for _part in (build, listing, info, check, run, opening, rerun, recover, export, linearize, hil, study, bridge, replay):
    app.command(_part.app)
app.register_install_completion_command(name="--install-completion")


def main() -> None:
    """Run the command line; an AdcsError becomes one line and exit code 1, words that it does not know exit code 2."""
    arguments = run.at_in_one(sys.argv[1:])
    logging.basicConfig(format="%(message)s")
    logging.getLogger("adcs").setLevel(logging.INFO)  # what is built, which takes a while
    try:
        app(arguments)
    except CycloptsError as error:
        print(f"adcs: {_told(error, arguments)}", file=sys.stderr)
        sys.exit(2)
    except AdcsError as error:
        print(f"adcs: {error}", file=sys.stderr)
        sys.exit(1)
    except OSError as error:  # a folder that is none, a disk that is full
        if error.filename is None:
            raise
        print(f"adcs: {error.filename}: {error.strerror}", file=sys.stderr)
        sys.exit(1)


def _told(error: CycloptsError, arguments: Sequence[str]) -> str:
    if isinstance(error, UnknownOptionError):
        old = str(error.token.keyword)
        if new := RENAMED.get(arguments[0], {}).get(old):
            return f"{old} is {new} now"
    return " ".join(str(error).split())
