"""What a study is for those who list and run it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from adcs.library.outcome import Outcome, Progress


@dataclass(frozen=True)
class StudyEntry:
    """A study by name.

    `choices` is the dataclass of what can be chosen; `run` gives the outcome, and label and manifest of each run.
    """

    name: str
    title: str
    summary: str
    choices: type[Any]
    run: Callable[[Any, Progress], tuple[Outcome, list[tuple[str, Mapping[str, Any]]]]]
