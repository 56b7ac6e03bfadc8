"""Files are written under another name and renamed when they are whole: there is the old one, or the new one."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from fmus.errors import AdcsError, Failed


def make_folder(folder: Path, asked: str) -> None:
    """Make a folder, and those above it; AdcsError names what is in its way, after what was `asked` for."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        obstacle = next((place for place in (folder, *folder.parents) if os.path.lexists(place)), folder)
        why = error.strerror if obstacle.is_dir() else f"{obstacle} is no folder"
        raise AdcsError(f"{asked}: {why}: give another place") from error


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yield the name to write to, beside `path` and with its ending; AdcsError where it cannot be written.

    A link in the place of the file is replaced, not followed. A device or a pipe is written to as it is.
    """
    path = Path(path)
    make_folder(path.parent, f"cannot write {path}")
    try:
        special = path.exists() and not path.is_file() and not path.is_dir()
        name = path if special else path.with_name(f".{os.getpid()}.{path.name}")
        try:
            if not special:
                name.unlink(missing_ok=True)
                os.close(os.open(name, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
            yield name
            if not special:
                name.replace(path)
        finally:
            if not special:
                with suppress(OSError):
                    name.unlink(missing_ok=True)
    except OSError as error:
        raise Failed(f"cannot write {path}: {error.strerror or ' '.join(str(error).split())}") from error
