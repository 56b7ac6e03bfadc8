"""What this folder adds to the catalogue: light, as it is read for every list of names; `entries` has the rest."""

from __future__ import annotations

SYSTEMS = {
    "observer-pd": "PD attitude tracking without gyro, by a smooth angular velocity observer",
    "full-state-pd": "PD attitude tracking with the true angular velocity",
    "quest-observer-pd": "PD attitude tracking by unit vectors alone: QUEST and the rate observer",
    "observer-inertia-error": "the rate observer with a wrong inertia, and no torque",
    "gyro-free": "attitude stabilisation from unit vectors alone",
    "gyro-free-full-state": "attitude stabilisation from unit vectors and the true angular velocity",
    "adaptive-baseline": "the adaptive law with known inertia on a rigid body",
    "comparison-baseline": "the comparison law with known inertia on a rigid body",
    "adaptive-appendage": "adaptive tracking with moving appendages, their masses estimated",
    "adaptive-appendage-full": "adaptive tracking with moving appendages, all of J_1 estimated",
    "comparison-appendage": "the comparison law with moving appendages",
    "adaptive-fuel": "adaptive tracking while fuel is lost, the diagonal of J_1 estimated",
    "adaptive-fuel-full": "adaptive tracking while fuel is lost, all of J_1 estimated",
    "comparison-fuel": "the comparison law while fuel is lost",
}
"""What each system is in a line."""
STUDIES = ("thakur",)
