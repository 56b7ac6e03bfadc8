"""The command `adcs`: a file for each of its commands, of which only the one that is given is loaded."""

from __future__ import annotations

import ast
import logging
import sys
from importlib import metadata
from io import TextIOWrapper
from pathlib import Path

from cyclopts import App, CycloptsError

from adcs.cli import slips
from adcs.cli.command import command
from fmus.errors import AdcsError
from fmus.nearby import instead

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


def _summary(file: str) -> str:
    """The first line of a command's docstring, read from its file: to load all of them would take a second."""
    tree = ast.parse((Path(__file__).parent / f"{file}.py").read_text(encoding="utf-8"))
    functions = (each for each in tree.body if isinstance(each, ast.FunctionDef))
    default = next(each for each in functions if any(ast.unparse(d) == "app.default" for d in each.decorator_list))
    return (ast.get_docstring(default) or "").partition("\n")[0]


def _commands(*, listed: bool = False) -> App:
    """All commands, none of them loaded; `listed` is for a list of them all, with their summaries."""
    made = command("adcs")
    about = metadata.metadata("adcs-fmus")  # of pyproject.toml
    made.help, made.version = f"{about['Summary']}.", about["Version"]
    for name, file in _FILES.items():  # a help that is given here is all that the command's own `--help` would say
        made.command(f"{__package__}.{file}:app", name=name, **({"help": _summary(file)} if listed else {}))
    made.register_install_completion_command(name="--install-completion")
    return made


app = _commands()


def main() -> None:
    """Run the command line; what is refused becomes one line and exit code 2, what fails one line and exit code 1."""
    arguments = sys.argv[1:]
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # what its encoding has not is no reason to fail
            stream.reconfigure(errors="replace")
    logging.basicConfig(format="%(message)s")
    logging.getLogger("adcs").setLevel(logging.INFO)  # what is built, which takes a while
    try:
        if arguments[:1] == ["run"]:
            from adcs.cli.run import at_in_one

            arguments = at_in_one(arguments)
        overview = not arguments or arguments[0].startswith("-")
        (_commands(listed=True) if overview else app)(arguments)
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
        print(f"adcs: {error.filename}: {error.strerror}{instead(error.filename)}", file=sys.stderr)
        sys.exit(2 if isinstance(error, FileNotFoundError) else 1)
