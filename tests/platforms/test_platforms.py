"""All components compute the same bits on every machine; each runs where its emulator is installed.

The digest program (digest.cpp) drives the components. It also loads the binaries of FMUs and drives those in the same
way, which ties what is shown of the program to what is delivered.
"""

import subprocess
import zipfile
from pathlib import Path

import digest_program
import pytest
from lxml import etree
from machines import FMA_HIDDEN, HASWELL, HERE, MACHINES, TARGET, Machine, found, processor_features

from fmus import fmu_path
from fmus.build import build
from fmus.paths import FMI_HEADERS

SAMPLED = ("FixedAxisReference", "PdTracking", "RigidBody", "SmoothRateObserver", "StarTracker", "BacksteppingControl")
"""One of every kind: the binaries of FMUs have the adaptor, too, and that is the same in all."""


def or_skipped(machine: Machine) -> object:
    """Skipped before anything is compiled for it, which takes minutes."""
    return pytest.param(
        machine, marks=pytest.mark.skipif(bool(machine.missing), reason=machine.missing), id=machine.name
    )


def by_component(printed: str) -> dict[str, str]:
    """What the program printed about each component: digest, number of values, scenarios that came to their end."""
    return dict(line.split(" ", 1) for line in printed.splitlines())


def last_line(printed: str) -> str:
    return printed.splitlines()[-1]


@pytest.fixture(scope="session")
def programs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The digest programs made so far, by machine."""
    return {}


def run(machine: Machine, programs: dict[str, Path], folder: Path, *arguments: str) -> str:
    if machine.name not in programs:
        programs[machine.name] = machine.made(folder)
    return machine.run(programs[machine.name], *arguments)


@pytest.fixture(scope="session")
def expected(programs: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    if HERE.missing:
        pytest.skip(HERE.missing)
    return by_component(run(HERE, programs, tmp_path_factory.mktemp("here")))


@pytest.fixture(scope="session")
def everywhere(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """FMUs with the binaries of all platforms."""
    dist = tmp_path_factory.mktemp("dist")
    build(SAMPLED, all_platforms=True, dist=dist)
    return dist


def test_every_component_is_driven(expected: dict[str, str]) -> None:
    assert list(expected) == [component.name for component in digest_program.driven()]
    digests, counts, ends = zip(*(line.split() for line in expected.values()), strict=True)
    assert len(set(digests)) == len(expected)
    assert min(map(int, counts)) > 5000
    assert min(map(int, ends)) >= 4  # of 12 scenarios: laws can leave their domain when driven at random


@pytest.mark.parametrize("machine", [or_skipped(m) for m in MACHINES])
def test_all_components_compute_the_same_bits(
    machine: Machine, expected: dict[str, str], programs: dict[str, Path], tmp_path: Path
) -> None:
    assert by_component(run(machine, programs, tmp_path)) == expected


@pytest.mark.parametrize("machine", [or_skipped(m) for m in (HERE, *MACHINES) if m.target])
def test_binaries_of_fmus_compute_what_the_program_does(
    machine: Machine, expected: dict[str, str], everywhere: Path, programs: dict[str, Path], tmp_path: Path
) -> None:
    target = TARGET[machine.target]
    for name in SAMPLED:
        member = f"binaries/{target.fmi2_folder}/{name}{target.suffix}"
        with zipfile.ZipFile(everywhere / f"{name}.fmu") as fmu:
            library = fmu.extract(member, tmp_path / name)
        path = f"Z:{library}" if target.suffix == ".dll" else library
        assert last_line(run(machine, programs, tmp_path, name, path)) == f"{name} {expected[name]}"


@pytest.mark.skipif(found("g++") is None, reason="g++ is not installed")
@pytest.mark.parametrize("flags", ["as described", "-O3 -march=haswell -ffp-contract=fast"])
def test_sources_in_an_fmu_give_the_same_bits(
    flags: str, expected: dict[str, str], programs: dict[str, Path], tmp_path: Path
) -> None:
    """Compiled by GCC as the FMU says, and as somebody would who knows nothing and has a processor with FMA."""
    if "haswell" in flags and not processor_features().issuperset(HASWELL):
        pytest.skip(f"the processor has not all of {', '.join(HASWELL)}")
    name = "FixedAxisReference"
    with zipfile.ZipFile(fmu_path(name)) as fmu:
        fmu.extractall(tmp_path, [n for n in fmu.namelist() if n.startswith("sources/")])
    sources, library = tmp_path / "sources", tmp_path / f"{name}.so"
    description = etree.parse(sources / "buildDescription.xml")
    options = description.find(".//SourceFileSet").get("compilerOptions") if flags == "as described" else flags
    files = [sources / file.get("name") for file in description.iter("SourceFile")]
    includes = [f"-I{sources}", f"-I{FMI_HEADERS}"]
    command = ["g++", "-std=c++17", *options.split(), "-shared", "-fPIC", *includes, *files, "-o", library]
    subprocess.run(command, check=True)
    assert last_line(run(HERE, programs, tmp_path, name, str(library))) == f"{name} {expected[name]}"


def test_the_c_library_does_not_compute_the_same_bits(tmp_path: Path) -> None:
    """So the comparison with FMA hidden from it can fail: it did, for six of the fifteen components that used it."""
    if HERE.missing or "fma" not in processor_features():
        pytest.skip(HERE.missing or "the processor has no FMA")
    libm = digest_program.small_program(Path(__file__).with_name("libm.cpp"))
    assert HERE.run(libm) != Machine("hidden", HERE.made, environment=FMA_HIDDEN).run(libm)
