"""What this folder adds to the catalogue."""

from __future__ import annotations

from adcs.library.entry import StudyEntry
from adcs.library.velocity_free import settings, study, systems, views
from orchestration.entry import SystemEntry

SYSTEMS = [
    SystemEntry(name, description, settings.REFERENCE, build, 60.0, 0.01, views.figures, views.key_numbers)
    for name, description, build in systems.CATALOG
]
STUDIES = [StudyEntry("velocity-free", study.TITLE, study.SUMMARY, settings.Choices, study.run)]
