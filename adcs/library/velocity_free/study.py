"""The study of Sec. V as a whole."""

from __future__ import annotations

from collections.abc import Callable

from adcs.library.outcome import Outcome, Progress
from adcs.library.sections import Manifests, conduct
from adcs.library.velocity_free import feasible, loops
from adcs.library.velocity_free.settings import Choices
from orchestration.results.result import Result
from orchestration.running.run import run as run_system

TITLE = "Attitude tracking without rate measurement: passivity and a filter"
SUMMARY = (
    "A CubeSat is brought to rest, and then follows a swinging reference, with a control law that knows its attitude "
    "but not its rate: the rate of a low-pass filter takes its place. Once everything is known; then attitude errors, "
    "environment torques and a wrong inertia come in, in ten random sequences. The gains come from the feasible region "
    "that the proof gives, which is computed here from its conditions. The paper prints figures and bounds, hardly a "
    "number: each statement is set beside what these components compute, with the criterion used."
)


def run(
    choices: Choices, progress: Progress, simulate: Callable[..., Result] = run_system
) -> tuple[Outcome, Manifests]:
    """Run everything; returns the outcome, and label and manifest of each run."""
    problems = [loops.problem(choices, which) for which in loops.PROBLEMS]
    environment = [loops.measurement_error(choices), loops.disturbance(choices)]
    return conduct([feasible.feasible(choices), *problems, *environment], progress, simulate)
