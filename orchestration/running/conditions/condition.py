"""A condition on recorded variables and time."""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import reduce
from math import isfinite
from typing import Any

import numpy as np

from fmus.errors import AdcsError, shown
from orchestration.plan.lowering import Floats
from orchestration.results.result import Recording
from orchestration.running.conditions.words import (
    EXAMPLE,
    FUNCTIONS,
    Seconds,
    Words,
    looks_like_a_name,
    taken_apart,
    unreadable,
    wrong,
)
from orchestration.system import End, System

Seen = Callable[[Floats, Floats], Any]
"""What a part of a condition is, in every row, or in all of them the same: of times and rows."""

_COMPARISONS = {"<=": operator.le, ">=": operator.ge, "<": operator.lt, ">": operator.gt}
_SIGNS: dict[type, str] = {ast.LtE: "<=", ast.GtE: ">=", ast.Lt: "<", ast.Gt: ">"}
_OPPOSITE = {"<=": ">", ">=": "<", "<": ">=", ">": "<="}
_ARITHMETIC: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_ONE_COMPARISON = re.compile(r"(?P<left>[^<>=]+)(?P<comparison><=|>=|<|>)(?P<bound>[^<>=]+)")
_FUNCTION = re.compile(rf"(?P<function>{'|'.join(FUNCTIONS)})\s*\((?P<inside>.+)\)", re.DOTALL)
_DEEPEST = 50


@dataclass(frozen=True)
class Condition:
    """A condition on recorded variables and time: `norm(controller.omega_BR_B) < 1e-4 and time > 20`."""

    text: str
    holds: Seen

    def __str__(self) -> str:
        return self.text

    @classmethod
    def parse(cls, text: str, system: System, recording: Recording) -> Condition:
        """Read it; AdcsError if it is none, or needs what is not recorded."""
        reader = _Reader(system, recording)
        plain = _one_comparison(text, system)
        if plain is not None:
            function, name, comparison, bound = plain
            end = system.end(name)
            with _of_condition(text):
                left = reader.variable(end, name) if function is None else reader.function(function, end)
            return cls(text, _compared(comparison, left, _constant(bound)))
        with _of_condition(text):
            return cls(text, reader.read(text))

    def first(self, times: Floats, rows: Floats) -> int | None:
        """Index of the first row that meets the condition."""
        with np.errstate(all="ignore"):  # what comes of it is infinite or NaN
            met = np.flatnonzero(np.broadcast_to(self.holds(times, rows), len(rows)))
        return int(met[0]) if len(met) else None


@contextmanager
def _of_condition(text: str) -> Iterator[None]:
    """Refusals within it say of which condition they are."""
    try:
        yield
    except AdcsError as error:
        raise AdcsError(f"condition {shown(repr(text))}: {error}") from None


def _one_comparison(text: str, system: System) -> tuple[str | None, str, str, float] | None:
    """Take `VARIABLE < NUMBER` apart: function, name, comparison and number; None if more than that is meant.

    There the name is all that stands before the sign or in the parentheses, whatever is in it.
    """
    match = _ONE_COMPARISON.fullmatch(text)
    try:
        bound = float(match["bound"]) if match else float("nan")
    except ValueError:
        return None
    if match is None or not isfinite(bound):
        return None
    left = match["left"].strip()
    call = _FUNCTION.fullmatch(left)
    function, name = (call["function"], call["inside"].strip()) if call else (None, left)
    if not looks_like_a_name(name) or name[:1].isdigit():  # `1/plant.y` may be a quotient
        try:
            system.end(name)
        except AdcsError:
            return None
    return function, name, match["comparison"], bound


