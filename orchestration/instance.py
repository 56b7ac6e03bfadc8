"""Instances of FMUs: from the file through fmpy to the end of initialisation, with what they had to say."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, chdir, contextmanager, suppress
from ctypes import byref
from math import isfinite
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from fmpy import calloc, fmi2, fmi3, free
from fmpy.fmi1 import FMICallException, printLogMessage

from fmus.errors import AdcsError
from orchestration.fmu import FmiVersion, Fmu, Kind, Port, extracted
from orchestration.plan import Call, Floats, Plan, make_plan
from orchestration.system import System

_STATUS = {0: "ok", 1: "warning", 2: "discard", 3: "error", 4: "fatal", 5: "pending"}
_CLASSES = {
    (2, "co-simulation"): fmi2.FMU2Slave,
    (2, "model-exchange"): fmi2.FMU2Model,
    (3, "co-simulation"): fmi3.FMU3Slave,
    (3, "model-exchange"): fmi3.FMU3Model,
}
# fmpy changes the working directory of the process while it loads a library, and leaves it so if that fails
_loading = Lock()


class CallFailed(AdcsError):
    """A call of an FMU failed: the component, the call with the FMU's last message, and the time where it is known."""

    def __init__(self, component: str, text: str) -> None:
        super().__init__(component, text)
        self.component = component
        self.text = text
        self.time: float | None = None

    def __str__(self) -> str:
        when = "" if self.time is None else f" failed at t = {self.time:.9g} s"
        return f"{self.component}{when}: {self.text}"


@contextmanager
def failing_at(time: float) -> Iterator[None]:
    """Note the time in a failure of a call that does not know it."""
    try:
        yield
    except CallFailed as error:
        if error.time is None:
            error.time = time
        raise


class Instance:
    """One instance of an FMU behind the methods that FMI 2 and FMI 3 have in common.

    `handle` is fmpy's object. Every failing call raises CallFailed.
    """

    def __init__(self, name: str, fmu: Fmu, kind: Kind, folder: Path, binary: Path) -> None:
        self.name = name
        self.fmu = fmu
        self.major = fmu.major_version
        self.messages: deque[tuple[int, str]] = deque(maxlen=20)
        self.warnings: list[str] = []
        self._alive = False
        self._fatal = False
        self._callbacks: Any = None
        interface = fmu.interface(kind)
        try:
            with _loading, chdir("."):
                self.handle: Any = _CLASSES[self.major, kind](
                    guid=fmu.model.guid,
                    unzipDirectory=str(folder),
                    modelIdentifier=interface.modelIdentifier,
                    instanceName=name,
                    **({"libraryPath": str(binary)} if self.major == 2 else {}),
                )
            if self.major == 2:
                self._callbacks = _fmi2_callbacks(self._log)
                self.handle.instantiate(callbacks=self._callbacks)
            else:
                self.handle.instantiate(logMessage=lambda _, status, __, text: self._log(status, text))
        except Exception as error:
            reason = self.last_message or _line(error)
            raise AdcsError(f"{name}: cannot instantiate {fmu.path.name}: {reason}") from error
        self._alive = True
        self._listen()

    def _listen(self) -> None:
        """Ask for the messages that explain failures, and for no others: many FMUs are silent otherwise."""
        wanted = {"logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal", "logError"}
        categories = [c.name for c in self.fmu.model.logCategories if c.name in wanted]
        if categories:
            with suppress(FMICallException):
                self.handle.setDebugLogging(True, categories)

    def _log(self, status: int, text: bytes | None) -> None:
        message = _line((text or b"").decode("utf-8", "replace"))
        self.messages.append((status, message))
        if status == 1 and len(self.warnings) < 20:
            self.warnings.append(message)

    @property
    def last_message(self) -> str:
        """The last message that speaks of a problem, else the last one at all."""
        problems = [text for status, text in self.messages if status > 0]
        return (problems or [text for _, text in self.messages] or [""])[-1]

    def failure(self, action: str, status: int) -> CallFailed:
        """Put a failed call into words."""
        self._fatal = self._fatal or status == 4
        reason = _STATUS.get(status, f"the unknown status {status}")
        return CallFailed(self.name, f"{action} returned {reason}: {self.last_message or 'the FMU gave no message'}")

    def ended(self) -> CallFailed:
        """Put into words that the FMU wants the simulation to end."""
        return CallFailed(self.name, f"asked to end the simulation: {self.last_message or 'it gave no reason'}")

    def returned_early(self) -> CallFailed:
        """Put into words that the FMU stepped less far than asked."""
        return CallFailed(self.name, "doStep returned early, which was not allowed")

    def call(self, action: str, method: str, *arguments: Any, **named: Any) -> Any:
        """Call a method of fmpy's object; `action` says what is done, for the error."""
        try:
            return getattr(self.handle, method)(*arguments, **named)
        except FMICallException as error:
            raise self.failure(action, error.status) from error

    def get(self, references: Sequence[int], size: int, action: str = "get") -> list[float]:
        """Get Float64 values."""
        if self.major == 2:
            return list(self.call(action, "getReal", references))
        return list(self.call(action, "getFloat64", references, size))

    def set(self, references: Sequence[int], values: Sequence[float], action: str = "set") -> None:
        """Set Float64 values."""
        self.call(action, "setReal" if self.major == 2 else "setFloat64", references, values)

    def set_start(self, port: Port, values: Sequence[Any]) -> None:
        """Set a start value of any type."""
        kind = {"Float64": "Real", "Int32": "Integer"}.get(port.type, port.type) if self.major == 2 else port.type
        shown = ", ".join(map(str, values[:12])) + (", ..." if len(values) > 12 else "")
        self.call(f"setting {port.name} = {shown}", f"set{kind}", port.references, values)

    def do_step(self, time: float, step: float) -> None:
        """Co-Simulation: step on from `time`."""
        ended = self.call("doStep", "doStep", time, step)
        if self.major == 3:
            _, terminate, early, _ = ended
            if terminate:
                raise self.ended()
            if early:
                raise self.returned_early()

    def enter_initialization(self, start_time: float, stop_time: float) -> None:
        """Enter initialisation mode."""
        action = "entering initialisation"
        times = {"startTime": start_time, "stopTime": stop_time if isfinite(stop_time) else None}
        if self.major == 2:
            self.call(action, "setupExperiment", **times)
            self.call(action, "enterInitializationMode")
        else:
            self.call(action, "enterInitializationMode", **times)

    def exit_initialization(self) -> None:
        """Leave initialisation mode."""
        self.call("initialisation", "exitInitializationMode")

    def close(self, *, healthy: bool) -> None:
        """Terminate, when nothing has failed, and free the instance; a fatal failure forbids any further call."""
        if self._alive and not self._fatal:
            self._alive = False
            if healthy:
                with suppress(FMICallException):
                    self.handle.terminate()
            self.handle.freeInstance()
        if self._callbacks is not None:
            _loggers.pop(self._callbacks.componentEnvironment, None)


