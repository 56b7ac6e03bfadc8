"""What the chapters share: the choices that the text leaves open, and how some of its words are taken."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from adcs.library.choices import PART, Checked, Must, at_least, choice, positive

Vector = tuple[float, ...]
Matrix = tuple[Vector, ...]

CHAPTERS = ("3", "4", "5")  # those with simulations
TRACKED_BY = 60.0  # s, by when the tracking errors are said to have converged
ALMOST_AN_ORDER = (0.8, 1.05)  # of log10 of the ratio
NO_WORSE = 1.25  # the errors of the two controls grow alike if within this factor

ABOVE_1 = Must(lambda factor, _: factor > 1, "a factor above 1")
AFTER_STEADY = Must(lambda stop, c: c.steady_from < stop < inf, "later than steady_from, {steady_from:g} s")
AFTER_REST = Must(lambda stop, c: c.rest_from < stop < inf, "later than rest_from, {rest_from:g} s")
LATE = Must(lambda start, _: start >= TRACKED_BY, f"{TRACKED_BY:g} s or later")
WITHIN_RUN = Must(lambda end, c: TRACKED_BY <= end <= c.stop_time, f"{TRACKED_BY:g} s to stop_time")
SPREAD = Must(lambda spread, _: 0 < spread <= 10, "a factor above 0 and at most 10")
SOME = Must(lambda _, c: bool(c.selected) and {*c.selected} <= {*CHAPTERS}, f"some of {','.join(CHAPTERS)}")


@dataclass(frozen=True)
class Choices(Checked):
    """What the text does not say, or says only in words. All of it is printed in the report."""

    settled: float = choice(0.02, "an error has converged once it stays below this part of its peak", PART)
    marginal: float = choice(2.0, "'only slightly better' means by less than this factor", ABOVE_1)
    stop_time: float = choice(200.0, "end of every run [s]", AFTER_STEADY)
    shown: float = choice(100.0, "end of the noise-free figures [s]", WITHIN_RUN)
    steady_from: float = choice(120.0, "steady state is from here to the end [s]", LATE)
    redraw_period: float = choice(0.1, "the noise is drawn anew after this time [s]", positive("time"))
    seed: int = choice(1, "seed of the first noise sequence; the others count up from it", at_least(0))
    draws: int = choice(4, "number of noise sequences over which steady states are taken", at_least(1))
    starts: int = choice(10, "number of random initial conditions", at_least(1))
    start_rate: float = choice(
        0.1, "random angular velocities are uniform within +- this per axis [rad/s]", positive("rate")
    )
    start_seed: int = choice(2014, "seed of the random initial conditions", at_least(0))
    vector_spread: float = choice(
        1 / 3, "standard deviation of a measured vector over the cone's half-angle, ch. 4", SPREAD
    )
    rest_stop_time: float = choice(400.0, "end of the runs with noise of ch. 4 [s]", AFTER_REST)
    rest_from: float = choice(250.0, "their steady state is from here to the end [s]", LATE)
    rest_rate: float = choice(
        0.02, "random angular velocities of ch. 4 are uniform within +- this per axis [rad/s]", positive("rate")
    )
    estimated: float = choice(0.1, "an estimate of ch. 3 has converged within this part of the true value", PART)
    chapters: str = choice("3,4,5", "the chapters to study, separated by commas", SOME)

    @property
    def selected(self) -> tuple[str, ...]:
        """The chapters to study."""
        return tuple(part.strip() for part in self.chapters.split(",") if part.strip())
