"""A file that stays open: a component may close its descriptor, whose number the system then gives to another file."""

from __future__ import annotations

import errno
import os
from contextlib import suppress
from pathlib import Path

_ALWAYS = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)


class OwnFile:
    """Opened to be read and written, with more flags of `os.open`; OSError if that fails."""

    def __init__(self, path: Path, flags: int) -> None:
        self._path = path.absolute()  # a component may change the working directory
        self._number = os.open(self._path, os.O_RDWR | _ALWAYS | flags, 0o666)
        self._identity = os.fstat(self._number)

    @property
    def is_open(self) -> bool:
        """Whether the number still stands for this file."""
        with suppress(OSError):
            return os.path.samestat(os.fstat(self._number), self._identity)
        return False

    @property
    def number(self) -> int:
        """The descriptor, opened again if need be; OSError if the file is gone."""
        if not self.is_open:
            number = os.open(self._path, os.O_RDWR | _ALWAYS)
            if not os.path.samestat(os.fstat(number), self._identity):
                os.close(number)
                raise OSError(errno.ENOENT, os.strerror(errno.ENOENT))
            self._number = number
        return self._number

    def close(self) -> None:
        """Close it, and no other one."""
        if self.is_open:
            os.close(self._number)
