"""Names that a component's header may be looking for: of C++, of the library of vectors, of this project's headers."""

from __future__ import annotations

import re
from functools import cache

from fmus.paths import SOURCES

TYPES = ("Vec3", "Mat3", "Quat")
MEMBERS = (
    *("dot", "cross", "norm", "squaredNorm", "normalized", "cwiseProduct", "cwiseAbs", "sum", "minCoeff", "maxCoeff"),
    *("transpose", "inverse", "determinant", "trace", "diagonal", "row", "col", "head", "tail", "segment", "block"),
)
_PLAIN = "of a number of type T it would lose the derivatives; {0}(value_of(x)) is for decisions"
WRITTEN = (
    {"fabs": "write abs(x)"}
    | {name: _PLAIN.format(f"std::{name}") for name in ("round", "trunc")}
    | {
        "sign": "write x > 0.0 ? 1.0 : -1.0",
        "self": "variables go by their bare names",
        "pi": "write 3.141592653589793",
    }
)
"""How it is written what is looked for by a name."""

_CPP = """
alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t class compl
const const_cast constexpr continue decltype default delete do double dynamic_cast else enum explicit export
extern false float for friend goto if inline int long mutable namespace new noexcept not not_eq nullptr
operator or or_eq private protected public register reinterpret_cast return short signed sizeof static
static_assert static_cast struct switch template this thread_local throw true try typedef typeid typename
union unsigned using virtual void volatile wchar_t while xor xor_eq
"""
WORDS = frozenset(_CPP.split())
"""Words of C++, which are no names."""


def units() -> tuple[str, ...]:
    """Return the units."""
    return _offered("fmi/units.hpp", r"constexpr Unit (\w+)")


def verbs() -> tuple[str, ...]:
    """Return what variables are declared by: `v.input()` and others."""
    return _offered(
        "fmi/declaration.hpp", r"(?:Refine|void) (time|sampled|event|input|output|parameter|seed|state|held)\("
    )


def refinements() -> tuple[str, ...]:
    """Return what the variable just declared may be given: `.above()` and others."""
    return _offered("fmi/declaration.hpp", r"Refine& (\w+)\(")


@cache
def _offered(file: str, pattern: str) -> tuple[str, ...]:
    """Return what a header of this project's offers."""
    return tuple(dict.fromkeys(re.findall(pattern, (SOURCES / file).read_text(encoding="utf-8"))))
