"""What can be chosen in a study: a number with what it means, and what it must be for the study to make sense."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from math import inf
from typing import Any

from fmus.errors import AdcsError

Condition = Callable[[Any, Any], bool]
"""Called with the value and with all choices."""


def choice(default: Any, meaning: str, holds: Condition | None = None, expected: str = "") -> Any:
    """A field of `Checked`; `expected` says in words what `holds` asks for, with other choices in braces."""
    return field(default=default, metadata={"help": meaning, "holds": holds, "expected": expected})


@dataclass(frozen=True)
class Checked:
    """Choices that refuse, in one line, what makes no sense."""

    def __post_init__(self) -> None:
        for f in fields(self):
            value, holds = getattr(self, f.name), f.metadata["holds"]
            if holds and not holds(value, self):
                expected = f.metadata["expected"].format(**vars(self))
                given = f"{value:g}" if isinstance(value, (int, float)) else repr(value)
                raise AdcsError(f"choice {f.name} = {given}: expected {expected}")


def positive(value: float, _: Any) -> bool:
    """Above 0, and finite."""
    return 0 < value < inf


def part(value: float, _: Any) -> bool:
    """Between 0 and 1."""
    return 0 < value < 1


def at_least(least: float) -> Condition:
    """That much or more."""
    return lambda value, _: value >= least
