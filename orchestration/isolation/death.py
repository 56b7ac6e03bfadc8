"""What the end of a process makes of its run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fmus.process_end import how
from orchestration.instances.instance import CallFailed
from orchestration.isolation import journal
from orchestration.isolation.journal import Kept
from orchestration.results.manifest import completed, row_times
from orchestration.results.result import Result
from orchestration.system import System


def failure(kept: Kept, code: int | None) -> CallFailed:
    """Say which call of which component ended the process, and when."""
    k, component, action = kept.where.now
    what = f"{action} ended the process: {how(code)}" if action else f"the process ended: {how(code)}"
    failed = CallFailed(component or "the run", what)
    settings = kept.about["manifest"]["settings"]
    if kept.where.place.started:
        coupled = settings["method"] == "model-exchange"
        last = float(kept.times[-1]) if len(kept.times) else float(settings["start_time"])
        failed.time = last if coupled else min(settings["start_time"] + k * settings["step"], settings["stop_time"])
    return failed


@dataclass(frozen=True)
class Found:
    """What is left of a run. `failed` is None where all rows are there: then the process ended at its very end."""

    result: Result
    failed: CallFailed | None
    about: dict[str, Any]

    @property
    def message(self) -> str:
        """What to say of it, if it failed."""
        return f"{reason(self.result.manifest['outcome'])}; {len(self.result.time)} rows are kept"


def reason(outcome: Mapping[str, Any]) -> str:
    """Say why a run failed, of which this is the outcome."""
    failed = CallFailed(outcome["component"] or "", outcome["message"])
    failed.time = outcome["time"]
    return str(failed) if failed.component else failed.text


def found(path: Path, code: int | None, hung: float | None = None) -> Found:
    """Return what a journal tells of a run whose process ended with a code, or since it hung for some time (s)."""
    kept = journal.read(path)
    manifest: dict[str, Any] = kept.notes or kept.about["manifest"]
    manifest.setdefault("warnings", [])
    manifest.setdefault("timing", {})
    about = manifest["system"]
    system = System(about["name"], about["description"])
    failed = failure(kept, code)
    if kept.failure:  # before the process ended, which is no news then
        failed = CallFailed(kept.failure["component"] or "", kept.failure["message"])
        failed.time = kept.failure["time"]
    elif hung is not None:
        failed.text = f"{kept.where.now[2] or 'it'} did not return within {hung:.3g} s, and its process was ended"
    rows, times = len(kept.data), row_times(kept.times, manifest)
    if kept.where.place.finished:
        manifest["warnings"].append(f"{failed.component}: {failed.text}; all rows are there")
        manifest["outcome"] = {**completed(manifest), "rows": rows}
    else:
        manifest["outcome"] = {
            "status": "failed",
            "component": failed.component or None,
            "time": failed.time,
            "message": failed.text,
            "rows": rows,
        }
    result = Result(system, times, kept.data, kept.ports, manifest)
    return Found(result, None if kept.where.place.finished else failed, kept.about)
