"""The `.ssp` file as an archive: its documents read with limits, its FMUs put where they can be opened."""

from __future__ import annotations

import hashlib
import io
import os
import posixpath
import tempfile
import time
import zipfile
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from urllib.parse import unquote, urlsplit

from lxml import etree

from fmus import paths
from fmus.errors import AdcsError
from orchestration.ssp.documents import parse
from orchestration.ssp.schemas import Kind

STRUCTURE = "SystemStructure.ssd"
CACHE = paths.BUILD / "ssp"
"""Where the FMUs of `.ssp` files are put."""
_LARGEST_DOCUMENT = 64 << 20  # bytes; XML of that size is an attack or a mistake
_LARGEST_FMU = 2 << 30


class Archive:
    """An opened `.ssp`, of a file or of the content of one inside another. A context manager; raises AdcsError."""

    def __init__(self, path: Path, content: bytes | None = None) -> None:
        self.path = path
        try:
            self._zip = zipfile.ZipFile(path if content is None else io.BytesIO(content))
        except OSError as error:
            raise AdcsError(f"cannot open {path}: {error.strerror or error}") from error
        except zipfile.BadZipFile:
            raise AdcsError(f"{path} is no SSP, it is not a zip archive: export or download it again") from None
        self._documents: dict[tuple[str, Kind], etree._Element] = {}
        self._packages: dict[str, Archive] = {}
        try:
            self._check()
        except AdcsError:
            self._zip.close()
            raise

    def __enter__(self) -> Archive:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Close the file, and those opened inside it."""
        for package in self._packages.values():
            package.close()
        self._zip.close()

    def _check(self) -> None:
        names = self._zip.namelist()
        for name in names:
            if "\\" in name or ":" in name or name.startswith("/") or ".." in name.split("/") or "\0" in name:
                raise AdcsError(f"{self.path.name}: it holds the path {name!r} that leads outside the archive: refused")
        if STRUCTURE not in names:
            raise AdcsError(
                f"{self.path.name}: it has no {STRUCTURE} at its root: pack it there, without a folder around it"
            )

    def locate(self, source: str, what: str, base: str = "") -> str:
        """Return the name of the member that a URI of the document `base` names."""
        parts = urlsplit(source)
        if parts.scheme or parts.netloc:
            raise AdcsError(f"{what} is at {source}: only files inside the .ssp are read, put it there")
        member = posixpath.normpath(posixpath.join(posixpath.dirname(base), unquote(parts.path)))
        if member.startswith(("..", "/")) or parts.fragment:
            raise AdcsError(f"{what} is at {source!r}: only files inside the .ssp are read, put it there")
        if member not in self._zip.namelist():
            raise AdcsError(f"{what} is missing: the archive has no file {member!r}, pack it there")
        return member

    def document(self, member: str, kind: Kind) -> etree._Element:
        """Read and check an XML document."""
        if (member, kind) not in self._documents:
            self._documents[member, kind] = parse(self._read(member, _LARGEST_DOCUMENT), member, kind)
        return self._documents[member, kind]

    def package(self, member: str) -> Archive:
        """Open an `.ssp` that is inside this one."""
        if member not in self._packages:
            self._packages[member] = Archive(Path(member), self._read(member, _LARGEST_FMU))
        return self._packages[member]

    def fmu(self, member: str) -> Path:
        """Return where an FMU of the archive lies as a file.

        It is copied into a folder named by the checksum of its content, once: the systems read keep working when the
        `.ssp` is gone, and the same FMU in two of them is one file.
        """
        content = self._read(member, _LARGEST_FMU)
        digest = hashlib.sha256(content).hexdigest()
        path = CACHE / digest[:32] / posixpath.basename(member)
        if path.suffix != ".fmu":
            path = path.with_name(f"{path.name}.fmu")
        with suppress(OSError):
            if hashlib.sha256(path.read_bytes()).hexdigest() == digest:
                return path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(path, content)
        except OSError as error:
            raise AdcsError(f"cannot put {member} into {path.parent} ({error.strerror or error})") from error
        return path

    def _read(self, member: str, largest: int) -> bytes:
        info = self._zip.getinfo(member)
        if info.file_size > largest:
            raise AdcsError(f"{member} has {info.file_size:,} bytes unpacked, more than {largest:,}: refused")
        if info.flag_bits & 1:
            raise AdcsError(f"{member} is encrypted: pack it without")
        try:
            return self._zip.read(info)
        except Exception as error:  # of zipfile, zlib or the file system
            raise AdcsError(f"{member} cannot be unpacked ({' '.join(str(error).split())}): pack it again") from error


@dataclass(frozen=True)
class Home:
    """A system structure in its archive: what the sources in it are relative to."""

    archive: Archive
    structure: str

    def locate(self, source: str, what: str) -> str:
        """Return the name of the member that a source names."""
        return self.archive.locate(source, what, self.structure)

    def document(self) -> etree._Element:
        """Return the system structure."""
        return self.archive.document(self.structure, "ssd")


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that nobody ever sees a part of it."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        Path(name).chmod(0o644)
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def packed(files: Mapping[str, bytes]) -> bytes:
    """A zip archive that only depends on the files' names and contents; FMUs are compressed already."""
    epoch = int(os.environ.get("SOURCE_DATE_EPOCH", 315532800))  # zip knows no time before 1980
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, time.gmtime(epoch)[:6])
            entry.compress_type = zipfile.ZIP_STORED if name.endswith(".fmu") else zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content)
    return buffer.getvalue()
