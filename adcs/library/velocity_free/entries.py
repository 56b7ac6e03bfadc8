"""What stands for the names of this folder's catalogue."""

from __future__ import annotations

from adcs.library.entry import StudyEntry
from adcs.library.velocity_free import catalogue, settings, study, systems, views
from orchestration.entry import SystemEntry

SYSTEMS = [
    SystemEntry(name, catalogue.SYSTEMS[name], settings.REFERENCE, build, 60.0, 0.01, views.figures, views.key_numbers)
    for name, build in systems.BUILDERS.items()
]
STUDIES = [StudyEntry("velocity-free", study.TITLE, study.SUMMARY, settings.Choices, study.run)]
