"""What the chapters share: the choices that the text leaves open, and how some of its words are taken."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from adcs.library.choices import Checked, at_least, choice, part, positive

Vector = tuple[float, ...]
Matrix = tuple[Vector, ...]

CHAPTERS = ("3", "4", "5")  # those with simulations
TRACKED_BY = 60.0  # s, by when the tracking errors are said to have converged
ALMOST_AN_ORDER = (0.8, 1.05)  # of log10 of the ratio
NO_WORSE = 1.25  # the errors of the two controls grow alike if within this factor
_LATE, _LATE_ENOUGH = at_least(TRACKED_BY), f"{TRACKED_BY:g} s or later"


@dataclass(frozen=True)
class Choices(Checked):
    """What the text does not say, or says only in words. All of it is printed in the report."""

    settled: float = choice(
        0.02, "an error has converged once it stays below this part of its peak", part, "a part between 0 and 1"
    )
    marginal: float = choice(
        2.0, "'only slightly better' means by less than this factor", lambda x, _: x > 1, "a factor above 1"
    )
    stop_time: float = choice(
        200.0,
        "end of every run [s]",
        lambda stop, c: c.steady_from < stop < inf,
        "later than steady_from, {steady_from:g} s",
    )
    shown: float = choice(
        100.0,
        "end of the noise-free figures [s]",
        lambda shown, c: TRACKED_BY <= shown <= c.stop_time,
        f"{TRACKED_BY:g} s to stop_time",
    )
    steady_from: float = choice(120.0, "steady state is from here to the end [s]", _LATE, _LATE_ENOUGH)
    redraw_period: float = choice(0.1, "the noise is drawn anew after this time [s]", positive, "a positive time")
    seed: int = choice(1, "seed of the first noise sequence; the others count up from it", at_least(0), "0 or more")
    draws: int = choice(4, "number of noise sequences over which steady states are taken", at_least(1), "1 or more")
    starts: int = choice(10, "number of random initial conditions", at_least(1), "1 or more")
    start_rate: float = choice(
        0.1, "random angular velocities are uniform within +- this per axis [rad/s]", positive, "a positive rate"
    )
    start_seed: int = choice(2014, "seed of the random initial conditions", at_least(0), "0 or more")
    vector_spread: float = choice(
        1 / 3,
        "standard deviation of a measured vector over the cone's half-angle, ch. 4",
        lambda spread, _: 0 < spread <= 10,
        "a factor above 0 and at most 10",
    )
    rest_stop_time: float = choice(
        400.0,
        "end of the runs with noise of ch. 4 [s]",
        lambda stop, c: c.rest_from < stop < inf,
        "later than rest_from, {rest_from:g} s",
    )
    rest_from: float = choice(250.0, "their steady state is from here to the end [s]", _LATE, _LATE_ENOUGH)
    rest_rate: float = choice(
        0.02,
        "random angular velocities of ch. 4 are uniform within +- this per axis [rad/s]",
        positive,
        "a positive rate",
    )
    estimated: float = choice(
        0.1, "an estimate of ch. 3 has converged within this part of the true value", part, "a part between 0 and 1"
    )
    chapters: str = choice(
        "3,4,5",
        "the chapters to study, separated by commas",
        lambda _, c: bool(c.selected) and not set(c.selected) - set(CHAPTERS),
        f"some of {','.join(CHAPTERS)}",
    )

    @property
    def selected(self) -> tuple[str, ...]:
        """The chapters to study."""
        return tuple(part.strip() for part in self.chapters.split(",") if part.strip())
