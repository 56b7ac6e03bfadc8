"""Results in HDF5: one dataset per variable, a group per component."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fmus.errors import AdcsError
from orchestration.fmu.file import Port
from orchestration.fmu.typed_values import typed
from orchestration.plan.lowering import Floats
from orchestration.plan.schedule import split
from orchestration.process.disk import Disk
from orchestration.process.writing import make_folder, replacing

if TYPE_CHECKING:
    from orchestration.results.result import Result

FORMAT = "adcs-results-1"
"""What a file says of itself: attribute `format` of its root."""

AT_ONCE = 2**23
"""Values that are written at once."""

_CHUNK = 512  # rows that are in one place of the file: on a full disk no more are lost for lack of a whole one
_INDEX, _DATASET, _SPARE = 256, 8192, 2**17  # bytes that HDF5 takes for a chunk, for a dataset, and once


def write(result: Result, path: str | Path) -> None:
    """Write a result: `/time`, `/COMPONENT/VARIABLE` (rows, *shape) with attributes `unit` and `description`."""
    check(Path(path), result.ports)
    rows = max(1, AT_ONCE // max(1, sum(port.size for port in result.ports.values())))
    with replacing(path) as name:
        file = File(name, result.ports, path)
        try:
            for first in range(0, len(result.time), rows):
                file.append(result.block(first, min(first + rows, len(result.time))))
        finally:
            file.close(result.time, result.manifest)


def check(path: Path, ports: Mapping[str, Port]) -> None:
    """Refuse a place where no file can be, and names that cannot stand side by side in it."""
    import h5py  # here, for runs without such a file

    if path.is_dir():
        raise AdcsError(f"cannot write {path}: it is a folder")
    if path.is_file() and not path.is_symlink() and path.stat().st_size and not h5py.is_hdf5(path):
        raise AdcsError(f"cannot write {path}: a file that is not HDF5 is there: give another name")
    places = [dataset_of(name) for name in ports]
    for place in places:
        if place.partition("/")[0] in ("time", "manifest") or any(other.startswith(f"{place}/") for other in places):
            raise AdcsError(
                f"{place} cannot have a place in an HDF5 file beside the others: give the component another name"
            )


class File:
    """A file to which rows are appended."""

    def __init__(self, path: Path, ports: Mapping[str, Port], shown: str | Path | None = None) -> None:
        import h5py

        self._ports = ports
        self._rows = 0
        shown = shown or path
        make_folder(path.parent, f"cannot write {shown}")
        try:
            self._disk = Disk(path, shown)
        except OSError as error:
            raise AdcsError(f"cannot write {shown}: {error.strerror or error}") from error
        self._file = h5py.File(self._disk, "w")
        self._file.attrs["format"] = FORMAT
        for name, port in ports.items():
            made = self._file.create_dataset(
                dataset_of(name),
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
            held = self._file[dataset_of(name)]
            n = len(held)
            held.resize(n + len(rows), axis=0)
            held[n:] = typed(rows[:, first : first + port.size].reshape(len(rows), *port.shape), port)
            first += port.size

    def close(self, times: Floats, manifest: Mapping[str, Any]) -> None:
        """Write the times and what is known about the run, and close it."""
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


def dataset_of(name: str) -> str:
    """`bus/battery.charge` -> `bus/battery/charge`; a slash in a variable would make a group."""
    component, variable = split(name)
    return f"{component}/{variable.replace('/', '_')}"
