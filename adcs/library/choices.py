"""What can be chosen in a study: a number with what it means, and what it must be for the study to make sense."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from math import inf
from typing import Any, NamedTuple

from fmus.errors import AdcsError


class Must(NamedTuple):
    """What is asked of a value: `holds` is called with it and with all choices; in `words` these stand in braces."""

    holds: Callable[[Any, Any], bool]
    words: str


ANYTHING = Must(lambda value, choices: True, "")
PART = Must(lambda value, _: 0 < value < 1, "a part between 0 and 1")


def positive(what: str) -> Must:
    """Above 0, and finite."""
    return Must(lambda value, _: 0 < value < inf, f"a positive {what}")


def at_least(least: int) -> Must:
    """That many or more, and finite."""
    return Must(lambda value, _: least <= value < inf, f"{least} or more")


def choice(default: Any, meaning: str, must: Must = ANYTHING) -> Any:
    """A field of `Checked`."""
    return field(default=default, metadata={"help": meaning, "must": must})


@dataclass(frozen=True)
class Checked:
    """Choices that refuse, in one line, what makes no sense."""

    def __post_init__(self) -> None:
        for f in fields(self):
            value, must = getattr(self, f.name), f.metadata["must"]
            if not must.holds(value, self):
                given = f"{value:g}" if isinstance(value, (int, float)) else repr(value)
                raise AdcsError(f"choice {f.name} = {given}: expected {must.words.format(**vars(self))}")
