"""What messages have in common: names that were perhaps meant, and sizes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from fmus import spelling


def hint(name: str, known: Iterable[str]) -> str:
    """` (did you mean x?)`, or what there is."""
    return f" ({spelling.hint(name, known, 'there is')})"


def sizes(shape: Iterable[Any]) -> str:
    """`(4, 4)` -> `4 x 4`; one that is left open is a question mark."""
    return " x ".join("?" if n is None else str(n) for n in shape) or "a scalar"


def has(shape: Iterable[Any]) -> str:
    """`(4, 4)` -> `has 4 x 4`, `()` -> `is a scalar`."""
    shape = tuple(shape)
    return f"has {sizes(shape)}" if shape else "is a scalar"
