"""The side of the run in `adcs run`: what its supervisor has to know of it. Nothing happens where there is none.

The supervisor, `adcs/supervisor.py`, makes a folder and names it in the environment; all that is said goes there.
"""

from __future__ import annotations

import ctypes
import itertools
import json
import os
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from threading import Thread

from fmus.lock import Lock
from orchestration.process import orphan
from orchestration.process.where import Place, Where

MARK = "ADCS_SUPERVISED"
_OUT_OF_THE_WAY = 210  # of a component that closes "all" descriptors
_PULSE = 0.5  # s
SAID = "said"  # what could not be printed, as a component has closed the standard output; the supervisor prints it
_APPEND = os.O_RDWR | os.O_CREAT | os.O_APPEND
_MOST = 2**20  # bytes of what components print that are passed on at once

_folder: Path | None = None
_where = Where()
printed: Callable[[], bool] | None = None
"""Whether components have printed to the standard output since it was asked; None where that is not looked after."""


def begin() -> None:
    """Take up what the supervisor has said."""
    global _folder, printed
    name = os.environ.pop(MARK, None)
    if name is None:
        return
    _folder = Path(name)
    Lock(_folder / ".alive").take()
    orphan.end_with_parent(lambda: _where.busy)
    Thread(target=_beat, args=(_folder / "pulse",), daemon=True, name="pulse").start()
    if sys.platform != "win32":
        with suppress(OSError):
            printed = _Printed(_folder / "printed")


def present() -> bool:
    """Whether another process looks after this one."""
    return _folder is not None


def _beat(path: Path) -> None:
    """Show that this process is alive, by another number again and again.

    One that is stopped, or stuck with Python's lock in its hands, does not.
    """
    for number in itertools.count():
        with suppress(OSError):
            path.write_text(str(number), encoding="ascii")
        time.sleep(_PULSE)


def watch(journal: Path, where: Where, timeout: float) -> None:
    """Say where the run is, in which file that is noted, and how long a call may take (s)."""
    global _where
    _where = where
    if _folder is not None:
        finite = timeout if timeout < 1e12 else None
        content = {"journal": str(journal), "timeout": finite, "size": ctypes.sizeof(Place), "at": 64}
        content |= {"doing": Place.doing.offset, "idle": -1}
        (_folder / "watch.part").write_text(json.dumps(content), encoding="utf-8")
        (_folder / "watch.part").replace(_folder / "watch")


def end(code: int) -> None:
    """Say that the command is done: what happens to the process after that is of no account."""
    if printed is not None:
        printed()
    with suppress(OSError, ValueError):
        sys.stdout.flush()
    if _folder is not None:
        with suppress(OSError):
            (_folder / "done.part").write_text(str(code), encoding="ascii")
            (_folder / "done.part").replace(_folder / "done")


if sys.platform != "win32":  # there it is not looked after

    class _Printed:
        """What is written to descriptor 1 past Python goes to the standard error, so that `--json` stays JSON."""

        def __init__(self, path: Path) -> None:
            import fcntl

            self._out = fcntl.fcntl(1, fcntl.F_DUPFD, _OUT_OF_THE_WAY)
            self._path = path
            file = os.open(path, _APPEND, 0o600)
            self._file = fcntl.fcntl(file, fcntl.F_DUPFD_CLOEXEC, _OUT_OF_THE_WAY)
            os.dup2(file, 1)
            os.close(file)
            sys.stdout = os.fdopen(self._out, "w", encoding=sys.stdout.encoding, errors=sys.stdout.errors)
            self._flush = ctypes.CDLL(None).fflush

        def __call__(self) -> bool:
            self._flush(None)
            _reopen(self._file, self._path)
            _reopen(self._out, self._path.with_name(SAID))
            with suppress(OSError):
                content = os.pread(self._file, _MOST, 0)
                if content:
                    os.ftruncate(self._file, 0)
                    os.write(2, content)
                    return True
            return False


def _reopen(number: int, path: Path) -> None:
    """Open a file under the number of one that a component has closed."""
    with suppress(OSError):
        os.fstat(number)
        return
    with suppress(OSError):
        file = os.open(path, _APPEND, 0o600)
        os.dup2(file, number)
        os.close(file)
