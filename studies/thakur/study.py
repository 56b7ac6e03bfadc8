"""The study of Sec. 5.4.1 and 5.4.2 as a whole."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from orchestration import Result
from orchestration import run as run_system
from studies.outcome import Outcome, Progress, Runner
from studies.thakur import exchange_step, noise, noise_free, random_starts
from studies.thakur.settings import Choices

TITLE = "Attitude tracking without gyro: Thakur, Sec. 5.4"
SUMMARY = (
    "A rigid spacecraft follows a turning reference with PD control, once with its true angular velocity and once with "
    "the estimate of a smooth observer that sees only the attitude quaternion. Each statement of the text on the "
    "simulations without and with noise is set beside what these components compute, with the criterion used where the "
    "text gives none."
)


def run(
    choices: Choices, progress: Progress, simulate: Callable[..., Result] = run_system
) -> tuple[Outcome, list[tuple[str, Mapping[str, Any]]]]:
    """Run everything; returns the outcome, and label and manifest of each run."""
    runs = noise_free.RUNS + exchange_step.RUNS + noise.run_count(choices) + choices.starts
    runner = Runner(progress, runs, simulate)
    outcome = (
        noise_free.noise_free(runner, choices)
        + exchange_step.exchange_step(runner, choices)
        + noise.noisy(runner, choices)
        + random_starts.random_starts(runner, choices)
    )
    return outcome, runner.runs