class _Reader:
    """Makes of the text of a condition what says of each row whether it meets it.

    `not` is carried down to the comparisons, and turns them around: so one with NaN never holds.
    """

    def __init__(self, system: System, recording: Recording) -> None:
        self._system, self._recording = system, recording
        self._words = Words("", "")

    def read(self, text: str) -> Seen:
        words = self._words = taken_apart(text, self._system)
        tree = _parsed(words)
        holds = self._truth(tree, True)
        if not any(isinstance(found, End) for found in words.found.values()) and "time" not in words.code:
            raise AdcsError(f"no variable is in it; {EXAMPLE}")
        return holds

    def variable(self, end: End, name: str) -> Seen:
        """The value of a scalar or of an element."""
        (*others, column) = self._columns(end)
        if others:
            raise AdcsError(f"{shown(name)} is an array, use norm(), max(), min() or one element of it")
        return lambda times, rows: rows[:, column]

    def function(self, name: str, end: End) -> Seen:
        """The norm, the largest or the least element."""
        columns = self._columns(end)
        if name == "norm":
            return lambda times, rows: np.linalg.norm(rows[:, columns], axis=1)
        if name == "max":
            return lambda times, rows: rows[:, columns].max(axis=1)
        return lambda times, rows: rows[:, columns].min(axis=1)

    def _columns(self, end: End) -> list[int]:
        """Where in a row the elements are."""
        whole = f"{end.component}.{end.port.name}"
        among = self._system.among(self._recording.ports, whole)
        if among is None:
            raise AdcsError(f"{whole} is not recorded, and has to be")
        if not end.elements:
            raise AdcsError(f"{whole} has no elements")
        first = 0
        for recorded, port in self._recording.ports.items():
            if recorded == among:
                break
            first += port.size
        return [first + i for i in end.elements]

    def _truth(self, node: ast.expr, wanted: bool) -> Seen:
        """Whether it is true, or false, if that is wanted."""
        match node:
            case ast.BoolOp():
                return _joined(
                    [self._truth(part, wanted) for part in node.values], isinstance(node.op, ast.And), wanted
                )
            case ast.UnaryOp(op=ast.Not()):
                return self._truth(node.operand, not wanted)
            case ast.Compare() if all(type(op) in _SIGNS for op in node.ops):
                self._times_apart(node)
                signs = [_SIGNS[type(op)] for op in node.ops]
                numbers = [self._number(part) for part in (node.left, *node.comparators)]
                parts = [
                    _compared(sign if wanted else _OPPOSITE[sign], left, right)
                    for sign, left, right in zip(signs, numbers, numbers[1:], strict=False)
                ]
                return _joined(parts, True, wanted)
        raise self._wrong(node, "is no comparison")

    def _number(self, node: ast.expr) -> Seen:
        match node:
            case ast.Name(id="time"):
                return lambda times, rows: times
            case ast.Name() if (found := self._found(node)) is not None:
                return self.variable(found, self._slice(node)) if isinstance(found, End) else _constant(found)
            case ast.UnaryOp(op=ast.USub()):
                return _applied(operator.neg, self._number(node.operand))
            case ast.UnaryOp(op=ast.UAdd()):
                return self._number(node.operand)
            case ast.BinOp() if type(node.op) in _ARITHMETIC:
                return _applied(_ARITHMETIC[type(node.op)], self._number(node.left), self._number(node.right))
            case ast.Call(func=ast.Name(id="abs"), args=[argument]):
                return _applied(np.abs, self._number(argument))
            case ast.Call(func=ast.Name(id=name)) if name in FUNCTIONS:
                end = self._found(node.args[0]) if len(node.args) == 1 else None
                if not isinstance(end, End):
                    raise self._wrong(node, f"is no number, {name}() takes one recorded variable")
                return self.function(name, end)
        raise self._wrong(node, "is no number")

    def _found(self, node: ast.expr) -> End | float | None:
        return self._words.found.get(node.col_offset) if isinstance(node, ast.Name) else None

    def _slice(self, node: ast.expr) -> str:
        return self._words.text[node.col_offset : node.end_col_offset]

    def _wrong(self, node: ast.expr, why: str) -> AdcsError:
        return wrong(self._slice(node), node.col_offset, why)

    def _times_apart(self, node: ast.Compare) -> None:
        """Refuse a time beside anything but `time`."""
        names = [part for part in ast.walk(node) if isinstance(part, ast.Name)]
        for part in names:
            if isinstance(self._found(part), Seconds) and all(name.id != "time" for name in names):
                raise self._wrong(part, "is a time, and is compared with no `time`")


def _parsed(words: Words) -> ast.expr:
    """Return the tree of a condition; its places are those in the text."""
    too_deep = AdcsError(f"it is nested deeper than {_DEEPEST} levels")
    try:
        tree = ast.parse(words.code, mode="eval").body
    except SyntaxError as error:
        if error.offset and error.offset <= len(words.text):
            raise unreadable(words.text, error.offset - 1) from None
        raise AdcsError(f"it ends too early; {EXAMPLE}") from None
    except (RecursionError, MemoryError):
        raise too_deep from None
    level: list[ast.AST] = [tree]
    for _ in range(_DEEPEST):
        level = [child for node in level for child in ast.iter_child_nodes(node)]
    if level:
        raise too_deep
    return tree


def _constant(value: float) -> Seen:
    number = np.float64(value)  # which can be divided by zero
    return lambda times, rows: number


def _applied(function: Callable[..., Any], *parts: Seen) -> Seen:
    return lambda times, rows: function(*(part(times, rows) for part in parts))


def _compared(sign: str, left: Seen, right: Seen) -> Seen:
    return _applied(_COMPARISONS[sign], left, right)


def _joined(parts: Sequence[Seen], by_and: bool, wanted: bool) -> Seen:
    """Whether all of them hold, or any; what is not wanted was turned around already, and so is this."""
    join = np.logical_and if by_and == wanted else np.logical_or
    return lambda times, rows: reduce(join, [part(times, rows) for part in parts])
