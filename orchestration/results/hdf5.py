"""Results in HDF5: one dataset per variable, a group per component; written as a run goes on, read piece by piece."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fmus.errors import AdcsError
from orchestration.fmu.file import Port
from orchestration.plan.lowering import Floats
from orchestration.plan.schedule import split
from orchestration.process.disk import Disk
from orchestration.process.writing import make_folder, replacing
from orchestration.results.result import Recording, Result, typed
from orchestration.system import System

_BUFFER = 2**23  # values that are collected before they are written
_CHUNK = 512  # rows that are in one place of the file: on a full disk no more are lost for lack of a whole one
_INDEX, _DATASET, _SPARE = 256, 8192, 2**17  # bytes that HDF5 takes for a chunk, for a dataset, and once


class FileRecording(Recording):
    """Rows that go to a file as they come, so that a run may be longer than memory."""

    def __init__(self, system: System, record: Sequence[str] | None, path: Path) -> None:
        super().__init__(system, record)
        self.path = path
        check(path, self.ports)
        self._buffer = np.empty((max(1, _BUFFER // max(self.size, 1)), self.size))
        self._used = 0
        self._open: _File | None = None
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

    def close(self, times: Floats, manifest: Mapping[str, Any]) -> bool:
        """Write the times and what is known about the run; False if there is no file, as no row has room in one."""
        if not self._given_up:
            self._flush().close(times, manifest)
        return not self._given_up

    def _flush(self) -> _File:
        """Write what is kept; the file is made by the first rows, so that a refused run leaves an older one alone."""
        if self._open is None:
            if self.path.is_symlink():  # it is replaced, not followed
                self.path.unlink()
            self._open = _File(self.path, self.ports)
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

    @classmethod
    def of(cls, system: System, times: Floats, recording: FileRecording, manifest: dict[str, Any]) -> FileResult:
        """Return the result of a finished recording."""
        result = cls(system, times, np.empty((0, recording.size)), recording.ports, manifest)
        result.path = recording.path
        return result

    def __getitem__(self, name: str) -> Any:
        port = self._port(name)
        with h5py.File(self.path) as file:
            values = file[_place(self._recorded(name))][:]
        return typed(np.asarray(values, float).reshape(len(self.time), *port.shape), port)

    def block(self, first: int, last: int) -> Floats:
        """Rows first .. last-1."""
        n = min(last, len(self.time)) - first
        with h5py.File(self.path) as file:
            parts = [
                np.asarray(file[_place(name)][first:last], float).reshape(n, port.size)
                for name, port in self.ports.items()
            ]
        return np.hstack([np.empty((n, 0)), *parts])

    def select(self, names: Sequence[str]) -> Result:
        """Return the result with these variables only."""
        chosen = FileResult(self.system, self.time, self.data, {n: self._port(n) for n in names}, self.manifest)
        chosen.path = self.path
        return chosen


def write(result: Result, path: str | Path) -> None:
    """Write a result: `/time`, `/COMPONENT/VARIABLE` (rows, *shape) with attributes `unit` and `description`."""
    check(Path(path), result.ports)
    rows = max(1, _BUFFER // max(1, sum(port.size for port in result.ports.values())))
    with replacing(path) as name:
        file = _File(name, result.ports, path)
        try:
            for first in range(0, len(result.time), rows):
                file.append(result.block(first, min(first + rows, len(result.time))))
        finally:
            file.close(result.time, result.manifest)


def check(path: Path, ports: Mapping[str, Port]) -> None:
    """Refuse a place where no file can be, and names that cannot stand side by side in it."""
    if path.is_dir():
        raise AdcsError(f"cannot write {path}: it is a folder")
    places = [_place(name) for name in ports]
    for place in places:
        if place.partition("/")[0] in ("time", "manifest") or any(other.startswith(f"{place}/") for other in places):
            raise AdcsError(
                f"{place} cannot have a place in an HDF5 file beside the others: give the component another name"
            )


class _File:
    def __init__(self, path: Path, ports: Mapping[str, Port], shown: str | Path | None = None) -> None:
        self._ports = ports
        self._rows = 0
        shown = shown or path
        make_folder(path.parent, f"cannot write {shown}")
        try:
            self._disk = Disk(path, shown)
        except OSError as error:
            raise AdcsError(f"cannot write {shown}: {error.strerror or error}") from error
        self._file = h5py.File(self._disk, "w")
        for name, port in ports.items():
            made = self._file.create_dataset(
                _place(name),
                shape=(0, *port.shape),
                maxshape=(None, *(n or None for n in port.shape)),  # which is no limit; a chunk of nothing cannot be
                chunks=(_chunk(port), *(max(1, n) for n in port.shape)),
                dtype=typed(np.empty(0), port).dtype,
            )
            made.attrs["unit"] = port.unit or ""
            made.attrs["description"] = port.description

    def append(self, rows: Floats) -> None:
        """Add rows; AdcsError, and the file is as it was, if the disk has no room for them and for the end."""
        self._disk.reserve(self._size(self._rows + len(rows)))
        self._rows += len(rows)
        first = 0
        for name, port in self._ports.items():
            dataset = self._file[_place(name)]
            n = len(dataset)
            dataset.resize(n + len(rows), axis=0)
            dataset[n:] = typed(rows[:, first : first + port.size].reshape(len(rows), *port.shape), port)
            first += port.size

    def close(self, times: Floats, manifest: Mapping[str, Any]) -> None:
        self._file["time"] = times
        self._file["time"].attrs["unit"] = "s"
        self._file["manifest"] = json.dumps(manifest)
        self._file.close()
        self._disk.close()

    def discard(self) -> None:
        """Close the file, whatever is in it."""
        self._file.close()
        with suppress(AdcsError):
            self._disk.close()

    def _size(self, rows: int) -> int:
        """A bound on the size of the file with so many rows: whole chunks, the times, and what HDF5 adds."""
        sizes = [max(1, port.size) for port in self._ports.values()]
        chunks = [_chunk(port) * size * 8 for port, size in zip(self._ports.values(), sizes, strict=True)]
        counts = [-(-rows * port.size * 8 // size) for port, size in zip(self._ports.values(), chunks, strict=True)]
        data = sum(n * (size + _INDEX) for n, size in zip(counts, chunks, strict=True))
        return data + 8 * rows + len(self._ports) * _DATASET + _SPARE


def _chunk(port: Port) -> int:
    return max(1, min(_CHUNK, 2**15 // max(1, port.size)))


def _place(name: str) -> str:
    """`bus/battery.charge` -> `bus/battery/charge`; a slash in a variable would make a group."""
    component, variable = split(name)
    return f"{component}/{variable.replace('/', '_')}"
