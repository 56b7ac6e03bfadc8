"""The magnetic field of the Earth, from the World Magnetic Model."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from math import degrees

import numpy as np
from pygeomag import GeoMag

from fmus.errors import AdcsError
from hil_bridge.frames import Earth, Floats, Place

_FROM, _TO = 2025.0, 2030.0  # WMM2025 is published for these years
_NANOTESLA = 1e-9


class MagneticField:
    """WMM2025, by the library pygeomag: the field of the core, without that of the crust and of currents above."""

    def __init__(self, earth: Earth) -> None:
        self._earth = earth
        year = self._year(0.0)
        if not _FROM <= year < _TO:
            raise AdcsError(f"epoch {earth.epoch:%Y-%m-%d}: the magnetic field model WMM2025 holds from 2025 to 2029")
        self._model = GeoMag()

    def at(self, t: float, place: Place) -> Floats:
        """Return the flux density (3,) [T] in the inertial frame at a place and time [s since the epoch]."""
        where = place.geodetic
        field = self._model.calculate(
            glat=degrees(where.latitude),
            glon=degrees(where.longitude),
            alt=1e-3 * where.height,
            time=min(self._year(t), _TO),
        )
        ned = _NANOTESLA * np.array([field.x, field.y, field.z])
        return np.asarray(place.C_FN.T @ ned, np.float64)

    def _year(self, t: float) -> float:
        now = self._earth.epoch + timedelta(seconds=t)
        first, next_ = (datetime(now.year + i, 1, 1, tzinfo=UTC) for i in (0, 1))
        return now.year + (now - first) / (next_ - first)
