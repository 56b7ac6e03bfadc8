"""Values that are set at given times."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from copy import deepcopy
from dataclasses import replace
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from orchestration import expected
from orchestration.running.change import Change
from orchestration.running.hook import MOST, Hook
from orchestration.running.hooks.ranges import outside_range
from orchestration.running.outline import Outline
from orchestration.system import System, Value, checked_value
from orchestration.times import Seconds


class Changes(Hook):
    """Unconnected inputs and tunable parameters get values at times (s) that are communication points."""

    _repeatable = True

    def __init__(self, changes: Sequence[tuple[Seconds, str, Value]]) -> None:
        """`changes` are times, names `component.variable` and values."""
        self._given = [(expected.seconds("at: time", time), n, deepcopy(v)) for time, n, v in changes]

    def for_manifest(self) -> Mapping[str, Any]:
        """Return what the manifest has to know to repeat it."""
        return {"changes": [[time, name, _plain(value)] for time, name, value in self._given]}

    @classmethod
    def of_manifest(cls, settings: dict[str, Any]) -> list[Hook]:
        """Take what `for_manifest` gave out of the settings of a manifest."""
        changes = settings.pop("changes", [])
        return [cls(changes)] if changes else []

    def prepare(self, outline: Outline) -> None:
        """Find the points of the times."""
        changes = [Change.at(outline.grid, *change) for change in self._given]
        for change, (time, name, _) in zip(changes, self._given, strict=True):
            if change.k < outline.first:
                begins = outline.grid.time(outline.first)
                raise AdcsError(f"the change of {name} at {time:g} s lies before the checkpoint, {begins:g} s")
        outline.changes += changes
        _refuse_two_names(outline.system, outline.changes)
        outline.warnings.extend(text for _, text in outside_range(outline.system, self._flat(outline.system)))
        self._pending = sorted(changes, key=lambda change: change.k)

    def _flat(self, system: System) -> Iterator[tuple[float, str, Sequence[Any]]]:
        for time, name, value in self._given:
            end = system.end(name)
            with suppress(AdcsError):  # which is refused when the run begins
                yield time, name, checked_value(name, replace(end.port, shape=end.shape), value)

    def changes(self, k: int) -> Sequence[Change]:
        """Return those of point k."""
        due = [change for change in self._pending if change.k == k]
        del self._pending[: len(due)]
        return due

    def ahead(self, k: int) -> int:
        """Go on to the next one."""
        return self._pending[0].k - k if self._pending else MOST


def at(time: Seconds, values: Mapping[str, Value]) -> Changes:
    """Set unconnected inputs and tunable parameters, by name, at a time [s] that is a communication point."""
    expected.by_name("at: values", values)
    return Changes([(time, name, value) for name, value in values.items()])


def _refuse_two_names(system: System, changes: Sequence[Change]) -> None:
    """Refuse two names of one variable at one point; of two changes by the same name the later one counts."""
    given: dict[Any, str] = {}
    for change in changes:
        places = [(change.k, place) for place in system.places(change.name)]
        for other in (given[place] for place in places if given.get(place, change.name) != change.name):
            raise AdcsError(
                f"the changes of {other} and {change.name} at one time are for two names of one variable: make one of "
                "them"
            )
        given.update(dict.fromkeys(places, change.name))


def _plain(value: Value) -> Any:
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
