"""The study of Sec. V as a whole."""

from __future__ import annotations

from adcs.library.sections import Section, study_of
from adcs.library.velocity_free import feasible, loops
from adcs.library.velocity_free.settings import Choices

TITLE = "Attitude tracking without rate measurement: passivity and a filter"
SUMMARY = (
    "A CubeSat is brought to rest, and then follows a swinging reference, with a control law that knows its attitude "
    "but not its rate: the rate of a low-pass filter takes its place. Once everything is known; then attitude errors, "
    "environment torques and a wrong inertia come in, in ten random sequences. The gains come from the feasible region "
    "that the proof gives, which is computed here from its conditions. The paper prints figures and bounds, hardly a "
    "number: each statement is set beside what these components compute, with the criterion used."
)


def sections(choices: Choices) -> list[Section]:
    """Gains, the two problems, and what disturbs them."""
    problems = [loops.problem(choices, which) for which in loops.PROBLEMS]
    environment = [loops.measurement_error(choices), loops.disturbance(choices)]
    return [feasible.feasible(choices), *problems, *environment]


run = study_of(sections)
