"""A run over time: named quantities with symbol and unit, what is measured of them, and how they are drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adcs.library import attitude
from orchestration.results.plots import Guide, Panel, Series, components, told_apart

Array = NDArray[np.float64]

_TINY = 1e-9  # s, against rounding of the time grid


@dataclass(frozen=True)
class Quantity:
    """Something that is looked at in a run, by its name in sentences and its symbol in figures.

    Below `floor` a value is rounding and nothing else: it is not drawn on a logarithmic axis.
    """

    name: str
    symbol: str
    unit: str = ""
    floor: float = 0.0

    def __str__(self) -> str:
        return self.name

    @property
    def title(self) -> str:
        """The name at the beginning of a line."""
        return self.name.capitalize()

    @property
    def in_unit(self) -> str:
        """` [unit]`, to be put behind a name or symbol; empty where there is none."""
        return f" [{self.unit}]" if self.unit else ""

    @property
    def size(self) -> str:
        """The norm of a vector, with its unit."""
        return f"‖{self.symbol}‖{self.in_unit}"


@dataclass(frozen=True)
class Trajectory:
    """Quantities (N,) or (N, n) at the times (N,) [s] of a run; those that the run does not have are not there.

    Measures are of the value of a scalar and of the Euclidean norm of a vector.
    """

    time: Array
    values: Mapping[Quantity, Array]

    def __contains__(self, what: Quantity) -> bool:
        return what in self.values

    def __getitem__(self, what: Quantity) -> Array:
        return self.values[what]

    def norm(self, what: Quantity) -> Array:
        """The scalar, or the norm of the vector, (N,)."""
        values = self.values[what]
        return values if values.ndim == 1 else attitude.norm(values)

    def start(self, what: Quantity) -> float:
        """The first value."""
        return float(self.norm(what)[0])

    def end(self, what: Quantity) -> float:
        """The last value."""
        return float(self.norm(what)[-1])

    def peak(self, what: Quantity) -> float:
        """The largest value; of the tail of a run, what its limit superior is judged by."""
        return float(self.norm(what).max())

    def least(self, what: Quantity) -> float:
        """The smallest value."""
        return float(self.norm(what).min())

    def rms(self, what: Quantity) -> float:
        """Root mean square over time."""
        return attitude.rms(self.norm(what))

    def area(self, what: Quantity) -> float:
        """Integral over time."""
        return float(np.trapezoid(self.norm(what), self.time))

    def settled(self, what: Quantity, part: float, of: float | None = None) -> float:
        """Time from which on it stays below `part` of its peak, or `of` another value [s]; NaN if it does not."""
        return attitude.settling_time(self.time, self.norm(what), part * (self.peak(what) if of is None else of))

    def oscillation(self, what: Quantity) -> float:
        """Total variation: how far the components travel up and down, summed."""
        return float(np.abs(np.diff(self.values[what], axis=0)).sum())

    def speed(self, what: Quantity) -> float:
        """Largest time derivative of a vector, by differences from row to row [unit/s]."""
        return float(attitude.norm(np.diff(self.values[what], axis=0) / np.diff(self.time)[:, None]).max())

    def at(self, what: Quantity, time: float) -> float:
        """The value at `time` [s], or the last one before it."""
        return float(self.norm(what)[int(np.searchsorted(self.time, time + _TINY)) - 1])

    def after(self, start: float) -> Trajectory:
        """The part from `start` [s] on."""
        return self.between(start, inf)

    def until(self, end: float) -> Trajectory:
        """The part up to `end` [s]."""
        return self.between(-inf, end)

    def between(self, start: float, end: float) -> Trajectory:
        """The part from `start` to `end` [s], both included."""
        return self._part((self.time >= start - _TINY) & (self.time <= end + _TINY))

    def every(self, stride: int) -> Trajectory:
        """Each `stride`-th row."""
        return self._part(slice(None, None, stride))

    def _part(self, kept: Any) -> Trajectory:
        return Trajectory(self.time[kept], {what: values[kept] for what, values in self.values.items()})


Runs = Mapping[str, Trajectory]
"""Runs by what they are called in a legend."""


def pooled_rms(runs: Sequence[Trajectory], what: Quantity) -> float:
    """Root mean square over time and over all runs."""
    return attitude.rms(np.concatenate([run.norm(what) for run in runs]))


def having(runs: Runs, what: Quantity) -> Runs:
    """Those that have the quantity."""
    return {label: run for label, run in runs.items() if what in run}


def norm_panel(
    what: Quantity,
    runs: Runs,
    title: str = "",
    group: str = "",
    *,
    log: bool = True,
    guides: Sequence[Guide] = (),
    note: str = "",
    faint: bool = False,
) -> Panel:
    """The scalar or the norm over time, a curve for each run that has it; many of them are drawn thin, `faint`."""
    series = []
    for color, (label, run) in enumerate(runs.items()):
        if what in run:
            values = run.norm(what)
            shown = np.where(values < what.floor, np.nan, values) if log and what.floor else values
            series.append(Series(label, run.time, shown, color=color, faint=faint))
    scalar = all(run[what].ndim == 1 for run in having(runs, what).values())
    label = what.symbol + what.in_unit if scalar else what.size
    return Panel(title or what.title, label, series, log, note, guides=guides, group=group)


def component_panel(what: Quantity, runs: Runs, title: str = "", group: str = "") -> Panel:
    """The components of a vector, all runs that have it in one panel, told apart by the dashes."""
    series = [
        curve
        for label, run, dash in told_apart(having(runs, what))
        for curve in components(label, run.time, run[what], dash)
    ]
    return Panel(title or what.title, what.symbol + what.in_unit, series, group=group)
