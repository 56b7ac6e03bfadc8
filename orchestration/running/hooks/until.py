"""A condition that ends a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from orchestration.plan.lowering import Floats
from orchestration.running.conditions.condition import Condition
from orchestration.running.hook import Hook, Outline


class Until(Hook):
    """The run ends with the first row that meets a condition."""

    ends = True

    def __init__(self, text: str) -> None:
        self._text = text

    def for_manifest(self) -> Mapping[str, Any]:
        """Return what the manifest has to know to repeat it."""
        return {"until": self._text}

    def prepare(self, outline: Outline) -> None:
        """Read the condition."""
        self._condition = Condition.parse(self._text, outline.system, outline.recording)

    def met(self, times: Floats, rows: Floats) -> int | None:
        """Return the index of the first row that meets the condition."""
        return self._condition.first(times, rows)

    def __str__(self) -> str:
        return self._text
