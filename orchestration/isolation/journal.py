"""The journal of a run: its rows, and where it is, in a file that is mapped into memory and outlives the process.

    0      magic, five numbers (`_Head`)
    64     where the run is (`Place`)
    1024   why it failed (`_Failure`): room that is there on a full disk, too
    4096   what the run is, as JSON, and the grid of its times
    then   rows; notes on how it ended, as JSON

Disk space is taken before it is written to: in a mapped file a full disk would end the process. That for the notes is
taken first; a run that fails has none to make, and gives it back for its manifest.
"""

from __future__ import annotations

import ctypes
import errno
import json
import mmap
import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import astuple, dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from fmus.errors import AdcsError, Failed, shown
from fmus.nearby import not_opened
from orchestration.fmu.file import Port
from orchestration.grid import Grid
from orchestration.plan.lowering import Floats
from orchestration.process.format import refuse_other_version
from orchestration.process.own_file import OwnFile
from orchestration.process.where import Place, Where
from orchestration.results.result import Recording
from orchestration.system import System

NAME = "run.journal"
_FORMAT = "adcs-journal-2"
_MAGIC = f"{_FORMAT}\n".encode().ljust(16, b"\0")
_PLACE, _FAILURE, _ABOUT = 64, 1024, 4096  # where they begin
_PAGE = 4096
_PIECE = 2**26  # bytes, that are taken from the disk at once
_MORE = 4096  # bytes, by which the notes may be longer than what the run is


class _Head(ctypes.LittleEndianStructure):
    _fields_ = (
        ("magic", ctypes.c_char * 16),
        ("about", ctypes.c_uint64),  # size
        ("rows", ctypes.c_uint64),  # where they begin
        ("width", ctypes.c_uint64),  # of a row
        ("capacity", ctypes.c_uint64),  # in rows
        ("notes", ctypes.c_uint64),  # size; they begin after the last row there is room for
    )


