"""The journal of a run: its rows, and where it is, in a file that is mapped into memory and outlives the process.

    0      magic, six numbers (`_Head`)
    64     where the run is (`Place`)
    4096   what the run is, as JSON
    then   times, rows, both page by page; notes on how it ended, as JSON

Disk space is taken before it is written to: in a mapped file a full disk would end the process.
"""

from __future__ import annotations

import ctypes
import errno
import json
import mmap
import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from orchestration.fmu.file import Port
from orchestration.plan.lowering import Floats
from orchestration.process.where import Place, Where
from orchestration.results.result import Recording
from orchestration.system import System

NAME = "run.journal"
_MAGIC = b"adcs-journal-1\n\0"
_PLACE, _ABOUT = 64, 4096  # where they begin
_PAGE = 65536  # a multiple of the page size of every platform
_PIECE = 2**26  # bytes, that are taken from the disk at once


class _Head(ctypes.LittleEndianStructure):
    _fields_ = (
        ("magic", ctypes.c_char * 16),
        ("about", ctypes.c_uint64),  # size
        ("times", ctypes.c_uint64),  # where they begin
        ("rows", ctypes.c_uint64),  # where they begin
        ("width", ctypes.c_uint64),  # of a row
        ("capacity", ctypes.c_uint64),  # in rows
        ("notes", ctypes.c_uint64),  # size; they begin after the last row there is room for
    )


