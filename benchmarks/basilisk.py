"""The same task in Basilisk: plant at 100 Hz, control at 10 Hz, nothing recorded."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from adcs import AdcsError
from benchmarks.variants import Variant, compiled
from fmus.paths import BUILD

CONTROL_STEP = 0.1
COMPARED = (
    "Both integrate the rotation of a rigid body with fourth-order Runge-Kutta steps of 0.01 s and compute a torque "
    "every 0.1 s, which is held in between: here as an exchange step of 0.1 s with a max_internal_step of 0.01 s. "
    "Here the law is the quaternion PD law; Basilisk runs mrpFeedback without integral, attTrackingError and simpleNav "
    "at 10 Hz, spacecraft and extForceTorque at 100 Hz. Basilisk's spacecraft has three translational degrees of "
    "freedom more, which can not be switched off; it feels no force. Nothing is recorded on either side."
)
_SCRIPT = Path(__file__).with_name("basilisk_loop.py")
_ENVIRONMENT = BUILD / "basilisk"


@dataclass(frozen=True)
class Speed:
    """Simulated seconds per CPU second."""

    ours: float
    basilisk: float


def interpreter() -> Path:
    """A Python with Basilisk: this one, or that in build/basilisk; AdcsError if neither has it.

    An environment of its own because Basilisk wants older versions of packages that are needed here.
    """
    own = _ENVIRONMENT / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    for python in (Path(sys.executable), own):
        if python.is_file() and _call(python, "-c", "import Basilisk").returncode == 0:
            return python
    raise AdcsError(
        f"Basilisk is not installed, the comparison with it is skipped; to have it: "
        f"{sys.executable} -m venv {_ENVIRONMENT} && {own} -m pip install bsk"
    )


def compare(python: Path, seconds: float) -> Speed:
    """Run both once; Basilisk simulates so many seconds, the loop here fifty times as many."""
    done = _call(python, str(_SCRIPT), str(seconds))
    if done.returncode != 0:
        raise AdcsError(f"Basilisk failed: {(done.stderr.strip().splitlines() or ['without a message'])[-1]}")
    steps = round(50 * seconds / CONTROL_STEP)
    ours = Variant("compiled", "", 1.0, partial(compiled, step=CONTROL_STEP)).run(steps)
    return Speed(CONTROL_STEP / ours.cpu, json.loads(done.stdout)["simulated_s_per_cpu_s"])


def _call(python: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([str(python), *arguments], capture_output=True, text=True, check=False)
