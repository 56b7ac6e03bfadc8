"""A slip in the words of a command line, told in one line with the way out."""

from __future__ import annotations

from collections.abc import Sequence

from cyclopts import (
    CoercionError,
    CycloptsError,
    MissingArgumentError,
    UnknownCommandError,
    UnknownOptionError,
    UnusedCliTokensError,
)

from fmus.errors import shown
from fmus.spelling import close

RENAMED = {
    "run": {"--inputs": "--input-table"},
    "bridge": {"--out": "--to", "--expose": "--remote", "--speed": "--real-time"},
    "replay": {"--out": "--to", "--expose": "--remote", "--speed": "--real-time"},
    "hil": {"--connect-timeout": "--wait", "--timeout": "--answer-timeout", "--speed": "--real-time"},
}
"""Options of one version ago, and the names that they have now: whoever writes the old one is told."""

_TAKES = {bool: "it is an option without a value", float: "expected a number", int: "expected a whole number"}


def told(error: CycloptsError, arguments: Sequence[str], commands: Sequence[str]) -> str:
    """Say what is wrong with the arguments of `adcs`, which has these commands."""
    way_out = f"`{' '.join(('adcs', *(error.command_chain or ())))} --help` shows all"
    words = [shown(repr(word), 80) for word in error.unused_tokens or ()]
    match error:
        case UnknownOptionError():
            old = str(error.token.keyword)
            if new := RENAMED.get(arguments[0], {}).get(old):
                return f"{old} is {new} now"
            text = _in_one_line(error)
            return text if text.endswith("?") else f"{text.removesuffix('.')}: {way_out}"
        case UnknownCommandError():
            meant = close(arguments[0], commands)
            if arguments[0] == "help":
                return f"no command 'help': {way_out}"
            return f"no command {words[0]}: {f'did you mean {meant}? ' if meant else ''}{way_out}"
        case UnusedCliTokensError():
            return f"{', '.join(words)} {'is' if len(words) == 1 else 'are'} more than it takes: {way_out}"
        case MissingArgumentError() if error.argument is not None:
            option = error.keyword or next((t.keyword for t in error.argument.tokens if t.keyword), None)
            return f"{option} needs a value: {way_out}" if option else f"{error.argument.name} is missing: {way_out}"
        case CoercionError() if error.msg is None and error.token is not None and error.target_type in _TAKES:
            return f"Invalid value {error.token.value!r} for {error.token.keyword}: {_TAKES[error.target_type]}"
    return _in_one_line(error)


def _in_one_line(error: CycloptsError) -> str:
    return " ".join(str(error).split())
