"""Where the relative path of a header or FMU is looked for first: beside the file whose code names it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

_folder: ContextVar[Path | None] = ContextVar("folder", default=None)


@contextmanager
def looked_for_in(folder: Path) -> Iterator[None]:
    """Let paths of components be looked for in this folder, before the one that the user is in."""
    token = _folder.set(folder.absolute())
    try:
        yield
    finally:
        _folder.reset(token)


def beside(path: str | Path) -> Path | None:
    """Return the path of a file in that folder; None if it has none of this path, or there is no such folder."""
    folder = _folder.get()
    found = None if folder is None else folder / path
    return found if found is not None and found.is_file() else None
