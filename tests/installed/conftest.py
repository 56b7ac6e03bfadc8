"""The wheel, installed where neither this repository nor a compiler can be reached."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

import fmus
from tests.installed.table import Table

ROOT = Path(__file__).parents[2]

_GUARD = f"""
import sys


def watch(event, arguments):
    if event in ("open", "os.listdir", "os.scandir", "ctypes.dlopen") and str(arguments[0]).startswith({str(ROOT)!r}):
        raise RuntimeError(f"{{event}} reaches into the repository: {{arguments[0]}}")
    if event == "subprocess.Popen" and str(arguments[0]).rpartition("/")[2] in ("zig", "cc", "c++", "gcc", "clang"):
        raise RuntimeError(f"a compiler is called: {{arguments[1]}}")


sys.addaudithook(watch)
"""


@dataclass
class Installed:
    """An environment, an empty folder, and what was measured."""

    wheel: Path
    environment: Path
    home: Path
    cache: Path
    """Of pip, filled."""
    measured: Table = field(default_factory=Table)
    took: float = 0.0
    """Time to make it, with the packages in pip's cache (s)."""

    @property
    def package(self) -> Path:
        (folder,) = self.environment.glob("lib/python3*/site-packages/fmus")
        return folder

    @property
    def variables(self) -> dict[str, str]:
        return {"HOME": str(self.home), "PATH": str(self.environment / "bin"), "CI": "1"}

    def adcs(self, *arguments: str | Path, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
        """Run the command in a folder, with nothing else on the path."""
        command = [self.environment / "bin" / "adcs", *arguments]
        return subprocess.run(
            command,
            cwd=folder or self.home,
            env=self.variables,
            capture_output=True,
            text=True,
            check=False,
            timeout=300,
        )


@pytest.fixture(scope="session")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Installed]:
    if "ADCS_WHEEL" not in os.environ:
        pytest.skip("installs a wheel: make installed")
    wheel = Path(os.environ["ADCS_WHEEL"]).resolve()
    folder = tmp_path_factory.mktemp("installed")
    empty = make_environment(folder / "first", wheel, folder / "cache")
    shutil.rmtree(folder / "first")
    warm = make_environment(folder / "environment", wheel, folder / "cache")
    (folder / "home").mkdir()
    found = Installed(wheel, folder / "environment", folder / "home", folder / "cache", took=warm)
    (found.package.parent / "adcs_guard.py").write_text(_GUARD)
    (found.package.parent / "adcs_guard.pth").write_text("import adcs_guard\n")
    size = sum(path.lstat().st_size for path in found.environment.rglob("*"))
    count, megabytes = len(fmus.components()), wheel.stat().st_size / 1e6
    found.measured.add("components", count)
    found.measured.add("wheel", megabytes, "MB", aim=4)
    found.measured.add("wheel, for each component", megabytes / count, "MB", aim=0.2)
    found.measured.add("environment with all that it needs", size / 1e6, "MB", aim=500)
    found.measured.add("making it, with an empty cache", empty, "s")
    found.measured.add("making it, with the packages in pip's cache", warm, "s")
    yield found
    print(f"\n{found.measured}")


def make_environment(environment: Path, wheel: str | Path, cache: Path, *more: str) -> float:
    """Make an environment with the wheel and more packages in it; return how long it took (s)."""
    began = time.perf_counter()
    subprocess.run([sys.executable, "-m", "venv", environment], check=True)
    pip = [environment / "bin" / "python", "-m", "pip", "--quiet", "--disable-pip-version-check", "--cache-dir", cache]
    subprocess.run([*pip, "install", wheel, *more], check=True, cwd=environment)
    return time.perf_counter() - began
