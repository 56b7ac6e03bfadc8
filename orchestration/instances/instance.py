"""Instances of FMUs: from the file through fmpy to the end of initialisation, with what they had to say."""

from __future__ import annotations

import itertools
import re
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import chdir, contextmanager, suppress
from ctypes import byref, c_bool, c_double
from functools import cached_property
from math import isfinite
from pathlib import Path
from threading import Lock
from typing import Any

from fmpy import calloc, fmi2, fmi3, free
from fmpy.fmi1 import FMICallException, printLogMessage

from fmus.errors import AdcsError, Failed
from orchestration.fmu.file import Fmu, Kind, Port
from orchestration.fmu.number_types import BEYOND, first_beyond, first_misfit
from orchestration.grid import SNAP
from orchestration.instances.events import Events
from orchestration.instances.inspected import inspected_once
from orchestration.instances.stepping import DISCARD, Stepper
from orchestration.process.guard import Guard
from orchestration.process.where import Calling, Where

_STATUS = {0: "ok", 1: "warning", 2: "discard", 3: "error", 4: "fatal", 5: "pending"}
_CLASSES = {
    (2, "co-simulation"): inspected_once(fmi2.FMU2Slave),
    (2, "model-exchange"): inspected_once(fmi2.FMU2Model),
    (3, "co-simulation"): inspected_once(fmi3.FMU3Slave),
    (3, "model-exchange"): inspected_once(fmi3.FMU3Model),
}
_FMI2_NAMES = {"Float64": "Real", "Int32": "Integer"}
_LAST_SUCCESSFUL_TIME, _TERMINATED = 2, 3  # of fmi2StatusKind
_WITHOUT_CATEGORY = "PythonFMU"  # whose messages of exceptions have none: they come if no categories are asked for
_WORD = re.compile(r"[A-Za-z_][\w.]*")
# fmpy changes the working directory of the process while it loads a library, and leaves it so if that fails
_loading = Lock()


class CallFailed(Failed):
    """A call of an FMU failed: the component, the call with the FMU's last message, and the time where it is known."""

    def __init__(self, component: str, text: str) -> None:
        super().__init__(component, text)
        self.component = component
        self.text = text
        self.time: float | None = None
        self.status: int | None = None
        """What the FMU returned, if it was that."""

    def __str__(self) -> str:
        when = "" if self.time is None else f" failed at t = {self.time:.9g} s"
        return f"{self.component}{when}: {self.text}"


