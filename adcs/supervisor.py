"""Starts a run as a process of its own and waits for it: should it die, its rows are made into files by another one.

This process loads no component and nothing large: it is not harmed by what a run does, and costs it nothing.
"""

from __future__ import annotations

import json
import mmap
import os
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

MARK = "ADCS_SUPERVISED"
IN_PROCESS = "--in-process"

_LOOK = 0.5  # s, between two looks at where the run is
_GRACE = 10.0  # s, longer than the run's own watchdog needs to give a call up and to begin to write
_EXIT = 5.0  # s, for a process to end that has said that it is done


def wanted(arguments: Sequence[str], environment: Mapping[str, str]) -> bool:
    """Whether this command line is for a run in a process of its own."""
    return arguments[:1] == ["run"] and MARK not in environment and not {IN_PROCESS, "--help"} & set(arguments)


def supervise(arguments: Sequence[str]) -> int:
    """Run; return the exit code."""
    folder = Path(tempfile.mkdtemp(prefix=f"adcs-run-{os.getpid()}-"))
    try:
        return _Run(folder, arguments).end()
    finally:
        shutil.rmtree(folder, ignore_errors=True)


class _Run:
    def __init__(self, folder: Path, arguments: Sequence[str]) -> None:
        self._folder = folder
        self._asked = 0  # the signal by which someone asked it to end
        self._asked_at = 0.0
        self._hung = 0.0  # s, for which a call has not returned
        self._resumed = 0.0  # when this process went on after Ctrl-Z
        own: dict[str, Any] = {} if sys.platform == "win32" else {"process_group": 0}  # signals go through here
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "adcs.child", *arguments],
            stdin=subprocess.DEVNULL,
            env={**os.environ, MARK: str(folder), "TMPDIR": str(folder)},
            **own,
        )
        self._listen()
        threading.Thread(target=self._watch, daemon=True).start()

    def end(self) -> int:
        """Wait for its end, and see to what it has left undone."""
        code = self._process.wait()
        done = self._read("done")
        print(self._read("said") or "", end="", flush=True)
        if done is not None:
            return int(done)
        with suppress(OSError):
            printed = (self._folder / "printed").read_bytes()
            os.write(2, printed)
        watch = self._read("watch")
        if watch is None or not Path(json.loads(watch)["journal"]).exists():
            if self._asked:
                return 128 + self._asked
            print(f"adcs: the process of the run ended before it began, with code {code}", file=sys.stderr)
            return 1
        results = str(Path(json.loads(watch)["journal"]).parent)
        command = [sys.executable, "-P", "-m", "adcs", "recover", results, "--ended-with", str(code)]
        if self._hung:
            command += ["--hung", f"{self._hung:g}"]
        recovered = subprocess.call(command, stdin=subprocess.DEVNULL)
        return 128 + self._asked if self._asked and recovered else recovered

    def _listen(self) -> None:
        """Hand on what is asked of this process."""
        for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK"):
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, self._hand_on)
        if sys.platform != "win32":
            signal.signal(signal.SIGTSTP, self._stop)

    def _hand_on(self, number: int, frame: object) -> None:
        self._asked, self._asked_at = number, self._asked_at or time.monotonic()
        if sys.platform != "win32":  # where it gets the same from the terminal
            with suppress(OSError):
                self._process.send_signal(number)

    def _stop(self, number: int, frame: object) -> None:
        """Ctrl-Z: the run stops, too, and goes on when this process does."""
        if sys.platform == "win32":  # which knows no such thing
            return
        self._process.send_signal(signal.SIGSTOP)
        os.kill(os.getpid(), signal.SIGSTOP)
        self._resumed = time.monotonic()
        self._process.send_signal(signal.SIGCONT)

    def _watch(self) -> None:
        """End a process whose own watchdog cannot: it is stuck in a call, or after it was done."""
        seen, since = b"", time.monotonic()
        pulse, beat = self._read("pulse"), since
        while self._process.poll() is None:
            time.sleep(_LOOK)
            now = time.monotonic()
            beat = max(beat, self._resumed)
            if (found := self._read("pulse")) != pulse:
                pulse, beat = found, now
            if self._read("done") is not None:
                time.sleep(_EXIT)
                self._process.kill()
                return
            place, patience = self._place()
            if place != seen or not place:
                seen, since = place, now
            asked = self._asked_at and now - self._asked_at > _GRACE and now - since > _GRACE
            frozen = pulse is not None and now - beat > patience + _GRACE  # as a lock of the loader does it, or SIGSTOP
            if asked or frozen or now - since > patience + _GRACE:
                self._hung = now - (beat if frozen else since)
                self._process.kill()
                return

    def _place(self) -> tuple[bytes, float]:
        """Where the run is, empty where it is in no component; and how long it may stay there (s)."""
        text = self._read("watch")
        if text is None:
            return b"", float("inf")
        watch = json.loads(text)
        patience = float("inf") if watch["timeout"] is None else float(watch["timeout"])
        with suppress(OSError, ValueError), Path(watch["journal"]).open("rb") as file:
            with mmap.mmap(file.fileno(), watch["at"] + watch["size"], access=mmap.ACCESS_READ) as journal:
                place = journal[watch["at"] : watch["at"] + watch["size"]]
            if struct.unpack_from("<i", place, watch["doing"])[0] != watch["idle"]:
                return place, patience
        return b"", patience

    def _read(self, name: str) -> str | None:
        with suppress(OSError):
            return (self._folder / name).read_text(encoding="utf-8")
        return None
