"""Where a drawing shows the elements of a system: columns along the flow, wires at right angles. Millimetres, y up."""

from __future__ import annotations

from orchestration.ssp.tree import Box, Wire

_WIDTH = 60.0  # of an element
_PITCH = 4.0  # between two connectors of an element
_LANE = 1.5  # between two parallel wires
_SPACE = 8.0  # around lanes
_BETWEEN = 16.0  # two elements of a column


def arrange(system: Box) -> None:
    """Place everything in a system and in those inside it."""
    for box in system.boxes.values():
        if box.component is None:
            arrange(box)
    _place_pins(system)
    columns = _columns(system)
    column_of = {name: c for c, names in enumerate(columns) for name in names}
    lanes = _lanes(system, column_of, len(columns))
    gaps = [2 * _SPACE + _LANE * len(lanes[g]) for g in range(len(columns) + 1)]
    x = 0.0
    for c, names in enumerate(columns):
        x += gaps[c]
        heights = [_height(system.boxes[name]) for name in names]
        y = (sum(heights) + _BETWEEN * (len(names) - 1)) / 2
        for name, height in zip(names, heights, strict=True):
            system.boxes[name].rectangle = (x, _rounded(y - height), x + _WIDTH, _rounded(y))
            y -= height + _BETWEEN
        x += _WIDTH
    width = x + gaps[-1]
    _route(system, lanes, gaps, width)


def _height(box: Box) -> float:
    sides = [sum((pin.kind == "input") == left for pin in box.pins.values()) for left in (True, False)]
    return _PITCH * (max(*sides, 4) + 1)


def _place_pins(system: Box) -> None:
    """Inputs on the left, outputs on the right, from the top, in units of the element's size."""
    for box in system.everything():
        for left in (True, False):
            names = [pin.name for pin in box.pins.values() if (pin.kind == "input") == left]
            height = _height(box)
            for i, name in enumerate(names):
                y = (height + _PITCH * (len(names) - 1)) / 2 - _PITCH * i
                box.places[name] = (0.0 if left else 1.0, _rounded(y / height))


def _columns(system: Box) -> list[list[str]]:
    """The elements by their longest way from an element without inputs; wires that close a loop do not count."""
    names = list(system.boxes)
    after: dict[str, list[str]] = {name: [] for name in names}
    for wire in system.wires:
        start, end = wire.start[0], wire.end[0]
        if start is not None and end is not None and start != end and end not in after[start]:
            after[start].append(end)
    reached = {end for ends in after.values() for end in ends}
    done: dict[str, None] = {}  # in this order
    for name in [*(n for n in names if n not in reached), *names]:
        _visit(name, after, done, set())
    rank = dict.fromkeys(names, 0)
    position = {name: i for i, name in enumerate(reversed(done))}
    for name in reversed(done):
        for end in after[name]:
            if position[end] > position[name]:
                rank[end] = max(rank[end], rank[name] + 1)
    columns: list[list[str]] = [[] for _ in range(max(rank.values(), default=0) + 1)]
    for name in names:
        columns[rank[name]].append(name)
    return columns


def _visit(first: str, after: dict[str, list[str]], done: dict[str, None], open_: set[str]) -> None:
    """Append what can be reached from an element, the farthest first."""
    if first in done:
        return
    stack = [(first, iter(after[first]))]
    open_.add(first)
    while stack:
        name, ends = stack[-1]
        end = next(ends, None)
        if end is None:
            done[name] = None
            stack.pop()
        elif end not in done and end not in open_:
            open_.add(end)
            stack.append((end, iter(after[end])))


def _lanes(system: Box, column_of: dict[str, int], count: int) -> list[list[tuple[int, str]]]:
    """For each gap between columns, which wires (and which end of one) turn in it."""
    lanes: list[list[tuple[int, str]]] = [[] for _ in range(count + 1)]
    for i, wire in enumerate(system.wires):
        c1, c2 = _column(wire, column_of, count)
        lanes[c1 + 1].append((i, "start"))
        if c2 != c1 + 1:
            lanes[c2].append((i, "end"))
    return lanes


def _column(wire: Wire, column_of: dict[str, int], count: int) -> tuple[int, int]:
    start, end = wire.start[0], wire.end[0]
    return (-1 if start is None else column_of[start]), (count if end is None else column_of[end])


def _route(system: Box, lanes: list[list[tuple[int, str]]], gaps: list[float], width: float) -> None:
    """Lead wires between neighbours straight, longer ones above all elements, those that go back below."""
    boxes = system.boxes.values()
    tall = _height(system)
    top = max([box.rectangle[3] for box in boxes] + [tall / 2]) + _SPACE
    bottom = min([box.rectangle[1] for box in boxes] + [-tall / 2]) - _SPACE
    turns: dict[tuple[int, str], float] = {}
    x = 0.0
    for gap, turning in zip(gaps, lanes, strict=True):
        for n, key in enumerate(turning):
            turns[key] = _rounded(x + _SPACE + _LANE * n)
        x += gap + _WIDTH
    up, down = top, bottom
    tracks: dict[int, float] = {}
    for i in range(len(system.wires)):
        if (i, "end") in turns:
            forward = turns[i, "end"] > turns[i, "start"]
            tracks[i] = _rounded(up if forward else down)
            up, down = (up + _LANE, down) if forward else (up, down - _LANE)
    system.canvas = (0.0, _rounded(down - _SPACE), _rounded(width), _rounded(up + _SPACE))
    for i, wire in enumerate(system.wires):
        y1, y2 = _y(system, wire.start), _y(system, wire.end)
        if i in tracks:
            x1, x2 = turns[i, "start"], turns[i, "end"]
            wire.points = ((x1, y1), (x1, tracks[i]), (x2, tracks[i]), (x2, y2))
        elif y1 != y2:
            wire.points = ((turns[i, "start"], y1), (turns[i, "start"], y2))


def _y(system: Box, end: tuple[str | None, str]) -> float:
    element, name = end
    if element is None:
        _, y1, _, y2 = system.canvas
        return _rounded(y1 + (y2 - y1) * system.places[name][1])
    box = system.boxes[element]
    _, y1, _, y2 = box.rectangle
    return _rounded(y1 + (y2 - y1) * box.places[name][1])


def _rounded(value: float) -> float:
    """Four digits are enough for a drawing, and the same on every machine."""
    return round(value, 4) + 0.0