class EndRequested(CallFailed):
    """A component wants the simulation to end, which is no failure; `time` is that up to which its values are valid.

    Where that lies between two points, its row has the component's values there, and the others' at `others_at` (s).
    """

    others_at: float | None = None
    """Of which time the values of the others are in the row of the end, if of another [s]."""

    def __str__(self) -> str:
        when = "" if self.time is None else f" at t = {self.time:.9g} s"
        return f"{self.component} ended the simulation{when}: {self.text}"

    def as_dict(self) -> dict[str, Any]:
        """For the manifest."""
        others = {} if self.others_at is None else {"others_at": self.others_at}
        return {"component": self.component, "time": self.time, "message": self.text, **others}


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

    def __init__(
        self,
        name: str,
        fmu: Fmu,
        kind: Kind,
        folder: Path,
        binary: Path,
        where: Where | None = None,
        guard: Guard | None = None,
    ) -> None:
        self.name = name
        self._where = where or Where()
        self._guard = guard
        self.fmu = fmu
        self.calling = Calling(self._where, name, None if guard is None or self.ours else guard.thread)
        self.major = fmu.major_version
        self.kind: Kind = kind
        self.messages: deque[tuple[int, str]] = deque(maxlen=20)
        self.warnings: list[str] = []
        self.sources: dict[str, str] = {}
        """Of each connected input, the output that feeds it: for messages."""
        self.wants_end = False
        """Whether it has asked to end the simulation, where it has come to."""
        self._changed: tuple[int, list[str]] = -1, []
        self._alive = False
        self._fatal = False
        self._callbacks: Any = None
        self._interface = interface = fmu.interface(kind)
        self._events: Events | None = None
        self._stepper: Stepper | None = None
        self._smaller: Stepper | None = None  # of an FMU that otherwise takes plain steps
        fmu.check_clocks(kind, name)
        try:
            with self.calling("instantiating"):
                self._instantiate(folder, binary)
        except Exception as error:
            reason = self.last_message or _line(error)
            if interface.needsExecutionTool:
                reason += f"; it needs the tool that made it, {fmu.model.generationTool or 'which it does not name'}"
            raise AdcsError(f"{name}: cannot instantiate {fmu.path.name}: {reason}") from error
        self._alive = True
        self._listen()
        self._check()
        if kind == "co-simulation" and self._needs_care():
            self._stepper = Stepper(self, self._events)

    def _instantiate(self, folder: Path, binary: Path) -> None:
        with _loading, chdir("."):
            self.handle: Any = _CLASSES[self.major, self.kind](
                guid=self.fmu.model.guid,
                unzipDirectory=str(folder),
                modelIdentifier=self._interface.modelIdentifier,
                instanceName=self.name,
                **({"libraryPath": str(binary)} if self.major == 2 else {}),
            )
        if self.major == 2:
            self._callbacks = _fmi2_callbacks(self._log)
            self.handle.instantiate(callbacks=self._callbacks)
        else:
            self._instantiate3(self.kind)

    def _instantiate3(self, kind: Kind) -> None:
        settings: dict[str, Any] = {"logMessage": lambda _, status, __, text: self._log(status, text)}
        if kind == "model-exchange":
            self.handle.instantiate(**settings)
            return
        if self._interface.providesIntermediateUpdate:
            settings["intermediateUpdate"] = _go_on
        early = self._interface.mightReturnEarlyFromDoStep
        try:  # an FMU with event mode but without clocks can do without, and is stepped faster then
            events = bool(self.fmu.clocks)
            self.handle.instantiate(eventModeUsed=events, earlyReturnAllowed=events or early, **settings)
        except Exception:
            if events or not self._interface.hasEventMode:
                raise
            events = True
            self.handle.instantiate(eventModeUsed=True, earlyReturnAllowed=True, **settings)
            self.messages.clear()
        if events:
            self._events = Events(self)

    def _needs_care(self) -> bool:
        """Whether a step may be more than one successful call of doStep."""
        early = self.major == 3 and self._interface.mightReturnEarlyFromDoStep
        return bool(self.asynchronous or self._events is not None or early or self.saves_for_retries)

    def _listen(self) -> None:
        """Ask for the messages that explain failures, and for no others: many FMUs are silent otherwise."""
        wanted = {"logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal", "logError"}
        categories = [c.name for c in self.fmu.model.logCategories if c.name in wanted]
        everything = (self.fmu.model.generationTool or "").startswith(_WITHOUT_CATEGORY)
        if categories or everything:
            with suppress(FMICallException):
                self.handle.setDebugLogging(True, [] if everything else categories)

    def _log(self, status: int, text: bytes | None) -> None:
        message = _line((text or b"").decode("utf-8", "replace"))
        self.messages.append((status, message))
        if status == 1:
            self.warn(message)

    @property
    def last_message(self) -> str:
        """The last message that speaks of a problem, else the last one at all."""
        problems = [text for status, text in self.messages if status > 0]
        return (problems or [text for _, text in self.messages] or [""])[-1]

    def failure(self, action: str, status: int, more: str = "") -> CallFailed:
        """Put a failed call into words; `more` follows the status."""
        self._fatal = self._fatal or status == 4
        reason = _STATUS.get(status, f"the unknown status {status}")
        if action == "doStep" and status == 2 and self.major == 2:
            last = self._last_successful_time()
            if self.terminated:
                return self.ended(last)
            if last is not None:
                more += f", having got to t = {last:.9g} s"
        elif action == "doStep" and status == 5:
            more += ", though it does not declare canRunAsynchronuously"
        message = self.last_message or "the FMU gave no message"
        failed = CallFailed(self.name, f"{action} returned {reason}{more}: {message}{self._fed(f'{action} {message}')}")
        failed.status = status
        return failed

    def after_discard(self, time: float, step: float) -> None:
        """Go on after a plain step was discarded: CallFailed, unless it is done all the same, or in smaller ones."""
        if self.may_discard:
            self._smaller = self._smaller or Stepper(self, None)
            self._smaller.step(time, step, discarded=True)
        elif not self.ends_with_discarded(time, step):
            raise self.failure("doStep", DISCARD)

    def ends_with_discarded(self, time: float, step: float) -> bool:
        """Whether an FMI 2 FMU has discarded a step to end the simulation at its very end: it is done, then.

        The FMU has no other way to say so; `wants_end` is set.
        """
        last = self._last_successful_time() if self.terminated else None
        self.wants_end = last is not None and last >= time + step - SNAP * step
        return self.wants_end

    def _last_successful_time(self) -> float | None:
        """Ask an FMI 2 FMU that has discarded a step how far it got."""
        with suppress(FMICallException):
            last = float(self.handle.getRealStatus(_LAST_SUCCESSFUL_TIME))
            return last if isfinite(last) else None
        return None

    def _fed(self, message: str) -> str:
        """Say where the inputs of which a message speaks come from."""
        words = set(_WORD.findall(message))
        fed = [f"{name} comes from {source}" for name, source in self.sources.items() if name in words]
        return f" ({', '.join(fed)})" if fed else ""

    def wrong(self, text: str) -> CallFailed:
        """Put into words that the FMU does something that it should not."""
        return CallFailed(self.name, text)

    def note(self, status: int, text: str) -> None:
        """Note a message on behalf of the FMU."""
        self._log(status, text.encode())

    def warn(self, text: str, instead_of: str = "") -> None:
        """Add a warning to those of the FMU, or put it in the place of another."""
        if instead_of and instead_of in self.warnings:
            self.warnings[self.warnings.index(instead_of)] = text
        elif len(self.warnings) < 20:
            self.warnings.append(text)

    @property
    def terminated(self) -> bool:
        """Whether an FMI 2 FMU that has discarded a step wants the simulation to end."""
        with suppress(FMICallException):
            return self.major == 2 and bool(self.handle.getBooleanStatus(_TERMINATED))
        return False

    def ended(self, time: float | None = None) -> EndRequested:
        """Put into words that the FMU wants the simulation to end, having come to a time."""
        end = EndRequested(self.name, self.last_message or "it gave no reason")
        end.time = time
        return end

    def returned_outside(self, last: float, now: float, target: float) -> CallFailed:
        """Say that a step ended early at no time of its own."""
        return self.wrong(
            f"doStep returned early at t = {last!r} s, which is not within its step from {now:.9g} to {target:.9g} "
            "s: the FMU must give its lastSuccessfulTime"
        )

    def returned_early(self, last: float) -> CallFailed:
        """Put into words that the FMU stepped less far than asked."""
        return CallFailed(self.name, f"doStep returned early at t = {last:.9g} s, which was not allowed")

    def call(self, action: str, method: str, *arguments: Any, **named: Any) -> Any:
        """Call a method of fmpy's object; `action` says what is done, for the error."""
        try:
            with self.calling(action):
                return getattr(self.handle, method)(*arguments, **named)
        except FMICallException as error:
            raise self.failure(action, error.status) from error

    def _check(self) -> None:
        if self._guard is not None and not self.ours:
            self._guard.check(self.name)

    @property
    def ours(self) -> bool:
        """Whether the FMU was built here: it leaves alone what is not its own."""
        return self.fmu.ours

    def read(self, references: Sequence[int], size: int, action: str = "get", type: str = "Float64") -> list[Any]:
        """Get values of a numeric type, named as in `Port.type`, as they are: an integer is one."""
        sizes = () if self.major == 2 else (size,)
        values = self.call(action, f"get{self._kind(type)}", references, *sizes)
        return [bool(v) for v in values] if type == "Boolean" else list(values)

    def get(self, references: Sequence[int], size: int, action: str = "get", type: str = "Float64") -> list[float]:
        """Get values of a numeric type as doubles, Boolean ones as 0 or 1; an integer that none can be is refused."""
        values = self.read(references, size, action, type)
        if not type.startswith("Float") and (first := first_beyond(values)) is not None:
            raise CallFailed(self.name, f"{action}: {values[first]}{BEYOND}")
        return [float(v) for v in values]

    def set(
        self, references: Sequence[int], values: Sequence[float], action: str = "set", type: str = "Float64"
    ) -> None:
        """Set values of a numeric type, named as in `Port.type`; a number that the type does not hold is refused."""
        misfit = first_misfit(type, values)
        if misfit is not None:
            raise CallFailed(self.name, f"{action}: {values[misfit[0]]!r}{misfit[1]}")
        if not type.startswith("Float"):
            values = [int(value) for value in values]
        self.call(action, f"set{self._kind(type)}", references, values)

    def _kind(self, type: str) -> str:
        return _FMI2_NAMES.get(type, type) if self.major == 2 else type

    def set_start(self, port: Port, values: Sequence[Any]) -> None:
        """Set a start value of any type."""
        if len(values):
            self.call(f"setting {_assigned(port, values)}", f"set{self._kind(port.type)}", port.references, values)

    def configure(self, start: Mapping[str, Sequence[Any]]) -> None:
        """Set start values by variable: structural parameters first and at once, as some are valid together only."""
        given = [(self.fmu.ports[variable], values) for variable, values in start.items()]
        structural = [(port, values) for port, values in given if port.structural]
        if structural:
            self.call("entering configuration mode", "enterConfigurationMode")
            for port, values in structural:
                self.set_start(port, values)
            together = ", ".join(_assigned(port, values) for port, values in structural)
            self.call(f"setting {together}", "exitConfigurationMode")
        for port, values in given:
            if not port.structural:
                self.set_start(port, values)

    def change(self, k: int, port: Port, values: Sequence[Any]) -> None:
        """Set a value of any type at communication point k of a run."""
        self._changed = k, [*self.changed_at(k), port.name]
        self.set_start(port, values)

    def changed_at(self, k: int) -> list[str]:
        """Name the variables that were changed at communication point k."""
        return self._changed[1] if self._changed[0] == k else []

    @property
    def in_step_mode(self) -> bool:
        """Whether values are exchanged in step mode, in which FMI forbids a get after a set without a step between."""
        return self.kind == "co-simulation" and self._events is None

    @property
    def can_save(self) -> bool:
        """Whether `save` and `restore` may be called."""
        return bool(self._interface.canGetAndSetFMUstate)

    @cached_property
    def never_returns(self) -> bool:
        """Whether no step is ever gone back behind: noSetFMUStatePriorToCurrentPoint of doStep."""
        return self.ours or not self.can_save

    @property
    def can_vary_step(self) -> bool:
        """Whether communication steps may be of different sizes."""
        return bool(self._interface.canHandleVariableCommunicationStepSize)

    @property
    def asynchronous(self) -> bool:
        """Whether doStep may return before the step is done."""
        return self.major == 2 and bool(self._interface.canRunAsynchronuously)

    @property
    def saves_for_retries(self) -> bool:
        """Whether the state is saved before each step, to return to if it is discarded and taken in smaller ones."""
        return self.major == 2 and self.can_save and self.can_vary_step and not self.ours

    @property
    def may_discard(self) -> bool:
        """Whether a step that is discarded leaves the FMU as it was before, so that smaller ones can be taken."""
        return self.major == 3 and self.can_vary_step and not self.ours

    @property
    def can_serialize(self) -> bool:
        """Whether a saved state can be made into bytes and back."""
        return self.can_save and bool(self._interface.canSerializeFMUstate)

    @property
    def has_directional_derivatives(self) -> bool:
        """Whether `directional_derivative` may be called."""
        return self.kind in self.fmu.directional

    def directional_derivative(
        self, unknowns: Sequence[int], knowns: Sequence[int], seed: Sequence[float], size: int
    ) -> list[float]:
        """Return (size,): how the unknown variables change as the known ones change by `seed`."""
        sizes = () if self.major == 2 else (size,)
        action = "getting directional derivatives"
        return list(self.call(action, "getDirectionalDerivative", unknowns, knowns, seed, *sizes))

    def save(self) -> Any:
        """Return the complete present state, to be given to `restore`, any number of times, and then to `free`."""
        state = self.call("saving the state", "getFMUState")
        return state if self._events is None else (state, self._events.snapshot())

    def restore(self, state: Any) -> None:
        """Return to a saved state of this instance."""
        if self._events is not None:
            state, snapshot = state
            self._events.restore(snapshot)
        self.call("restoring a state", "setFMUState", state)

    def free(self, state: Any) -> None:
        """Give back the memory of a saved state."""
        self.call("freeing a state", "freeFMUState", state if self._events is None else state[0])

    def serialize(self, state: Any) -> bytes:
        """Return a saved state as bytes, which another instance of the same FMU understands."""
        if self._events is None:
            return bytes(self.call("serializing a state", "serializeFMUState", state))
        content = self.call("serializing a state", "serializeFMUState", state[0])
        events = self._events.to_bytes(state[1])
        return len(events).to_bytes(8, "little") + events + bytes(content)

    def deserialize(self, content: bytes) -> Any:
        """Return the saved state that the bytes hold."""
        if self._events is None:
            return self.call("deserializing a state", "deserializeFMUState", content)
        end = 8 + int.from_bytes(content[:8], "little")
        state = self.call("deserializing a state", "deserializeFMUState", content[end:])
        return state, self._events.from_bytes(content[8:end])

    @property
    def special(self) -> bool:
        """Whether steps must go through `do_step` here: the FMU's own doStep is not all that there is to them."""
        return self._stepper is not None

    def do_step(self, time: float, step: float) -> None:
        """Co-Simulation: step on from `time`. EndRequested if it ends the simulation before the end of the step.

        If it does so at the end of the step, `wants_end` says so.
        """
        if self._stepper is not None:
            self._stepper.step(time, step)
            return
        if self.major == 2:
            try:
                self.call("doStep", "doStep", time, step, self.never_returns)
            except EndRequested:
                if not self.ends_with_discarded(time, step):
                    raise
            return
        event, terminate, early, last = c_bool(), c_bool(), c_bool(), c_double(time + step)  # which not all FMUs set
        do_step = getattr(self.handle, "_functions")["fmi3DoStep"]  # noqa: B009 - what fmpy loaded
        results = [byref(r) for r in (event, terminate, early, last)]
        with self.calling("doStep"):
            status = do_step(self.handle.component, time, step, self.never_returns, *results)
        if status == DISCARD:
            self.after_discard(time, step)
            return
        if status not in (0, 1):
            raise self.failure("doStep", status)
        if terminate.value:
            self.end_at(time, step, early=early.value, last=last.value)
        elif early.value:
            raise self.returned_early(last.value)

    def end_at(self, time: float, step: float, *, early: bool, last: float) -> None:
        """Take an FMI 3 step for what it is that ends the simulation at time `last`: EndRequested if it is not done."""
        if last >= time + step - SNAP * step:
            self.wants_end = True
        elif last >= time:
            raise self.ended(last)
        elif early:
            allowed = self._events is not None or self._interface.mightReturnEarlyFromDoStep
            raise self.returned_outside(last, time, time + step) if allowed else self.returned_early(last)
        else:  # it has not said how far it got, and need not
            self.wants_end = True

    def enter_initialization(self, start_time: float, stop_time: float) -> None:
        """Enter initialisation mode."""
        action = "entering initialisation"
        self._start_time = start_time
        times = {"startTime": start_time, "stopTime": stop_time if isfinite(stop_time) else None}
        if self.major == 2:
            self.call(action, "setupExperiment", **times)
            self.call(action, "enterInitializationMode")
        else:
            self.call(action, "enterInitializationMode", **times)
            if self._events is not None:
                self._events.initialise()

    def exit_initialization(self) -> None:
        """Leave initialisation mode."""
        if self._events is not None:
            self._events.prepare(self._start_time)
        self.call("initialisation", "exitInitializationMode")
        if self._events is not None:
            self._events.begin(self._start_time)
        self._check()

    def abandon(self) -> None:
        """Never call it again: a call of it is still going on."""
        self._fatal = True

    def close(self, *, healthy: bool) -> None:
        """Terminate, when nothing has failed, and free the instance; a fatal failure forbids any further call."""
        if self._alive and not self._fatal:
            self._alive = False
            if self._stepper is not None:
                self._stepper.close()
            if healthy:
                with self.calling("terminating"), suppress(FMICallException):
                    self.handle.terminate()
            with self.calling("freeing"):
                self.handle.freeInstance()
            self._check()
        if self._callbacks is not None:
            _loggers.pop(self._callbacks.componentEnvironment, None)


def _assigned(port: Port, values: Sequence[Any]) -> str:
    return f"{port.name} = {', '.join(map(str, values[:12]))}{', ...' if len(values) > 12 else ''}"


def _go_on(*arguments: Any) -> None:
    """Answer an intermediate update: no early return is asked for."""
    arguments[6][0] = False


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
