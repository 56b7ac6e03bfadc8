"""What stands for the names of this folder's catalogue."""

from __future__ import annotations

from adcs.library.entry import StudyEntry
from adcs.library.trigo import catalogue, settings, study, systems, views
from orchestration.entry import SystemEntry

SYSTEMS = [
    SystemEntry(
        name,
        catalogue.SYSTEMS[name],
        settings.REFERENCE,
        build,
        settings.STOP_TIME,
        1 / settings.CONTROL_RATE,
        views.figures,
        views.key_numbers,
        check_step=lambda step: systems.stride(step, settings.CONTROL_RATE),
    )
    for name, build in systems.BUILDERS.items()
]
STUDIES = [StudyEntry("trigo", study.TITLE, study.SUMMARY, settings.Choices, study.run)]
