"""What a run leaves: the recorded rows and how they came about, in memory and as CSV, MAT and JSON files."""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from orchestration.fmu.file import Port, element_names
from orchestration.plan.lowering import Floats
from orchestration.plan.schedule import Name, split
from orchestration.process.writing import replacing
from orchestration.system import NUMERIC, System


class Recording:
    """The rows of a run while it goes on: `data` (rows, row size), of which the first `filled` are valid."""

    def __init__(self, system: System, record: Sequence[str] | None, rows: int = 0) -> None:
        """`record` names `component.variable`; None means every output of a numeric type."""
        self.ports: dict[str, Port] = {}
        for name in system.outputs() if record is None else record:
            port = system.port(name)[1]
            if not port.type.startswith(NUMERIC):
                raise AdcsError(f"{name} is of type {port.type}: only numbers and Booleans can be recorded")
            if name.partition(".")[2] != port.name:
                raise AdcsError(f"{name} is an element of an array: record {name.rpartition('[')[0]}")
            self.ports[name] = port
        self.filled = 0
        self.size = sum(port.size for port in self.ports.values())
        self.data = self._allocate(rows)

    def _allocate(self, rows: int) -> Floats:
        try:
            return np.empty((rows, self.size))
        except (MemoryError, ValueError):  # of more than can be addressed
            raise AdcsError(
                f"{rows} rows of {self.size} values do not fit into memory: write them to a file as they come "
                "(--format hdf5), record fewer variables, or not every step"
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


@dataclass
class Result:
    """The recorded values of a run.

    `result["plant.q_BN"]` is an array (rows, *shape of the variable), `time` is (rows,). After coupled Model Exchange
    `states` (rows, number of states) holds the continuous states that `state_names` name; else it is empty.
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

    def __getitem__(self, name: str) -> Any:
        port = self._port(name)
        first = self._first[self._recorded(name)]
        return typed(self.data[:, first : first + port.size].reshape(len(self.time), *port.shape), port)

    def block(self, first: int, last: int) -> Floats:
        """Rows first .. last-1, all variables side by side as numbers."""
        return self.data[first:last]

    def unit(self, name: str) -> str | None:
        """Unit of a recorded variable; None if it has none."""
        return self._port(name).unit

    def description(self, name: str) -> str:
        """Description of a recorded variable."""
        return self._port(name).description

    def select(self, names: Sequence[str]) -> Result:
        """Return the result with these variables only."""
        ports = {name: self._port(name) for name in names}
        firsts = [self._first[self._recorded(name)] for name in ports]
        parts = [self.data[:, first : first + p.size] for first, p in zip(firsts, ports.values(), strict=True)]
        return replace(self, data=np.hstack([np.empty((len(self.time), 0)), *parts]), ports=ports)

    def write_csv(self, path: str | Path) -> None:
        """Write one row per communication point, numbers with all their digits; header `name[unit]`, `[-]` if none."""
        header = ["time[s]"]
        for name, port in self.ports.items():
            header += [f"{element}[{port.unit or '-'}]" for element in element_names(name, port.shape)]
        write = [float, *(_written_as(port) for port in self.ports.values() for _ in range(port.size))]
        with replacing(path) as to, to.open("w", encoding="utf-8", newline="\n") as file:
            file.write(",".join(f'"{h}"' if "," in h else h for h in header) + "\n")
            for first in range(0, len(self.time), _LINES):
                rows = self.block(first, min(first + _LINES, len(self.time)))
                for time, row in zip(self.time[first:].tolist(), rows.tolist(), strict=False):
                    file.write(",".join([repr(w(v)) for w, v in zip(write, [time, *row], strict=True)]) + "\n")

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
        from orchestration.results import hdf5

        hdf5.write(self, path)

    def write_manifest(self, path: str | Path) -> None:
        """Write all that is needed to repeat the run, as JSON."""
        with replacing(path) as to:
            to.write_text(json.dumps(self.manifest, indent=2) + "\n", encoding="utf-8")

    def _recorded(self, name: str) -> str:
        """Return the name under which a variable was recorded that may have several."""
        if name in self.ports:
            return name
        try:
            return self.system.among(self.ports, name) or name
        except AdcsError:  # there is no such variable
            return name

    def _port(self, name: str) -> Port:
        name = self._recorded(name)
        if name not in self.ports:
            close = difflib.get_close_matches(name, self.ports, 3, 0.5)
            hint = f"did you mean {' or '.join(close)}?" if close else f"recorded are {', '.join(self.ports) or 'none'}"
            raise AdcsError(f"{name!r} was not recorded: {hint}")
        return self.ports[name]


def typed(values: Floats, port: Port) -> Any:
    """Return numbers as what they are: Boolean values as bool, integers as int64."""
    if port.type == "Boolean":
        return values != 0
    return values if port.type.startswith("Float") else values.astype(np.int64)


_LINES = 10_000  # of a CSV file, that are written at once


def _written_as(port: Port) -> type:
    return float if port.type.startswith("Float") else int


class RunFailed(AdcsError):
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
