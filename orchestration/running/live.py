"""What may happen during a co-simulation: changes at times, inputs from a table, a condition that ends it, pace."""

from __future__ import annotations

import operator
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from time import perf_counter, sleep
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fmus.errors import AdcsError, shown
from orchestration.fmu.number_types import BEYOND, EXACT, first_beyond, first_misfit
from orchestration.grid import Grid
from orchestration.plan.lowering import Floats
from orchestration.results.result import Recording
from orchestration.running.tables import read_table, whole_column
from orchestration.system import System, Value

if TYPE_CHECKING:
    from orchestration.running.session import Session


@dataclass(frozen=True)
class Change:
    """A variable gets a value at point k, and the row of that point is one with it."""

    k: int
    name: str
    value: Value

    @classmethod
    def at(cls, grid: Grid, time: float, name: str, value: Value) -> Change:
        """Find the communication point of a time [s]; refuse one between two points."""
        return cls(grid.index(time, f"the change of {name}"), name, value)

    def check(self, simulation: Session) -> None:
        """Refuse what could not be set when its time comes."""
        simulation.check_change(self.name, self.value)

    def may_follow(self, simulation: Session) -> bool:
        """Whether the row of its point is the same without it: then it is set after that, as FMI wants it."""
        return not simulation.shows(self.name)

    def apply(self, simulation: Session) -> None:
        """Set it now."""
        simulation.set(self.name, self.value)


def refuse_two_names(system: System, changes: Sequence[Change]) -> None:
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


class Inputs:
    """Inputs whose values come from a table over time, for `names`.

    Between two times values of Float type are interpolated linearly, all others hold; before the first and after the
    last time they keep the values there.
    """

    def __init__(self, system: System, times: Floats, columns: dict[str, Floats]) -> None:
        """`times` (n,) in s, increasing; `columns` give (n,) or (n, size) by `component.variable` or an element."""
        times = np.asarray(times, float)
        if len(times) == 0 or not np.isfinite(times).all() or (np.diff(times) <= 0).any():
            raise AdcsError("inputs: times must be finite and increasing, and there must be at least one")
        self.names = list(columns)
        self._times = times
        self._continuous: list[bool] = []
        parts = []
        for name, values in columns.items():
            end = system.end(name)
            part = np.asarray(values).reshape(len(times), -1)
            if part.shape[1] != len(end.elements):
                raise AdcsError(f"inputs: {name} has {len(end.elements)} elements, the table has {part.shape[1]}")
            _check(name, end.port.type, times, part)
            parts.append(part.astype(float))
            self._continuous += [end.port.type.startswith("Float")] * part.shape[1]
        self._parts = parts
        self._values = np.hstack(parts) if parts else np.empty((len(times), 0))

    @classmethod
    def from_csv(cls, system: System, path: Path) -> Inputs:
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
            name, unit = _known(system, text)
            if name in columns:
                raise AdcsError(f"{path}: {name} has two columns")
            port = system.port(name)[1]
            if unit not in (None, "-", port.unit):
                raise AdcsError(f"{path}: {name} is in {unit!r}, expected {port.unit!r}")
            columns[name] = table[:, column]
            if (
                port.type in ("Int64", "UInt64") and (np.abs(columns[name]) >= EXACT).any()
            ):  # which may have been rounded
                columns[name] = whole_column(path, column)
        return cls(system, table[:, 0], columns)

    def rows(self) -> Iterator[tuple[float, str, Floats]]:
        """Yield all that is in the table: time [s], name and values."""
        for name, part in zip(self.names, self._parts, strict=True):
            for time, values in zip(self._times.tolist(), part, strict=True):
                yield time, name, values

    def at(self, times: Floats) -> Floats:
        """Return the values at these times, (n, number of values)."""
        held = np.clip(np.searchsorted(self._times, times, side="right") - 1, 0, None)
        values: Floats = self._values[held].copy()
        for column in np.flatnonzero(self._continuous):
            values[:, column] = np.interp(times, self._times, self._values[:, column])
        return values


def _check(name: str, type_: str, times: Floats, values: NDArray[Any]) -> None:
    """Refuse by name, value and time what the input's type does not hold, or what a double could not hand on."""
    misfit = first_misfit(type_, values)
    if misfit is None and values.dtype.kind != "f" and not type_.startswith("Float"):
        beyond = first_beyond(values.ravel().tolist())
        misfit = None if beyond is None else (beyond, BEYOND)
    if misfit is not None:
        index, why = misfit
        value, row = values.ravel().tolist()[index], index // values.shape[1]
        raise AdcsError(f"inputs: {name} = {value!r} at {times[row]:g} s{why}")


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


