"""Results that are in a file: written as a run goes on, read piece by piece."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fmus.errors import AdcsError
from orchestration.plan.lowering import Floats
from orchestration.plan.schedule import split
from orchestration.results import hdf5
from orchestration.results.hdf5 import File, check, dataset_of
from orchestration.results.result import Recording, Result
from orchestration.system import System

if TYPE_CHECKING:
    import h5py


class FileRecording(Recording):
    """Rows that go to a file as they come, so that a run may be longer than memory."""

    def __init__(self, system: System, record: Sequence[str] | None, path: Path) -> None:
        super().__init__(system, record)
        self.path = path
        check(path, self.ports)
        self._buffer = np.empty((max(1, hdf5.AT_ONCE // max(self.size, 1)), self.size))
        self._used = 0
        self._open: File | None = None
        self._given_up = False  # there was no room for a single row

    @property
    def capacity(self) -> int:
        """The most rows for which there is room at once."""
        return len(self._buffer)

    def room(self, rows: int) -> Floats:
        """The next rows, to be filled."""
        if self._used + rows > len(self._buffer):
            self._flush()
        return self._buffer[self._used : self._used + rows]

    def commit(self, rows: int) -> None:
        """Keep what was filled, to be written when there is more."""
        self._used += rows
        self.filled += rows

    def flush(self) -> None:
        """Write what is kept; AdcsError if the disk is full, and what fitted is kept."""
        self._flush()

    def result(self, times: Floats, manifest: dict[str, Any]) -> Result:
        """Write the times and what is known about the run; in memory if there is no file, as no row has room in one."""
        if self._given_up:
            return super().result(times, manifest)
        self._flush().close(times, manifest)
        return FileResult.of(self.system, times, self, manifest)

    def _flush(self) -> File:
        """Write what is kept; the file is made by the first rows, so that a refused run leaves an older one alone."""
        if self._open is None:
            if self.path.is_symlink() or self.path.is_file():  # it is replaced, not followed or changed
                self.path.unlink()
            self._open = File(self.path, self.ports)
        done, piece = 0, max(1, self._used)
        while done < self._used:
            try:
                self._open.append(self._buffer[done : min(done + piece, self._used)])
                done += piece
            except AdcsError:  # the disk is full: what fits is kept
                if piece == 1:
                    self.filled -= self._used - done
                    self._used = 0
                    if not self.filled:
                        self._given_up = True
                        self._open.discard()
                        self.path.unlink(missing_ok=True)
                    raise
                piece = max(1, piece // 4)
        self._used = 0
        return self._open


class FileResult(Result):
    """A result whose values stay in their file until they are asked for."""

    path: Path
    mark: tuple[int, ...] | None = None
    """Tells the file from another one in its place."""

    @classmethod
    def of(cls, system: System, times: Floats, recording: FileRecording, manifest: dict[str, Any]) -> FileResult:
        """Return the result of a finished recording."""
        result = cls(system, times, np.empty((0, recording.size)), recording.ports, manifest)
        result.path = recording.path
        result.mark = mark_of(recording.path)
        return result

    def _file(self) -> h5py.File:
        import h5py

        if self.mark is not None and mark_of(self.path) != self.mark:
            raise AdcsError(f"{self.path} is not the file any more that this result is in: give each run its own")
        return h5py.File(self.path)

    def _read(self, name: str, element: int | None) -> Floats:
        with self._file() as file:
            dataset = file[self._held(name)]
            if element is None:
                return np.asarray(dataset[:], float)
            return np.asarray(dataset[:, *np.unravel_index(element, self.ports[name].shape)], float)

    def block(self, first: int, last: int) -> Floats:
        """Rows first .. last-1."""
        n = min(last, len(self.time)) - first
        with self._file() as file:
            parts = [
                np.asarray(file[self._held(name)][first:last], float).reshape(n, port.size)
                for name, port in self.ports.items()
            ]
        return np.hstack([np.empty((n, 0)), *parts])

    def _held(self, name: str) -> str:
        """Where a variable is in the file, which knows it by one of its names."""
        return dataset_of(f"{split(name)[0]}.{self.ports[name].name}")

    def select(self, names: Sequence[str]) -> Result:
        """Return the result with these variables only."""
        ports = {name: self.ports[self._whole(name)] for name in names}
        chosen = FileResult(self.system, self.time, self.data, ports, {**self.manifest, "written": list(names)})
        chosen.path, chosen.mark = self.path, self.mark
        return chosen


def mark_of(path: Path) -> tuple[int, ...] | None:
    """Return what tells a file from another one in its place; None if it is not there."""
    try:
        about = path.stat()
    except OSError:
        return None
    return about.st_dev, about.st_ino, about.st_size, about.st_mtime_ns
