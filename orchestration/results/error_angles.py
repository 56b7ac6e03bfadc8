"""Attitude errors as angles: which recorded variables are quaternions of such errors, and by how much those turn."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import ArrayLike, NDArray

_ERROR = re.compile(r"q_(?![A-Z][NO])[A-Z]{2}")  # relative to N or O, as q_BN, it is an attitude, not the error of one
_NOT_ONE = 1e-3  # by how much the norm of a quaternion may differ from 1, as that of a state does in long steps


def is_error_quaternion(variable: str, unit: str | None, values: ArrayLike) -> bool:
    """Whether recorded values, (N, *shape), are unit quaternions of an attitude error, by the names that those have.

    q_BR is the attitude of B relative to R, of frames that are meant to be one.
    """
    q = np.asarray(values, dtype=float)
    if not _ERROR.fullmatch(variable) or unit not in (None, "", "1") or q.ndim != 2 or q.shape[1] != 4 or not len(q):
        return False
    return bool(np.all(np.abs(np.linalg.norm(q, axis=1) - 1.0) <= _NOT_ONE))


def turned_by(q: ArrayLike) -> NDArray[np.float64]:
    """By which angle [rad], 0 to pi, quaternions turn, (N, 4), scalar first: of q and -q, one attitude, the shorter."""
    q = np.asarray(q, dtype=float)
    angle: NDArray[np.float64] = 2 * np.arctan2(np.linalg.norm(q[..., 1:], axis=-1), np.abs(q[..., 0]))
    return angle
