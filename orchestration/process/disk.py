"""A file that HDF5 writes to, which cannot stand a full disk: once a write has failed, it ends the process."""

from __future__ import annotations

import io
import os
from pathlib import Path

from fmus.errors import AdcsError
from orchestration.process.own_file import OwnFile


class Disk(io.RawIOBase):
    """A new file. `reserve` takes disk space ahead of what is written; a write that fails is told at the end.

    What comes after a write that failed is kept in memory, so that HDF5 can close the file in peace.
    """

    def __init__(self, path: Path, shown: str | Path | None = None) -> None:
        """`shown` is what errors call it."""
        super().__init__()
        self._path = shown or path
        self._file = OwnFile(path, os.O_CREAT | os.O_TRUNC)
        self._place = self._reserved = self._used = 0
        self._failed: OSError | None = None
        self._rest: list[tuple[int, bytes]] = []

    def reserve(self, size: int) -> None:
        """Take disk space for a file of this size; AdcsError if there is none, before anything is changed."""
        if self._failed is None and size > self._reserved and hasattr(os, "posix_fallocate"):
            try:
                os.posix_fallocate(self._file.number, 0, size)
                self._reserved = size
            except OSError as error:
                raise self._told(error) from error
        elif self._failed is not None:
            raise self._told(self._failed) from self._failed

    def write(self, content: object) -> int:
        """Write, or seem to."""
        data = bytes(content)  # type: ignore[call-overload]
        if self._failed is None:
            try:
                done = 0
                os.lseek(self._file.number, self._place, os.SEEK_SET)
                while done < len(data):
                    done += os.write(self._file.number, data[done:])
            except OSError as error:
                self._failed = error
        if self._failed is not None:
            self._rest.append((self._place, data))
        self._place += len(data)
        self._used = max(self._used, self._place)
        return len(data)

    def readinto(self, to: object) -> int:
        """Read what was written, wherever it is."""
        view = memoryview(to).cast("B")  # type: ignore[arg-type]
        os.lseek(self._file.number, self._place, os.SEEK_SET)
        content = bytearray(os.read(self._file.number, len(view)).ljust(len(view), b"\0"))
        for place, data in self._rest:
            first, last = max(place, self._place), min(place + len(data), self._place + len(view))
            if first < last:
                content[first - self._place : last - self._place] = data[first - place : last - place]
        view[:] = content
        self._place += len(view)
        return len(view)

    def seek(self, offset: int, whence: int = 0) -> int:
        """Go to a place."""
        self._place = offset + (0, self._place, self._used)[whence]
        return self._place

    def tell(self) -> int:
        """The place."""
        return self._place

    def truncate(self, size: int | None = None) -> int:
        """Note the size, which the file gets when it is closed."""
        self._used = self._place if size is None else size
        return self._used

    def readable(self) -> bool:
        """It is."""
        return True

    writable = seekable = readable

    def close(self) -> None:
        """Close the file; AdcsError if not all of it could be written."""
        if self.closed:
            return
        try:
            os.ftruncate(self._file.number, self._used)
        except OSError as error:
            self._failed = self._failed or error
        self._file.close()
        super().close()
        if self._failed is not None:
            raise self._told(self._failed) from self._failed

    def _told(self, error: OSError) -> AdcsError:
        return AdcsError(f"cannot write {self._path}: {error.strerror}")
