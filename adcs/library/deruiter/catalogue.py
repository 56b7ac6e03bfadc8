"""What this folder adds to the catalogue: light, as it is read for every list of names; `entries` has the rest."""

from __future__ import annotations

SYSTEMS = {
    "bounded-adaptive": "adaptive tracking with guaranteed bounds, from exact states",
    "bounded-adaptive-errors": "adaptive tracking with guaranteed bounds, from estimates that err within bounds",
    "bounded-adaptive-observer": "adaptive tracking with guaranteed bounds, without gyro, by a rate observer",
}
"""What each system is in a line."""
STUDIES = ("deruiter",)
