"""A lock on a file: held by one process, and given up by the system when that ends, however it ends."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

_OUT_OF_THE_WAY = 200  # of a component that closes "all" descriptors
_FAR = 1 << 30  # Windows locks bytes, and locked ones cannot be read: this one is never there


class Lock:
    """`take` it, `release` it; the file holds the number of the process that has it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file: int | None = None

    def take(self) -> bool:
        """Return whether it is ours now; a link in its place is not followed."""
        file = os.open(self.path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
        try:
            if sys.platform != "win32":
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                with suppress(OSError):
                    high = fcntl.fcntl(file, fcntl.F_DUPFD_CLOEXEC, _OUT_OF_THE_WAY)
                    os.close(file)
                    file = high
            else:
                os.lseek(file, _FAR, os.SEEK_SET)
                msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
                os.lseek(file, 0, os.SEEK_SET)
        except OSError:
            os.close(file)
            return False
        if sys.platform != "win32" and not self._same(file):  # who had it has removed the file meanwhile
            os.close(file)
            return self.take()
        with suppress(OSError):  # a full disk: the lock is there all the same
            os.ftruncate(file, 0)
            os.write(file, str(os.getpid()).encode())
        self._file = file
        return True

    def _same(self, file: int) -> bool:
        try:
            return os.path.samestat(os.fstat(file), os.lstat(self.path))
        except FileNotFoundError:
            return False

    @property
    def holder(self) -> str:
        """The number of the process that has, or had, the lock; empty if it is not known."""
        with suppress(OSError, UnicodeDecodeError):
            return self.path.read_text(encoding="ascii")
        return ""

    def release(self) -> None:
        """Give it up, and remove the file."""
        if self._file is not None:
            if sys.platform != "win32":  # which removes no open file
                self.path.unlink(missing_ok=True)
            with suppress(OSError):
                os.close(self._file)
            self._file = None
            with suppress(OSError):
                self.path.unlink(missing_ok=True)