def propagate(plan: Plan, instances: Mapping[str, Instance]) -> None:
    """Execute the calls of a plan through fmpy's own methods."""
    for call in plan.calls:
        instance = instances[call.component]
        if call.kind == "set":
            instance.set(call.references, plan.signals[call.where].tolist(), action_of(call))
        else:
            values = instance.get(call.references, len(call.where), action_of(call))
            check_finite(instance.name, call.elements, values)
            plan.signals[call.where] = values


def action_of(call: Call) -> str:
    """Name a get or set call by its variables."""
    variables = dict.fromkeys(e.partition("[")[0] for e in call.elements)
    return f"{call.kind}ting {', '.join(variables)}"


def check_finite(component: str, elements: Sequence[str], values: Sequence[float] | Floats) -> None:
    """Refuse NaN and infinity by the name of the variable."""
    for element, value in zip(elements, values, strict=True):
        if not np.isfinite(value):
            raise CallFailed(component, f"{element} is {value}")


@contextmanager
def initialised(
    system: System, kind: Kind, start_time: float, stop_time: float, version: FmiVersion = "2.0"
) -> Iterator[dict[str, Instance]]:
    """Instantiate and initialise all components, values propagated along the connections; frees them at the end."""
    system.check()
    fmus = {c.name: c.open(version) for c in system.components.values()}
    plan = make_plan(fmus, system.connections, initial=True)
    with ExitStack() as stack:
        instances: dict[str, Instance] = {}
        folders: dict[str, tuple[Path, Path]] = {}
        for name, fmu in fmus.items():
            # a second copy of the file is a second library, which an FMU with global data needs
            alone = fmu.interface(kind).canBeInstantiatedOnlyOncePerProcess
            key = f"{fmu.sha256} {name if alone else ''}"
            if key not in folders:
                folders[key] = stack.enter_context(extracted(fmu, kind))
            instance = Instance(name, fmu, kind, *folders[key])
            stack.push(lambda kind_of_error, _, __, instance=instance: instance.close(healthy=kind_of_error is None))
            instances[name] = instance
        for component in system.components.values():
            for variable, values in component.start.items():
                instances[component.name].set_start(fmus[component.name].ports[variable], values)
        for instance in instances.values():
            instance.enter_initialization(start_time, stop_time)
        propagate(plan, instances)
        for instance in instances.values():
            instance.exit_initialization()
        yield instances


_loggers: dict[int, Callable[[int, bytes | None], None]] = {}
_numbers = itertools.count(1)


def _dispatch(environment: int | None, name: bytes, status: int, category: bytes, message: bytes) -> None:
    if environment in _loggers:
        _loggers[environment](status, message)
    else:
        printLogMessage(environment, name, status, category, message)


_LOGGER = fmi2.fmi2CallbackLoggerTYPE(_dispatch)


def _fmi2_callbacks(log: Callable[[int, bytes | None], None]) -> Any:
    """Return FMI 2 callbacks. fmpy's proxy, which formats the variadic message, has room for one logger only."""
    callbacks = fmi2.fmi2CallbackFunctions()
    callbacks.logger = _LOGGER
    callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
    callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
    callbacks.componentEnvironment = next(_numbers)
    _loggers[callbacks.componentEnvironment] = log
    with suppress(ImportError, OSError):  # fmpy brings it for some platforms only; the bare format text remains
        from fmpy.logging import addLoggerProxy

        addLoggerProxy(byref(callbacks))
    return callbacks


def _line(text: object) -> str:
    return " ".join(str(text).split())
