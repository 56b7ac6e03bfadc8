"""Where a spacecraft is over the Earth, and its attitude relative to the frames that ground tools know.

Quaternions are scalar first, and q_BF is the attitude of B relative to F: its matrix C_BF takes components in F to
components in B. MAVLink's quaternion "from body to F" has the same four numbers. They are turned here number by number,
for every message: SciPy's rotations take 7 to 50 times as long for a single one, and judge these in the tests.

The Earth is that of IAU's standards (library ERFA): WGS 84, precession and nutation of 2006/2000A, and the Earth
rotation angle with UT1 = UTC and no polar motion, which is right within some 450 m on the ground.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import lru_cache
from math import asin, atan2, cos, pi, sin, sqrt
from typing import Literal

import erfa
import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
FrameName = Literal["ned", "lvlh", "eci"]

EARTH_RATE = 7.292115e-5
"""Angular velocity of the Earth, WGS 84 [rad/s]."""

_WGS84 = 1  # ERFA's number of the ellipsoid
_REFRESH = 60.0  # s; precession and nutation move the pole by less than 1e-8 rad in between


@dataclass(frozen=True)
class Geodetic:
    """A place over the WGS 84 ellipsoid: latitude and longitude in rad, height in m."""

    latitude: float
    longitude: float
    height: float


@dataclass(frozen=True)
class Place:
    """Where a spacecraft is, as seen from the rotating Earth.

    `velocity_ned` (3,) is relative to the Earth's surface [m/s]; `C_FN` (3, 3) takes components in the inertial frame
    N to north, east, down there.
    """

    geodetic: Geodetic
    velocity_ned: Floats
    C_FN: Floats


class Earth:
    """The rotating Earth; time is in s since `epoch`."""

    def __init__(self, epoch: datetime) -> None:
        """`epoch` without time zone is UTC."""
        self.epoch = epoch if epoch.tzinfo is not None else epoch.replace(tzinfo=UTC)
        utc = self.epoch.astimezone(UTC)
        seconds = utc.second + 1e-6 * utc.microsecond
        self._utc = erfa.dtf2d("UTC", utc.year, utc.month, utc.day, utc.hour, utc.minute, seconds)
        self._tt = erfa.taitt(*erfa.utctai(*self._utc))
        self._pole = lru_cache(maxsize=4)(self._celestial_to_intermediate)

    def unix_time(self, t: float) -> float:
        """Return the UNIX time of t [s]."""
        return (self.epoch + timedelta(seconds=t)).timestamp()

    def C_EN(self, t: float) -> Floats:
        """Return (3, 3) from the celestial frame (GCRS) to the terrestrial one (ITRS, Earth centred, Earth fixed)."""
        turned: Floats = erfa.rz(erfa.era00(self._utc[0], self._utc[1] + t / 86400.0), self._pole(t // _REFRESH))
        return turned

    def place(self, t: float, r_N: ArrayLike, v_N: ArrayLike) -> Place:
        """Return where position (3,) [m] and velocity (3,) [m/s] in the celestial frame are over the Earth."""
        C_EN = self.C_EN(t)
        r_E = C_EN @ np.asarray(r_N, float)
        v_E = C_EN @ np.asarray(v_N, float) - np.cross([0.0, 0.0, EARTH_RATE], r_E)
        geodetic = geodetic_of(r_E)
        C_FE = ned(geodetic.latitude, geodetic.longitude)
        return Place(geodetic, C_FE @ v_E, C_FE @ C_EN)

    def _celestial_to_intermediate(self, k: float) -> Floats:
        matrix: Floats = erfa.c2i06a(self._tt[0], self._tt[1] + k * _REFRESH / 86400.0)
        return matrix


def geodetic_of(r_E: ArrayLike) -> Geodetic:
    """Return the place of a position (3,) in the Earth fixed frame [m]."""
    longitude, latitude, height = erfa.gc2gd(_WGS84, np.asarray(r_E, float))
    return Geodetic(float(latitude), float(longitude), float(height))


def position_of(place: Geodetic) -> Floats:
    """Return the position (3,) of a place in the Earth fixed frame [m]."""
    r_E: Floats = erfa.gd2gc(_WGS84, place.longitude, place.latitude, place.height)
    return r_E


def ned(latitude: float, longitude: float) -> Floats:
    """Return (3, 3) from the Earth fixed frame to north, east, down at a geodetic latitude and longitude [rad]."""
    sp, cp, sl, cl = sin(latitude), cos(latitude), sin(longitude), cos(longitude)
    return np.array([[-sp * cl, -sp * sl, cp], [-sl, cl, 0.0], [-cp * cl, -cp * sl, -sp]])


def lvlh(r_N: ArrayLike, v_N: ArrayLike) -> Floats:
    """Return (3, 3) from N to the orbit frame: x along the track, y against the orbit's normal, z to the Earth."""
    r, v = np.asarray(r_N, float), np.asarray(v_N, float)
    z = -r / np.linalg.norm(r)
    h = np.cross(r, v)
    y = -h / np.linalg.norm(h)
    return np.array([np.cross(y, z), y, z])


