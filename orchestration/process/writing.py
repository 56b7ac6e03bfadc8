"""Files are written under another name and renamed when they are whole: there is the old one, or the new one."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from fmus.errors import AdcsError


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yield the name to write to, beside `path` and with its ending; AdcsError where it cannot be written.

    A link in the place of the file is replaced, not followed. A device or a pipe is written to as it is.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
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
        raise AdcsError(f"cannot write {path}: {error.strerror or ' '.join(str(error).split())}") from error
