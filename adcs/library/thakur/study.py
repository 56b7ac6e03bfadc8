"""The study of the dissertation as a whole, by chapters."""

from __future__ import annotations

from collections.abc import Callable

from adcs.library.sections import Section, study_of
from adcs.library.thakur.adaptive import appendage, baseline, fuel, steps
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.gyro_free import claims as gyro_free
from adcs.library.thakur.gyro_free import noise as gyro_free_noise
from adcs.library.thakur.gyro_free import random_starts as gyro_free_starts
from adcs.library.thakur.gyro_free import steps as gyro_free_steps
from adcs.library.thakur.gyro_free import theorem as gyro_free_theorem
from adcs.library.thakur.observer import exchange_step, inertia_errors, noise, noise_free, quest, random_starts

TITLE = "Attitude control with less knowledge: Thakur, chapters 3 to 5"
SUMMARY = (
    "Three problems of one dissertation. Chapter 3: a spacecraft whose inertia is unknown and changes, as appendages "
    "move or fuel is burnt, follows a turning reference. Chapter 4: one comes to rest at an attitude from measured "
    "unit vectors alone, without a gyro. Chapter 5: one follows a turning reference with PD control and the angular "
    "velocity that a smooth observer makes of the attitude. Each statement of the text on its simulations is set "
    "beside what these components compute, with the criterion used where the text gives none."
)


PARTS: dict[str, tuple[Callable[[Choices], Section], ...]] = {
    "3": (
        baseline.known_inertia,
        appendage.moving_appendages,
        fuel.losing_fuel,
        steps.exchange_steps,
        steps.fuel_limits,
    ),
    "4": (
        gyro_free.noise_free,
        gyro_free_theorem.theorem,
        gyro_free_noise.noisy,
        gyro_free_starts.random_starts,
        gyro_free_steps.exchange_steps,
    ),
    "5": (
        noise_free.noise_free,
        exchange_step.exchange_step,
        noise.noisy,
        random_starts.random_starts,
        quest.quest,
        inertia_errors.inertia_errors,
    ),
}
"""By chapter, in the order of the text."""


def sections(choices: Choices) -> list[Section]:
    """Those of the chapters that are chosen."""
    return [part(choices) for chapter in PARTS if chapter in choices.selected for part in PARTS[chapter]]


run = study_of(sections)
