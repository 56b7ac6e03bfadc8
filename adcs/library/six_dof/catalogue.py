"""What this folder adds to the catalogue: light, as it is read for every list of names; `entries` has the rest."""

from __future__ import annotations

SYSTEMS = {
    "six-dof": "Orbit and attitude tracked at once, without any velocity measurement",
    "six-dof-saturated": (
        "Orbit and attitude tracked at once, without any velocity measurement, force and torque limited"
    ),
}
"""What each system is in a line."""
STUDIES = ("six-dof",)
