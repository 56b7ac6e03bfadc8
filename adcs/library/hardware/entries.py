"""What stands for the names of this folder's catalogue."""

from __future__ import annotations

from adcs.library.entry import StudyEntry
from adcs.library.hardware import catalogue, systems, views
from orchestration.entry import SystemEntry

SYSTEMS = [
    SystemEntry(
        "hil-spacecraft",
        catalogue.SYSTEMS["hil-spacecraft"],
        "",
        systems.hil_spacecraft,
        60.0,
        systems.PERIOD,
        views.figures,
        views.key_numbers,
    )
]
STUDIES: list[StudyEntry] = []
