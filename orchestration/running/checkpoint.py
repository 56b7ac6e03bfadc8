"""A simulation in a file: saved at a point, and gone on from there to the last bit."""

from __future__ import annotations

import io
import json
from contextlib import suppress
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from fmus.archive import Archive
from fmus.errors import AdcsError, shown
from fmus.nearby import not_opened
from orchestration.process.format import refuse_other_version
from orchestration.process.writing import replacing
from orchestration.running.method import Method
from orchestration.running.simulation import Simulation

_FORMAT = "adcs-checkpoint-1"


def is_checkpoint(path: Path) -> bool:
    """Whether a file is a checkpoint, of whatever version."""
    with suppress(OSError, ValueError, BadZipFile, EOFError), np.load(path, allow_pickle=False) as content:
        return "about" in getattr(content, "files", ())
    return False


@dataclass(frozen=True)
class Checkpoint:
    """Point `k`, what belongs to the system that was there, and its state."""

    path: Path
    k: int
    about: dict[str, Any]
    arrays: dict[str, NDArray[Any]]

    @classmethod
    def read(cls, path: Path) -> Checkpoint:
        """Read a file that `write` made."""
        none = AdcsError(f"{path} is not a checkpoint of this program: give a file that `checkpoint` has written")
        try:
            with Archive(path):  # refuses what would be larger than memory
                pass
            with np.load(path, allow_pickle=False) as file:
                arrays = {name: file[name] for name in file.files}
            about = json.loads(arrays.pop("about").tobytes())
            said, k = about.pop("format"), about.pop("k", None)
        except OSError as error:
            raise not_opened(path, error) from error
        except AdcsError as error:
            if str(error).startswith("cannot open"):
                raise
            raise none from error
        except Exception:  # numpy and zipfile let many kinds out
            raise none from None
        way_out = "run from the start, or go on with the adcs-fmus that wrote it"
        refuse_other_version(path, "a checkpoint", said, _FORMAT, way_out)
        if said != _FORMAT or not isinstance(k, int) or k < 0:
            raise none
        return cls(path, k, about, arrays)

    @property
    def method(self) -> dict[str, Any] | None:
        """The settings of its method, unless that is co-simulation."""
        method = self.about.get("method")
        return dict(method) if isinstance(method, dict) else None

    def apply(self, simulation: Simulation, method: Method) -> None:
        """Take a simulation that was just initialised to the point; AdcsError if it is of another system."""
        for key, here in {"method": None, **_about(simulation, method)}.items():
            there = self.about.get(key)
            if here != there:
                raise AdcsError(f"{self.path} is of another run: {_difference(key, there, here)}")
        if not aligned(simulation, self.k):
            raise not_aligned(simulation, self.k)
        states = [f"state_{i}" for i in range(len(simulation.instances))]
        expected = simulation.memory()
        fits = all(
            name in self.arrays and self.arrays[name].shape == array.shape and self.arrays[name].dtype == array.dtype
            for name, array in expected.items()
        )
        if not fits or not all(name in self.arrays and self.arrays[name].dtype == np.uint8 for name in states):
            raise AdcsError(f"{self.path} is not complete, or of another run")
        for i, instance in enumerate(simulation.instances.values()):
            try:
                state = instance.deserialize(self.arrays[f"state_{i}"].tobytes())
            except (ValueError, TypeError, KeyError, OverflowError):  # what is kept of clocks and events
                raise AdcsError(f"{self.path}: the saved state of {instance.name} is damaged") from None
            instance.restore(state)
            instance.free(state)
        simulation.remember(self.k, self.arrays)


def content(simulation: Simulation, k: int, method: Method) -> bytes:
    """Return what `write` saves: a simulation at point k, at which all its components communicate.

    What was propagated there is propagated again when it is gone on with; of Model Exchange, the last step is made
    again.
    """
    arrays: dict[str, NDArray[Any]] = {
        "about": np.frombuffer(
            json.dumps({"format": _FORMAT, "k": k, **_about(simulation, method)}).encode(), np.uint8
        ),
        **simulation.memory(),
    }
    for i, instance in enumerate(simulation.instances.values()):
        state = instance.save()
        arrays[f"state_{i}"] = np.frombuffer(instance.serialize(state), np.uint8)
        instance.free(state)
    file = io.BytesIO()
    np.savez(file, **arrays)  # type: ignore[arg-type]
    return file.getvalue()


def write(content: bytes, path: Path) -> None:
    """Save it; AdcsError if there is no room, and an older one stays."""
    with replacing(path) as name:
        name.write_bytes(content)


def check(simulation: Simulation, path: Path) -> None:
    """Refuse by name what cannot be saved, and where no file can be, before the run."""
    if path.is_dir():
        raise AdcsError(f"cannot write {path}: it is a folder")
    for instance in simulation.instances.values():
        if not instance.can_serialize:
            raise AdcsError(
                f"{instance.name} ({instance.fmu.path.name}) cannot save its state to a file: a checkpoint needs "
                "canGetAndSetFMUstate and canSerializeFMUstate"
            )


def aligned(simulation: Simulation, k: int) -> bool:
    """Whether all components communicate at point k."""
    return all(k % component.every == 0 for component in simulation.system.components.values())


def not_aligned(simulation: Simulation, k: int) -> AdcsError:
    """Put into words that a checkpoint is not possible at point k."""
    name, every = next((c.name, c.every) for c in simulation.system.components.values() if k % c.every)
    time = simulation.grid.time(k)
    return AdcsError(f"no checkpoint at t = {time:.9g} s: {name} communicates at every {every} steps, and not then")


def _about(simulation: Simulation, method: Method) -> dict[str, Any]:
    connections = [
        [c.source, c.target, c.factor, c.offset, [list(pair) for pair in c.mapping], c.delay_steps, c.delay]
        for c in simulation.system.connections
    ]
    components = simulation.system.components.values()
    return {
        **({"method": method.for_manifest()} if method.kind == "model-exchange" else {}),
        "start time": simulation.grid.start,
        "step": simulation.grid.step,
        "FMUs": {name: instance.fmu.sha256 for name, instance in simulation.instances.items()},
        "connections": connections,
        "start values": {c.name: {n: repr(v) for n, v in sorted(c.start.items())} for c in components},
        "rates": {c.name: c.every for c in components},
        "recorded variables": list(simulation.ports),
        "inputs from outside": list(simulation.external),
    }


def _difference(key: str, there: Any, here: Any) -> str:
    """Name the first of several things that is not the same, or both of single ones."""
    if isinstance(here, dict) and isinstance(there, dict):
        first = next(name for name in [*here, *there] if there.get(name) != here.get(name))
        if isinstance(here.get(first), dict) and isinstance(there.get(first), dict):  # the start values of a component
            return _difference(f"{key} of {first}", there[first], here[first])
        return f"the {key} are not the same, {first} is the first that differs"
    if isinstance(here, list) and isinstance(there, list):
        pairs = zip_longest(there, here)
        was, is_ = next((was, is_) for was, is_ in pairs if was != is_)
        return f"the {key} are not the same, {_named(was)} there is {_named(is_)} here"
    return f"{key} is {there} there, {here} here"


def _named(entry: Any) -> str:
    """Write a connection, or a variable by its name; what one run has and the other has not is nothing."""
    if isinstance(entry, list):
        return shown(f"{entry[0]} to {entry[1]} {entry[2:]}" if len(entry) > 2 else str(entry))
    return "none" if entry is None else str(entry)
