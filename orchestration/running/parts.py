"""The parts of a run from what its manifest says of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from orchestration.running.hooks.changes import Changes
from orchestration.running.hooks.inputs import Inputs
from orchestration.running.hooks.pace import Pace
from orchestration.running.hooks.until import Until
from orchestration.running.method import Method
from orchestration.running.save import Save

_HOOKS = (Changes, Inputs, Until, Pace)
_TIMES = ("start_time", "stop_time", "step")


def parts(settings: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the arguments of `run` that make the settings of a manifest, and what of those is not known here."""
    left = dict(settings)
    asked = {name: left.pop(name) for name in (*_TIMES, "fmi_version", "resume") if name in left}
    asked["method"], asked["save"] = Method.of_manifest(left), Save.of_manifest(left)
    asked["hooks"] = [hook for kind in _HOOKS for hook in kind.of_manifest(left)]
    return asked, left
