"""The command `adcs`: a file for each of its commands, of which only the one that is given is loaded."""

from __future__ import annotations

import logging
import sys
from contextlib import suppress
from importlib import metadata

from cyclopts import CycloptsError

from adcs.cli import slips
from adcs.cli.command import command
from fmus.errors import AdcsError

_FILES = {
    "build": "build",
    "list": "listing",
    "info": "info",
    "check": "check",
    "fmus": "copies",
    "new": "new",
    "run": "run",
    "open": "opening",
    "rerun": "rerun",
    "recover": "recover",
    "export": "export",
    "linearize": "linearize",
    "hil": "hil",
    "study": "study",
    "bridge": "bridge",
    "replay": "replay",
}
"""Each command, and the module here that has it."""

COMMANDS = list(_FILES)

_EXTRAS = {"ziglang": "build", "lief": "build", "matplotlib": "plot", "pymavlink": "mavlink"}
"""Packages that not everyone needs, and the extra of this package that brings them."""

app = command("adcs")
app.help = "Spacecraft attitude control as native FMI components: build them, wire them, run them."
app.version = metadata.version("adcs-fmus")
for _name, _file in _FILES.items():
    app.command(f"{__package__}.{_file}:app", name=_name)
app.register_install_completion_command(name="--install-completion")


def main() -> None:
    """Run the command line; what is refused becomes one line and exit code 2, what fails one line and exit code 1."""
    arguments = sys.argv[1:]
    logging.basicConfig(format="%(message)s")
    logging.getLogger("adcs").setLevel(logging.INFO)  # what is built, which takes a while
    try:
        if arguments[:1] == ["run"]:
            from adcs.cli.run import at_in_one

            arguments = at_in_one(arguments)
        elif not arguments or arguments[0].startswith("-"):
            _load_all()
        app(arguments)
    except CycloptsError as error:
        print(f"adcs: {slips.told(error, arguments, COMMANDS)}", file=sys.stderr)
        sys.exit(2)
    except AdcsError as error:
        print(f"adcs: {error}", file=sys.stderr)
        sys.exit(1 if error.failed else 2)
    except ImportError as error:
        missing = error.__cause__ if isinstance(error.__cause__, ImportError) else error
        package = str(missing.name).partition(".")[0]
        if package not in _EXTRAS:
            raise
        print(f"adcs: {package} is not installed: pip install 'adcs-fmus[{_EXTRAS[package]}]'", file=sys.stderr)
        sys.exit(1)
    except OSError as error:  # a folder that is none, a disk that is full
        if error.filename is None:
            raise
        print(f"adcs: {error.filename}: {error.strerror}", file=sys.stderr)
        sys.exit(2 if isinstance(error, FileNotFoundError) else 1)


def _load_all() -> None:
    """Load the commands, whose help is asked for, but those that need what is not installed."""
    for name in _FILES:
        with suppress(ImportError):
            app[name].help  # noqa: B018
