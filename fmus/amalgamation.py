"""The headers of a library in few files, without what only people read of them: half the size, the same program.

Eigen has 163 headers, which would be most of an FMU. Each of its modules (`Eigen/Core`, `Eigen/LU`, ...) becomes one
file, with its own headers where it includes them. Copyright notices stay.
"""

from __future__ import annotations

import os
import re
from collections.abc import Collection
from functools import cache, lru_cache
from pathlib import Path

_TOKEN = re.compile(
    r"""
      (?P<raw>\b(?:u8|[uUL])?R"(?P<end>[^()\\\s]{0,16})\(.*?\)(?P=end)")
    | (?P<comment>//(?:\\\n|[^\n])*(?:\n[ \t]*//(?:\\\n|[^\n])*)*|/\*.*?\*/)  # lines of one comment together
    | "(?:\\.|[^"\\\n])*"                      # a string
    | \.?[0-9](?:[eEpP][+-]|'?[0-9a-zA-Z_.])*  # a number, whose digits ' may separate
    | [a-zA-Z_][a-zA-Z_0-9]*
    | '(?:\\.|[^'\\\n])+'                      # a character
    | (?P<blank>[ \t]+)
    """,
    re.DOTALL | re.VERBOSE,
)
_BREAK = "\0"  # of a line inside a token
_NOTICE = re.compile(r"copyright|licen[cs]e", re.IGNORECASE)
_INCLUDE = re.compile(r'^#[ ]?include[ ]?"([^"\n]+)".*\n', re.MULTILINE)
_GUARD = re.compile(r"(?:(?://.*|/\*(?s:.*?)\*/)\s*)*#[ ]?ifndef (\w+)\n#[ ]?define \1\b")  # after a notice


def amalgamated(files: Collection[Path], base: Path, without: frozenset[Path] = frozenset()) -> dict[str, bytes]:
    """Return what to write instead of these headers, by paths relative to `base`.

    Those in folders called `src` go into the files that include them, but for the few that include themselves; those
    of `without` go nowhere.
    """
    everything = frozenset(files) - without
    includes = {file: {_named(file, include) for include in _INCLUDE.finditer(_stripped(file))} for file in everything}
    included = {other for file, others in includes.items() for other in others - {file}}
    parts = frozenset(f for f in included & everything if "src" in f.relative_to(base).parts and f not in includes[f])
    whole = sorted(everything - parts)
    return {file.relative_to(base).as_posix(): _alone(file, parts, everything, without) for file in whole}


def stripped(code: str) -> str:
    """Return C++ code without comments, empty lines and indentation; a comment with a copyright notice stays."""
    kept: list[str] = []
    for line in _TOKEN.sub(_shortened, code.replace("\r\n", "\n")).split("\n"):
        bare = line.strip(" ")
        if bare or (kept and kept[-1].endswith("\\")):  # where an empty line ends a macro
            kept.append(bare)
    return "\n".join(kept).replace(_BREAK, "\n") + "\n"


def _shortened(token: re.Match[str]) -> str:
    stays = token["raw"] is not None or (token["comment"] is not None and _NOTICE.search(token[0]))
    if stays:
        return token[0].replace("\n", _BREAK)
    return " " if token["comment"] is not None or token["blank"] is not None else token[0]


@lru_cache
def _alone(file: Path, parts: frozenset[Path], everything: frozenset[Path], without: frozenset[Path]) -> bytes:
    """Return the code of a header, with that of each of `parts` at the place where it is included."""
    done: set[Path] = set()

    def expanded(part: Path) -> str:
        code = _stripped(part)
        if _GUARD.match(code):  # others are meant to be there each time
            done.add(part)
        return _INCLUDE.sub(lambda include: content(include, _named(part, include)), code)

    def content(include: re.Match[str], other: Path) -> str:
        if other in without:
            return ""
        if other in parts:
            return "" if other in done else expanded(other)
        if other in everything:
            return f'#include "{Path(os.path.relpath(other, file.parent)).as_posix()}"\n'
        return include[0]

    return expanded(file).encode()


@cache
def _stripped(file: Path) -> str:
    return stripped(file.read_text(encoding="utf-8"))


def _named(file: Path, include: re.Match[str]) -> Path:
    return Path(os.path.normpath(file.parent / include[1]))
