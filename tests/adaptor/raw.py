"""An FMU instance with its log, before and after initialization, FMI 2 and FMI 3 alike."""

import ctypes
from collections.abc import Sequence
from functools import lru_cache
from tempfile import TemporaryDirectory
from typing import Any, Self

import fmpy.fmi2
import fmpy.fmi3
import numpy as np
from fmpy import extract, read_model_description
from fmpy.model_description import ModelDescription

from fmus import fmu_path


@lru_cache
def unpacked(name: str, version: int) -> tuple[TemporaryDirectory[str], ModelDescription]:
    folder = TemporaryDirectory(prefix=name)
    path = str(fmu_path(name, f"{version}.0"))
    extract(path, folder.name)
    return folder, read_model_description(path)


class Raw:
    """`messages` holds (status, category, text). Values are addressed by the array's name."""

    def __init__(
        self, name: str, version: int, cosim: bool = True, token: str | None = None, log: bool = False
    ) -> None:
        folder, description = unpacked(name, version)
        self.version, self.messages = version, []
        module: Any = fmpy.fmi2 if version == 2 else fmpy.fmi3
        kind = getattr(module, f"FMU{version}{'Slave' if cosim else 'Model'}")
        self.references: dict[str, list[int]] = {}
        self.sizes: dict[str, int] = {}
        for v in description.modelVariables:
            base = v.name.split("[")[0] if version == 2 else v.name
            self.references.setdefault(base, []).append(v.valueReference)
            self.sizes[base] = int(np.prod(v.shape or [1])) if version == 3 else len(self.references[base])
        enumeration = "Integer" if version == 2 else "Int64"
        self.kinds = {
            v.name.split("[")[0]: enumeration if v.type == "Enumeration" else v.type for v in description.modelVariables
        }
        self.integers = {name for name, type_ in self.kinds.items() if type_ not in ("Real", "Float64")}
        """And whatever else is no real number."""
        self.fmu = kind(
            guid=token or description.guid or description.instantiationToken,
            unzipDirectory=folder.name,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="it",
        )
        if version == 2:
            callbacks = fmpy.fmi2.fmi2CallbackFunctions()
            callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(
                lambda _, __, status, category, text: self.messages.append((status, category.decode(), text.decode()))
            )
            self.fmu.instantiate(callbacks=callbacks, loggingOn=log)
        else:
            self.fmu.instantiate(
                logMessage=lambda _, status, category, text: self.messages.append(
                    (status, category.decode(), text.decode())
                ),
                loggingOn=log,
            )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.fmu.freeInstance()

    def set(self, name: str, value: Any) -> None:
        flat = np.atleast_1d(np.asarray(value)).ravel().tolist()
        getattr(self.fmu, f"set{self.kinds[name]}")(self.references[name], flat)

    def get(self, name: str) -> np.ndarray:
        sizes = {} if self.version == 2 else {"nValues": self.sizes[name]}
        return np.array(getattr(self.fmu, f"get{self.kinds[name]}")(self.references[name], **sizes))

    def initialize(self, start: float = 0.0, stop: float | None = None, **values: Any) -> Self:
        for name, value in values.items():
            self.set(name, value)
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
        *_, defined, time = update()
        self.fmu.enterContinuousTimeMode()
        return bool(defined), time

    def states(self, x: Sequence[float]) -> None:
        array = np.asarray(x, float)
        self.fmu.setContinuousStates(array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), array.size)

    def derivatives(self, n: int) -> np.ndarray:
        array = np.empty(n)
        read = self.fmu.getDerivatives if self.version == 2 else self.fmu.getContinuousStateDerivatives
        read(array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), n)
        return array

    def save(self) -> Any:
        return self.fmu.getFMUstate() if self.version == 2 else self.fmu.getFMUState()

    def restore(self, state: Any) -> None:
        (self.fmu.setFMUstate if self.version == 2 else self.fmu.setFMUState)(state)

    def to_bytes(self, state: Any) -> bytes:
        return (self.fmu.serializeFMUstate if self.version == 2 else self.fmu.serializeFMUState)(state)

    def from_bytes(self, data: bytes) -> Any:
        return (self.fmu.deSerializeFMUstate if self.version == 2 else self.fmu.deserializeFMUState)(data)
