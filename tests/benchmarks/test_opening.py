"""What the benchmarks of opening, commands, building and memory run; how long it takes is not tested."""

import sys
from pathlib import Path

import pytest

from benchmarks import building, commands, memory, opening


@pytest.mark.parametrize("system", opening.SYSTEMS.values(), ids=opening.SYSTEMS)
def test_a_run_of_one_step_takes_time(system: object) -> None:
    assert opening.one_step(system) > 0


def test_commands_end_well_and_take_time(tmp_path: Path) -> None:
    assert commands.taken(commands.COMMANDS["adcs --help"], tmp_path) > 0
    assert all("-m" in words or "-c" in words for words in commands.COMMANDS.values())


def test_a_first_build_is_one_of_all_that_is_named() -> None:
    count, cpu = building.first_build(["TorqueSwitch"])
    assert count == 1
    assert cpu > 0


@pytest.mark.skipif(sys.platform != "linux", reason="glibc alone tells what is allocated")
def test_derivatives_take_memory_once_they_are_asked_for() -> None:
    body, reference = memory.measure("RigidBody"), memory.measure("FixedAxisReference")
    assert 1e3 < body.instance < 1e5
    assert 1e3 < body.derivatives < 1e5
    assert reference.derivatives == 0  # it has no inputs, and so no derivatives
