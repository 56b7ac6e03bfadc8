"""Inputs whose values come from a table over time."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.errors import AdcsError
from orchestration import expected
from orchestration.fmu.number_types import BEYOND, EXACT, first_beyond, first_misfit
from orchestration.plan.lowering import Floats
from orchestration.plan.outside import Lines, Straight
from orchestration.running.hook import Hook, listed
from orchestration.running.hooks.ranges import outside_range
from orchestration.running.hooks.tables import read_table, whole_column
from orchestration.running.outline import Outline
from orchestration.system import System


class Table(Straight):
    """Inputs whose values come from a table over time, for `names`.

    Between two times values of Float type are interpolated linearly, all others hold; before the first and after the
    last time they keep the values there.
    """

    def __init__(self, system: System, times: Floats, columns: dict[str, Floats], source: str = "inputs") -> None:
        """`times` (n,) in s, increasing; `columns` give (n,) or (n, size) by `component.variable` or an element.

        `source` is where they come from, for errors.
        """
        times = np.ascontiguousarray(times, float)
        if len(times) == 0 or not np.isfinite(times).all() or (np.diff(times) <= 0).any():
            raise AdcsError(f"{source}: times must be finite and increasing, and there must be at least one")
        self.names = list(columns)
        self._times = times
        self._continuous: list[bool] = []
        parts = []
        for name, values in columns.items():
            end = system.end(name)
            part = np.asarray(values).reshape(len(times), -1)
            if part.shape[1] != len(end.elements):
                raise AdcsError(
                    f"{source}: {name} has {len(end.elements)} elements, the table has {part.shape[1]}: give each a "
                    f"column, {name}[{','.join('1' * len(end.shape))}] and so on"
                )
            _check(source, name, end.port.type, times, part)
            parts.append(part.astype(float))
            self._continuous += [end.port.type.startswith("Float")] * part.shape[1]
        self._parts = parts
        self._values = np.hstack(parts) if parts else np.empty((len(times), 0))
        slopes = np.zeros_like(self._values)
        with np.errstate(over="ignore", invalid="ignore"):  # what comes of it is refused where it is set
            slopes[:-1] = np.where(self._continuous, np.diff(self._values, axis=0) / np.diff(times)[:, None], 0.0)
        self.lines = (Lines(times, self._values, slopes),)

    @classmethod
    def from_csv(cls, system: System, path: Path) -> Table:
        """Read a table whose header is `time` and the names of inputs, elements of arrays one by one.

        `[unit]` after a name, as in the files that a run writes, must be the input's own unit.
        """
        header, table = read_table(path, header=True)
        if not header or _name(header[0])[0].strip() != "time":
            raise AdcsError(f"{path}: the first line must be `time` and the names of inputs")
        if _name(header[0])[1] not in (None, "s"):
            raise AdcsError(f"{path}: time is in {_name(header[0])[1]!r}, expected 's'")
        columns: dict[str, Floats] = {}
        for column, text in enumerate(header[1:], 1):
            try:
                name, unit = _known(system, text)
            except AdcsError as error:
                raise AdcsError(f"{path}: {error}") from None
            if name in columns:
                raise AdcsError(f"{path}: {name} has two columns")
            port = system.port(name)[1]
            if unit not in (None, "-", port.unit):
                raise AdcsError(f"{path}: {name} is in {unit!r}, expected {port.unit!r}")
            columns[name] = table[:, column]
            whole = port.type in ("Int64", "UInt64")
            if whole and (np.abs(columns[name]) >= EXACT).any():  # which may have been rounded
                columns[name] = whole_column(path, column)
        return cls(system, table[:, 0], columns, str(path))

    def rows(self) -> Iterator[tuple[float, str, list[Any]]]:
        """Yield all that is in the table: time [s], name and values."""
        for name, part in zip(self.names, self._parts, strict=True):
            for time, values in zip(self._times.tolist(), part.tolist(), strict=True):
                yield time, name, values

    def jump(self, after: float) -> float:
        """Return the next time (s) at which a value jumps or bends; inf if there is none."""
        k = int(np.searchsorted(self._times, after, side="right"))
        return float(self._times[k]) if k < len(self._times) else inf

    def at(self, times: Floats) -> Floats:
        """Return the values at these times, (n, number of values)."""
        held = np.clip(np.searchsorted(self._times, times, side="right") - 1, 0, None)
        values: Floats = self._values[held].copy()
        for column in np.flatnonzero(self._continuous):
            values[:, column] = np.interp(times, self._times, self._values[:, column])
        return values


def _check(source: str, name: str, type_: str, times: Floats, values: NDArray[Any]) -> None:
    """Refuse by name, value and time what the input's type does not hold, or what a double could not hand on."""
    misfit = first_misfit(type_, values)
    if misfit is None and values.dtype.kind != "f" and not type_.startswith("Float"):
        beyond = first_beyond(values.ravel().tolist())
        misfit = None if beyond is None else (beyond, BEYOND)
    if misfit is not None:
        index, why = misfit
        value, row = values.ravel().tolist()[index], index // values.shape[1]
        raise AdcsError(f"{source}: {name} = {value!r} at {times[row]:g} s{why}")


_HEADER = re.compile(r"(?P<name>.*?)(?:\[(?P<unit>[^\[\]]*)\])?", re.DOTALL)


def _name(text: str) -> tuple[str, str | None]:
    match = _HEADER.fullmatch(text.strip())
    assert match is not None
    return match["name"], match["unit"]


def _known(system: System, text: str) -> tuple[str, str | None]:
    """Tell `plant.u[2]`, an element, from `plant.u[N.m]`, a unit."""
    try:
        system.end(text.strip())
        return text.strip(), None
    except AdcsError:
        name, unit = _name(text)
        port = system.port(name)[1]
        if unit != port.unit and re.fullmatch(r"[\d,\s]+", unit or ""):  # an element that there is not
            raise
        return name, unit


class Inputs(Hook):
    """Unconnected inputs follow a CSV table: columns `time` [s] and `component.variable`."""

    _repeatable = True

    def __init__(self, path: str | Path) -> None:
        expected.path("inputs", path)
        self._path = Path(path)

    def for_manifest(self) -> Mapping[str, Any]:
        """Return what the manifest has to know to repeat it."""
        return {"inputs": str(self._path)}

    @classmethod
    def of_manifest(cls, settings: dict[str, Any]) -> list[Hook]:
        """Take what `for_manifest` gave out of the settings of a manifest."""
        return [cls(path) for path in listed(settings.pop("inputs", []))]

    def prepare(self, outline: Outline) -> None:
        """Read the table."""
        table = Table.from_csv(outline.system, self._path)
        outline.sources.append(table)
        outline.reads("inputs", self._path)
        first: dict[Any, str] = {}
        for element, text in outside_range(outline.system, table.rows()):
            first.setdefault(element, text)  # of each element once
        outline.warnings.extend(first.values())


inputs = Inputs
