"""Runs with random noise or random starts, taken together, and compared sequence by sequence."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from adcs.library.outcome import Claim
from adcs.library.trajectory import Quantity, Trajectory, pooled_rms

Steady = dict[Quantity, float]
"""Root mean square of quantities in steady state."""


def steady(runs: Sequence[Trajectory], start: float) -> Steady:
    """Root mean square, over time from `start` [s] on and over the runs, of each quantity that they have."""
    ends = [run.after(start) for run in runs]
    return {what: pooled_rms(ends, what) for what in ends[0].values}


def spread(first: Iterable[float], second: Iterable[float]) -> str:
    """Say between what the ratio of first to second, a value for each sequence, lies."""
    ratios = [a / b for a, b in zip(first, second, strict=True)]
    return f"{min(ratios):.3g} to {max(ratios):.3g} over {len(ratios)} noise sequences"


def spread_of(what: Quantity, first: Sequence[Trajectory], second: Sequence[Trajectory], start: float) -> str:
    """The same of the steady state of runs with the same noise sequences."""
    pair = ([steady([run], start)[what] for run in runs] for runs in (first, second))
    return spread(*pair)


def residual_set(
    where: str, cell: str, half_angle: float, what: Quantity, runs: Sequence[Trajectory], start: float, part: float
) -> Claim:
    """That from `start` [s] on all runs stay below the `part` of their peak that counts as converged."""
    bounded = sum(stays_small(run, what, start, part) for run in runs)
    worst = max(run.after(start).peak(what) for run in runs)
    settings, ours = f"{len(runs)} random starts, {half_angle:g} deg", f"{bounded} of {len(runs)}"
    note = f"after {start:g} s below {part:g} of the run's own peak; never above {worst:.2g}"
    return Claim(where, cell, settings, "all", ours, bounded == len(runs), note)


def stays_small(run: Trajectory, what: Quantity, start: float, part: float) -> bool:
    """Whether it does in one run."""
    return run.after(start).peak(what) <= part * run.peak(what)
