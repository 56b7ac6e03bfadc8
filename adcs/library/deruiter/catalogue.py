"""What this folder adds to the catalogue."""

from __future__ import annotations

from adcs.library.deruiter import settings, study, systems, views
from adcs.library.entry import StudyEntry
from orchestration.entry import SystemEntry

SYSTEMS = [
    SystemEntry(name, description, settings.REFERENCE, build, 600.0, 0.05, views.figures, views.key_numbers)
    for name, description, build in systems.CATALOG
]
STUDIES = [StudyEntry("deruiter", study.TITLE, study.SUMMARY, settings.Choices, study.run)]
