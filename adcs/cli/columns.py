"""Lines, and rows in columns as wide as what is in them: nothing is cut at any width, and a pipe has none."""

from __future__ import annotations

import os
from collections.abc import Sequence
from textwrap import wrap

from rich.text import Text

from adcs.cli.printing import OUT

_INDENT = "    "


def say(text: str, *, bold: int = 0, style: str = "") -> None:
    """Print a line, broken between words where it is too long; so many characters at its beginning are bold."""
    lines = [Text(line, style) for line in _wrapped(text, _width(), "")]
    for line in lines[:1]:
        line.stylize("bold", 0, bold)
    _print(lines)


def show(columns: Sequence[str], rows: Sequence[Sequence[str]], notes: Sequence[str] = ()) -> None:
    """Print rows under the names of their columns, each with its note below.

    The last cell of a row, if it is too long for the line, stands below, too, behind the name of its column.
    """
    widths = [max(map(len, cells)) for cells in zip(columns, *rows, strict=True)][:-1]
    width = _width()
    lines = [Text(_line(columns, widths), "bold")]
    for row, note in zip(rows, notes or [""] * len(rows), strict=True):
        whole = _line(row, widths)
        fits = width is None or len(whole) <= width
        line = Text(whole if fits else _line([*row[:-1], ""], widths))
        line.stylize("bold", 0, len(row[0]))
        lines.append(line)
        below = [] if fits else [f"{columns[-1]}: {row[-1]}"]
        lines += [Text(text, "dim") for part in [*below, note] for text in _wrapped(part, width, _INDENT)]
    _print(lines)


def _width() -> int | None:
    return OUT.width if OUT.is_terminal or "COLUMNS" in os.environ else None


def _print(lines: Sequence[Text]) -> None:
    if OUT.is_terminal:
        OUT.print(Text("\n").join(lines), soft_wrap=True)
    else:
        OUT.out("\n".join(line.plain for line in lines), highlight=False)


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    padded = [cell.ljust(width) for cell, width in zip(cells, widths, strict=False)]
    return "  ".join([*padded, cells[-1]]).rstrip()


def _wrapped(text: str, width: int | None, indent: str) -> list[str]:
    return wrap(
        text,
        width or len(indent + text) or 1,
        initial_indent=indent,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
