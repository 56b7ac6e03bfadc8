"""What this folder adds to the catalogue."""

from __future__ import annotations

from adcs.library.entry import StudyEntry
from adcs.library.six_dof import settings, study, systems, views
from orchestration.entry import SystemEntry

SYSTEMS = [
    SystemEntry(name, description, settings.REFERENCE, build, 300.0, 0.1, views.figures, views.key_numbers)
    for name, description, build in systems.CATALOG
]
STUDIES = [StudyEntry("six-dof", study.TITLE, study.SUMMARY, settings.Choices, study.run)]
