"""Work that may hang, or be interrupted, is done in another thread and watched from here."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from contextlib import suppress
from contextvars import copy_context
from functools import partial
from math import inf
from threading import Event, Thread
from time import monotonic
from typing import Any, TypeVar

Answer = TypeVar("Answer")

_LOOK = 0.05  # s, between two looks at Ctrl-C and at what is going on
_GRACE = 5.0  # s, for work that was told to stop


class Hung(Exception):
    """Nothing changed for too long; `doing` says what was going on, first the point, the component and the action."""

    def __init__(self, doing: Any) -> None:
        super().__init__(doing)
        self.doing = doing


class Watched:
    """Does work in a thread of its own, one piece after the other.

    KeyboardInterrupt is raised only when the piece that was going on has been stopped by `stop`; Hung when `doing`
    stayed the same for `timeout` seconds, unless that is nothing: its second and third item are empty. After Hung the
    thread is given up, and nothing it works on may be used: `lost` is True.
    """

    def __init__(self, doing: Callable[[], Any], stop: Callable[[], None] = lambda: None, timeout: float = inf) -> None:
        self.stop = stop
        self._doing, self._timeout = doing, timeout
        self._wanted, self._done = Event(), Event()
        self._work: Callable[[], Any] | None = None
        self._answer: Any = None
        self._error: BaseException | None = None
        self.interrupted = self.lost = False
        self._thread = Thread(target=self._serve, daemon=True, name="co-simulation")  # one that hangs must not hold us
        self._thread.start()

    def __call__(
        self, work: Callable[[], Answer], doing: Callable[[], Any] | None = None, *, throw: bool = False
    ) -> Answer:
        """Do a piece of work and return its answer; after an interrupt `interrupted` is True.

        `doing` says what is going on, where it is not what is watched usually. With `throw` an interrupt is raised
        within the work, which is pure Python, instead of `stop` being called.
        """
        doing = doing or self._doing
        self._work, self._error = partial(copy_context().run, work), None
        self._done.clear()
        self._wanted.set()
        seen, since = doing(), monotonic()
        patience = self._timeout
        while True:
            with suppress(KeyboardInterrupt):
                if self._done.wait(_LOOK):
                    break
                if (now := doing()) != seen or not any(now[1:3]):
                    seen, since = now, monotonic()
                elif monotonic() - since > patience:
                    self.lost = True
                    raise Hung(seen)
                continue
            self.interrupted = True
            if throw:
                self._throw()
            else:
                self.stop()
            patience, since = min(patience, _GRACE), monotonic()
        if self._error is not None:
            raise self._error
        answer: Answer = self._answer
        return answer

    def close(self) -> None:
        """Let the thread end."""
        self._work = None
        self._wanted.set()

    def _throw(self) -> None:
        """Raise KeyboardInterrupt in the thread, as the system does in the main one."""
        identity = ctypes.c_ulong(self._thread.ident or 0)
        ctypes.pythonapi.PyThreadState_SetAsyncExc(identity, ctypes.py_object(KeyboardInterrupt))

    def _serve(self) -> None:
        while True:
            with suppress(KeyboardInterrupt):  # one that came too late for its work
                self._wanted.wait()
                self._wanted.clear()
                if self._work is None:
                    return
                try:
                    self._answer = self._work()
                except BaseException as error:
                    self._error = error
                self._done.set()
                continue
            self._done.set()


class Unwatched:
    """Does work where it is called, for what is watched by nobody; `Watched` otherwise."""

    interrupted = False

    def __call__(self, work: Callable[[], Answer], doing: Callable[[], Any] | None = None) -> Answer:
        """Do it."""
        return work()