_NAP = 60.0  # s; longer ones are more than some systems sleep
_MOST_KEPT = 200_000  # of how late points were

_COMPARISONS = {"<=": operator.le, ">=": operator.ge, "<": operator.lt, ">": operator.gt}
_CONDITION = re.compile(r"(?P<left>[^<>=]+)(?P<comparison><=|>=|<|>)(?P<bound>[^<>=]+)")
_FUNCTION = re.compile(r"(?P<function>norm|max|min)\s*\((?P<inside>.+)\)", re.DOTALL)


@dataclass(frozen=True)
class Condition:
    """A condition on one recorded variable that ends a run: `norm(controller.omega_BR_B) < 1e-4`."""

    text: str
    function: str | None
    where: tuple[int, ...]
    comparison: str
    bound: float

    def __str__(self) -> str:
        return self.text

    @classmethod
    def parse(cls, text: str, system: System, recording: Recording) -> Condition:
        """Read `VARIABLE < NUMBER` (or <=, >, >=), the variable possibly within norm(), max() or min()."""
        match = _CONDITION.fullmatch(text)
        try:
            bound = float(match["bound"]) if match else float("nan")
        except ValueError:
            bound = float("nan")
        if match is None or not isfinite(bound):
            raise AdcsError(
                f"condition {shown(repr(text))}: expected VARIABLE < NUMBER, or norm(VARIABLE), max(), min(); <=, >, >="
            )
        left = match["left"].strip()
        call = _FUNCTION.fullmatch(left)
        function, name = (call["function"], call["inside"].strip()) if call else (None, left)
        end = system.end(name)
        whole = f"{end.component}.{end.port.name}"
        among = system.among(recording.ports, whole)
        if among is None:
            raise AdcsError(f"condition {shown(repr(text))}: {whole} is not recorded, and has to be")
        if function is None and len(end.elements) > 1:
            raise AdcsError(
                f"condition {shown(repr(text))}: {shown(name)} is an array, use norm(), max(), min() or one "
                "element of it"
            )
        first = 0
        for recorded, port in recording.ports.items():
            if recorded == among:
                break
            first += port.size
        where = tuple(first + i for i in end.elements)
        return cls(text, function, where, match["comparison"], bound)

    def first(self, rows: Floats) -> int | None:
        """Index of the first row that meets the condition."""
        values = rows[:, list(self.where)]
        if self.function == "norm":
            value = np.linalg.norm(values, axis=1)
        else:
            value = values.min(axis=1) if self.function == "min" else values.max(axis=1)
        met = np.flatnonzero(_COMPARISONS[self.comparison](value, self.bound))
        return int(met[0]) if len(met) else None


class Pace:
    """Keeps a run to real time, or `speed` times as fast: point k is not taken before its time.

    Deadlines are absolute, so lateness does not add up; what is late is counted.
    """

    def __init__(self, grid: Grid, speed: float = 1.0) -> None:
        if not (isfinite(speed) and speed > 0):
            raise AdcsError(f"speed = {speed}: expected a positive number, 1 for real time")
        self.speed = speed
        self._step = grid.step / speed
        if not isfinite(self._step):
            raise AdcsError(f"speed = {speed}: a step of {grid.step:g} s would last for ever")
        self._late: list[float] = []
        self._points, self._most, self._every = 0, 0.0, 1

    def start(self, k: int) -> None:
        """Let point k be now."""
        self._origin = perf_counter() - k * self._step

    def wait(self, k: int) -> int:
        """Wait for point k; return how many points are due."""
        deadline = self._origin + k * self._step
        while (early := deadline - perf_counter()) > 0:
            sleep(min(early, _NAP) if early > 2e-3 else 0)  # sleeping longer than asked is what makes late
        self._points, self._most = self._points + 1, max(self._most, -early)
        if self._points % self._every == 0:
            self._late.append(-early)
            if len(self._late) == _MOST_KEPT:  # of a long run every second one is kept, then every fourth ...
                self._late, self._every = self._late[1::2], 2 * self._every
        return 1

    def report(self) -> dict[str, Any]:
        """Speed and how late points were taken [s]."""
        late = np.array(self._late or [0.0])
        p50, p99 = np.percentile(late, [50, 99])
        return {
            "speed": self.speed,
            "points": self._points,
            "late_median_s": float(p50),
            "late_99_percent_s": float(p99),
            "late_most_s": self._most,
        }
