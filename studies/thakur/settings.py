"""The numbers of Sec. 5.4, once, and the choices that the text leaves open."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, pi, sqrt
from typing import Any

from fmus.errors import AdcsError

REFERENCE = "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Sec. 5.4"

Vector = tuple[float, ...]
Matrix = tuple[Vector, ...]

INERTIA = ((10.0, 1.2, 0.5), (1.2, 19.0, 1.5), (0.5, 1.5, 25.0))  # kg.m2, Eq. (5.62)
INERTIA_ERRORS: tuple[Matrix, Matrix] = (  # kg.m2, delta J_1 and delta J_2 of Eq. (5.63)
    ((1.0, 1.0, 1.5), (1.0, 1.0, 1.5), (1.5, 1.5, -1.0)),
    ((-1.0, -0.4, 0.6), (-0.4, -2.0, -0.7), (0.6, -0.7, -5.0)),
)
GUIDANCE: dict[str, Any] = {
    "amplitude": 0.1,
    "frequency": 1.0,
    "decay": 0.01,
    "ramp": 0.08 * pi,
    "wobble": 0.006,
    "axis": (1.0, 1.0, 1.0),
    "q_RN_0": (sqrt(1 - 3 * 0.1826**2), 0.1826, 0.1826, 0.1826),
}
PD_GAINS = {"k_p": 1.5, "k_v": 5.0}
OBSERVER_GAINS = {"lambda": 1.0, "gamma": 3.0}
CHAPTERS = ("3", "4", "5")  # those with simulations
TRACKED_BY, ESTIMATED_BY = 60.0, 50.0  # s, by when the errors are said to have converged


@dataclass(frozen=True)
class Start:
    """Where plant and observer start; the observer's attitude starts at the true one."""

    q_BN: Vector = (sqrt(1 - 3 * 0.1**2), -0.1, 0.1, -0.1)
    omega_BN_B: Vector = (0.005, 0.006, 0.004)  # rad/s
    omega_EN_E: Vector = (-0.03, 0.01, -0.02)  # rad/s


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
