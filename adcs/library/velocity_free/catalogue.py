"""What this folder adds to the catalogue: light, as it is read for every list of names; `entries` has the rest."""

from __future__ import annotations

SYSTEMS = {
    "velocity-free-stabilisation": "Stabilisation without rate measurement, everything known",
    "velocity-free-tracking": "Attitude tracking without rate measurement, everything known",
    "velocity-free-stabilisation-uncertain": (
        "Stabilisation without rate measurement, with measurement error and environment torque"
    ),
    "velocity-free-tracking-uncertain": (
        "Attitude tracking without rate measurement, with measurement error, environment torque and wrong inertia"
    ),
}
"""What each system is in a line."""
STUDIES = ("velocity-free",)
