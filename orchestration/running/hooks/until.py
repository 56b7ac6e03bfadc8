"""A condition that ends a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from orchestration import expected
from orchestration.plan.lowering import Floats
from orchestration.running.conditions.condition import Condition
from orchestration.running.hook import Hook, listed
from orchestration.running.outline import Outline


class Until(Hook):
    """The run ends with the first row that meets a condition, as "norm(plant.omega_BN_B) < 1e-3 and time > 20"."""

    _repeatable = True

    def __init__(self, condition: str) -> None:
        expected.text("until", condition)
        self._text = condition

    def for_manifest(self) -> Mapping[str, Any]:
        """Return what the manifest has to know to repeat it."""
        return {"until": self._text}

    @classmethod
    def of_manifest(cls, settings: dict[str, Any]) -> list[Hook]:
        """Take what `for_manifest` gave out of the settings of a manifest."""
        return [cls(text) for text in listed(settings.pop("until", []))]

    def prepare(self, outline: Outline) -> None:
        """Read the condition."""
        self._condition = Condition.parse(self._text, outline.system, outline.recording)

    def met(self, times: Floats, rows: Floats) -> int | None:
        """Return the index of the first row that meets the condition."""
        return self._condition.first(times, rows)

    def __str__(self) -> str:
        return self._text


until = Until
