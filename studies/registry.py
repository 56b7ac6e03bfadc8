"""Every system that `adcs run` knows by name, and every study that `adcs study` knows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from orchestration import Result, System
from orchestration.plots import Panel
from orchestration.report import KeyNumber
from studies.deruiter import settings as deruiter
from studies.deruiter import study as deruiter_study
from studies.deruiter import systems as deruiter_systems
from studies.deruiter import views as deruiter_views
from studies.hardware import systems as hardware_systems
from studies.hardware import views as hardware_views
from studies.outcome import Outcome, Progress
from studies.six_dof import settings as six_dof
from studies.six_dof import study as six_dof_study
from studies.six_dof import systems as six_dof_systems
from studies.six_dof import views as six_dof_views
from studies.thakur import (
    adaptive_settings,
    adaptive_systems,
    adaptive_views,
    gyro_free_settings,
    gyro_free_views,
    inertia_errors,
)
from studies.thakur import settings as thakur
from studies.thakur import study as thakur_study
from studies.thakur import views as thakur_views
from studies.thakur.gyro_free_systems import gyro_free, gyro_free_full_state
from studies.thakur.systems import full_state_pd, observer_inertia_error, observer_pd, quest_observer_pd
from studies.trigo import settings as trigo
from studies.trigo import study as trigo_study
from studies.trigo import systems as trigo_systems
from studies.trigo import views as trigo_views
from studies.velocity_free import settings as velocity_free
from studies.velocity_free import study as velocity_free_study
from studies.velocity_free import systems as velocity_free_systems
from studies.velocity_free import views as velocity_free_views


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
    start_time: float = 0.0  # s
    check_step: Callable[[float], object] = lambda step: None  # refuses an exchange step [s]


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
        SystemEntry(
            "quest-observer-pd",
            "PD attitude tracking by unit vectors alone: QUEST and the rate observer",
            thakur.REFERENCE,
            quest_observer_pd,
            100.0,
            0.01,
            thakur_views.figures,
            thakur_views.key_numbers,
        ),
        SystemEntry(
            "observer-inertia-error",
            "the rate observer with a wrong inertia, and no torque",
            thakur.REFERENCE,
            observer_inertia_error,
            200.0,
            0.01,
            inertia_errors.figures,
            inertia_errors.key_numbers,
        ),
        SystemEntry(
            "gyro-free",
            "attitude stabilisation from unit vectors alone",
            gyro_free_settings.REFERENCE,
            gyro_free,
            200.0,
            0.01,
            gyro_free_views.figures,
            gyro_free_views.key_numbers,
        ),
        SystemEntry(
            "gyro-free-full-state",
            "attitude stabilisation from unit vectors and the true angular velocity",
            gyro_free_settings.REFERENCE,
            gyro_free_full_state,
            200.0,
            0.01,
            gyro_free_views.figures,
            gyro_free_views.key_numbers,
        ),
        *(
            SystemEntry(
                name,
                adaptive_systems.DESCRIPTIONS[name],
                adaptive_settings.REFERENCE,
                build,
                100.0,
                0.001,
                adaptive_views.figures,
                adaptive_views.key_numbers,
            )
            for name, build in adaptive_systems.BUILDERS.items()
        ),
        *(
            SystemEntry(
                name,
                description,
                velocity_free.REFERENCE,
                build,
                60.0,
                0.01,
                velocity_free_views.figures,
                velocity_free_views.key_numbers,
            )
            for name, description, build in velocity_free_systems.CATALOG
        ),
        *(
            SystemEntry(
                name,
                description,
                six_dof.REFERENCE,
                build,
                300.0,
                0.1,
                six_dof_views.figures,
                six_dof_views.key_numbers,
            )
            for name, description, build in six_dof_systems.CATALOG
        ),
        *(
            SystemEntry(
                name,
                description,
                deruiter.REFERENCE,
                build,
                600.0,
                0.05,
                deruiter_views.figures,
                deruiter_views.key_numbers,
            )
            for name, description, build in deruiter_systems.CATALOG
        ),
        *(
            SystemEntry(
                name,
                description,
                trigo.REFERENCE,
                build,
                trigo.STOP_TIME,
                1 / trigo.CONTROL_RATE,
                trigo_views.figures,
                trigo_views.key_numbers,
                check_step=lambda step: trigo_systems.stride(step, trigo.CONTROL_RATE),
            )
            for name, description, build in trigo_systems.CATALOG
        ),
        SystemEntry(
            "hil-spacecraft",
            hardware_systems.DESCRIPTION,
            "",
            hardware_systems.hil_spacecraft,
            60.0,
            hardware_systems.PERIOD,
            hardware_views.figures,
            hardware_views.key_numbers,
        ),
    )
}

STUDIES = {
    entry.name: entry
    for entry in (
        StudyEntry("thakur", thakur_study.TITLE, thakur_study.SUMMARY, thakur.Choices, thakur_study.run),
        StudyEntry(
            "velocity-free",
            velocity_free_study.TITLE,
            velocity_free_study.SUMMARY,
            velocity_free.Choices,
            velocity_free_study.run,
        ),
        StudyEntry("six-dof", six_dof_study.TITLE, six_dof_study.SUMMARY, six_dof.Choices, six_dof_study.run),
        StudyEntry("deruiter", deruiter_study.TITLE, deruiter_study.SUMMARY, deruiter.Choices, deruiter_study.run),
        StudyEntry("trigo", trigo_study.TITLE, trigo_study.SUMMARY, trigo.Choices, trigo_study.run),
    )
}
