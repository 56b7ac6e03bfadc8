"""Functions that each platform's C library rounds in its own way: laws that call them give other results elsewhere."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache

from fmus.code import without_comments
from fmus.paths import SOURCES

FUNCTIONS = frozenset(
    (
        *("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sincos"),
        *("sinh", "cosh", "tanh", "asinh", "acosh", "atanh"),
        *("exp", "exp2", "exp10", "expm1", "log", "log2", "log10", "log1p", "pow", "cbrt", "hypot", "fma"),
        *("erf", "erfc", "tgamma", "lgamma"),
    )
)
"""Those that IEEE 754 does not round exactly, or that compilers may fuse. sqrt, abs, floor and ceil are exact."""

_ARGUMENTS = {
    **dict.fromkeys(("pow", "hypot", "fmod", "min", "max", "copysign"), "x, y"),
    "atan2": "y, x",
    "clamp": "x, low, high",
    "select": "condition, a, b",
}
"""Of those that take another number of them than one."""

_CALL = re.compile(
    rf"\b(std::(?:{'|'.join(sorted(FUNCTIONS))}))\b|(?<![\w:])(::(?:{'|'.join(sorted(FUNCTIONS))}))\s*\("
)


def called_in(code: str) -> Iterator[tuple[int, str]]:
    """Yield the lines of C++ code that call one by its full name, and that name."""
    for number, line in enumerate(without_comments(code).splitlines(), 1):
        for found in _CALL.finditer(line):
            yield number, found[1] or found[2]


def bare(function: str) -> str:
    """Return the name without where it is: `sin` of `std::sin`."""
    return function.rpartition("::")[2]


def advice(function: str) -> str:
    """Say what is wrong with calling one, and the way out."""
    name = bare(function)
    way = f"write {usage(name)}" if name in offered() else f"express it by {', '.join(offered())}"
    return f"{function}, which rounds differently on each platform ({way})"


def usage(name: str) -> str:
    """Show how a law calls one of `offered()`."""
    return f"{name}({_ARGUMENTS.get(name, 'x')})"


@cache
def offered() -> tuple[str, ...]:
    """Return the functions of this project's that round alike everywhere."""
    text = (SOURCES / "math" / "functions.hpp").read_text(encoding="utf-8")
    return tuple(re.findall(r"using math::([a-z]\w*);", text))
