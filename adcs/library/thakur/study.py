"""The study of the dissertation as a whole, by chapters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from adcs.library.outcome import Outcome, Progress, Runner
from adcs.library.thakur.adaptive import appendage as adaptive_appendage
from adcs.library.thakur.adaptive import baseline as adaptive_baseline
from adcs.library.thakur.adaptive import fuel as adaptive_fuel
from adcs.library.thakur.adaptive import steps as adaptive_steps
from adcs.library.thakur.choices import Choices
from adcs.library.thakur.gyro_free import claims as gyro_free
from adcs.library.thakur.gyro_free import noise as gyro_free_noise
from adcs.library.thakur.gyro_free import steps as gyro_free_steps
from adcs.library.thakur.gyro_free import theorem as gyro_free_theorem
from adcs.library.thakur.observer import exchange_step, inertia_errors, noise, noise_free, quest, random_starts
from orchestration.results.result import Result
from orchestration.running.run import run as run_system

TITLE = "Attitude control with less knowledge: Thakur, chapters 3 to 5"
SUMMARY = (
    "Three problems of one dissertation. Chapter 3: a spacecraft whose inertia is unknown and changes, as appendages "
    "move or fuel is burnt, follows a turning reference. Chapter 4: one comes to rest at an attitude from measured "
    "unit vectors alone, without a gyro. Chapter 5: one follows a turning reference with PD control and the angular "
    "velocity that a smooth observer makes of the attitude. Each statement of the text on its simulations is set "
    "beside what these components compute, with the criterion used where the text gives none."
)


@dataclass(frozen=True)
class Part:
    """A piece of the study: how many runs it makes, and what makes them."""

    runs: Callable[[Choices], int]
    outcome: Callable[[Runner, Choices], Outcome]


PARTS: dict[str, tuple[Part, ...]] = {
    "3": (
        Part(lambda _: adaptive_baseline.RUNS, adaptive_baseline.known_inertia),
        Part(lambda _: adaptive_appendage.RUNS, adaptive_appendage.moving_appendages),
        Part(lambda _: adaptive_fuel.RUNS, adaptive_fuel.losing_fuel),
        Part(lambda _: adaptive_steps.RUNS, adaptive_steps.exchange_steps),
    ),
    "4": (
        Part(lambda _: gyro_free.RUNS, gyro_free.noise_free),
        Part(lambda _: gyro_free_theorem.RUNS, gyro_free_theorem.theorem),
        Part(gyro_free_noise.run_count, gyro_free_noise.noisy),
        Part(lambda choices: choices.starts, gyro_free_noise.random_starts),
        Part(lambda _: gyro_free_steps.RUNS, gyro_free_steps.exchange_steps),
    ),
    "5": (
        Part(lambda _: noise_free.RUNS, noise_free.noise_free),
        Part(lambda _: exchange_step.RUNS, exchange_step.exchange_step),
        Part(noise.run_count, noise.noisy),
        Part(lambda choices: choices.starts, random_starts.random_starts),
        Part(lambda _: quest.RUNS, quest.quest),
        Part(lambda _: inertia_errors.RUNS, inertia_errors.inertia_errors),
    ),
}
"""By chapter, in the order of the text."""


def run(
    choices: Choices, progress: Progress, simulate: Callable[..., Result] = run_system
) -> tuple[Outcome, list[tuple[str, Mapping[str, Any]]]]:
    """Run the chapters chosen; returns the outcome, and label and manifest of each run."""
    parts = [part for chapter, parts in PARTS.items() if chapter in choices.selected for part in parts]
    runner = Runner(progress, sum(part.runs(choices) for part in parts), simulate)
    outcome = Outcome()
    for part in parts:
        outcome += part.outcome(runner, choices)
    return outcome, runner.runs
