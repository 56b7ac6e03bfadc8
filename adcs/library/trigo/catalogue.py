"""What this folder adds to the catalogue."""

from __future__ import annotations

from adcs.library.entry import StudyEntry
from adcs.library.trigo import settings, study, systems, views
from orchestration.entry import SystemEntry

SYSTEMS = [
    SystemEntry(
        name,
        description,
        settings.REFERENCE,
        build,
        settings.STOP_TIME,
        1 / settings.CONTROL_RATE,
        views.figures,
        views.key_numbers,
        check_step=lambda step: systems.stride(step, settings.CONTROL_RATE),
    )
    for name, description, build in systems.CATALOG
]
STUDIES = [StudyEntry("trigo", study.TITLE, study.SUMMARY, settings.Choices, study.run)]
