"""Runs of a system of which one component does harm: `segfault_doStep` does the first in the second, from t = 0.5 s."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from adcs import System, write_ssp

ADCS = (sys.executable, "-P", "-m", "adcs")
ROOT = Path(__file__).parents[2]


def system(mock: Callable[..., Path], name: str, version: str = "2.0") -> System:
    made = System("hostile")
    made.add("source", mock("source", version))
    made.add(name, mock("hostile", version))
    return made


def as_file(mock: Callable[..., Path], folder: Path, name: str) -> Path:
    """The system as an SSP, for the command line."""
    path = folder / f"{name}.ssp"
    write_ssp(system(mock, name), path)
    return path


def start(*arguments: Any, cwd: Path, before: Callable[[], None] | None = None) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [*ADCS, *map(str, arguments)],
        cwd=cwd,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        preexec_fn=before,
    )


def adcs(*arguments: Any, cwd: Path, timeout: float = 120.0) -> tuple[int, str, str]:
    """Run the command in a process; return its exit code, and what it printed to the two outputs."""
    process = start(*arguments, cwd=cwd)
    out, err = process.communicate(timeout=timeout)
    return process.returncode, out, err


def until(condition: Callable[[], bool], timeout: float = 60.0) -> None:
    """Wait for something to come true."""
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)
