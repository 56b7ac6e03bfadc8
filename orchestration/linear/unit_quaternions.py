"""Unit quaternions among the states of a linear system: four numbers for three degrees of freedom."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from orchestration.linear.state_space import StateSpace
from orchestration.plan.lowering import Floats

_STANDS_STILL = 1e-8


@dataclass(frozen=True)
class UnitQuaternion:
    """Four states whose norm is 1 and keeps to itself: it returns to 1 with the `rate` (1/s), 0 where it is kept.

    `speed` is |dq/dt| (1/s).
    """

    name: str
    where: slice
    rate: float
    speed: float

    @property
    def stands_still(self) -> bool:
        """Whether q is constant at the operating point."""
        return self.speed <= _STANDS_STILL


def unit_quaternions(system: StateSpace) -> list[UnitQuaternion]:
    """Find them by what they do.

    If q'q stays what it is along all solutions near the point, then p = (0, q, 0) has p'A + (0, dq/dt, 0)' = 0; if its
    deviation from 1 changes with a rate r, the right side is r p'.
    """
    found = []
    for name, where in _quadruples(system.states):
        p, turning = np.zeros(len(system.x)), np.zeros(len(system.x))
        p[where], turning[where] = system.x[where], system.dx[where]
        if abs(np.linalg.norm(p) - 1) > 1e-6:
            continue
        left = p @ system.A + turning
        rate = float(left @ p) / float(p @ p)
        if np.linalg.norm(left - rate * p) <= 1e-8 * (1 + np.linalg.norm(system.A)):
            found.append(UnitQuaternion(name, where, rate, float(np.linalg.norm(turning))))
    return found


def with_notes(system: StateSpace, quaternions: Sequence[UnitQuaternion]) -> StateSpace:
    """Say which eigenvalue belongs to each norm. Where q stands still, p is a left eigenvector of A for the rate."""
    belongs = tuple((complex(q.rate), f"norm of {q.name}") for q in quaternions if q.stands_still)
    mixed = tuple(
        f"{q.name} turns at |dq/dt| = {q.speed:.3g} 1/s: its norm, which is no degree of freedom, has no eigenvalue of "
        "its own here but is mixed with others; minimal coordinates do not have it"
        for q in quaternions
        if not q.stands_still
    )
    return replace(system, belongs=belongs, notes=(*mixed, *system.notes))


def minimal(system: StateSpace, quaternions: Sequence[UnitQuaternion]) -> StateSpace:
    """Replace each by the three angles (rad) of a small rotation d: dq = q o (0, d) / 2, seen in the turning frame.

    With x - x0 = T z and z = P (x - x0), z' = (P A T + P' T) z, for the basis turns with q.
    """
    T, P, turning = (np.eye(len(system.x)) for _ in range(3))
    turning[:] = 0.0
    names = list(system.states)
    drop = []
    for q in quaternions:
        basis, rate = _tangents(system.x[q.where]), _tangents(system.dx[q.where])
        three = slice(q.where.start, q.where.start + 3)  # the fourth goes
        T[q.where, q.where], P[q.where, q.where] = 0.0, 0.0
        T[q.where, three], P[three, q.where] = basis / 2, 2 * basis.T
        turning[three, q.where] = 2 * rate.T
        names[three] = [f"{q.name}.angle[{i}]" for i in (1, 2, 3)]
        drop.append(q.where.stop - 1)
    keep = [i for i in range(len(names)) if i not in drop]
    T, P, turning = T[:, keep], P[keep], turning[keep]
    x = system.x.copy()
    for q in quaternions:
        x[q.where] = 0.0
    return replace(
        system,
        A=P @ system.A @ T + turning @ T,
        B=P @ system.B,
        C=system.C @ T,
        states=tuple(names[i] for i in keep),
        x=x[keep],
        dx=P @ system.dx,
    )


def _tangents(q: Floats) -> Floats:
    """Return the columns q o i, q o j, q o k, (4, 3): for |q| = 1 an orthonormal basis of the directions across q."""
    w, x, y, z = q
    return np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])


def _quadruples(states: Sequence[str]) -> list[tuple[str, slice]]:
    """Return names and places of arrays of four states."""
    found = []
    for i, state in enumerate(states):
        name = state.removesuffix("[1]")
        if name != state and f"{name}[5]" not in states and states[i + 3 : i + 4] == (f"{name}[4]",):
            found.append((name, slice(i, i + 4)))
    return found
