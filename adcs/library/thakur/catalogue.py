"""What this folder adds to the catalogue."""

from __future__ import annotations

from collections.abc import Callable

from adcs.library.entry import StudyEntry
from adcs.library.thakur import study
from adcs.library.thakur.adaptive import settings as adaptive_settings
from adcs.library.thakur.adaptive import systems as adaptive
from adcs.library.thakur.adaptive import views as adaptive_views
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.gyro_free import settings as gyro_free_settings
from adcs.library.thakur.gyro_free import systems as gyro_free
from adcs.library.thakur.gyro_free import views as gyro_free_views
from adcs.library.thakur.observer import inertia_errors, settings, systems, views
from orchestration.entry import SystemEntry
from orchestration.system import System


def _tracking(name: str, description: str, build: Callable[[], System]) -> SystemEntry:
    return SystemEntry(name, description, settings.REFERENCE, build, 100.0, 0.01, views.figures, views.key_numbers)


def _gyro_free(name: str, description: str, build: Callable[[], System]) -> SystemEntry:
    figures, key_numbers = gyro_free_views.figures, gyro_free_views.key_numbers
    return SystemEntry(name, description, gyro_free_settings.REFERENCE, build, 200.0, 0.01, figures, key_numbers)


def _adaptive(name: str, description: str, build: Callable[[], System]) -> SystemEntry:
    figures, key_numbers = adaptive_views.figures, adaptive_views.key_numbers
    return SystemEntry(name, description, adaptive_settings.REFERENCE, build, 100.0, 0.001, figures, key_numbers)


SYSTEMS = [
    _tracking(
        "observer-pd",
        "PD attitude tracking without gyro, by a smooth angular velocity observer",
        systems.observer_pd,
    ),
    _tracking(
        "full-state-pd",
        "PD attitude tracking with the true angular velocity",
        systems.full_state_pd,
    ),
    _tracking(
        "quest-observer-pd",
        "PD attitude tracking by unit vectors alone: QUEST and the rate observer",
        systems.quest_observer_pd,
    ),
    SystemEntry(
        "observer-inertia-error",
        "the rate observer with a wrong inertia, and no torque",
        settings.REFERENCE,
        systems.observer_inertia_error,
        200.0,
        0.01,
        inertia_errors.figures,
        inertia_errors.key_numbers,
    ),
    _gyro_free(
        "gyro-free",
        "attitude stabilisation from unit vectors alone",
        gyro_free.gyro_free,
    ),
    _gyro_free(
        "gyro-free-full-state",
        "attitude stabilisation from unit vectors and the true angular velocity",
        gyro_free.gyro_free_full_state,
    ),
    *(_adaptive(name, adaptive.DESCRIPTIONS[name], build) for name, build in adaptive.BUILDERS.items()),
]
STUDIES = [StudyEntry("thakur", study.TITLE, study.SUMMARY, Choices, study.run)]
