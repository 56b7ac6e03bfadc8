"""FMUs unpacked to be loaded: those built here once in the life of a process, others each time."""

from __future__ import annotations

import atexit
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from threading import Lock

from orchestration.fmu.file import Fmu, Kind, extracted

_kept: dict[tuple[int, str, Kind], tuple[Path, Path]] = {}  # by process, content and kind
_lock = Lock()


@contextmanager
def unpacked(fmu: Fmu, kind: Kind) -> Iterator[tuple[Path, Path]]:
    """Yield the folder of an FMU, and the binary in it.

    What is not built here may change the files that it comes with, and has the folder for itself.
    """
    if not fmu.ours:
        with extracted(fmu, kind) as places:
            yield places
        return
    yield _folder_of(fmu, kind, os.getpid())


def _folder_of(fmu: Fmu, kind: Kind, process: int) -> tuple[Path, Path]:
    key = process, fmu.sha256, kind
    with _lock:
        if key not in _kept or not _kept[key][1].is_file():  # as where a machine clears up what is temporary
            stack = ExitStack()
            _kept[key] = stack.enter_context(extracted(fmu, kind))
            atexit.register(lambda: stack.close() if os.getpid() == process else None)  # not at the end of a fork
        return _kept[key]
