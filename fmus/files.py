"""Files by their content, and files that are never half there."""

import hashlib
import os
import threading
from functools import cache
from pathlib import Path

from fmus.errors import Failed


def digest(path: str | Path) -> str:
    """SHA-256 of a file's content, empty if there is none."""
    try:
        status = os.stat(path)  # noqa: PTH116  takes half the time of `Path.stat`, and is called thousands of times
    except FileNotFoundError:
        return ""
    return _digest(str(path), status.st_mtime_ns, status.st_size)


def make_folder(path: Path) -> None:
    """Make a folder that the program needs for itself; AdcsError if it cannot be."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        way_out = "LOCALAPPDATA" if os.name == "nt" else "XDG_CACHE_HOME"
        raise Failed(f"cannot make {path}: {error.strerror or error}: set {way_out} to a folder for it") from error


def write_atomically(path: Path, content: bytes) -> None:
    """Writes a file that others, writing it at the same time, see either old or new, never half."""
    make_folder(path.parent)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.{threading.get_ident()}")
    temporary.write_bytes(content)
    temporary.replace(path)


@cache
def _digest(path: str, _modified: int, _size: int) -> str:
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()
