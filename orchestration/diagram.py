"""Blocks, each in a row and a column of its own, and arrows between them at right angles, as SVG.

An arrow leaves its block sideways and enters the next from above or below; what it carries stands at the corner, in the
row of the one and the column of the other. What goes forward leaves to the right, and what is fed back to the left. So
nothing has to be placed by trial, no label can cover another, and the same blocks give the same picture. (Libraries for
this either need another program or place the blocks only; what is read here is the labels.)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from itertools import accumulate

# All are legible on white and on near-black alike, as a notebook may be either.
_STYLES = {"block": ("#3b7dd8", "#ffffff"), "label": ("#e9edf3", "#20262e")}
_BOLD = ' font-weight="bold"'
_LINE = "#7d8796"
_FONT = 'font-family="ui-monospace,Menlo,Consolas,DejaVu Sans Mono,monospace" font-size="11"'
_CHARACTER, _ROW = 6.7, 14.0  # width and height of a character, in pixels
_INSIDE, _BETWEEN, _AROUND = 7.0, 22.0, 4.0  # pixels around a text, between two boxes, and around all
_SMALLEST = 0.75  # of its size, as far as a narrow window makes it smaller; then it scrolls
_MOST = 6  # lines of a label


_Cell = tuple[int, int]  # row and column
_Size = tuple[float, float]


@dataclass(frozen=True)
class Box:
    """Lines of text, and what is said of them where the pointer rests."""

    lines: Sequence[str]
    more: str = ""


Blocks = Mapping[str, Box]
Arrows = Mapping[tuple[str, str], Box]
"""By the names of the two blocks: what is carried from the first to the second."""


def svg(blocks: Blocks, arrows: Arrows) -> str:
    """Draw them. What a block carries to itself is not drawn."""
    place = {name: i for i, name in enumerate(_in_order(list(blocks), arrows))}
    boxes = {(i, i): blocks[name] for name, i in place.items()}
    boxes |= {(place[a], place[b]): box for (a, b), box in arrows.items() if a != b}
    boxes = {cell: Box(_short(box.lines), box.more) for cell, box in sorted(boxes.items())}
    sizes = {cell: (_width(box.lines), _ROW * len(box.lines) + 2 * _INSIDE) for cell, box in boxes.items()}
    x = _columns({cell: width / 2 for cell, (width, _) in sizes.items()})
    y = _rows([max(height for (i, _), (_, height) in sizes.items() if i == row) for row in place.values()])
    drawn = [_line(i, j, x, y, sizes) for i, j in boxes if i != j]
    drawn += [_text(box, x[j], y[i], sizes[i, j], i == j) for (i, j), box in boxes.items()]
    width = max((x[j] + size[0] / 2 for (_, j), size in sizes.items()), default=0.0) + _AROUND
    height = max((y[i] + size[1] / 2 for (i, _), size in sizes.items()), default=0.0) + _AROUND
    size = f'width="{width:.0f}" height="{height:.0f}" viewBox="0 0 {width:.0f} {height:.0f}"'
    size += f' style="max-width:100%;min-width:{_SMALLEST * width:.0f}px;height:auto"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} {_FONT} text-anchor="middle">{"".join(drawn)}</svg>'


def _in_order(names: Sequence[str], arrows: Arrows) -> list[str]:
    """Put them so that few arrows are fed back: next is what needs the least of the rest, and of these what gives most.

    Of equals it is the first.
    """
    rest, ordered = list(names), list[str]()
    while rest:
        between = [(a, b) for a, b in arrows if a in rest and b in rest and a != b]
        needs = {name: sum(b == name for _, b in between) for name in rest}
        gives = {name: sum(a == name for a, _ in between) for name in rest}
        ordered.append(min(rest, key=lambda name: (needs[name], -gives[name])))
        rest.remove(ordered[-1])
    return ordered


def _short(lines: Sequence[str]) -> list[str]:
    return list(lines) if len(lines) <= _MOST else [*lines[: _MOST - 1], f"and {len(lines) - _MOST + 1} more"]


def _width(lines: Sequence[str]) -> float:
    return _CHARACTER * max(map(len, lines)) + 2 * _INSIDE


def _rows(heights: Sequence[float]) -> list[float]:
    """Return the middle of each row, of which none reaches into another."""
    ends = accumulate((_BETWEEN + height for height in heights), initial=_AROUND - _BETWEEN)
    return [end + _BETWEEN + height / 2 for end, height in zip(ends, heights, strict=False)]


def _columns(halves: Mapping[_Cell, float]) -> list[float]:
    """Return the middle of each column, as far to the left as what stands in the same rows allows.

    Half the width of each cell is given. The line of a column goes from its first cell to its last.
    """
    x: list[float] = []
    for j in range(max((j for _, j in halves), default=-1) + 1):
        rows = [i for i, column in halves if column == j]
        least = _AROUND + max(halves[i, j] for i in rows)
        taken = dict.fromkeys(range(min(rows), max(rows) + 1), 0.0) | {i: halves[i, j] for i in rows}
        for before, there in enumerate(x):
            others = [i for i, column in halves if column == before]
            for i in range(max(min(rows), min(others)), min(max(rows), max(others)) + 1):
                least = max(least, there + halves.get((i, before), 0.0) + _BETWEEN + taken[i])
        x.append(least)
    return x


def _line(i: int, j: int, x: Sequence[float], y: Sequence[float], sizes: Mapping[_Cell, _Size]) -> str:
    """From the side of block i to the corner in its row, and on to the top or bottom of block j."""
    forward = 1 if j > i else -1
    start, end = x[i] + forward * sizes[i, i][0] / 2, y[j] - forward * sizes[j, j][1] / 2
    head = f"M{x[j] - 4:.1f} {end - forward * 7:.1f}L{x[j]:.1f} {end:.1f}L{x[j] + 4:.1f} {end - forward * 7:.1f}"
    path = f"M{start:.1f} {y[i]:.1f}H{x[j]:.1f}V{end:.1f}{head}"
    return f'<path d="{path}" fill="none" stroke="{_LINE}" stroke-width="1.4"/>'


def _text(box: Box, x: float, y: float, size: _Size, block: bool) -> str:
    back, front = _STYLES["block" if block else "label"]
    width, height = size
    edges = f'x="{x - width / 2:.1f}" y="{y - height / 2:.1f}" width="{width:.1f}" height="{height:.1f}"'
    first = y - height / 2 + _INSIDE + 0.75 * _ROW
    spans = "".join(
        f'<tspan x="{x:.1f}" y="{first + k * _ROW:.1f}"{_BOLD if block and not k else ""}>{escape(line)}</tspan>'
        for k, line in enumerate(box.lines)
    )
    drawn = f'<rect {edges} rx="{4 if block else 2}" fill="{back}"/><text fill="{front}">{spans}</text>'
    return f"<g><title>{escape(box.more)}</title>{drawn}</g>"
