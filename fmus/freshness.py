"""Whether a built FMU is made of the sources that are here now: seen in those that it carries, nothing compiled."""

from __future__ import annotations

import logging
import zlib
from functools import lru_cache
from pathlib import Path

from fmus.archive import Archive
from fmus.errors import AdcsError
from fmus.paths import SOURCES

_log = logging.getLogger("adcs")
_said: set[str] = set()


def outdated(component: str, fmu: Path) -> str | None:
    """Return the warning that an FMU was built from other sources, None if it was not; one line.

    It is about content, not times: a header that is saved unchanged is no news. Only files of `src/` are compared; an
    FMU that cannot be read is a matter for whoever opens it.
    """
    try:
        status = fmu.stat()
        changed = [name for name, known in _carried(fmu, status.st_mtime_ns, status.st_size) if known != _here(name)]
    except (AdcsError, OSError):
        return None
    if not changed:
        return None
    more = f" (and {len(changed) - 1} more)" if len(changed) > 1 else ""
    return f"{fmu.name} was built from another src/{changed[0]}{more}: run `adcs build {component}`"


def warn_if_outdated(component: str, fmu: Path) -> None:
    """Log the warning, once in a process."""
    text = outdated(component, fmu)
    if text is not None and text not in _said:
        _said.add(text)
        _log.warning(text)


@lru_cache(maxsize=256)
def _carried(fmu: Path, _modified: int, _size: int) -> tuple[tuple[str, tuple[int, int]], ...]:
    """Size and CRC-32 of the files in `sources/` that are from `src/`, the component's own header first."""
    with Archive(fmu) as archive:
        known = archive.checksums
    sources = {name.removeprefix("sources/"): each for name, each in known.items() if name.startswith("sources/")}
    mine = {name: each for name, each in sources.items() if name.endswith((".hpp", ".cpp")) and "/" in name}
    return tuple(sorted(mine.items(), key=lambda item: (item[0].startswith("fmi/"), item[0])))


def _here(name: str) -> tuple[int, int] | None:
    path = SOURCES / name
    try:
        status = path.stat()
    except FileNotFoundError:
        return None
    return _checksum(path, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=1024)
def _checksum(path: Path, _modified: int, _size: int) -> tuple[int, int]:
    content = path.read_bytes()
    return len(content), zlib.crc32(content)
