"""Ground tools in a run from Python: `adcs.bridge`."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from adcs.cli.ground_tools import attached
from adcs.cli.options import GroundTools
from fmus.errors import AdcsError
from fmus.spelling import hint
from hil_bridge.ground.attach import Bridge
from orchestration import expected
from orchestration.system import System, check_system
from orchestration.times import Seconds


def bridge(system: System, *, step: Seconds | None = None, speed: float = 1.0, **options: Any) -> Bridge:
    """Return a hook that lets ground tools watch a run of this system, and a context manager that starts and ends it.

        with adcs.bridge(system, allow="param") as bridge:
            adcs.run(system, hooks=[adcs.pace(), bridge])

    `options` are those of `adcs bridge` by their names there: `to`, `remote`, `peer`, `allow`, `key`, `frame`, `epoch`,
    `position`, `map`, `show`, `rate`, `wheel_limit`, `tlog`. `step` is that of the run, if not the system's own, and
    `speed` that of its pace. What is allowed may rewire the system, so it is the one that is to be run.
    """
    check_system(system)
    known = [field.name for field in fields(GroundTools)]
    for name in options:
        if name not in known:
            raise AdcsError(f"bridge has no option {name!r}: {hint(name, known)}")
    start, _, given = system.run_times(None, 0.0, step)
    expected.number("speed", speed)
    made = attached(system, GroundTools(**options), step=given, start=start, speed=speed)
    assert isinstance(made, Bridge)
    return made
