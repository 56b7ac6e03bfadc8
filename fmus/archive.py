"""Zip archives from anywhere, `.fmu` and `.ssp` alike: looked over when they are opened, unpacked within limits."""

from __future__ import annotations

import io
import posixpath
import stat
import zipfile
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import Self

from fmus.errors import AdcsError
from fmus.nearby import not_opened

LARGEST_XML = 64 << 20  # bytes; a model of 100 000 variables has 20 MB
LARGEST_ARCHIVE = 4 << 30  # bytes unpacked
_HARMLESS = 256 << 20  # bytes unpacked, however well they were packed
_MOST_PACKED = 100  # times smaller than unpacked; zeros reach 1000, binaries and tables of numbers 3 to 20
_MOST_MEMBERS = 100_000
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_ENCRYPTED = 0x1 | 0x40 | 0x2000  # flags: the content, strongly, the directory
_AGAIN = "build or download it again"


class Archive:
    """An opened zip archive that can be unpacked without harm. A context manager; raises AdcsError.

    Refused are paths that lead outside, links, members that exist twice, what tools of FMI and SSP need not read
    (encryption, other methods than deflate), and archives that unpack to more than `LARGEST_ARCHIVE` or are packed as
    only a bomb is. `content` is given for an archive inside another; `path` is then its name.
    """

    def __init__(self, path: Path, content: bytes | None = None) -> None:
        self.path = path
        try:
            if content is None and not stat.S_ISREG(path.stat().st_mode):
                raise AdcsError(f"cannot open {path}: it is no file")
            self._zip = zipfile.ZipFile(path if content is None else io.BytesIO(content))
        except OSError as error:
            raise not_opened(path, error) from error
        except AdcsError:
            raise
        except Exception as error:  # zipfile lets those of struct, of decoding and others out of a damaged directory
            raise AdcsError(f"{path} is not a readable zip archive ({_line(error)}): {_AGAIN}") from error
        try:
            self._look_over(path.stat().st_size if content is None else len(content))
        except AdcsError:
            self._zip.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._zip.close()

    @property
    def names(self) -> list[str]:
        """Paths of the members, folders among them."""
        return self._zip.namelist()

    @property
    def checksums(self) -> dict[str, tuple[int, int]]:
        """Size and CRC-32 of each member, as the archive's directory says."""
        return {info.filename: (info.file_size, info.CRC) for info in self._zip.infolist()}

    def read(self, member: str, largest: int = LARGEST_ARCHIVE) -> bytes:
        """Return the content of a member, of at most `largest` bytes."""
        info = self._zip.getinfo(member)
        if info.file_size > largest:
            raise AdcsError(
                f"{self.path}: {member!r} has {info.file_size:,} bytes unpacked, more than {largest:,}: refused"
            )
        try:
            return self._zip.read(info)  # never more than the size that the directory says
        except Exception as error:  # of zipfile, zlib or the file system
            raise AdcsError(f"{self.path}: {member!r} cannot be unpacked ({_line(error)}): pack it again") from error

    def extract(self, folder: Path, members: Iterable[str]) -> None:
        """Unpack members into a folder."""
        try:
            self._zip.extractall(folder, members)
        except Exception as error:  # of zipfile, zlib or the file system
            raise AdcsError(f"{self.path} cannot be extracted ({_line(error)}): {_AGAIN}") from error

    def _look_over(self, packed: int) -> None:
        members = self._zip.infolist()
        if len(members) > _MOST_MEMBERS:
            raise AdcsError(f"{self.path} has {len(members):,} members, more than {_MOST_MEMBERS:,}: refused")
        for info in members:
            name = info.orig_filename  # zipfile would cut it at a NUL, and put what leads outside elsewhere
            outside = name.startswith("/") or ".." in name.split("/") or posixpath.normpath(name).startswith("..")
            if outside or any(character in name for character in "\\:\0"):
                raise AdcsError(f"{self.path} holds the path {name!r} that leads outside the archive: refused")
            if info.external_attr >> 28 == stat.S_IFLNK >> 12:
                raise AdcsError(f"{self.path}: {name!r} is a link: pack what it leads to")
            if info.flag_bits & _ENCRYPTED:
                raise AdcsError(f"{self.path}: {name!r} is encrypted: pack it without")
            if info.compress_type not in _METHODS:
                method = zipfile.compressor_names.get(info.compress_type, info.compress_type)  # type: ignore[attr-defined]
                raise AdcsError(f"{self.path}: {name!r} is packed by {method}: only deflate is read, pack it so")
        name, count = next(iter(Counter(self._zip.namelist()).most_common(1)), ("", 0))
        if count > 1:
            raise AdcsError(f"{self.path} holds {name!r} {count} times: pack it once")
        unpacked = sum(info.file_size for info in members)
        if unpacked > LARGEST_ARCHIVE or unpacked > max(_HARMLESS, _MOST_PACKED * packed):
            raise AdcsError(
                f"{self.path} has {packed:,} bytes and would have {unpacked:,} unpacked: refused, as a zip bomb is so"
            )


def _line(error: object) -> str:
    return " ".join(str(error).split()) or type(error).__name__