def quaternion(C_BF: Floats) -> Floats:
    """Return q_BF (4,), with a scalar part that is not negative, of C_BF (3, 3)."""
    C = C_BF.tolist()
    trace = C[0][0] + C[1][1] + C[2][2]
    squares = [1 + trace, *(1 + 2 * C[i][i] - trace for i in range(3))]  # 4 q_i^2
    i = max(range(4), key=squares.__getitem__)  # divide by the largest only
    q = [0.0, C[1][2] - C[2][1], C[2][0] - C[0][2], C[0][1] - C[1][0]]
    if i:
        j, k = i % 3 + 1, (i + 1) % 3 + 1
        q = [q[i], *q[1:]]
        q[j] = C[i - 1][j - 1] + C[j - 1][i - 1]
        q[k] = C[i - 1][k - 1] + C[k - 1][i - 1]
    q[i] = squares[i]
    return unit(canonical(q))


def unit(q: ArrayLike) -> Floats:
    """Return the quaternion at length 1."""
    values = np.asarray(q, float)
    length = sqrt(float(values @ values))
    return values / length if length > 0 else np.array([1.0, 0.0, 0.0, 0.0])


def multiply(q_BG: ArrayLike, q_GF: ArrayLike) -> Floats:
    """Return q_BF (4,), of C_BF = C_BG C_GF."""
    a, b, c, d = np.asarray(q_GF, float).tolist()
    w, x, y, z = np.asarray(q_BG, float).tolist()
    return np.array(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ]
    )


def conjugate(q: ArrayLike) -> Floats:
    """Return q_FB (4,) of q_BF."""
    return np.asarray(q, float) * [1.0, -1.0, -1.0, -1.0]


def canonical(q: ArrayLike) -> Floats:
    """Return the one of q and -q (4,), which are the same attitude, whose scalar part is not negative."""
    values = np.asarray(q, float)
    return -values if values[0] < 0 else values


def nearest(q: ArrayLike, to: ArrayLike) -> Floats:
    """Return the one of q and -q (4,) that is nearest to another quaternion, as four numbers.

    Control laws tell q from -q: from one of them to the other they turn the body by a whole revolution.
    """
    values = np.asarray(q, float)
    return -values if float(values @ np.asarray(to, float)) < 0 else values


def rotation_angle(q: ArrayLike) -> float:
    """Return the angle of a rotation, 0 to pi [rad]."""
    w, x, y, z = np.asarray(q, float).tolist()
    return 2 * atan2(sqrt(x * x + y * y + z * z), abs(w))


def euler(q_BF: ArrayLike) -> tuple[float, float, float]:
    """Return roll, pitch and yaw [rad] of B relative to F: turn about z, then y, then x."""
    w, x, y, z = unit(q_BF).tolist()
    pitch = 2 * (w * y - z * x)
    if abs(pitch) > 1 - 1e-12:  # roll and yaw turn about the same axis: all of it is yaw
        return 0.0, (pi / 2 if pitch > 0 else -pi / 2), -2 * atan2(x, w) if pitch > 0 else 2 * atan2(x, w)
    return (
        atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
        asin(pitch),
        atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
    )


def from_mrp(sigma_BF: ArrayLike) -> Floats:
    """Return q_BF (4,) of modified Rodrigues parameters (3,)."""
    s = np.asarray(sigma_BF, float)
    square = float(s @ s)
    return np.array([1 - square, *(2 * s)]) / (1 + square)
