"""Every system that `adcs run` knows by name, and every study that `adcs study` knows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from orchestration import Result, System
from orchestration.plots import Panel
from orchestration.report import KeyNumber
from studies.outcome import Outcome, Progress
from studies.thakur import settings as thakur
from studies.thakur import study as thakur_study
from studies.thakur import views as thakur_views
from studies.thakur.systems import full_state_pd, observer_pd


@dataclass(frozen=True)
class SystemEntry:
    """A system by name, how long it is worth running, and how its result is shown."""

    name: str
    description: str
    reference: str
    build: Callable[[], System]
    stop_time: float  # s
    step: float  # s
    figures: Callable[[Result], Sequence[Panel]]
    key_numbers: Callable[[Result], Sequence[KeyNumber]]


@dataclass(frozen=True)
class StudyEntry:
    """A study by name.

    `choices` is the dataclass of what can be chosen; `run` gives the outcome, and label and manifest of each run.
    """

    name: str
    title: str
    summary: str
    choices: type[Any]
    run: Callable[[Any, Progress], tuple[Outcome, list[tuple[str, Mapping[str, Any]]]]]


SYSTEMS = {
    entry.name: entry
    for entry in (
        SystemEntry(
            "observer-pd",
            "PD attitude tracking without gyro, by a smooth angular velocity observer",
            thakur.REFERENCE,
            observer_pd,
            100.0,
            0.01,
            thakur_views.figures,
            thakur_views.key_numbers,
        ),
        SystemEntry(
            "full-state-pd",
            "PD attitude tracking with the true angular velocity",
            thakur.REFERENCE,
            full_state_pd,
            100.0,
            0.01,
            thakur_views.figures,
            thakur_views.key_numbers,
        ),
    )
}

STUDIES = {
    entry.name: entry
    for entry in (StudyEntry("thakur", thakur_study.TITLE, thakur_study.SUMMARY, thakur.Choices, thakur_study.run),)
}
