"""Signals that ask a command to end: all of them as Ctrl-C does, with what there is written."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

last: int = signal.SIGINT
"""Which came last: a command that it ended ends with the code 128 + this."""

_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")


def _end(number: int, frame: FrameType | None) -> None:
    global last
    last = number
    raise KeyboardInterrupt


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
