"""The engine and its DOP853, driven by a program, solve systems to the same bits on every machine, and as Python does.

The components are the binaries of their FMUs, the engine is compiled as for Python (solve.c).
"""

import zipfile
from functools import cache
from pathlib import Path

import pytest
import solve_program
from machines import HERE, MACHINES, TARGET, Machine
from test_platforms import or_skipped

from adcs import ModelExchange, System, run, systems
from benchmarks import loop
from fmus.build import build

SYSTEMS = {
    "rigid-body-pd": loop.system,
    "observer-pd": systems()["observer-pd"].build,
    "velocity-free-tracking": systems()["velocity-free-tracking"].build,
}


@cache
def system_of(name: str) -> System:
    return SYSTEMS[name]()


@cache
def solved_by_python(name: str) -> tuple[str, str]:
    """Digest of all rows (FNV-1a), and bits of the last one, as the program prints them."""
    stop = solve_program.STEP * (solve_program.ROWS - 1)
    method = ModelExchange(rtol=solve_program.RTOL)
    result = run(system_of(name), stop_time=stop, step=solve_program.STEP, method=method)
    assert result.data.shape[0] == solve_program.ROWS
    digest = 0xCBF29CE484222325
    for byte in result.data.astype("<f8").tobytes():
        digest = (digest ^ byte) * 0x100000001B3 & (1 << 64) - 1
    return f"{digest:016x}", " ".join(f"{bits:016x}" for bits in result.data[-1].astype("<f8").view("<u8").tolist())


@pytest.fixture(scope="session")
def delivered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """FMUs of all components of these systems, with the binaries of all platforms."""
    dist = tmp_path_factory.mktemp("delivered")
    components = {c.source for name in SYSTEMS for c in system_of(name).components.values()}
    build(sorted(components), all_platforms=True, dist=dist)
    return dist


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("machine", [or_skipped(m) for m in (HERE, *MACHINES) if m.target])
def test_every_machine_finds_the_same_solution(machine: Machine, name: str, delivered: Path, tmp_path: Path) -> None:
    target = TARGET[machine.target]
    binaries = []
    for component in system_of(name).components.values():
        member = f"binaries/{target.fmi2_folder}/{component.source}{target.suffix}"
        with zipfile.ZipFile(delivered / f"{component.source}.fmu") as fmu:
            library = fmu.extract(member, tmp_path / component.name)
        binaries.append(f"Z:{library}" if target.suffix == ".dll" else library)
    printed = machine.run(solve_program.program(system_of(name), target), *binaries)
    assert tuple(line.strip() for line in printed.splitlines()) == solved_by_python(name)
