"""The wheel, installed where neither this repository nor a compiler can be reached."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

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
    measured: dict[str, str] = field(default_factory=dict)

    @property
    def package(self) -> Path:
        (folder,) = self.environment.glob("lib/python3*/site-packages/fmus")
        return folder

    def adcs(self, *arguments: str | Path, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
        """Run the command in a folder, with nothing else on the path."""
        environment = {"HOME": str(self.home), "PATH": str(self.environment / "bin"), "CI": "1"}
        command = [self.environment / "bin" / "adcs", *arguments]
        return subprocess.run(
            command, cwd=folder or self.home, env=environment, capture_output=True, text=True, check=False, timeout=300
        )


@pytest.fixture(scope="session")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Installed]:
    if "ADCS_WHEEL" not in os.environ:
        pytest.skip("installs a wheel: make installed")
    wheel = Path(os.environ["ADCS_WHEEL"]).resolve()
    folder = tmp_path_factory.mktemp("installed")
    began = time.perf_counter()
    subprocess.run([sys.executable, "-m", "venv", folder / "environment"], check=True)
    made = time.perf_counter()
    pip = [folder / "environment" / "bin" / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, wheel], check=True, cwd=folder)
    done = time.perf_counter()
    (folder / "home").mkdir()
    found = Installed(wheel, folder / "environment", folder / "home")
    (found.package.parent / "adcs_guard.py").write_text(_GUARD)
    (found.package.parent / "adcs_guard.pth").write_text("import adcs_guard\n")
    size = sum(path.lstat().st_size for path in found.environment.rglob("*"))
    found.measured |= {
        "wheel": f"{wheel.stat().st_size / 1e6:.2f} MB",
        "environment with all that it needs": f"{size / 1e6:.0f} MB",
        "making the environment": f"{made - began:.1f} s",
        "pip install": f"{done - made:.1f} s",
    }
    yield found
    print("\n" + "\n".join(f"{what:36} {value:>8}" for what, value in found.measured.items()))