class _Failure(ctypes.LittleEndianStructure):
    _fields_ = (("size", ctypes.c_uint64), ("text", ctypes.c_char * (_ABOUT - _FAILURE - 8)))


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
        self._file: OwnFile | None = None
        self._taken = 0

    def record(self, system: System, record: Sequence[str] | None) -> JournalRecording:
        """Return what takes the rows, after `begin`."""
        self.recording = JournalRecording(system, record, self)
        return self.recording

    def begin(self, system: System, grid: Grid, manifest: dict[str, Any], first: int = 0, every: int = 1) -> None:
        """Make the file, for a row at every `every`-th point of a grid from point `first` on."""
        assert self.recording is not None
        self._prepare(manifest)
        about = {
            **self._about,
            "pid": os.getpid(),
            "manifest": manifest,
            "components": list(system.components),
            "grid": astuple(grid),
            "points": [first, every],
            "ports": [[name, _port_to_json(port)] for name, port in self.recording.ports.items()],
        }
        text = json.dumps(about).encode()
        self._times = partial(grid.places, first, every)
        rows, width = grid.capacity(first, every), self.recording.size
        self._rows_at, self._row = _pages(_ABOUT + len(text)), width * 8
        self._end = self._rows_at + _pages(rows * self._row)
        try:
            self._file = OwnFile(self.path, os.O_CREAT | os.O_EXCL)
            self._take(self._rows_at)
            os.ftruncate(self._file.number, self._end)
            self._for_notes = len(text) + _MORE
            try:
                self._allocate(self._end, self._for_notes)
            except OSError:  # they are of use, but not needed
                self._for_notes = 0
            self._map = mmap.mmap(self._file.number, self._end + self._for_notes)
        except OSError as error:
            self.close()
            raise self._refused(error, "the journal of the run") from error
        self._head = _Head.from_buffer(self._map)
        self._map[_ABOUT : _ABOUT + len(text)] = text
        self.recording.data = np.frombuffer(self._map, np.float64, rows * width, self._rows_at).reshape(rows, width)
        self.where.names = list(system.components)
        self.where.move(Place.from_buffer(self._map, _PLACE))
        self._head.about, self._head.rows = len(text), self._rows_at
        self._head.width, self._head.capacity = width, rows
        self.where.at_finish = lambda: self.note(manifest)
        self._head.magic = _MAGIC

    def room(self, rows: int) -> int:
        """How many rows there is disk space for after so many, and at least one: `reserve` says if there is none."""
        if self._rows_at + (rows + 1) * self._row > self._taken:
            piece = _PIECE
            while piece >= _PAGE:
                with suppress(OSError):
                    self._take(max(self._taken, self._rows_at + rows * self._row) + piece)
                    break
                piece //= 2
        return max(1, (self._taken - self._rows_at) // max(self._row, 1) - rows)

    def reserve(self, rows: int) -> None:
        """Make sure that there is disk space for so many rows; AdcsError if there is not."""
        end = self._rows_at + rows * self._row
        if end > self._taken:
            try:
                self._take(end)
            except OSError as error:
                time = self._times((self._taken - self._rows_at) // self._row + 1)[-1]
                raise self._refused(error, f"another row at t = {time:.9g} s") from error

    def note(self, notes: dict[str, Any]) -> None:
        """Note how the run came out, when there is no more to come but its end."""
        text = json.dumps(notes).encode()
        if len(text) <= self._for_notes:
            self._map[self._end : self._end + len(text)] = text
        else:
            try:
                os.lseek(self._number, self._end, os.SEEK_SET)
                os.write(self._number, text)
            except OSError:
                return
        self._head.notes = len(text)

    def fail(self, outcome: Mapping[str, Any]) -> None:
        """Note why the run has failed, when there are no more rows to come."""
        failure = _Failure.from_buffer(self._map, _FAILURE)
        text = json.dumps({**outcome, "message": shown(outcome["message"], 400)}).encode()
        if len(text) < _Failure.text.size:
            failure.text, failure.size = text, len(text)
        self._for_notes = 0
        with suppress(OSError):  # of Windows, where a file that is mapped keeps its size
            os.ftruncate(self._number, self._end)

    def close(self, *, remove: bool = False) -> None:
        """Close the file; `remove` it when all that is in it is elsewhere. Rows stay readable in this process."""
        if self._file is not None:
            self._file.close()
            self._file = None
        if remove:
            with suppress(PermissionError):  # of Windows, which removes no file that is mapped: the next run does
                self.path.unlink(missing_ok=True)

    @property
    def _number(self) -> int:
        assert self._file is not None
        return self._file.number

    def _take(self, end: int) -> None:
        """Take the file's disk space up to `end`, and to the end of that page: pages of memory are written whole."""
        end = max(self._taken, min(-(-end // mmap.PAGESIZE) * mmap.PAGESIZE, self._end))
        self._allocate(self._taken, end - self._taken)
        self._taken = end

    def _allocate(self, first: int, size: int) -> None:
        if size > 0 and hasattr(os, "posix_fallocate"):
            os.posix_fallocate(self._number, first, size)
        elif size > 0:  # what was never written is only promised
            os.lseek(self._number, first, os.SEEK_SET)
            while size > 0:
                size -= os.write(self._number, bytes(min(size, _PIECE)))

    def _refused(self, error: OSError, what: str) -> AdcsError:
        if error.errno == errno.EEXIST:
            return Failed(f"{self.path} is there already: `adcs recover {self.path.parent}`, or remove it")
        return Failed(f"no room for {what} in {self.path}: {error.strerror}")


class JournalRecording(Recording):
    """Rows that go to a journal."""

    def __init__(self, system: System, record: Sequence[str] | None, journal: Journal) -> None:
        super().__init__(system, record)
        self._journal = journal
        self.where = journal.where

    @property
    def printed(self) -> Callable[[], bool] | None:
        """Says whether components have printed to the standard output since it was asked; None if nobody knows."""
        return self._journal.printed

    def begin(self, grid: Grid, manifest: dict[str, Any], first: int, every: int) -> None:
        """Make the file."""
        self._journal.begin(self.system, grid, manifest, first, every)

    def fail(self, outcome: Mapping[str, Any]) -> None:
        """Note it in the file."""
        self._journal.fail(outcome)

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
    failure: dict[str, Any]
    """The outcome of a run that had failed before its process ended; empty if it had not."""
    ports: dict[str, Port]
    data: Floats
    where: Where
    capacity: int
    """How many rows there were to be."""

    @cached_property
    def times(self) -> Floats:
        """Of the rows [s], as their grid has them."""
        first, every = self.about["points"]
        return Grid(*self.about["grid"]).places(first, every, len(self.data))


def read(path: Path) -> Kept:
    """Read a journal, whether or not its run is alive; AdcsError if it is none, of another version, or not whole."""
    try:
        size = path.stat().st_size
        content = np.memmap(path, np.uint8, "r") if size else np.empty(0, np.uint8)
    except OSError as error:
        raise not_opened(path, error) from error
    magic = content[:16].tobytes()
    said = magic.partition(b"\n")[0].decode("ascii", "replace")
    refuse_other_version(path, "a journal", said, _FORMAT, "recover it with the adcs-fmus that wrote it")
    if size < _ABOUT or magic != _MAGIC:
        raise AdcsError(f"{path} is no journal of a run, or of one that had not begun")
    head = _Head.from_buffer_copy(content[: ctypes.sizeof(_Head)].tobytes())
    place = Place.from_buffer_copy(content[_PLACE : _PLACE + ctypes.sizeof(Place)].tobytes())
    end = head.rows + _pages(head.capacity * head.width * 8)
    if not (0 <= place.rows <= head.capacity and head.rows <= end <= size):
        raise AdcsError(f"{path} is not whole: it was cut off, or changed")
    try:
        about = json.loads(content[_ABOUT : _ABOUT + head.about].tobytes())
        notes = json.loads(content[end : end + head.notes].tobytes()) if head.notes else {}
        failure = _Failure.from_buffer_copy(content[_FAILURE:_ABOUT].tobytes())
        failed = json.loads(failure.text[: failure.size]) if failure.size else {}
        ports = {name: _port_from_json(name.partition(".")[2], given) for name, given in about["ports"]}
        where = Where(place, about["components"])
    except (ValueError, KeyError, TypeError) as error:
        raise AdcsError(f"{path} is not whole: what it says of its run cannot be read") from error
    n, width = int(place.rows), int(head.width)
    data = np.frombuffer(content, np.float64, n * width, head.rows).reshape(n, width)
    return Kept(about, notes, failed, ports, data, where, int(head.capacity))


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
