"""One FMU of a component through fmpy, its variables set and read by name as arrays, FMI 2 and FMI 3 alike."""

import ctypes
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from math import inf, prod
from tempfile import TemporaryDirectory
from types import TracebackType
from typing import Any, Self

import fmpy.fmi2
import fmpy.fmi3
import numpy as np
from fmpy import extract, read_model_description
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

    @property
    def is_real(self) -> bool:
        return self.first.type in ("Real", "Float64")

    def kind(self, version: int) -> str:
        """By which functions of FMI it is set and got."""
        enumeration = {2: "Integer", 3: "Int64"}[version]
        return enumeration if self.first.type == "Enumeration" else str(self.first.type)


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
def unpacked(name: str, version: int) -> tuple[TemporaryDirectory[str], ModelDescription]:
    """The FMU's files, and its model description."""
    path = str(fmu_path(name, f"{version}.0"))
    folder = TemporaryDirectory(prefix=name)
    extract(path, folder.name)
    return folder, read_model_description(path)


class Raw:
    """An instance with its log, before and after initialization; `messages` holds (status, category, text)."""

    def __init__(
        self, name: str, version: int, cosim: bool = True, token: str | None = None, log: bool = False
    ) -> None:
        folder, self.description = unpacked(name, version)
        self.version = version
        self.messages: list[tuple[int, str, str]] = []
        self.variables = united(self.description)
        self.references = {n: v.references for n, v in self.variables.items()}
        self.sizes = {n: v.size for n, v in self.variables.items()}
        self.kinds = {n: v.kind(version) for n, v in self.variables.items()}
        self.integers = {n for n, v in self.variables.items() if not v.is_real}
        """And whatever else is no real number."""
        module: Any = fmpy.fmi2 if version == 2 else fmpy.fmi3
        kind = self.description.coSimulation if cosim else self.description.modelExchange
        self.fmu: Any = getattr(module, f"FMU{version}{'Slave' if cosim else 'Model'}")(
            guid=token or self.description.guid or self.description.instantiationToken,
            unzipDirectory=folder.name,
            modelIdentifier=kind.modelIdentifier,
            instanceName="it",
        )
        if version == 2:
            callbacks = fmpy.fmi2.fmi2CallbackFunctions()
            callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(lambda _, __, *message: self._note(*message))
            self.fmu.instantiate(callbacks=callbacks, loggingOn=log)
        else:
            self.fmu.instantiate(logMessage=lambda _, *message: self._note(*message), loggingOn=log)

    def _note(self, status: int, category: bytes, text: bytes) -> None:
        self.messages.append((status, category.decode(), text.decode()))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        self.fmu.freeInstance()

    def set(self, values: Mapping[str, ArrayLike]) -> None:
        for name, value in values.items():
            v = self.variables[name]
            numbers = value if self.kinds[name] == "String" else np.asarray(value, float if v.is_real else int)
            flat = np.broadcast_to(np.ravel(numbers), v.size).tolist()
            getattr(self.fmu, f"set{self.kinds[name]}")(v.references, flat)

    def get(self, name: str) -> Array:
        v = self.variables[name]
        sizes = {} if self.version == 2 else {"nValues": v.size}
        return np.array(getattr(self.fmu, f"get{self.kinds[name]}")(v.references, **sizes))

    def initialize(self, start: float = 0.0, stop: float | None = None, **values: Any) -> Self:
        self.set(values)
        self.enter(start, stop)
        self.fmu.exitInitializationMode()
        return self

    def enter(self, start: float = 0.0, stop: float | None = None) -> None:
        if self.version == 2:
            self.fmu.setupExperiment(startTime=start, stopTime=stop)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=start, stopTime=stop)

    def step(self, time: float, size: float) -> None:
        self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=size)

    def event_update(self) -> tuple[bool, float]:
        """New discrete states, then continuous time: whether and when the next event is."""
        update = self.fmu.newDiscreteStates if self.version == 2 else self.fmu.updateDiscreteStates
        again = True
        while again:
            again, _, _, _, defined, time = update()
        self.fmu.enterContinuousTimeMode()
        return bool(defined), time

    def set_state_vector(self, x: Sequence[float] | Array) -> None:
        array = np.asarray(x, float)
        self.fmu.setContinuousStates(array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), array.size)

    def rates(self, n: int) -> Array:
        """Of the state vector."""
        array = np.empty(n)
        read = self.fmu.getDerivatives if self.version == 2 else self.fmu.getContinuousStateDerivatives
        read(array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), n)
        return array

    def save(self) -> Any:
        return self.fmu.getFMUstate() if self.version == 2 else self.fmu.getFMUState()

    def restore(self, state: Any) -> None:
        (self.fmu.setFMUstate if self.version == 2 else self.fmu.setFMUState)(state)

    def to_bytes(self, state: Any) -> bytes:
        data: bytes = (self.fmu.serializeFMUstate if self.version == 2 else self.fmu.serializeFMUState)(state)
        return data

    def from_bytes(self, data: bytes) -> Any:
        return (self.fmu.deSerializeFMUstate if self.version == 2 else self.fmu.deserializeFMUState)(data)


class Component(Raw):
    """An initialised instance: a Co-Simulation slave, or for Model Exchange resting in Continuous-Time Mode."""

    def __init__(
        self,
        name: str,
        version: int,
        start: Mapping[str, ArrayLike] | None = None,
        co_simulation: bool = False,
        start_time: float = 0.0,
    ) -> None:
        super().__init__(name, version, co_simulation)
        self.next_event = inf
        self.initialize(start_time, **(start or {}))
        if not co_simulation:
            self._finish_event()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None:
            self.fmu.terminate()
        super().__exit__(kind, error, trace)

    def names(self, *causalities: str) -> list[str]:
        """Arrays of these causalities that are real numbers."""
        return [n for n, v in self.variables.items() if v.first.causality in causalities and v.is_real]

    @property
    def states(self) -> list[str]:
        """Continuous states in the order of the state vector."""
        listed = [array_name(u.variable.derivative.name)[0] for u in self.description.derivatives]
        return list(dict.fromkeys(listed))

    def get(self, name: str) -> Array:
        return super().get(name).reshape(self.variables[name].shape)

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
        defined, time = self.event_update()
        self.next_event = time if defined else inf

    def set_states(self, values: Mapping[str, ArrayLike]) -> None:
        """All continuous states, by name."""
        if self.states:
            self.set_state_vector(np.concatenate([np.ravel(np.asarray(values[n], float)) for n in self.states]))

    def derivatives(self) -> dict[str, Array]:
        """Of the state vector, by the name of the state."""
        if not self.states:
            return {}
        variables = [self.variables[n] for n in self.states]
        parts = np.split(self.rates(sum(v.size for v in variables)), np.cumsum([v.size for v in variables])[:-1])
        return {n: p.reshape(v.shape) for n, p, v in zip(self.states, parts, variables, strict=True)}

    def directional(self, unknowns: list[str], known: str, seed: Array) -> Array:
        """The derivative of the unknowns, laid end to end, along ``seed`` of one known."""
        references = [r for n in unknowns for r in self.variables[n].references]
        towards = self.variables[known].references
        if self.version == 2:
            return np.array(self.fmu.getDirectionalDerivative(references, towards, seed.ravel().tolist()))
        size = sum(self.variables[n].size for n in unknowns)
        return np.array(self.fmu.getDirectionalDerivative(references, towards, seed.ravel().tolist(), size))
