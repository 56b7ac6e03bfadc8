"""What a run leaves: the recorded rows and how they came about, in memory and as CSV, MAT and JSON files."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fmus.errors import AdcsError, Failed, shown
from fmus.spelling import hint
from orchestration import expected
from orchestration.fmu.file import Port, element_names
from orchestration.fmu.typed_values import typed
from orchestration.grid import Grid
from orchestration.plan.lowering import Floats
from orchestration.plan.schedule import Name, split
from orchestration.process.where import Where
from orchestration.process.writing import replacing
from orchestration.results import frames, hdf5, summary
from orchestration.results.lines import lines
from orchestration.system import NUMERIC, System

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame
    from xarray import Dataset


class Recording:
    """The rows of a run while it goes on: `data` (rows, row size), of which the first `filled` are valid."""

    def __init__(self, system: System, record: Sequence[str] | None, rows: int = 0) -> None:
        """`record` names `component.variable`; None means every output of a numeric type."""
        if record is not None:
            expected.texts("record", record)
        self.ports: dict[str, Port] = {}
        for name in system.outputs() if record is None else record:
            port = system.port(name)[1]
            if not port.type.startswith(NUMERIC):
                raise AdcsError(f"{name} is of type {port.type}: only numbers and Booleans can be recorded")
            if name.partition(".")[2] != port.name:
                raise AdcsError(f"{name} is an element of an array: record {name.rpartition('[')[0]}")
            self.ports[name] = port
        self.system = system
        self.where = Where()
        """Where the run is, of which these are the rows."""
        self.filled = 0
        self.size = sum(port.size for port in self.ports.values())
        self.data = self._allocate(rows)

    def _allocate(self, rows: int) -> Floats:
        try:
            return np.empty((rows, self.size))
        except (MemoryError, ValueError):  # of more than can be addressed
            raise AdcsError(
                f"{rows} rows of {self.size} values do not fit into memory: write them to a file as they come "
                '(adcs.Save(to="run.h5"), --format hdf5), record fewer variables, or not every step'
            ) from None

    @property
    def capacity(self) -> int:
        """The most rows for which there is room at once."""
        return max(1, len(self.data))

    def room(self, rows: int) -> Floats:
        """The next rows, to be filled."""
        return self.data[self.filled : self.filled + rows]

    def commit(self, rows: int) -> None:
        """Keep what was filled."""
        self.filled += rows

    @property
    def names(self) -> list[Name]:
        """The recorded variables in the order of the columns."""
        return [split(name) for name in self.ports]

    @property
    def printed(self) -> Callable[[], bool] | None:
        """Says whether components have printed to the standard output since it was asked; None if nobody knows."""
        return None

    def begin(self, grid: Grid, manifest: dict[str, Any], first: int, every: int) -> None:
        """See a run that was found right: rows are of every `every`-th point of the grid from `first` on."""

    def flush(self) -> None:
        """Write what is to go to a file and has not; AdcsError without room."""

    def fail(self, outcome: Mapping[str, Any]) -> None:
        """See that the run has failed, and how: there are no more rows to come."""

    def result(self, times: Floats, manifest: dict[str, Any]) -> Result:
        """Return what was recorded, at these times (s)."""
        return Result(self.system, times, self.data[: len(times)], self.ports, manifest)


class Unrecorded(Recording):
    """Rows that nobody keeps."""

    def __init__(self, system: System, record: Sequence[str] | None) -> None:
        super().__init__(system, record, 1)

    def room(self, rows: int) -> Floats:
        """The next rows, to be filled over those before."""
        return self.data[:rows]


@dataclass(eq=False, repr=False)
class Result:
    """The recorded values of a run.

    `result["plant.q_BN"]` is an array (rows, *shape of the variable), `result["plant.q_BN[2]"]` one element of it,
    counted from 1, and `time` is (rows,). After coupled Model Exchange `states` (rows, number of states) holds the
    continuous states that `state_names` name; else it is empty.

    As in a dict, `in` asks for a name (or an element), and iteration and `len` go over the names of the variables;
    the number of rows is `len(result.time)`. Two results are equal if they have the same variables, times and values,
    bit by bit; NaN is equal to NaN. How they came about does not count.
    """

    system: System
    time: Floats
    data: Floats
    ports: dict[str, Port]
    manifest: dict[str, Any]
    states: Floats = field(default_factory=lambda: np.empty((0, 0)))
    state_names: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._first = dict(zip(self.ports, np.cumsum([0, *(p.size for p in self.ports.values())]), strict=False))

    @property
    def names(self) -> list[str]:
        """The recorded variables, `component.variable`."""
        return list(self.ports)

    def __getitem__(self, name: str) -> NDArray[Any]:
        recorded, element = self._find(name)
        port = self.ports[recorded]
        values = self._read(recorded, element)
        shape = (len(self.time), *(port.shape if element is None else ()))
        found: NDArray[Any] = typed(values.reshape(shape), port)
        return found

    def __contains__(self, name: object) -> bool:
        try:
            self._find(name)
        except AdcsError:
            return False
        return True

    def __iter__(self) -> Iterator[str]:
        return iter(self.ports)

    def __len__(self) -> int:
        return len(self.ports)

    def keys(self) -> list[str]:
        """The recorded variables, as those of a dict."""
        return self.names

    def items(self) -> Iterator[tuple[str, Any]]:
        """Name and values of each recorded variable."""
        return ((name, self[name]) for name in self.ports)

    def get(self, name: str, default: Any = None) -> Any:
        """Return the values of a variable or an element, or the default if it was not recorded."""
        try:
            return self[name]
        except AdcsError:
            return default

    def __bool__(self) -> bool:
        return True  # also where no variable was recorded

    def __eq__(self, other: object) -> bool:
        return _equal(self, other) if isinstance(other, Result) else NotImplemented

    def __repr__(self) -> str:
        return summary.text(self)

    def _repr_html_(self) -> str:
        return summary.html(self)

    def _read(self, name: str, element: int | None) -> Floats:
        """The values of a recorded variable, or of one element of it, as numbers."""
        first = self._first[name]
        if element is not None:
            return self.data[:, first + element]
        return self.data[:, first : first + self.ports[name].size]

    def block(self, first: int, last: int) -> Floats:
        """Rows first .. last-1, all variables side by side as numbers."""
        return self.data[first:last]

    def unit(self, name: str) -> str | None:
        """Unit of a recorded variable; None if it has none."""
        return self.ports[self._find(name)[0]].unit

    def description(self, name: str) -> str:
        """Description of a recorded variable."""
        return self.ports[self._find(name)[0]].description

    def select(self, names: Sequence[str]) -> Result:
        """Return the result with these variables only."""
        expected.texts("names", names)
        whole = [self._whole(name) for name in names]
        ports = {name: self.ports[recorded] for name, recorded in zip(names, whole, strict=True)}
        parts = [self._read(recorded, None) for recorded in whole]
        data = np.hstack([np.empty((len(self.time), 0)), *parts])
        return replace(self, data=data, ports=ports, manifest={**self.manifest, "written": list(names)})

    def to_pandas(self) -> DataFrame:
        """Return a DataFrame over time [s], with a column for each element; `attrs["units"]` has the units."""
        return frames.to_pandas(self)

    def to_xarray(self) -> Dataset:
        """Return a Dataset over time [s], with an array for each variable and its unit in the `attrs` of that.

        The elements are counted from 1 along `plant.q_BN_dim_1`, `plant.J_B_dim_2` and so on.
        """
        return frames.to_xarray(self)

    def plot(self, *names: str) -> Figure:
        """Draw variables or elements over time, each in a panel of its own; by default all that were recorded.

        What comes back shows itself in a notebook; `savefig` writes it to a file.
        """
        from orchestration.results import plots

        if not (names or self.ports):
            raise AdcsError("there is nothing to plot: no variable was recorded")
        drawn = names or tuple(self.ports)
        return plots.make_figure([plots.over_time(name, self.time, self[name], self.unit(name)) for name in drawn])

    def write_csv(self, path: str | Path) -> None:
        """Write one row per communication point, numbers with all their digits; header `name[unit]`, `[-]` if none."""
        header = ["time[s]"]
        for name, port in self.ports.items():
            header += [f"{element}[{port.unit or '-'}]" for element in element_names(name, port.shape)]
        ports = self.ports.values()
        whole = np.array([False, *(not p.type.startswith("Float") for p in ports for _ in range(p.size))])
        with replacing(path) as to, to.open("wb") as file:
            file.write((",".join(f'"{h}"' if "," in h else h for h in header) + "\n").encode())
            for first in range(0, len(self.time), _LINES):
                rows = self.block(first, min(first + _LINES, len(self.time)))
                file.write(lines(np.column_stack([self.time[first : first + _LINES], rows]), whole))

    def write_mat(self, path: str | Path) -> None:
        """Write a MATLAB file with `time` and one struct per component, so that `plant.q_BN` is the name there too.

        `units` holds the units in the same structs. Characters that MATLAB does not allow in names become `_`.
        """
        tree: dict[str, Any] = {"time": self.time}
        units: dict[str, Any] = {}
        taken: dict[str, dict[str, str]] = {"": {".time": "time", ".units": "units"}}
        for name, port in self.ports.items():
            component, variable = split(name)
            struct = _matlab_name(component, taken[""])
            field_ = _matlab_name(variable, taken.setdefault(component, {}))
            tree.setdefault(struct, {})[field_] = self[name]
            units.setdefault(struct, {})[field_] = port.unit or ""
        import scipy.io  # here, since a run in a process of its own needs none

        content = {**tree, "units": units}
        with replacing(path if str(path).endswith(".mat") else f"{path}.mat") as to, to.open("wb") as file:
            scipy.io.savemat(file, content, long_field_names=True, oned_as="column")

    def write_hdf5(self, path: str | Path) -> None:
        """Write one dataset per variable, `/plant/q_BN` (rows, *shape), with its unit and description; and `/time`."""
        hdf5.write(self, path)

    def write_manifest(self, path: str | Path) -> None:
        """Write all that is needed to repeat the run, as JSON."""
        with replacing(path) as to:
            to.write_text(json.dumps(self.manifest, indent=2) + "\n", encoding="utf-8")

    def _find(self, name: object) -> tuple[str, int | None]:
        """Return the name under which a variable was recorded that may have several, and which element is meant."""
        if not isinstance(name, str):
            raise AdcsError(
                f"{shown(repr(name))} names no variable: give a text as {next(iter(self), 'component.variable')!r}"
            )
        if name in self.ports:
            return name, None
        try:
            end = self.system.end(name)
        except AdcsError:
            if "[" in name and name.rpartition("[")[0] in self:  # it has no such element
                raise
            raise self._unknown(name) from None
        whole = self.system.among(self.ports, name)
        if whole is not None:
            return whole, None
        nodes = self.system.components[end.component].fmu.nodes
        if len(end.elements) == 1:
            place = nodes.place(end.port, end.elements[0])
            for recorded, port in self.ports.items():
                if split(recorded)[0] == end.component:
                    for i in range(port.size):
                        if nodes.place(port, i) == place:
                            return recorded, i
        raise self._unknown(name)

    def _whole(self, name: str) -> str:
        """Return the name under which a variable was recorded; refuse an element of one."""
        recorded, element = self._find(name)
        if element is not None:
            raise AdcsError(f"{name} is an element of an array: select {recorded}")
        return recorded

    def _unknown(self, name: str) -> AdcsError:
        if name == "time":
            return AdcsError("'time' is no variable: it is result.time")
        return AdcsError(f"{name!r} was not recorded: {hint(name, self.ports, 'recorded are')}")


def _equal(one: Result, other: Result) -> bool:
    def layout(result: Result) -> dict[str, Any]:
        return {name: (port.shape, typed(np.empty(0), port).dtype) for name, port in result.ports.items()}

    if layout(one) != layout(other) or not _same_bits(one.time, other.time):
        return False
    return all(_same_bits(one._read(name, None), other._read(name, None)) for name in one)


def _same_bits(one: Floats, other: Floats) -> bool:
    """Whether two arrays of as many doubles are the same to the last bit, or NaN at the same places."""
    a, b = (np.ascontiguousarray(values, float).ravel() for values in (one, other))
    return a.size == b.size and bool(np.all((a.view(np.int64) == b.view(np.int64)) | (np.isnan(a) & np.isnan(b))))


_LINES = 10_000  # of a CSV file, that are written at once


class RunFailed(Failed):
    """A component failed while running; `result` holds what was recorded until then."""

    def __init__(self, message: str, result: Result) -> None:
        super().__init__(message)
        self.result = result


class RunInterrupted(KeyboardInterrupt):
    """Ctrl-C while running; `result` holds what was recorded until then."""

    def __init__(self, result: Result) -> None:
        super().__init__(f"interrupted at t = {result.time[-1] if len(result.time) else '-'} s")
        self.result = result


def _matlab_name(name: str, taken: dict[str, str]) -> str:
    """Make a valid and unused name; `taken` remembers which original got which."""
    if name not in taken:
        valid = re.sub(r"\W", "_", name, flags=re.ASCII).strip("_")
        valid = (valid if valid[:1].isalpha() else f"x_{valid}")[:60]
        candidates = (valid, *(f"{valid}_{i}" for i in range(2, 100)))
        taken[name] = next(c for c in candidates if c not in taken.values())
    return taken[name]
