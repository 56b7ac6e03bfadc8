"""A process that was started by another one ends with it."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from threading import Thread
from typing import Any

_LOOK = 0.2  # s
_GRACE = 10.0  # s


def end_with_parent(busy: Callable[[], Any]) -> None:
    """When the process that started this one is gone, tell this one to end, as SIGTERM does.

    `busy` returns in which call it is, or nothing. If it stays in one for 10 s after that, the call hangs and nobody is
    there to give it up: the process ends.
    """
    if os.name != "posix":
        return
    parent = os.getppid()

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(_LOOK)
        os.kill(os.getpid(), signal.SIGTERM)
        seen, since = busy(), time.monotonic()
        while True:
            time.sleep(_LOOK)
            if (now := busy()) != seen or not now:
                seen, since = now, time.monotonic()
            elif time.monotonic() - since > _GRACE:
                os._exit(128 + signal.SIGTERM)

    Thread(target=watch, daemon=True, name="parent").start()
