"""What stands for the names of this folder's catalogue."""

from __future__ import annotations

from adcs.library.deruiter import catalogue, settings, study, systems, views
from adcs.library.entry import StudyEntry
from orchestration.entry import SystemEntry

SYSTEMS = [
    SystemEntry(name, catalogue.SYSTEMS[name], settings.REFERENCE, build, 600.0, 0.05, views.figures, views.key_numbers)
    for name, build in systems.BUILDERS.items()
]
STUDIES = [StudyEntry("deruiter", study.TITLE, study.SUMMARY, settings.Choices, study.run)]
