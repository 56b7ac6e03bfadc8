"""The guarantee of de Ruiter's law computed before any run: dead zone, bounds on the errors, and what they presuppose.

    from adcs.library.deruiter.design import EstimationBounds, Guarantee, Law, Task

    guarantee = Guarantee(Law(inertia=...), Task(...), EstimationBounds(...))
    guarantee.require()                 # one line that names each condition that fails
    guarantee.q_limit, guarantee.rate_limit

Equation numbers are those of the paper. In its Eqs. (36) and (40)-(48) the bounds with a subscript omega inside
brackets belong to the filtered rate error; a tilde is lost in print, without which (40) would define v_omega by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import inf, isfinite, sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fmus.errors import AdcsError

Array = NDArray[np.float64]

_ITEMS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
WORST = sqrt(5 / 3)
"""Largest norm of a symmetric 3 x 3 matrix whose six elements have norm 1: 1 on and 2 off the diagonal, scaled."""


def parameters(inertia: ArrayLike) -> tuple[Array, Array]:
    """`theta` (18,) [-] and `theta_p` (6,) [1/(kg.m2)] of an inertia (3, 3) [kg.m2], Eqs. (14), (18)."""
    J = _inertia(inertia, "inertia")
    P = np.linalg.inv(J)
    gyroscopic = np.zeros((3, 6))  # omega x J omega in the products of Eq. (16)
    for column, (i, j) in enumerate(_ITEMS):
        for a, b in {(i, j), (j, i)}:
            gyroscopic[:, column] += np.cross(np.eye(3)[a], J[:, b])
    return (P @ gyroscopic).ravel(), np.array([P[i, j] for i, j in _ITEMS])


@dataclass(frozen=True)
class Law:
    """Parameters of `BoundedAdaptiveTracking`, under its names."""

    inertia: Sequence[Sequence[float]]  # I*, kg.m2: `J_B` of the component
    k: float = 0.3  # 1/s
    lam: float = 0.05  # 1/s
    eta: float = 0.35
    eta_p: float = 0.015  # 1/(kg.m2)
    epsilon: float = 0.1
    epsilon_p: float = 0.1

    def __post_init__(self) -> None:
        """Refuse what is not positive."""
        _inertia(self.inertia, "inertia")
        for name in ("k", "lam", "eta", "eta_p", "epsilon", "epsilon_p"):
            if not 0 < getattr(self, name) < inf:
                raise AdcsError(f"{name} = {getattr(self, name):g}: expected a positive number")

    @cached_property
    def theta(self) -> Array:
        """theta*, (18,)."""
        return parameters(self.inertia)[0]

    @cached_property
    def theta_p(self) -> Array:
        """theta_p*, (6,) [1/(kg.m2)]."""
        return parameters(self.inertia)[1]

    @property
    def radii(self) -> tuple[float, float]:
        """Radii of G and G_p, sqrt(1 + eps) eta; print has the root over the eta too."""
        return sqrt(1 + self.epsilon) * self.eta, sqrt(1 + self.epsilon_p) * self.eta_p

    @property
    def largest_eta_p(self) -> float:
        """The eta_p from which on the estimate of the inverse inertia could become singular [1/(kg.m2)]."""
        smallest = 1 / float(np.linalg.eigvalsh(np.asarray(self.inertia, float))[-1])
        return smallest / (WORST * sqrt(1 + self.epsilon_p))


@dataclass(frozen=True)
class Task:
    """What is known of reference, disturbance and inertia."""

    rate: float  # bound on the angular velocity of the reference, rad/s
    acceleration: float  # bound on its time derivative, rad/s2
    torque: float  # bound on the disturbance torque, N.m
    smallest_moment: float  # lambda_I, lower bound on the smallest principal moment of inertia, kg.m2

    def __post_init__(self) -> None:
        """Refuse what cannot be a bound."""
        for name in ("rate", "acceleration", "torque"):
            _bound(name, getattr(self, name))
        if not 0 < self.smallest_moment < inf:
            raise AdcsError(f"smallest_moment = {self.smallest_moment:g}: expected a positive moment of inertia")


@dataclass(frozen=True)
class EstimationBounds:
    """Ultimate bounds on the estimation errors and their time derivatives, Assumption 1; all 0: exact states."""

    attitude: float = 0.0  # on the vector part of the error quaternion, below 1
    rate: float = 0.0  # rad/s
    attitude_rate: float = 0.0  # 1/s
    rate_rate: float = 0.0  # rad/s2

    def __post_init__(self) -> None:
        """Refuse what cannot be a bound."""
        for name in ("attitude", "rate", "attitude_rate", "rate_rate"):
            _bound(name, getattr(self, name))
        if self.attitude >= 1:
            raise AdcsError(
                f"attitude = {self.attitude:g}: the vector part of the attitude's estimation error must stay below 1 "
                "(Assumption 1), else nothing is known of the attitude"
            )


@dataclass(frozen=True)
class Condition:
    """One presupposition, `left < right`."""

    name: str
    source: str
    statement: str
    left: float
    right: float
    remedy: str

    @property
    def holds(self) -> bool:
        """A NaN does not."""
        return self.left < self.right


@dataclass(frozen=True)
class Guarantee:
    """Theorem 1 for a law, a task and an observer. `margin` is the dead zone relative to its lower limit (47).

    `dead_zone` [rad/s] overrides that. `true_inertia`, if known (as in a simulation), adds the conditions on it.
    """

    law: Law
    task: Task
    estimation: EstimationBounds = field(default_factory=EstimationBounds)
    margin: float = 1.05
    given_dead_zone: float | None = None
    true_inertia: Sequence[Sequence[float]] | None = None

    @cached_property
    def lost_scalar(self) -> float:
        """1 - sqrt(1 - v_q^2)."""
        return 1 - sqrt(1 - self.estimation.attitude**2)

    @cached_property
    def v_filtered(self) -> float:
        """Bound on the error of the filtered rate error, Eq. (40) [rad/s]."""
        return self._v_filtered(1.0)

    def _v_filtered(self, q: float) -> float:
        """Eq. (40) where |q| is at most `q`, as in Eq. (48) [rad/s]."""
        e, lam = self.estimation, self.law.lam
        return e.rate + q * lam * self.lost_scalar + (2 * self.task.rate + lam) * e.attitude

    @cached_property
    def terms(self) -> dict[str, float]:
        """The hatted a to f, Eqs. (41)-(46): a, c, e [1/s] and b, d, f [rad/s2]."""
        e, lam, w, w_dot = self.estimation, self.law.lam, self.task.rate, self.task.acceleration
        v_q, v_w = e.attitude, e.rate
        v_q4_dot = v_q * e.attitude_rate / sqrt(1 - v_q**2)  # (10), where print has |v_q4| for its derivative
        size = float(np.linalg.norm(self.law.theta)) + self.law.eta
        slope = 2 * v_q * w + lam / 2 * (self.lost_scalar + 2 * v_q)
        return {
            "a": sqrt(6) * v_w * size,
            "b": (v_w**2 + sqrt(6) * v_w * (self.v_filtered + w + lam)) * size,
            "c": slope,
            "d": slope * (self.v_filtered + lam) + 2 * v_q * w_dot + (v_w + 2 * v_q * w) * (w + lam / 2),
            "e": slope,
            "f": slope * (self.v_filtered + lam)
            + e.rate_rate
            + 2 * (e.attitude_rate * (v_q + 1) + v_q * v_q4_dot) * w
            + 2 * v_q * w_dot
            + lam * (v_q4_dot + e.attitude_rate),
        }

    @property
    def gain_needed(self) -> float:
        """a + c + e, which k must exceed [1/s]."""
        return self.terms["a"] + self.terms["c"] + self.terms["e"]

    @cached_property
    def dead_zone_limit(self) -> float:
        """Right-hand side of Eq. (47), which the dead zone must exceed; infinite if the gain is too small [rad/s]."""
        spare = self.law.k - self.gain_needed
        t = self.terms
        disturbance = self.task.torque / self.task.smallest_moment
        return (t["b"] + t["d"] + t["f"] + disturbance) / spare if spare > 0 else inf

    @property
    def dead_zone(self) -> float:
        """The dead zone Omega: the given one, else `margin` times the limit [rad/s]."""
        return self.margin * self.dead_zone_limit if self.given_dead_zone is None else self.given_dead_zone

    def sequence(self, n: int) -> tuple[Array, Array]:
        """Algorithm 1: `q_i` [-] and `r_i` [rad/s], i = 1..n, each (n,)."""
        q, r = np.empty(n), np.empty(n)
        last = 1.0
        for i in range(n):
            r[i] = self.dead_zone + self._v_filtered(last)
            last = q[i] = r[i] / self.law.lam
        return q, r

    @property
    def r_limit(self) -> float:
        """Limit of `r_i`, the bound on the filtered rate error [rad/s]; |delta omega| ends below twice that."""
        return (self.dead_zone + self._v_filtered(0.0)) / (1 - self.lost_scalar)

    @property
    def q_limit(self) -> float:
        """Limit of `q_i`: the vector part of the tracking error's quaternion ends below it."""
        return self.r_limit / self.law.lam

    @property
    def rate_limit(self) -> float:
        """The rate error ends below it [rad/s]."""
        return 2 * self.r_limit

    @cached_property
    def conditions(self) -> list[Condition]:
        """Everything that the theorem presupposes, as `left < right`."""
        law, task = self.law, self.task
        found = [
            Condition("gain", "Theorem 1", "a + c + e < k [1/s]", self.gain_needed, law.k,
                      "raise k, or use a better observer"),
            Condition("dead zone", "Eq. (47)",
                      "(b + d + f + torque / smallest_moment) / (k - a - c - e) < dead_zone [rad/s]",
                      self.dead_zone_limit, self.dead_zone, "enlarge the dead zone"),
            Condition("bound below 1", "Theorem 1", "q_1 < 1, else the bound on the attitude error says nothing",
                      float(self.sequence(1)[0][0]), 1.0,
                      "raise lam, or make dead zone, disturbance or estimation errors smaller"),
            Condition("invertibility", "after Eq. (22)",
                      "eta_p < lambda_min(P*) / sqrt(5/3 (1 + epsilon_p)) [1/(kg.m2)]", law.eta_p, law.largest_eta_p,
                      "know the inertia better, for a smaller eta_p"),
        ]  # fmt: skip
        if self.true_inertia is not None:
            theta, theta_p = parameters(self.true_inertia)
            off, off_p = (float(np.linalg.norm(x)) for x in (theta - law.theta, theta_p - law.theta_p))
            smallest = float(np.linalg.eigvalsh(np.asarray(self.true_inertia, float))[0])
            found += [
                Condition("theta within F", "after Eq. (19)", "|theta - theta*| < eta", off, law.eta, "enlarge eta"),
                Condition("theta_p within F_p", "after Eq. (19)", "|theta_p - theta_p*| < eta_p [1/(kg.m2)]",
                          off_p, law.eta_p, "enlarge eta_p"),
                Condition("smallest moment", "after Eq. (19)", "smallest_moment < lambda_min(I) [kg.m2]",
                          task.smallest_moment, smallest, "lower smallest_moment"),
            ]  # fmt: skip
        return found

    @property
    def failing(self) -> list[Condition]:
        """The conditions that do not hold; none: the theorem applies."""
        return [condition for condition in self.conditions if not condition.holds]

    def require(self, case: str = "") -> None:
        """Raise AdcsError, one line that names each condition that fails with its numbers and the way out.

        `case` says of what it is a guarantee, for the message.
        """
        # without enough gain there is no dead zone at all: what follows from that is left out
        causes = [c for c in self.failing if isfinite(c.left)]
        if causes:
            texts = [
                f"{c.name} ({c.source}): {c.statement}, but {_number(c.left)} is not below {_number(c.right)}; "
                f"{c.remedy}"
                for c in causes
            ]
            raise AdcsError(f"no bound is guaranteed{f' for {case}' if case else ''}: " + ". ".join(texts))


def _inertia(value: ArrayLike, name: str) -> Array:
    J = np.asarray(value, float)
    if J.shape != (3, 3) or not np.isfinite(J).all() or not np.array_equal(J, J.T):
        raise AdcsError(f"{name} = {np.asarray(value).tolist()}: expected a symmetric 3 x 3 matrix in kg.m2")
    if np.linalg.eigvalsh(J)[0] <= 0:
        raise AdcsError(f"{name} = {J.tolist()}: expected a positive definite matrix")
    return J


def _bound(name: str, value: float) -> None:
    if not (isfinite(value) and value >= 0):
        raise AdcsError(f"{name} = {value:g}: expected a bound, 0 or more")


def _number(value: float) -> str:
    return f"{value:.4g}" if isfinite(value) else "infinite"
