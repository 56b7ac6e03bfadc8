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
from urllib.parse import unquote, urlsplit

from lxml import etree

from fmus import paths
from fmus.archive import LARGEST_XML, Archive
from fmus.errors import AdcsError
from orchestration.ssp.documents import parse
from orchestration.ssp.names import STRUCTURE
from orchestration.ssp.schemas import Kind

CACHE = paths.BUILD / "ssp"
"""Where the FMUs of `.ssp` files are put."""
_LARGEST_FMU = 2 << 30  # bytes, packed


class SspArchive(Archive):
    """An opened `.ssp`, of a file or of the content of one inside another."""

    def __init__(self, path: Path, content: bytes | None = None) -> None:
        super().__init__(path, content)
        self._documents: dict[tuple[str, Kind], etree._Element] = {}
        self._packages: dict[str, SspArchive] = {}
        if STRUCTURE not in self.names:
            self.close()
            raise AdcsError(
                f"{path.name}: it has no {STRUCTURE} at its root: pack it there, without a folder around it"
            )

    @property
    def structures(self) -> tuple[str, ...]:
        """The names of the system structures at its root: the variants that it has."""
        return tuple(name for name in self.names if name.endswith(".ssd") and "/" not in name)

    def structure(self, name: str) -> str:
        """Return the name of a system structure; AdcsError with those there are if it is not there."""
        if name not in self.names or not name.endswith(".ssd"):
            choices = ", ".join(filter(self._readable, self.names)) or "none, as there is no other"
            raise AdcsError(f"it has no system structure {name!r}: choose one of {choices}")
        return name

    def _readable(self, name: str) -> bool:
        """Whether a member is a system structure that can be read, in whatever folder."""
        try:
            return name.endswith(".ssd") and self.document(name, "ssd") is not None
        except AdcsError:
            return False

    def close(self) -> None:
        """Close the file, and those opened inside it."""
        for package in self._packages.values():
            package.close()
        super().close()

    def locate(self, source: str, what: str, base: str = "") -> str:
        """Return the name of the member that a URI of the document `base` names."""
        parts = urlsplit(source)
        if parts.scheme or parts.netloc:
            raise AdcsError(f"{what} is at {source}: only files inside the .ssp are read, put it there")
        member = posixpath.normpath(posixpath.join(posixpath.dirname(base), unquote(parts.path)))
        if member.startswith(("..", "/")) or parts.fragment:
            raise AdcsError(f"{what} is at {source!r}: only files inside the .ssp are read, put it there")
        if member not in self.names:
            raise AdcsError(f"{what} is missing: the archive has no file {member!r}, pack it there")
        return member

    def document(self, member: str, kind: Kind) -> etree._Element:
        """Read and check an XML document."""
        if (member, kind) not in self._documents:
            self._documents[member, kind] = parse(self.read(member, LARGEST_XML), member, kind)
        return self._documents[member, kind]

    def package(self, member: str) -> SspArchive:
        """Open an `.ssp` that is inside this one."""
        if member not in self._packages:
            self._packages[member] = SspArchive(Path(member), self.read(member, _LARGEST_FMU))
        return self._packages[member]

    def fmu(self, member: str) -> Path:
        """Return where an FMU of the archive lies as a file.

        It is copied into a folder named by the checksum of its content, once: the systems read keep working when the
        `.ssp` is gone, and the same FMU in two of them is one file.
        """
        content = self.read(member, _LARGEST_FMU)
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


@dataclass(frozen=True)
class Home:
    """A system structure in its archive: what the sources in it are relative to."""

    archive: SspArchive
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
