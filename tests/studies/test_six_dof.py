"""The six-degree-of-freedom study: its numbers against an independent closed loop, its choices, its systems."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from adcs import AdcsError, ModelExchange
from adcs import run as run_system
from adcs.catalogue import STUDIES, SYSTEMS
from adcs.library.outcome import Outcome
from adcs.library.six_dof import study
from adcs.library.six_dof.settings import Choices, Scaling
from adcs.library.six_dof.signals import ATTITUDE, DELTA_V, FORCE, POSITION, TORQUE, signals
from adcs.library.six_dof.systems import BUILDERS, saturated, six_dof
from adcs.listed import SYSTEMS as DESCRIPTIONS
from references.six_dof import Loop, S

COUPLED: dict[str, Any] = {"method": ModelExchange(rtol=1e-10, atol=1e-9)}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stop_time": 0.0}, "choice stop_time = 0: expected a positive time"),
        ({"settled": 1.0}, "choice settled = 1: expected a part between 0 and 1"),
        ({"max_force": -1.0}, "choice max_force = -1: expected a positive force"),
        ({"max_torque": float("nan")}, "choice max_torque = nan: expected a positive torque"),
    ],
)
def test_choices_that_cannot_be_judged_are_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(AdcsError) as error:
        Choices(**changes)
    assert str(error.value) == message


@pytest.mark.parametrize(("name", "build"), BUILDERS.items())
def test_the_systems_are_registered_run_and_are_shown(name: str, build: Any) -> None:
    entry, system = SYSTEMS[name], build()
    assert (system.name, system.description) == (name, entry.description) == (entry.name, DESCRIPTIONS[name])
    result = run_system(system, stop_time=2.0, step=0.1)
    panels = entry.figures(result)
    assert {panel.group for panel in panels} >= {"Tracking", "Control"}
    numbers = {number.label: number.value for number in entry.key_numbers(result)}
    limited = 2 * np.sqrt(3)
    assert numbers["Largest force"] == pytest.approx(10.868 if name == "six-dof" else limited, rel=1e-4)


def test_the_velocity_increment_is_that_of_an_independent_loop() -> None:
    """By the trapezoidal rule on the recomputed force over 100 s; and the errors there."""
    loop, times = Loop(), np.linspace(0, 5, 401)
    expected = loop.run(times)
    forces = []
    for tau, z in zip(times, expected, strict=True):
        s, e_f = loop.surroundings(tau, z), loop.auxiliary(z)[0]
        forces.append(loop.law.control(s["R"], s["R_d"], z[6:10], s["w"], s["w_dot"], e_f)[0] * S["force"])
    delta_v = np.trapezoid(np.linalg.norm(forces, axis=1), times * S["time"]) / 100
    ours = signals(run_system(six_dof(), stop_time=100.0, step=1.0, **COUPLED))
    assert ours.end(DELTA_V) == pytest.approx(delta_v, rel=1e-4)
    assert ours.peak(FORCE) == pytest.approx(np.linalg.norm(forces[0]), rel=1e-8)
    assert ours.end(POSITION) == pytest.approx(np.linalg.norm(expected[-1, :3]), abs=1e-7)
    assert ours.end(ATTITUDE) == pytest.approx(np.linalg.norm(expected[-1, 7:10]), abs=1e-9)


def test_limits_are_kept_and_slow_the_approach() -> None:
    free, limited = (
        signals(run_system(system, stop_time=100.0, step=1.0, **COUPLED))
        for system in (six_dof(), saturated(1.0, 0.02))
    )
    assert limited.peak(FORCE) <= np.sqrt(3) + 1e-12
    assert limited.peak(TORQUE) <= 0.02 * np.sqrt(3) + 1e-12
    assert free.peak(FORCE) > 10
    assert limited.end(POSITION) > free.end(POSITION)


def test_in_si_units_the_law_takes_kilonewtons_and_seconds() -> None:
    """The same law in other units is another law: its time constant is one unit of time."""
    ours = signals(run_system(six_dof(scaling=Scaling(1, 1, 1)), stop_time=10.0, step=0.1, **COUPLED))
    assert ours.peak(FORCE) == pytest.approx(3473.6, rel=1e-4)
    assert ours.settled(POSITION, 0.01, ours.start(POSITION)) < 5


def test_the_study_shortened() -> None:
    messages: list[str] = []
    outcome, runs = study.run(Choices(stop_time=60.0), lambda done, text: messages.append(text))
    assert isinstance(outcome, Outcome)
    assert len(runs) == 3 + len(study.STEPS)
    verdicts = {(row.statement, row.settings): row.verdict for row in outcome.claims}
    assert verdicts["position error converges to zero", study.FREE] == "not reproduced", "not within 60 s"
    assert verdicts["position error converges to zero", study.PRINTED] == "reproduced"
    assert verdicts["velocity measurements used", "connections from the plant to filter and controller"] == "reproduced"
    assert {panel.group for panel in outcome.panels} == {study.GROUP, study.CONTROL_GROUP}
    assert STUDIES["six-dof"].run is study.run
