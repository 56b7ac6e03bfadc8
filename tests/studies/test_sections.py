"""Which runs are made for the sections of a study, what is said of them, and what the sections get."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from adcs import AdcsError, System
from adcs.library.choices import PART, Checked, Must, at_least, choice, positive
from adcs.library.outcome import Claim
from adcs.library.sections import Section, Simulation, conduct
from orchestration.results.result import RunFailed


def system(gain: float) -> System:
    made = System("body", "")
    made.add("plant", "RigidBody", {"J_B": 10 * gain * np.eye(3)})
    return made


class Recorded:
    """What a run gives, as far as it matters here."""

    def __init__(self, of: System) -> None:
        self.manifest = {"name": of.name}
        self.inertia = of.components["plant"].start["J_B"][0]


def view(result: Any) -> float:
    return float(result.inertia)


def halved(result: Any) -> float:
    return view(result) / 2


def simulation(label: str, gain: float) -> Simulation:
    return Simulation(label, system(gain), view, 10.0, 0.1, record=["plant.q_BN"])


def simulate(made: list[System]) -> Callable[..., Any]:
    def run(of: System, *, stop_time: float, step: float, method: Any, save: Any, progress: Any) -> Any:
        assert (stop_time, step, method.kind, save.names) == (10.0, 0.1, "co-simulation", ("plant.q_BN",))
        made.append(of)
        progress(0.5)
        return Recorded(of)

    return run


def test_equal_runs_are_made_once_and_progress_counts_them() -> None:
    said: list[tuple[float, str]] = []
    made: list[System] = []
    got: list[dict[str, float]] = []

    def show(runs: dict[str, float]) -> Iterator[Claim]:
        got.append(runs)
        yield Claim("Sec. 1", "a", "", "1", 1.0, True)

    sections = [
        Section("one", "", show, {"x": simulation("first", 1.0), "y": simulation("second", 2.0)}),
        Section("two", "Claims", show, {"x": simulation("first once more", 1.0)}),
        Section("three", "", show, {"x": replace(simulation("third", 2.0), view=halved)}),
    ]
    outcome, manifests = conduct(sections, lambda done, text: said.append((done, text)), simulate(made))
    assert said == [(0.0, "first"), (0.25, "first"), (0.5, "second"), (0.75, "second")]
    assert got == [{"x": 10.0, "y": 20.0}, {"x": 10.0}, {"x": 10.0}]
    assert [label for label, _ in manifests] == ["first", "second"]
    assert len(outcome.claims) == 3
    assert [(table.title, table.group) for table in outcome.tables] == [("Claims", "two")]


@pytest.mark.parametrize(
    "change",
    [
        {"step": 0.2},
        {"stop_time": 5.0},
        {"every": 2},
        {"record": ["plant.omega_BN_B"]},
        {"record": None},
        {"may_fail": True},
    ],
)
def test_what_makes_a_run_another_one(change: dict[str, Any]) -> None:
    one = simulation("a", 1.0)
    assert one.key == simulation("b", 1.0).key
    assert replace(one, **change).key != one.key


def test_a_run_that_fails_ends_the_study_unless_it_may() -> None:
    def fail(of: System, **_: Any) -> Any:
        raise RunFailed("beyond the range of numbers", Recorded(of))  # type: ignore[arg-type]

    section = Section("g", "", lambda runs: [Claim("", "", "", "", runs["x"], True)])
    with pytest.raises(RunFailed):
        conduct([replace(section, runs={"x": simulation("a", 1.0)})], simulate=fail)
    outcome, _ = conduct([replace(section, runs={"x": replace(simulation("a", 1.0), may_fail=True)})], simulate=fail)
    assert outcome.claims[0].measure == 10.0


def test_choices_are_refused_in_one_line_with_what_was_expected() -> None:
    @dataclass(frozen=True)
    class Choices(Checked):
        start: float = choice(1.0, "begins", positive("time"))
        end: float = choice(2.0, "ends", Must(lambda end, c: end > c.start, "later than start, {start:g} s"))
        share: float = choice(0.5, "how much", PART)
        count: int = choice(1, "how many", at_least(1))
        name: str = choice("a", "anything")

    assert Choices().end == 2.0
    for change, message in (
        ({"start": -1.0}, "choice start = -1: expected a positive time"),
        ({"start": float("inf")}, "choice start = inf: expected a positive time"),
        ({"start": 3.0}, "choice end = 2: expected later than start, 3 s"),
        ({"share": float("nan")}, "choice share = nan: expected a part between 0 and 1"),
        ({"count": 0}, "choice count = 0: expected 1 or more"),
    ):
        with pytest.raises(AdcsError) as error:
            Choices(**change)  # type: ignore[arg-type]
        assert str(error.value) == message
