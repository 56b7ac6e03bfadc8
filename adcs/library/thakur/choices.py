"""What the chapters share: the choices that the text leaves open, and how some of its words are taken."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf

from fmus.errors import AdcsError

Vector = tuple[float, ...]
Matrix = tuple[Vector, ...]

CHAPTERS = ("3", "4", "5")  # those with simulations
TRACKED_BY = 60.0  # s, by when the tracking errors are said to have converged
ALMOST_AN_ORDER = (0.8, 1.05)  # of log10 of the ratio
NO_WORSE = 1.25  # the errors of the two controls grow alike if within this factor


@dataclass(frozen=True)
class Choices:
    """What the text does not say, or says only in words. All of it is printed in the report."""

    settled: float = field(
        default=0.02, metadata={"help": "an error has converged once it stays below this part of its peak"}
    )
    marginal: float = field(default=2.0, metadata={"help": "'only slightly better' means by less than this factor"})
    stop_time: float = field(default=200.0, metadata={"help": "end of every run [s]"})
    shown: float = field(default=100.0, metadata={"help": "end of the noise-free figures [s]"})
    steady_from: float = field(default=120.0, metadata={"help": "steady state is from here to the end [s]"})
    redraw_period: float = field(default=0.1, metadata={"help": "the noise is drawn anew after this time [s]"})
    seed: int = field(default=1, metadata={"help": "seed of the first noise sequence; the others count up from it"})
    draws: int = field(default=4, metadata={"help": "number of noise sequences over which steady states are taken"})
    starts: int = field(default=10, metadata={"help": "number of random initial conditions"})
    start_rate: float = field(
        default=0.1, metadata={"help": "random angular velocities are uniform within +- this per axis [rad/s]"}
    )
    start_seed: int = field(default=2014, metadata={"help": "seed of the random initial conditions"})
    vector_spread: float = field(
        default=1 / 3, metadata={"help": "standard deviation of a measured vector over the cone's half-angle, ch. 4"}
    )
    rest_stop_time: float = field(default=400.0, metadata={"help": "end of the runs with noise of ch. 4 [s]"})
    rest_from: float = field(default=250.0, metadata={"help": "their steady state is from here to the end [s]"})
    rest_rate: float = field(
        default=0.02,
        metadata={"help": "random angular velocities of ch. 4 are uniform within +- this per axis [rad/s]"},
    )
    estimated: float = field(
        default=0.1, metadata={"help": "an estimate of ch. 3 has converged within this part of the true value"}
    )
    chapters: str = field(default="3,4,5", metadata={"help": "the chapters to study, separated by commas"})

    def __post_init__(self) -> None:
        """Refuse choices with which the statements of the text cannot be judged."""
        for name, holds, expected in (
            ("settled", 0 < self.settled < 1, "a part between 0 and 1"),
            ("marginal", self.marginal > 1, "a factor above 1"),
            ("steady_from", self.steady_from >= TRACKED_BY, f"{TRACKED_BY:g} s or later"),
            ("stop_time", self.steady_from < self.stop_time < inf, f"later than steady_from, {self.steady_from:g} s"),
            ("shown", TRACKED_BY <= self.shown <= self.stop_time, f"{TRACKED_BY:g} s to stop_time"),
            ("redraw_period", 0 < self.redraw_period < inf, "a positive time"),
            ("seed", self.seed >= 0, "0 or more"),
            ("draws", self.draws >= 1, "1 or more"),
            ("starts", self.starts >= 1, "1 or more"),
            ("start_rate", 0 < self.start_rate < inf, "a positive rate"),
            ("start_seed", self.start_seed >= 0, "0 or more"),
            ("vector_spread", 0 < self.vector_spread <= 10, "a factor above 0 and at most 10"),
            ("rest_from", self.rest_from >= TRACKED_BY, f"{TRACKED_BY:g} s or later"),
            (
                "rest_stop_time",
                self.rest_from < self.rest_stop_time < inf,
                f"later than rest_from, {self.rest_from:g} s",
            ),
            ("rest_rate", 0 < self.rest_rate < inf, "a positive rate"),
            ("estimated", 0 < self.estimated < 1, "a part between 0 and 1"),
        ):
            if not holds:
                raise AdcsError(f"choice {name} = {getattr(self, name):g}: expected {expected}")
        if not self.selected or set(self.selected) - set(CHAPTERS):
            raise AdcsError(f"choice chapters = {self.chapters!r}: expected some of {','.join(CHAPTERS)}")

    @property
    def selected(self) -> tuple[str, ...]:
        """The chapters to study."""
        return tuple(part.strip() for part in self.chapters.split(",") if part.strip())
