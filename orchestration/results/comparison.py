"""Whether a result is that of a file, to the last bit."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.errors import AdcsError
from orchestration.process.temporary import temporary_folder
from orchestration.results.result import Result

Columns = dict[str, NDArray[Any]]
"""What a file holds: rows of each column or variable, and `time`."""

NAMES = ("result.csv", "result.h5", "result.mat")
"""Files of results, those that are compared first."""


def deviation(result: Result, file: Path, *, may_go_on: bool = False) -> str | None:
    """Say where a result differs from a file of results (.csv, .h5, .mat) first, and by what; None if it does not.

    Where one of the two ends before the other, what both have is compared, and then that is said, unless the result
    `may_go_on` after the end of the file.
    """
    with temporary_folder("compared") as folder:
        written = folder / file.name
        {".csv": result.write_csv, ".h5": result.write_hdf5, ".mat": result.write_mat}[file.suffix](written)
        if file.suffix == ".csv" and written.read_bytes() == file.read_bytes():
            return None
        before, now = _read(file), _read(written)
    for name in before.keys() ^ now.keys():
        return f"{name} is recorded {'no more' if name in before else 'now, and was not'}"
    rows = [len(columns["time"]) for columns in (before, now)]
    both = min(rows)
    first = {name: row for name in before if (row := _first(before[name][:both], now[name][:both])) is not None}
    if first:
        name, row = min(first.items(), key=lambda item: item[1])
        old, new = (np.atleast_1d(columns[name][row]) for columns in (before, now))
        at = int(np.flatnonzero([a.tobytes() != b.tobytes() for a, b in zip(old.flat, new.flat, strict=True)])[0])
        time = float(before["time"][row])
        return f"{name} at t = {time:.9g} s was {old.flat[at]} and is {new.flat[at]}"
    return (
        None
        if rows[0] == rows[1] or (may_go_on and rows[0] < rows[1])
        else f"there were {rows[0]} rows and are {rows[1]}"
    )


def _first(before: NDArray[Any], now: NDArray[Any]) -> int | None:
    """Return the first row in which two columns differ by a bit."""
    if before.dtype.kind == "U" or now.dtype.kind == "U":
        differ = before != now
    else:
        if before.shape != now.shape or before.dtype != now.dtype:
            return 0
        raw = [np.ascontiguousarray(values).reshape(len(values), -1).view(np.uint8) for values in (before, now)]
        differ = (raw[0] != raw[1]).any(axis=1)
    found = np.flatnonzero(differ)
    return int(found[0]) if len(found) else None


def _read(path: Path) -> Columns:
    try:
        if path.suffix == ".csv":
            with path.open(encoding="utf-8", newline="") as file:
                header, *rows = csv.reader(file)
            names = ["time", *header[1:]]
            return {name: np.array(column) for name, column in zip(names, np.array(rows).T, strict=True)}
        if path.suffix == ".h5":
            return _from_hdf5(path)
        import scipy.io

        content = scipy.io.loadmat(path, chars_as_strings=False)
        structs = {key: value for key, value in content.items() if key not in ("time", "units") and key[:2] != "__"}
        fields = {f"{key}.{name}": s[name][0, 0] for key, s in structs.items() for name in s.dtype.names}
        return {"time": content["time"].ravel(), **fields}
    except (OSError, ValueError, KeyError) as error:
        raise AdcsError(f"{path} cannot be read as a result ({' '.join(str(error).split())})") from error


def _from_hdf5(path: Path) -> Columns:
    import h5py

    found: Columns = {}

    def see(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and name != "manifest":
            found[name] = item[()]

    with h5py.File(path) as file:
        file.visititems(see)
    return found
