"""Binaries for other platforms compute what the native ones do; each runs where its emulator is installed.

Debian: apt-get install wine64 qemu-user libc6-arm64-cross
"""

import platform
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from fmpy import read_model_description

from fmus import fmu_path
from fmus.build import build
from fmus.toolchain import FMI_HEADERS, TARGETS, Target

COMPONENTS = ("FixedAxisReference", "PdTracking", "RigidBody", "SmoothRateObserver", "StarTracker")
STEPS, STEP = 200, 0.05
LIBM = {
    "FixedAxisReference": 5e-16
}  # its sin, cos and exp are the platform's, which may round the last bit differently


class Emulator(NamedTuple):
    target: str
    command: tuple[str, ...]
    needs: tuple[str, ...]


EMULATORS = [
    Emulator("x86_64-windows", ("wine64",), ("wine64",)),
    Emulator(
        "aarch64-linux",
        ("qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"),
        ("qemu-aarch64", "/usr/aarch64-linux-gnu/lib"),
    ),
]


@pytest.fixture(scope="session")
def everywhere(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """FMUs with the binaries of all platforms: one of each kind, for a platform is a matter of the adaptor."""
    dist = tmp_path_factory.mktemp("dist")
    build(COMPONENTS, all_platforms=True, dist=dist)
    return dist


def runner(target: Target, folder: Path) -> Path:
    output = folder / f"runner-{target.name}{'.exe' if 'windows' in target.name else ''}"
    source = Path(__file__).with_name("runner.c")
    command = ["-target", target.triple, "-O1", f"-I{FMI_HEADERS}", str(source), "-o", str(output)]
    subprocess.run(
        [sys.executable, "-m", "ziglang", "cc", *command, *(() if "windows" in target.name else ("-ldl",))], check=True
    )
    return output


def scenario(name: str) -> list[str]:
    """Random inputs, parameters that bring every branch of the component to life, and all outputs."""
    description = read_model_description(str(fmu_path(name)))
    rng = np.random.default_rng(5)
    values, outputs = [], []
    quaternion = [0.5, -0.5, 0.5, 0.5]
    for v in description.modelVariables:
        if v.causality == "output":
            outputs.append(str(v.valueReference))
        if v.name.startswith("q_") and v.start is not None:
            values.append(f"{v.valueReference}={quaternion[int(v.name[-2]) - 1]!r}")
        elif v.causality == "input" or (v.name.startswith("omega_") and v.start is not None):
            values.append(f"{v.valueReference}={rng.uniform(-0.2, 0.2)!r}")
        elif v.name == "half_angle":
            values.append(f"{v.valueReference}=0.01")
    return [str(description.guid), str(STEP), str(STEPS), *values, "--", *outputs]


def run(
    command: tuple[str, ...], program: Path, fmu: Path, target: Target, folder: Path, arguments: list[str]
) -> np.ndarray:
    member = f"binaries/{target.fmi2_folder}/{fmu.stem}{target.suffix}"
    with zipfile.ZipFile(fmu) as archive:
        library = Path(archive.extract(member, folder / fmu.stem))
    path = f"Z:{library}" if target.suffix == ".dll" else str(library)
    result = subprocess.run(
        [*command, str(program), path, *arguments], capture_output=True, text=True, timeout=120, check=False
    )
    assert result.returncode == 0, result.stderr
    bits = [[int(word, 16) for word in line.split()] for line in result.stdout.splitlines()]
    return np.array(bits, np.uint64).view(np.float64)


def missing(emulator: Emulator) -> list[str]:
    places = (shutil.which, lambda n: Path(n).exists(), lambda n: Path("/usr/lib/wine", n).exists())
    return [n for n in emulator.needs if not any(place(n) for place in places)]


def or_skipped(emulator: Emulator) -> object:
    """Skipped before the FMUs of all platforms are built for it, which takes minutes."""
    reason = f"{', '.join(missing(emulator))} is not installed"
    return pytest.param(emulator, marks=pytest.mark.skipif(bool(missing(emulator)), reason=reason), id=emulator.target)


@pytest.mark.skipif(
    platform.system() != "Linux" or platform.machine() != "x86_64", reason="the emulators run on x86_64 Linux"
)
@pytest.mark.parametrize("emulator", [or_skipped(e) for e in EMULATORS])
def test_outputs_equal_the_native_ones(emulator: Emulator, everywhere: Path, tmp_path: Path) -> None:
    found = shutil.which(emulator.command[0]) or str(Path("/usr/lib/wine", emulator.command[0]))
    command = (found, *emulator.command[1:])
    targets = {t.name: t for t in TARGETS}
    foreign, native = targets[emulator.target], targets["x86_64-linux"]
    programs = {t.name: runner(t, tmp_path) for t in (foreign, native)}
    for name in COMPONENTS:
        fmu, arguments = everywhere / f"{name}.fmu", scenario(name)
        expected = run((), programs[native.name], fmu, native, tmp_path, arguments)
        got = run(command, programs[foreign.name], fmu, foreign, tmp_path, arguments)
        assert expected.shape[0] == STEPS + 1
        assert np.abs(expected).max() > 0
        np.testing.assert_allclose(got, expected, rtol=0, atol=LIBM.get(name, 0), err_msg=name)
