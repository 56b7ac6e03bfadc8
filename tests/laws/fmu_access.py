"""One component through fmpy, its variables set and read by name as arrays, FMI 2 and FMI 3 alike."""

import ctypes
import re
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from math import inf, prod
from types import TracebackType
from typing import Any, Self

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.model_description import ModelDescription, ModelVariable
from numpy.typing import ArrayLike

from fmus import fmu_path
from references.observer_pd import Array

VERSIONS = (2, 3)


@dataclass
class Variable:
    """An array: of one value reference in FMI 3, of the elements' in FMI 2."""

    first: ModelVariable
    shape: tuple[int, ...]
    references: list[int] = field(default_factory=list)

    @property
    def size(self) -> int:
        return prod(self.shape)


def array_name(name: str) -> tuple[str, tuple[int, ...]]:
    """``J_B[2,3]`` -> ``J_B``, (2, 3)."""
    base, _, index = name.partition("[")
    return base, tuple(int(i) for i in re.findall(r"\d+", index))


def united(md: ModelDescription) -> dict[str, Variable]:
    """The arrays of a model description; a derivative goes by the name of its state, ``der(omega_BN_B)``."""
    arrays: dict[str, Variable] = {}
    for v in md.modelVariables:
        name, index = array_name(v.name if v.derivative is None else v.derivative.name)
        if v.derivative is not None:
            name = f"der({name})"
        shape = tuple(v.shape or ()) if md.fmiVersion.startswith("3") else index
        array = arrays.setdefault(name, Variable(v, shape))
        array.shape = shape  # of FMI 2 elements, the last index is the shape
        array.references.append(v.valueReference)
    return arrays


@lru_cache
def unpacked(name: str, version: int) -> tuple[tempfile.TemporaryDirectory[str], ModelDescription]:
    """The FMU's files, and its model description."""
    path = fmu_path(name, f"{version}.0")
    folder = tempfile.TemporaryDirectory(prefix=name)
    extract(str(path), folder.name)
    return folder, read_model_description(str(path))


class Component:
    """An initialised instance: a Co-Simulation slave, or for Model Exchange resting in Continuous-Time Mode."""

    def __init__(
        self,
        name: str,
        version: int,
        start: Mapping[str, ArrayLike] | None = None,
        co_simulation: bool = False,
        start_time: float = 0.0,
    ) -> None:
        folder, self.description = unpacked(name, version)
        self.version, self.next_event = version, inf
        self.variables = united(self.description)
        kind = self.description.coSimulation if co_simulation else self.description.modelExchange
        types = {(2, False): FMU2Model, (2, True): FMU2Slave, (3, False): FMU3Model, (3, True): FMU3Slave}
        self.fmu: Any = types[version, co_simulation](
            guid=self.description.guid if version == 2 else self.description.instantiationToken,
            unzipDirectory=folder.name,
            modelIdentifier=kind.modelIdentifier,
            instanceName=name,
        )
        self.fmu.instantiate()
        self.set(start or {})
        if version == 2:
            self.fmu.setupExperiment(startTime=start_time)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=start_time)
        self.fmu.exitInitializationMode()
        if not co_simulation:
            self._finish_event()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        if error is None:
            self.fmu.terminate()
        self.fmu.freeInstance()

    def names(self, *causalities: str) -> list[str]:
        """Arrays of these causalities that are real numbers."""
        return [
            n
            for n, v in self.variables.items()
            if v.first.causality in causalities and v.first.type in ("Real", "Float64")
        ]

    @property
    def states(self) -> list[str]:
        """Continuous states in the order of the state vector."""
        listed = [array_name(u.variable.derivative.name)[0] for u in self.description.derivatives]
        return list(dict.fromkeys(listed))

    def set(self, values: Mapping[str, ArrayLike]) -> None:
        for name, value in values.items():
            v = self.variables[name]
            real = v.first.type in ("Real", "Float64")
            flat = np.broadcast_to(np.asarray(value, float if real else int), v.shape).ravel().tolist()
            setter = {2: ("setInteger", "setReal"), 3: ("setInt32", "setFloat64")}[self.version][real]
            getattr(self.fmu, setter)(v.references, flat)

    def get(self, name: str) -> Array:
        v = self.variables[name]
        flat = self.fmu.getReal(v.references) if self.version == 2 else self.fmu.getFloat64(v.references, v.size)
        return np.array(flat).reshape(v.shape)

    def at(self, time: float) -> None:
        """Go to ``time``, through every announced time event on the way."""
        while self.next_event <= time:
            self.fmu.setTime(self.next_event)
            with self.event():
                pass
        self.fmu.setTime(time)

    @contextmanager
    def event(self) -> Iterator[None]:
        """Event Mode, where tunable parameters and discrete inputs may change."""
        self.fmu.enterEventMode()
        yield
        self._finish_event()

    def _finish_event(self) -> None:
        update = self.fmu.newDiscreteStates if self.version == 2 else self.fmu.updateDiscreteStates
        again = True
        while again:
            again, _, _, _, defined, time = update()
        self.next_event = time if defined else inf
        self.fmu.enterContinuousTimeMode()

    def set_states(self, values: Mapping[str, ArrayLike]) -> None:
        """All continuous states, by name."""
        x = (
            np.concatenate([np.ravel(np.asarray(values[n], float)) for n in self.states])
            if self.states
            else np.empty(0)
        )
        if x.size:
            self.fmu.setContinuousStates(x.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), x.size)

    def derivatives(self) -> dict[str, Array]:
        """Of the state vector, by the name of the state."""
        shapes = [self.variables[n].shape for n in self.states]
        dx = np.empty(sum(prod(s) for s in shapes))
        if not dx.size:
            return {}
        read = self.fmu.getDerivatives if self.version == 2 else self.fmu.getContinuousStateDerivatives
        read(dx.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), dx.size)
        parts = np.split(dx, np.cumsum([prod(s) for s in shapes])[:-1])
        return {n: p.reshape(s) for n, p, s in zip(self.states, parts, shapes, strict=True)}

    def directional(self, unknowns: list[str], known: str, seed: Array) -> Array:
        """The derivative of the unknowns, laid end to end, along ``seed`` of one known."""
        references = [r for n in unknowns for r in self.variables[n].references]
        towards = self.variables[known].references
        if self.version == 2:
            return np.array(self.fmu.getDirectionalDerivative(references, towards, seed.ravel().tolist()))
        size = sum(self.variables[n].size for n in unknowns)
        return np.array(self.fmu.getDirectionalDerivative(references, towards, seed.ravel().tolist(), size))
