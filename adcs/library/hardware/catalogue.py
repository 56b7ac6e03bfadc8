"""What this folder adds to the catalogue."""

from __future__ import annotations

from adcs.library.entry import StudyEntry
from adcs.library.hardware import systems, views
from orchestration.entry import SystemEntry

SYSTEMS = [
    SystemEntry(
        "hil-spacecraft",
        systems.DESCRIPTION,
        "",
        systems.hil_spacecraft,
        60.0,
        systems.PERIOD,
        views.figures,
        views.key_numbers,
    )
]
STUDIES: list[StudyEntry] = []
