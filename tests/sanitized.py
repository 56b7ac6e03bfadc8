"""Runs the tests of adaptor, components and stepping loop on the sanitized binaries of CMake's `sanitize` preset.

`make sanitize` builds them. An error of ASan or UBSan aborts the run. Leaks are looked for in tests/native, where
nothing of Python's is in the way.
"""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

from fmus.freshness import keep_record, read_record
from fmus.paths import BUILD, DIST

FOLDERS = ("binaries/linux64/", "binaries/x86_64-linux/")
TESTS = (
    "tests/adaptor",
    "tests/laws/test_every_law.py",
    "tests/orchestration/test_checkpoint.py",
    "tests/orchestration/test_cosimulation.py",
    "tests/orchestration/test_coupled.py",
    "tests/orchestration/test_files.py",
    "tests/orchestration/test_foreign_types.py",
    "tests/orchestration/test_live.py",
    "tests/orchestration/test_loops.py",
    "tests/orchestration/test_rates_and_delays.py",
    "tests/orchestration/test_tracking_loop.py",
)


def swap_binary(fmu: Path, to: Path, library: Path) -> None:
    """A copy of the FMU with another x86_64 Linux binary."""
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(to, "w", zipfile.ZIP_DEFLATED) as target:
        for member in source.namelist():
            is_binary = member.startswith(FOLDERS)
            target.writestr(member, library.read_bytes() if is_binary else source.read(member))


def main() -> int:
    libraries = BUILD / "cmake" / "sanitize"
    dist = libraries / "dist"
    dist.mkdir(exist_ok=True)
    for fmu in DIST.glob("*.fmu"):
        library = libraries / f"{fmu.name.split('.')[0]}.so"
        if library.exists():
            swap_binary(fmu, dist / fmu.name, library)
        else:  # not one of those that were built with sanitizers
            shutil.copyfile(fmu, dist / fmu.name)
        if (record := read_record(fmu)) is not None:
            keep_record(dist / fmu.name, record)
    compiler = os.environ.get("CXX", "c++")
    preload = [
        subprocess.check_output([compiler, f"-print-file-name={name}"], text=True).strip()
        for name in ("libasan.so", "libubsan.so")
    ]
    environment = os.environ | {
        "ADCS_DIST": str(dist),
        "ADCS_ENGINE": str(libraries / "engine.so"),
        "LD_PRELOAD": " ".join(preload),
        "ASAN_OPTIONS": "detect_leaks=0:halt_on_error=1",
        "UBSAN_OPTIONS": "print_stacktrace=1",
    }
    return subprocess.call(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-n", "auto", "--dist", "loadfile", *TESTS],
        env=environment,
    )


if __name__ == "__main__":
    sys.exit(main())
