"""What an FMU may change for the whole process, or for the thread that calls it: compared, changed back, reported."""

from __future__ import annotations

import ctypes
import errno
import locale
import os
import signal
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Protocol

from fmus.errors import AdcsError

_KEPT_FROM = 200  # descriptors that are kept aside are moved here, out of the way of one that closes "all" of them

_DESCRIPTORS = "file descriptors of this process"


class Floats(Protocol):
    """The floating-point control of the calling thread."""

    def control(self) -> int:
        """Return it."""
        ...

    def restore(self, value: int) -> list[str]:
        """Put it back; say what was changed."""
        ...


class Guard:
    """Looks after the process during a run; `close` it at the end.

    `changes` says who has changed what, each once: pairs of a component, empty if it is not known, and a sentence.
    `printed`, if given, is asked for what came to the standard output.
    """

    def __init__(self, floats: Floats | None = None, printed: Callable[[], bool] | None = None) -> None:
        self.changes: list[tuple[str, str]] = []
        self._floats, self._printed = floats, printed
        self._control = 0 if floats is None else floats.control()
        self._folder = _cwd()
        self._locale = locale.setlocale(locale.LC_ALL)
        self._umask = _umask()
        self._handlers = _Handlers()
        self._standard = _Standard()
        self._limits = _Limits()
        self._descriptors = _Descriptors()

    def close(self) -> None:
        """Give back what was kept for changing things back."""
        self._standard.close()
        self._descriptors.close()

    def thread(self, component: str) -> None:
        """After a call: look at the thread that made it."""
        if self._floats is not None and self._floats.control() != self._control:
            for what in self._floats.restore(self._control):
                self._tell(component, f"changed {what}, which was changed back")

    def check(self, component: str = "") -> None:
        """Look at the process."""
        self.thread(component)
        if (folder := _cwd()) != self._folder:
            with suppress(OSError):
                os.chdir(self._folder)
            self._tell(component, f"changed the working directory to {folder}, which was changed back")
        if (chosen := locale.setlocale(locale.LC_ALL)) != self._locale:
            locale.setlocale(locale.LC_ALL, self._locale)
            self._tell(component, f"changed the locale to {chosen}, which was changed back")
        if self._umask is not None and (mask := os.umask(self._umask)) != self._umask:
            self._tell(component, f"changed the umask to {mask:03o}, which was changed back")
        for name in self._handlers.restore():
            self._tell(component, f"took {name} for itself, which was given back")
        for name, back in self._limits.restore():
            self._tell(
                component, f"changed the limit {name}, which {'was changed back' if back else 'only root can undo'}"
            )
        if self._descriptors.closed():
            self._tell(component, f"closed {_DESCRIPTORS} that were not its own")
        for name in self._standard.restore():
            self._tell(component, f"closed the standard {name}, which was opened again")
        if self._printed is not None and self._printed():
            self._tell(component, "prints to the standard output, which was sent to the standard error instead")

    def _tell(self, component: str, text: str) -> None:
        if (component, text) not in self.changes:
            self.changes.append((component, text))

    def warnings(self, foreign: Sequence[str]) -> list[str]:
        """Return the changes as sentences; where one component was not built here, it is the one."""
        unknown = foreign[0] if len(foreign) == 1 else "a component"
        return list(dict.fromkeys(f"{component or unknown}: {text}" for component, text in self.changes))


def _cwd() -> str:
    try:
        return str(Path.cwd())
    except OSError:  # it was removed
        return ""


def _umask() -> int | None:
    if sys.platform == "win32":  # has one, which nothing but this process's own files go by
        return None
    mask = os.umask(0o077)
    os.umask(mask)
    return mask


_LIMITS = {errno.EFBIG: "RLIMIT_FSIZE", errno.EMFILE: "RLIMIT_NOFILE", errno.EBADF: _DESCRIPTORS}


def is_of_this_process(error: AdcsError) -> bool:
    """Whether a file could not be written for what this process may, and not for lack of room."""
    return isinstance(error.__cause__, OSError) and error.__cause__.errno in _LIMITS


