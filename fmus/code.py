"""C++ code as text: lines without comments, and where they are."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

_COMMENT = re.compile(r'(?P<kept>"(?:\\.|[^"\\\n])*")|//[^\n]*|/\*.*?(?:\*/|\Z)', re.DOTALL)


class Place(NamedTuple):
    """A line of a file, from 1, and the column in it."""

    path: Path
    line: int
    column: int = 1

    @property
    def source(self) -> str:
        """The line itself; empty if it is not there."""
        try:
            return self.path.read_text(encoding="utf-8", errors="replace").splitlines()[self.line - 1]
        except (OSError, IndexError):
            return ""

    @property
    def before(self) -> str:
        """What stands before it in the line."""
        return self.source[: self.column - 1]

    @property
    def after(self) -> str:
        """What stands in the line from it on."""
        return self.source[self.column - 1 :]

    def __str__(self) -> str:
        """Return how it is told: `law.hpp:17`, from the folder that the user is in if it is there."""
        here = Path.cwd()
        return f"{self.path.relative_to(here) if self.path.is_relative_to(here) else self.path}:{self.line}"


def line_of(file: Path, text: str) -> Place | None:
    """Return the last line of a file that has a text, comments left out; None if none has."""
    places = [number for number, line in code_lines(file) if text in line] if text else []
    return Place(file, places[-1]) if places else None


def code_lines(file: Path) -> Iterator[tuple[int, str]]:
    """Yield the lines of a file by number, without comments."""
    yield from enumerate(without_comments(file.read_text(encoding="utf-8", errors="replace")).splitlines(), 1)


def without_comments(code: str) -> str:
    """Return code whose comments are blank; texts between quotes stay."""
    return _COMMENT.sub(lambda found: found["kept"] or re.sub(r"[^\n]", " ", found[0]), code)
