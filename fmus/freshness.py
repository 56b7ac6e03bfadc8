"""Whether an FMU is made of what is here now: a record beside it says what it was made of, by content, not by time."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import cache, lru_cache
from pathlib import Path

from fmus.files import digest, write_atomically
from fmus.paths import LICENSE, PACKAGE, SOURCES

_PLACE = ".made"
"""The folder of the records, beside the FMUs."""


@dataclass(frozen=True)
class Record:
    """All that an FMU was made of."""

    sources: dict[str, str]
    """Each file of `src/`, and the digest of its content."""
    packer: str
    """Stands for the code that packed it, templates, licences, and the time of the files in it."""
    compiler: str
    """With the libraries that it compiled in; empty where binaries came compiled."""
    platforms: tuple[str, ...]
    fmu: str = ""
    """Digest of the FMU itself."""

    def without_fmu(self) -> Record:
        """Return the same of any FMU."""
        return replace(self, fmu="")


def make_record(sources: Mapping[str, str], platforms: Iterable[str], compiler: str) -> Record:
    """Return the record of an FMU that is packed now."""
    return Record(dict(sources), _packer(), compiler, tuple(platforms))


def keep_record(fmu: Path, record: Record) -> None:
    """Write the record of an FMU that was written."""
    content = json.dumps(asdict(replace(record, fmu=digest(fmu))), indent=1)
    write_atomically(_place(fmu), content.encode())


def read_record(fmu: Path) -> Record | None:
    """Return the record of an FMU; None if it has none, or is another file than the one that the record is of."""
    place = _place(fmu)
    record = _read(place, digest(place))
    return record if record is not None and record.fmu == digest(fmu) else None


@lru_cache(maxsize=256)
def _read(place: Path, _digest: str) -> Record | None:
    try:
        known = json.loads(place.read_bytes())
        return Record(**{**known, "platforms": tuple(known["platforms"])})
    except (OSError, ValueError, TypeError, KeyError):
        return None


def recorded(dist: Path) -> set[Path]:
    """Return the paths of the FMUs that were built into a folder."""
    return {dist / place.stem for place in (dist / _PLACE).glob("*.json")}


def orphaned(fmu: Path) -> bool:
    """Whether an FMU was built of a header beside it that is gone."""
    record = read_record(fmu)
    beside = [Path(n) for n in record.sources if Path(n).parent == fmu.parent.absolute()] if record is not None else []
    return bool(beside) and not any(header.is_file() for header in beside)


def forget(fmu: Path) -> None:
    """Remove an FMU and its record."""
    fmu.unlink(missing_ok=True)
    _place(fmu).unlink(missing_ok=True)


def outdated(fmu: Path, platform: str, compiler: str = "", header: str | None = None) -> str | None:
    """Say why an FMU cannot be taken on this platform, in words that follow its name; None if it can.

    `compiler` is the one that there is, empty if there is none; `header` one from elsewhere, of which it has to be.
    """
    if not fmu.is_file():
        return "is not built"
    record = read_record(fmu)
    if record is None:
        return "is not as it was built"
    if header is not None and header not in record.sources:
        return "was built from another header"
    src = str(SOURCES)
    changed = [n for n, known in record.sources.items() if digest(os.path.join(src, n)) != known]  # noqa: PTH118 quick
    if changed:
        first = min(changed, key=lambda name: (name.startswith("fmi/"), name))
        more = f" (and {len(changed) - 1} more)" if len(changed) > 1 else ""
        return f"was built from another {first if Path(first).is_absolute() else f'src/{first}'}{more}"
    if record.packer != _packer():
        return "was packed by another version of adcs-fmus"
    if record.compiler and compiler and record.compiler != compiler:
        return f"was built by {record.compiler}"
    if platform not in record.platforms:
        return f"has no binary for {platform}"
    return None


def _place(fmu: Path) -> Path:
    return fmu.parent / _PLACE / f"{fmu.name}.json"


def _packer() -> str:
    return f"{_package()} {os.environ.get('SOURCE_DATE_EPOCH', '')}".strip()


@cache
def _package() -> str:
    """Digest of the code that packs: it is loaded, and does not change any more while this process lives."""
    files = [file for pattern in ("*.py", "templates/*", "licenses/*") for file in sorted(PACKAGE.glob(pattern))]
    return hashlib.sha256("\n".join(map(digest, (*files, LICENSE))).encode()).hexdigest()
