"""A run in a process of its own: `run(..., isolated=True)`. What is asked for crosses as a pickle, rows as a journal.

The other process is `python -m orchestration.running.child FOLDER`.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from orchestration.isolation import journal
from orchestration.isolation.death import found, reason
from orchestration.process.temporary import temporary_folder
from orchestration.results import hdf5
from orchestration.results.manifest import row_times
from orchestration.results.result import Result, RunFailed, RunInterrupted
from orchestration.results.stored import FileResult, mark_of

ASKED, ANSWER = "asked", "answer"  # files in the folder
_LOOK = 0.05  # s, between two looks at the other process
_GRACE = 10.0  # s, for it to end after Ctrl-C


def run_apart(asked: Mapping[str, Any]) -> Result:
    """Run what `orchestration.running.run.run` was asked to; refuse by name what cannot cross to another process."""
    settings = {name: value for name, value in asked.items() if name not in ("isolated", "progress")}
    for hook in asked["hooks"]:
        if not hook.repeatable:
            kind = type(hook).__name__
            raise AdcsError(f"hooks: {kind} is part of this process, and cannot take part in an isolated run")
    save, file = asked["save"], asked["save"].to
    if isinstance(file, journal.Journal):
        raise AdcsError("save: an isolated run has a journal of its own")
    if file is not None:
        hdf5.check(Path(file), {})
        settings["save"] = replace(save, to=None)
    for name, value in settings.items():
        try:
            pickle.dumps(value)
        except Exception as error:
            raise AdcsError(f"{name}: it cannot cross to the process of an isolated run ({error})") from error
    with temporary_folder("isolated") as place:
        (place / ASKED).write_bytes(pickle.dumps(settings))
        code = _serve(place, asked["progress"])
        result, failed = _answer(asked, place, code)
    if file is not None:
        result, failed = _to_file(result, Path(file), failed)
    if failed is not None:
        raise failed
    return result


def _serve(place: Path, progress: Any) -> int:
    """Let the other process run; return the code it ended with."""
    # not in our group: Ctrl-C is for us, and handed on
    apart: dict[str, Any] = {"process_group": 0} if os.name == "posix" else {}
    command = [sys.executable, "-P", "-m", "orchestration.running.child", str(place)]
    environment = os.environ | {"TMPDIR": str(place)}  # what it leaves there goes with the folder
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, env=environment, **apart)
    try:
        while True:
            try:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    return process.wait(_LOOK)
                if progress is not None:
                    with contextlib.suppress(AdcsError):
                        kept = journal.read(place / journal.NAME)
                        progress(len(kept.times) / max(1, kept.capacity))
            except KeyboardInterrupt:
                if os.name == "posix":
                    process.send_signal(signal.SIGINT)
                with contextlib.suppress(subprocess.TimeoutExpired):
                    return process.wait(_GRACE)
                process.kill()
                return process.wait()
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()


def _answer(asked: Mapping[str, Any], place: Path, code: int) -> tuple[Result, RunFailed | RunInterrupted | None]:
    """Return what came of it, and what is to be raised."""
    path = place / journal.NAME
    if not (place / ANSWER).exists():
        if not path.exists():
            raise AdcsError(f"the process of the isolated run ended before it began, with code {code}")
        left = found(path, code)
        left.result.system = asked["system"]
        result = _detached(left.result)
        if left.failed is None:
            return result, None
        if left.failed.time is None:
            raise left.failed
        return result, RunFailed(left.message, result)
    answer = pickle.loads((place / ANSWER).read_bytes())
    if "refused" in answer:
        raise answer["refused"]
    kept = journal.read(path)
    n = answer["rows"]
    times = row_times(kept.times[:n], answer["manifest"])
    result = Result(asked["system"], times, kept.data[:n], kept.ports, answer["manifest"])
    result.states, result.state_names = answer["states"], answer["state_names"]
    result = _detached(result)
    if answer["failed"] is not None:
        return result, RunFailed(answer["failed"], result)
    return result, RunInterrupted(result) if answer["interrupted"] else None


def _detached(result: Result) -> Result:
    """The result without its file, which goes: a mapping stays on POSIX."""
    if os.name != "posix":
        result.time, result.data = np.array(result.time), np.array(result.data)
    return result


def _to_file(
    result: Result, path: Path, failed: RunFailed | RunInterrupted | None
) -> tuple[Result, RunFailed | RunInterrupted | None]:
    """Return the result with its values in a file, and what is to be raised; without room they stay in memory."""
    try:
        result.write_hdf5(path)
    except AdcsError as error:
        outcome, rows = result.manifest["outcome"], len(result.time)
        if isinstance(failed, RunInterrupted):
            result.manifest["warnings"].append(str(error))
            return result, failed
        why = "" if failed is None else f"{reason(outcome)}; "
        if failed is None:
            last = float(result.time[-1]) if rows else result.manifest["settings"]["start_time"]
            outcome = {"status": "failed", "component": None, "time": last, "message": str(error), "rows": rows}
            result.manifest["outcome"] = outcome
        return result, RunFailed(f"{why}{error}; {rows} rows are kept", result)
    written = FileResult(result.system, np.array(result.time), result.data[:0], result.ports, result.manifest)
    written.path, written.mark = path, mark_of(path)
    if failed is not None:
        failed.result = written
    return written, failed
