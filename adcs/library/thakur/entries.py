"""What stands for the names of this folder's catalogue."""

from __future__ import annotations

from collections.abc import Callable

from adcs.library.entry import StudyEntry
from adcs.library.thakur import study
from adcs.library.thakur.adaptive import settings as adaptive_settings
from adcs.library.thakur.adaptive import systems as adaptive
from adcs.library.thakur.adaptive import views as adaptive_views
from adcs.library.thakur.catalogue import SYSTEMS as DESCRIPTIONS
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.gyro_free import settings as gyro_free_settings
from adcs.library.thakur.gyro_free import systems as gyro_free
from adcs.library.thakur.gyro_free import views as gyro_free_views
from adcs.library.thakur.observer import inertia_errors, settings, systems, views
from orchestration.entry import SystemEntry
from orchestration.system import System


def _tracking(name: str, build: Callable[[], System]) -> SystemEntry:
    about = DESCRIPTIONS[name], settings.REFERENCE
    return SystemEntry(name, *about, build, 100.0, 0.01, views.figures, views.key_numbers)


def _inertia_error(name: str, build: Callable[[], System]) -> SystemEntry:
    about = DESCRIPTIONS[name], settings.REFERENCE
    return SystemEntry(name, *about, build, 200.0, 0.01, inertia_errors.figures, inertia_errors.key_numbers)


def _gyro_free(name: str, build: Callable[[], System]) -> SystemEntry:
    about = DESCRIPTIONS[name], gyro_free_settings.REFERENCE
    return SystemEntry(name, *about, build, 200.0, 0.01, gyro_free_views.figures, gyro_free_views.key_numbers)


def _adaptive(name: str, build: Callable[[], System]) -> SystemEntry:
    about = DESCRIPTIONS[name], adaptive_settings.REFERENCE
    return SystemEntry(name, *about, build, 100.0, 0.001, adaptive_views.figures, adaptive_views.key_numbers)


SYSTEMS = [
    _tracking("observer-pd", systems.observer_pd),
    _tracking("full-state-pd", systems.full_state_pd),
    _tracking("quest-observer-pd", systems.quest_observer_pd),
    _inertia_error("observer-inertia-error", systems.observer_inertia_error),
    _gyro_free("gyro-free", gyro_free.gyro_free),
    _gyro_free("gyro-free-full-state", gyro_free.gyro_free_full_state),
    *(_adaptive(name, build) for name, build in adaptive.BUILDERS.items()),
]
STUDIES = [StudyEntry("thakur", study.TITLE, study.SUMMARY, Choices, study.run)]
