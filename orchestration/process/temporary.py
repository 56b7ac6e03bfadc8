"""Temporary folders that are removed at the end; those of processes that were killed, by a later one."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from fmus.lock import Lock

_LOCK = ".alive"
_NAME = "adcs-{what}-{pid}-"


@contextmanager
def temporary_folder(what: str) -> Iterator[Path]:
    """Yield a new folder, `adcs-WHAT-PID-...`. A lock in it says that its process lives."""
    _clear_up(tempfile.gettempdir())
    folder, lock = _taken(what)
    try:
        yield folder
    finally:
        lock.release()
        shutil.rmtree(folder, ignore_errors=True)


def _taken(what: str) -> tuple[Path, Lock]:
    """Make a folder and its lock; another one, if a process that clears up took it for one that was left."""
    while True:
        folder = Path(tempfile.mkdtemp(prefix=_NAME.format(what=what, pid=os.getpid())))
        lock = Lock(folder / _LOCK)
        with suppress(FileNotFoundError):
            if lock.take():
                return folder, lock


@cache
def _clear_up(where: str) -> None:
    """Remove what processes that were killed left there, once in the life of this one."""
    for folder in Path(where).glob(_NAME.format(what="*", pid="*") + "*"):
        with suppress(OSError):
            pid = folder.name.split("-")[2]
            if folder.is_symlink() or not pid.isdecimal() or not (folder / _LOCK).is_file() or not _mine(folder):
                continue
            lock = Lock(folder / _LOCK)
            if lock.take():
                lock.release()
                shutil.rmtree(folder, ignore_errors=True)


def _mine(folder: Path) -> bool:
    return sys.platform == "win32" or folder.stat().st_uid == os.getuid()
