"""Signals that ask a command to end: all of them as Ctrl-C does, with what there is written."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

last: int = signal.SIGINT
"""Which came last: a command that it ended ends with the code 128 + this."""

_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")


noted = False
"""Whether one came while what had to be finished was being finished."""

_SOON = 1.0  # s; what comes so soon after another one is the same wish
_at = -_SOON
_patient = False


def _end(number: int, frame: FrameType | None) -> None:
    global last, noted, _at
    last, before, _at = number, _at, time.monotonic()
    if _at - before < _SOON:
        return
    if _patient and not noted:
        noted = True
        return
    raise KeyboardInterrupt


@contextmanager
def patient() -> Iterator[None]:
    """Within it the first one is noted only, and what is short is finished; a second one, a while later, ends it."""
    global _patient, noted
    _patient, noted = True, False
    try:
        yield
    finally:
        _patient = False


@contextmanager
def heard() -> Iterator[None]:
    """Within it they raise KeyboardInterrupt; one that is ignored, as behind `nohup`, stays so."""
    before: dict[int, Any] = {}
    if threading.current_thread() is threading.main_thread():
        for name in _SIGNALS:
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) not in (signal.SIG_IGN, None):
                before[number] = signal.signal(number, _end)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
