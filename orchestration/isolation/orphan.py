"""A process that was started by another one ends with it."""

from __future__ import annotations

import os
import signal
import time
from threading import Thread

_LOOK = 0.2  # s


def end_with_parent() -> None:
    """When the process that started this one is gone, tell this one to end, as SIGTERM does."""
    if os.name != "posix":
        return
    parent = os.getppid()

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(_LOOK)
        os.kill(os.getpid(), signal.SIGTERM)

    Thread(target=watch, daemon=True, name="parent").start()