def explained(error: AdcsError, warnings: Iterable[str]) -> str:
    """Put into words that a file could not be written, with which component has brought that about, if one has."""
    number = error.__cause__.errno if isinstance(error.__cause__, OSError) else None
    sign = _LIMITS.get(number or 0)
    blame = [text for text in warnings if sign is not None and sign in text]
    return f"{error} ({blame[0]})" if blame else str(error)


class _Handlers:
    """What happens at the signals that end a run."""

    _NAMES = ("SIGINT", "SIGTERM", "SIGHUP")

    def __init__(self) -> None:
        self._get, self._set = ctypes.pythonapi.PyOS_getsig, ctypes.pythonapi.PyOS_setsig
        self._get.restype = self._set.restype = ctypes.c_void_p
        self._get.argtypes, self._set.argtypes = (ctypes.c_int,), (ctypes.c_int, ctypes.c_void_p)
        known = {name: getattr(signal, name) for name in self._NAMES if hasattr(signal, name)}
        self._at_first = {name: (number, self._get(number)) for name, number in known.items()}

    def restore(self) -> list[str]:
        changed = []
        for name, (number, handler) in self._at_first.items():
            if self._get(number) != handler:
                self._set(number, handler)
                changed.append(name)
        return changed


class _Limits:
    """Limits of the process that decide whether its files can be written."""

    _NAMES = ("RLIMIT_AS", "RLIMIT_DATA", "RLIMIT_FSIZE", "RLIMIT_NOFILE", "RLIMIT_CPU")

    def __init__(self) -> None:
        self._at_first: dict[str, tuple[int, tuple[int, int]]] = {}
        if sys.platform != "win32":  # which has none
            import resource

            self._get, self._set = resource.getrlimit, resource.setrlimit
            known = {name: getattr(resource, name) for name in self._NAMES if hasattr(resource, name)}
            self._at_first = {name: (number, self._get(number)) for name, number in known.items()}

    def restore(self) -> list[tuple[str, bool]]:
        """Name what was changed, and whether that is undone."""
        changed: list[tuple[str, bool]] = []
        if sys.platform == "win32":
            return changed
        for name, (number, (soft, hard)) in self._at_first.items():
            if (now := self._get(number)) != (soft, hard):
                try:
                    self._set(number, (soft, hard))
                except (ValueError, OSError):  # only root may raise a hard limit
                    with suppress(ValueError, OSError):
                        self._set(number, (now[1], now[1]))
                changed.append((name, self._get(number) == (soft, hard)))
        return changed


class _Descriptors:
    """A file that is open for nothing but to be found closed, by a component that closes what it did not open."""

    def __init__(self) -> None:
        self._file = -1
        with suppress(OSError):  # too many are open: then it is not looked after
            self._file = os.open(os.devnull, os.O_RDONLY)
        self._identity = _identity(self._file)

    def __del__(self) -> None:  # of a run that did not get to its end
        self.close()

    def closed(self) -> bool:
        """Whether it was; then it is gone."""
        gone = self._file >= 0 and _identity(self._file) != self._identity
        if gone:
            self._file = -1
        return gone

    def close(self) -> None:
        if not self.closed() and self._file >= 0:
            os.close(self._file)
            self._file = -1


def _identity(file: int) -> tuple[int, int] | None:
    """Which file a descriptor stands for; None if it is closed."""
    try:
        found = os.fstat(file)
    except OSError:
        return None
    return found.st_dev, found.st_ino


class _Standard:
    """Standard input, output and error, and copies of them."""

    _NAMES = ("input", "output", "error")

    def __init__(self) -> None:
        self._copies: dict[int, int] = {}
        if sys.platform == "win32":
            return
        import fcntl

        for number in range(3):
            with suppress(OSError):
                self._copies[number] = fcntl.fcntl(number, fcntl.F_DUPFD_CLOEXEC, _KEPT_FROM)

    def __del__(self) -> None:  # of a run that did not get to its end
        self.close()

    def restore(self) -> list[str]:
        changed = []
        for number, copy in self._copies.items():
            try:
                os.fstat(number)
            except OSError:
                with suppress(OSError):
                    os.dup2(copy, number)
                changed.append(self._NAMES[number])
        return changed

    def close(self) -> None:
        for copy in self._copies.values():
            with suppress(OSError):
                os.close(copy)
        self._copies = {}
