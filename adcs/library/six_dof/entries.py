"""What stands for the names of this folder's catalogue."""

from __future__ import annotations

from adcs.library.entry import StudyEntry
from adcs.library.six_dof import catalogue, settings, study, systems, views
from orchestration.entry import SystemEntry

SYSTEMS = [
    SystemEntry(name, catalogue.SYSTEMS[name], settings.REFERENCE, build, 300.0, 0.1, views.figures, views.key_numbers)
    for name, build in systems.BUILDERS.items()
]
STUDIES = [StudyEntry("six-dof", study.TITLE, study.SUMMARY, settings.Choices, study.run)]