class Journal:
    """Written by the process that runs. `where` is told where it is, `about` is kept for whoever reads the file.

    `prepare` is called with the manifest before the file is made: the run has been found right, and begins. `printed`
    says whether anything came to the standard output.
    """

    def __init__(
        self,
        path: Path,
        about: dict[str, Any] | None = None,
        prepare: Callable[[dict[str, Any]], None] = lambda manifest: None,
        printed: Callable[[], bool] | None = None,
    ) -> None:
        self.path = path.absolute()
        self.printed, self._prepare = printed, prepare
        self.where = Where()
        self.recording: JournalRecording | None = None
        self._about = about or {}
        self._file = -1
        self._taken = 0

    def record(self, system: System, record: Sequence[str] | None) -> JournalRecording:
        """Return what takes the rows, after `begin`."""
        self.recording = JournalRecording(system, record, self)
        return self.recording

    def begin(self, system: System, times: Floats, manifest: dict[str, Any]) -> None:
        """Make the file, for a row at each of these times (s)."""
        assert self.recording is not None
        self._prepare(manifest)
        about = {
            **self._about,
            "pid": os.getpid(),
            "manifest": manifest,
            "components": list(system.components),
            "ports": [[name, _port_to_json(port)] for name, port in self.recording.ports.items()],
        }
        text = json.dumps(about).encode()
        times_at = _pages(_ABOUT + len(text))
        rows_at = times_at + _pages(times.nbytes)
        width = self.recording.size
        self._end = rows_at + _pages(len(times) * width * 8)
        try:
            flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
            self._file = os.open(self.path, flags, 0o666)
            self._take(rows_at)
            os.ftruncate(self._file, self._end)
            self._map = mmap.mmap(self._file, self._end)
        except OSError as error:
            self.close()
            raise self._refused(error, "the journal of the run") from error
        self._head = _Head.from_buffer(self._map)
        self._map[_ABOUT : _ABOUT + len(text)] = text
        np.frombuffer(self._map, np.float64, len(times), times_at)[:] = times
        self.recording.data = np.frombuffer(self._map, np.float64, len(times) * width, rows_at).reshape(
            len(times), width
        )
        self._rows_at, self._width = rows_at, width
        self.where.names = list(system.components)
        self.where.move(Place.from_buffer(self._map, _PLACE))
        self._head.about, self._head.times, self._head.rows = len(text), times_at, rows_at
        self._head.width, self._head.capacity = width, len(times)
        self.where.at_finish = lambda: self.note(manifest)
        self._head.magic = _MAGIC

    def room(self, rows: int) -> int:
        """How many rows there is disk space for after so many, and at least one: `reserve` says if there is none."""
        size = self._width * 8
        if self._rows_at + (rows + 1) * size > self._taken:
            piece = _PIECE
            while piece >= _PAGE:
                with suppress(OSError):
                    self._take(min(max(self._taken, _pages(self._rows_at + rows * size)) + piece, self._end))
                    break
                piece //= 2
        return max(1, (self._taken - self._rows_at) // max(size, 1) - rows)

    def reserve(self, rows: int) -> None:
        """Make sure that there is disk space for so many rows; AdcsError if there is not."""
        end = self._rows_at + rows * self._width * 8
        if end > self._taken:
            try:
                self._take(min(_pages(end), self._end))
            except OSError as error:
                raise self._refused(error, "another row") from error

    def note(self, notes: dict[str, Any]) -> None:
        """Note how the run came out, when there is no more to come but its end."""
        text = json.dumps(notes).encode()
        try:
            os.lseek(self._file, self._end, os.SEEK_SET)
            os.write(self._file, text)
        except OSError:
            return  # they are of use, but not needed
        self._head.notes = len(text)

    def close(self, *, remove: bool = False) -> None:
        """Close the file; `remove` it when all that is in it is elsewhere. Rows stay readable in this process."""
        if self._file >= 0:
            with suppress(OSError):  # a component may have closed it
                os.close(self._file)
            self._file = -1
        if remove:
            with suppress(PermissionError):  # of Windows, which removes no file that is mapped: the next run does
                self.path.unlink(missing_ok=True)

    def _take(self, end: int) -> None:
        """Take the file's disk space up to `end`."""
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(self._file, self._taken, end - self._taken)
        else:  # what was never written is only promised
            os.lseek(self._file, self._taken, os.SEEK_SET)
            left = end - self._taken
            while left > 0:
                left -= os.write(self._file, bytes(min(left, _PIECE)))
        self._taken = end

    def _refused(self, error: OSError, what: str) -> AdcsError:
        if error.errno == errno.EEXIST:
            return AdcsError(f"{self.path} is there already: `adcs recover {self.path.parent}`, or remove it")
        return AdcsError(f"no room for {what} in {self.path}: {error.strerror}")


class JournalRecording(Recording):
    """Rows that go to a journal."""

    def __init__(self, system: System, record: Sequence[str] | None, journal: Journal) -> None:
        super().__init__(system, record)
        self._journal = journal

    @property
    def capacity(self) -> int:
        """The most rows for which there is room at once."""
        return self._journal.room(self.filled)

    def room(self, rows: int) -> Floats:
        """The next rows, to be filled."""
        self._journal.reserve(self.filled + rows)
        return super().room(rows)

    def commit(self, rows: int) -> None:
        """Keep what was filled."""
        super().commit(rows)
        self._journal.where.place.rows = self.filled


@dataclass(frozen=True)
class Kept:
    """What is in a journal: times (rows,) and data (rows, width), how it was described, and where the run was."""

    about: dict[str, Any]
    notes: dict[str, Any]
    ports: dict[str, Port]
    times: Floats
    data: Floats
    where: Where
    capacity: int
    """How many rows there were to be."""


def read(path: Path) -> Kept:
    """Read a journal, whether or not its run is alive; AdcsError if it is none, or not whole."""
    try:
        size = path.stat().st_size
        content = np.memmap(path, np.uint8, "r") if size else np.empty(0, np.uint8)
    except OSError as error:
        raise AdcsError(f"cannot open {path}: {error.strerror or error}") from error
    if size < _ABOUT or content[:16].tobytes() != _MAGIC:
        raise AdcsError(f"{path} is no journal of a run, or of one that had not begun")
    head = _Head.from_buffer_copy(content[: ctypes.sizeof(_Head)].tobytes())
    place = Place.from_buffer_copy(content[_PLACE : _PLACE + ctypes.sizeof(Place)].tobytes())
    end = head.rows + _pages(head.capacity * head.width * 8)
    if not (0 <= place.rows <= head.capacity and head.times + 8 * head.capacity <= head.rows <= end <= size):
        raise AdcsError(f"{path} is not whole: it was cut off, or changed")
    try:
        about = json.loads(content[_ABOUT : _ABOUT + head.about].tobytes())
        notes = json.loads(content[end : end + head.notes].tobytes()) if head.notes else {}
        ports = {name: _port_from_json(name.partition(".")[2], given) for name, given in about["ports"]}
        where = Where(place, about["components"])
    except (ValueError, KeyError, TypeError) as error:
        raise AdcsError(f"{path} is not whole: what it says of its run cannot be read") from error
    n, width = int(place.rows), int(head.width)
    times = np.frombuffer(content, np.float64, n, head.times)
    data = np.frombuffer(content, np.float64, n * width, head.rows).reshape(n, width)
    return Kept(about, notes, ports, times, data, where, int(head.capacity))


def _pages(size: int) -> int:
    return -(-size // _PAGE) * _PAGE


def _port_to_json(port: Port) -> dict[str, Any]:
    return {"shape": port.shape, "type": port.type, "unit": port.unit, "description": port.description}


def _port_from_json(name: str, given: dict[str, Any]) -> Port:
    return Port(
        name=name,
        shape=tuple(given["shape"]),
        type=given["type"],
        unit=given["unit"],
        causality="output",
        variability="continuous",
        initial=None,
        references=(),
        start=None,
        description=given["description"],
    )
