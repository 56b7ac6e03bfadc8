"""What this folder adds to the catalogue: light, as it is read for every list of names; `entries` has the rest."""

from __future__ import annotations

SYSTEMS = {
    "hil-spacecraft": (
        "a spacecraft in orbit with gyro, accelerometer, magnetometer and star tracker, flown from outside"
    ),
}
"""What each system is in a line."""
STUDIES: tuple[str, ...] = ()
