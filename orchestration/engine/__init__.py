"""The compiled engine, engine.c and walk.c: built on first use, called through ctypes."""

from __future__ import annotations

import ctypes
import hashlib
import itertools
import os
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from fmus import toolchain
from fmus.carried import compiled
from fmus.files import make_folder, write_atomically
from fmus.paths import BUILD
from orchestration.instances.instance import CallFailed, EndRequested, Instance
from orchestration.plan.lowering import Call, Floats, Plan
from orchestration.plan.outside import Lines
from orchestration.plan.propagation import Ring, action_of, not_doubled, not_finite, not_handed_on, read_after_set
from orchestration.process.where import ACTIONS, Action, Doing, Place, Where

_SOURCES = tuple(Path(__file__).with_name(name) for name in ("engine.c", "walk.c"))
_HEADERS = tuple(Path(__file__).with_name(name) for name in ("engine.h", "dop853.h"))
_FLAGS = ("-std=c11", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-Wall", "-Wextra", "-g0", "-s", "-shared")

_STATUS, _NOT_FINITE, _TERMINATED, _EARLY_RETURN, _DOES_NOT_FIT, _RAISED, _GIVEN_UP = range(1, 8)
_TYPES = ["Float64", "Float32", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64", "Boolean"]
_CONTROLS = ("the rounding mode", "the flushing of denormal numbers", "the traps of floating-point exceptions")
_BOOL32 = len(_TYPES)  # FMI 2's
_SIZES = dict(zip(_TYPES, (8, 4, 1, 1, 2, 2, 4, 4, 8, 8, 4), strict=True))
_FMI2_NAMES = {"Float64": "Real", "Int32": "Integer", "Boolean": "Boolean"}

_NEVER = 2**63 - 1  # the point at which nobody ends the simulation

_CALLBACK = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int32, ctypes.c_int32, ctypes.c_double, ctypes.c_double)


class _Component(ctypes.Structure):
    _fields_ = (
        ("instance", ctypes.c_void_p),
        ("do_step", ctypes.c_void_p),
        ("set_time", ctypes.c_void_p),
        ("set_states", ctypes.c_void_p),
        ("get_derivatives", ctypes.c_void_p),
        ("get_indicators", ctypes.c_void_p),
        ("n_states", ctypes.c_size_t),
        ("n_indicators", ctypes.c_size_t),
        ("every", ctypes.c_int64),
        ("fmi", ctypes.c_int32),
        ("foreign", ctypes.c_bool),
        ("never_returns", ctypes.c_bool),
        ("changed", ctypes.c_int32),
    )


class _Pair(ctypes.Structure):
    _fields_ = (("here", ctypes.c_double), ("there", ctypes.c_double))


class _Piece(ctypes.Structure):
    _fields_ = (
        ("start", ctypes.c_size_t),
        ("n", ctypes.c_size_t),
        ("factor", ctypes.c_double),
        ("offset", ctypes.c_double),
        ("mapping", ctypes.POINTER(_Pair)),
        ("n_mapping", ctypes.c_size_t),
        ("plain", ctypes.c_bool),
        ("whole", ctypes.c_bool),
    )


class _Call(ctypes.Structure):
    _fields_ = (
        ("references", ctypes.POINTER(ctypes.c_uint32)),
        ("n_references", ctypes.c_size_t),
        ("values", ctypes.c_void_p),
        ("n_values", ctypes.c_size_t),
        ("raw", ctypes.c_void_p),
        ("pieces", ctypes.POINTER(_Piece)),
        ("n_pieces", ctypes.c_size_t),
        ("access", ctypes.c_void_p),
        ("kind", ctypes.c_int32),
        ("type", ctypes.c_int32),
        ("component", ctypes.c_uint32),
        ("every", ctypes.c_int64),
        ("plain", ctypes.c_bool),
    )


class _Delay(ctypes.Structure):
    _fields_ = (
        ("start", ctypes.c_size_t),
        ("to", ctypes.c_size_t),
        ("n", ctypes.c_size_t),
        ("steps", ctypes.c_int64),
        ("history", ctypes.c_void_p),
    )


class _Lines(ctypes.Structure):
    _fields_ = (
        ("times", ctypes.c_void_p),
        ("values", ctypes.c_void_p),
        ("slopes", ctypes.c_void_p),
        ("n_times", ctypes.c_size_t),
        ("n", ctypes.c_size_t),
        ("to", ctypes.c_size_t),
        ("current", ctypes.c_size_t),
    )


class Failure(ctypes.Structure):
    """What failed, in numbers (engine.h)."""

    _fields_ = tuple((name, ctypes.c_int32) for name in ("reason", "kind", "component", "call", "status", "element"))


class _Plan(ctypes.Structure):
    _fields_ = (
        ("components", ctypes.POINTER(_Component)),
        ("n_components", ctypes.c_size_t),
        ("calls", ctypes.POINTER(_Call)),
        ("n_calls", ctypes.c_size_t),
        ("signals", ctypes.c_void_p),
        ("n_external", ctypes.c_size_t),
        ("delays", ctypes.POINTER(_Delay)),
        ("n_delays", ctypes.c_size_t),
        ("lines", ctypes.POINTER(_Lines)),
        ("n_lines", ctypes.c_size_t),
        ("record", ctypes.POINTER(_Piece)),
        ("n_record", ctypes.c_size_t),
        ("record_every", ctypes.c_int64),
        ("callback", _CALLBACK),
        ("failure", Failure),
        ("ending", ctypes.c_int64),
        ("ender", ctypes.c_int32),
        ("returned", ctypes.c_double),
        ("where", ctypes.POINTER(Place)),
        ("control", ctypes.c_uint32),
        ("stop", ctypes.c_int32),
    )


class ThreadControl:
    """The floating-point control of the thread that asks."""

    def control(self) -> int:
        """Return it."""
        return int(library().adcs_control())

    def restore(self, value: int) -> list[str]:
        """Put it back; say what was changed."""
        return _controls(int(library().adcs_restore(value)))


class Engine:
    """A plan bound to the function pointers of its instances, which must stay open as long as it is used.

    `solve` solves the loop of a given number; `rings` hold what is on its way in the plan's delays; `lines` are those
    that the signals from outside follow in `evaluate`; `where` is told where the loop is.
    """

    def __init__(
        self,
        plan: Plan,
        instances: Mapping[str, Instance],
        *,
        rings: tuple[Ring, ...] = (),
        lines: Sequence[Lines] = (),
        record_every: int = 1,
        solve: Callable[[int], None] | None = None,
        where: Where | None = None,
    ) -> None:
        self._plan = plan
        self._where = where or Where()
        self._where.names = list(instances)
        self._instances = list(instances.values())
        self._solve = solve
        self.raised: BaseException | None = None
        """What a callback could not pass through C."""
        self._library = library()
        self._number = {name: i for i, name in enumerate(instances)}
        self._keep: list[Any] = [plan, rings]  # what the C structures point to
        components = (_Component * len(instances))(*(_component(i, plan.every.get(i.name, 1)) for i in self._instances))
        calls = (_Call * len(plan.calls))(*map(self._call, plan.calls))
        delays = (_Delay * len(rings))(
            *(
                _Delay(
                    r.delay.source.start,
                    r.delay.target.start,
                    r.delay.source.stop - r.delay.source.start,
                    r.delay.steps,
                    r.values.ctypes.data,
                )
                for r in rings
            )
        )
        begins = itertools.accumulate((line.values.shape[1] for line in lines), initial=0)
        followed = (_Lines * len(lines))(*map(self._followed, lines, begins))
        record, n_record = _pieces(plan.row)
        self.raw = _Plan(
            components=components,
            n_components=len(components),
            calls=calls,
            n_calls=len(calls),
            signals=plan.signals.ctypes.data,
            n_external=plan.n_external,
            delays=delays,
            n_delays=len(delays),
            lines=followed,
            n_lines=len(followed),
            record=record,
            n_record=n_record,
            record_every=record_every,
            callback=_CALLBACK(self._called_back),
            where=ctypes.pointer(self._where.place),
        )
        self._reference = ctypes.byref(self.raw)
        self.forget_end()

    @property
    def doing(self) -> Doing:
        """Point, component and call that are going on; to be read from another thread."""
        return self._where.now

    def stop(self, at_once: bool = False) -> None:
        """Let `steps` return before its next point, or before its next call; to be called from another thread."""
        self.raw.stop = 2 if at_once else 1

    def forget_end(self) -> None:
        """Nobody has asked yet to end the simulation, unless it was in initialisation."""
        asking = next((n for n, instance in enumerate(self._instances) if instance.wants_end), None)
        self.raw.ending, self.raw.ender = _NEVER if asking is None else -1, asking or 0

    def ending(self, k: int) -> EndRequested | None:
        """Return the wish of a component to end the simulation at point k, or before."""
        return None if k < self.raw.ending else self._instances[self.raw.ender].ended()

    @property
    def changed(self) -> dict[str, list[str]]:
        """What components have changed of the thread that they are called in, and was changed back, by their names."""
        bits = {instance.name: int(self.raw.components[i].changed) for i, instance in enumerate(self._instances)}
        return {name: _controls(changed) for name, changed in bits.items() if changed}

    def propagate(self, k: int = 0, time: float = 0.0) -> None:
        """Execute the get and set calls of point k once."""
        if not self._library.adcs_propagate(self._reference, k, time):
            raise self.failed()

    def move_on(self, k: int, last: int, time: float, step: float) -> None:
        """Step all components on from point k; none beyond point `last`."""
        if not self._library.adcs_move_on(self._reference, k, last, time, step):
            raise self.failed()

    def steps(
        self, start: float, step: float, first: int, count: int, last: int, external: Floats | None, rows: Floats
    ) -> tuple[int, int, CallFailed | None]:
        """Co-simulate from point `first` to before point `first + count`; do not step on from point `last`.

        `external` (count, number of external signals) is what comes from outside. Returns the next point, how many
        `rows` (n, row size) were written, and what failed, if so.
        """
        self._where.place.k = first
        given = None if external is None else external.ctypes.data
        written = self._library.adcs_steps(self._reference, start, step, first, count, last, given, rows.ctypes.data)
        if not self.raw.failure.reason:
            return self._where.place.k, written, None
        failed = self.failed()
        if failed.time is None:
            failed.time = start + self._where.place.k * step
        return self._where.place.k, written, failed

    def evaluate(self, time: float, states: Floats, derivatives: Floats | None, row: Floats | None = None) -> None:
        """Coupled Model Exchange: write the derivatives and the row at a time and state vector (contiguous arrays)."""
        if not self._library.adcs_evaluate(
            self._reference,
            time,
            states.ctypes.data,
            None if derivatives is None else derivatives.ctypes.data,
            None if row is None else row.ctypes.data,
        ):
            failed = self.failed()
            failed.time = time
            raise failed

    def _called_back(self, kind: int, number: int, time: float, step: float) -> int:
        try:
            if kind == Action.SOLVE:
                assert self._solve is not None
                self._solve(number)
            elif kind == Action.DISCARDED:
                self._instances[number].after_discard(time, step)
                return 2 if self._instances[number].wants_end else 0
            else:
                self._instances[number].do_step(time, step)
                return 2 if self._instances[number].wants_end else 0
        except BaseException as error:  # cannot pass through C
            self.raised = error
            return 1
        return 0

    def _call(self, call: Call) -> _Call:
        if call.kind == "solve":
            return _Call(kind=Action.SOLVE, component=call.loop, every=call.every)
        instance = self._instances[self._number[call.component]]
        n = len(call.where)
        references = (ctypes.c_uint32 * len(call.references))(*call.references)
        raw = None
        if call.type != "Float64":
            raw = ctypes.create_string_buffer(n * _SIZES[call.type])
            self._keep.append(raw)
        made = _Call(
            references=references,
            n_references=len(references),
            n_values=n,
            raw=None if raw is None else ctypes.addressof(raw),
            access=_access(instance, call),
            type=_BOOL32 if instance.major == 2 and call.type == "Boolean" else _TYPES.index(call.type),
            component=self._number[call.component],
            every=call.every,
            plain=call.plain and not (call.where < self._plan.n_external).any(),
        )
        if call.kind == "get":
            made.kind = Action.GET
            made.values = self._plan.signals.ctypes.data + int(call.where[0]) * self._plan.signals.itemsize
        else:
            made.kind = Action.SET
            staging = np.zeros(n)
            made.values = staging.ctypes.data
            made.pieces, made.n_pieces = _pieces(call.where, call)
            self._keep.append(staging)
        return made

    def _followed(self, lines: Lines, to: int) -> _Lines:
        read = [np.ascontiguousarray(part) for part in (lines.times, lines.values, lines.slopes)]
        self._keep.append(read)
        return _Lines(*(part.ctypes.data for part in read), *lines.values.shape, to)

    def failed(self) -> CallFailed:
        """Return what has failed in the call that was made last, or raise what a callback raised."""
        failure: Any = self.raw.failure
        if failure.reason == _RAISED:
            error, self.raised = self.raised, None
            if isinstance(error, CallFailed):
                return error
            raise error or RuntimeError("a callback failed without a reason")
        instance: Instance = self._instances[failure.component]
        if failure.reason == _GIVEN_UP:
            return CallFailed(instance.name, "it was given up")
        if failure.kind in (Action.GET, Action.SET):
            call = self._plan.calls[failure.call]
            action, elements = action_of(call), call.elements
            if failure.reason == _DOES_NOT_FIT and failure.kind == Action.SET:
                return not_handed_on(call, failure.element, self._plan.signals)
            if failure.reason == _DOES_NOT_FIT:
                return not_doubled(call, failure.element, self._whole(failure.call, failure.element))
        else:
            action = ACTIONS[failure.kind].text
            elements = tuple(f"the derivative of {state}" for state in instance.fmu.states)
            if failure.kind == Action.GET_INDICATORS:
                n = instance.fmu.event_indicators
                elements = tuple(f"event indicator {i + 1} of {n}" for i in range(n))
        if failure.reason == _NOT_FINITE:
            return not_finite(instance.name, elements[failure.element])
        if failure.reason == _TERMINATED:
            return instance.ended(self.raw.returned)
        if failure.reason == _EARLY_RETURN:
            return instance.returned_early(self.raw.returned)
        failed = instance.failure(action, failure.status)
        if failure.kind == Action.GET:
            return read_after_set(failed, self._plan, call, instance, self._where.place.k)
        return failed

    def _whole(self, number: int, element: int) -> int:
        """Return one of the integers that a get call has got last."""
        call: Any = self.raw.calls[number]
        kind = ctypes.c_uint64 if self._plan.calls[number].type == "UInt64" else ctypes.c_int64
        return int(ctypes.cast(call.raw, ctypes.POINTER(kind))[element])


def _controls(bits: int) -> list[str]:
    return [what for bit, what in enumerate(_CONTROLS) if bits >> bit & 1]


def _access(instance: Instance, call: Call) -> int | None:
    kind = _FMI2_NAMES.get(call.type, call.type) if instance.major == 2 else call.type
    return _address(instance, f"{call.kind.capitalize()}{kind}")


def _address(instance: Instance, function: str) -> int | None:
    functions = getattr(instance.handle, "_functions")  # noqa: B009 - what fmpy loaded
    pointer = functions.get(f"fmi{instance.major}{function}")
    return None if pointer is None else ctypes.cast(pointer, ctypes.c_void_p).value


def _component(instance: Instance, every: int) -> _Component:
    return _Component(
        instance=instance.handle.component,
        do_step=None if instance.special else _address(instance, "DoStep"),
        set_time=_address(instance, "SetTime"),
        set_states=_address(instance, "SetContinuousStates"),
        get_derivatives=_address(
            instance, "GetDerivatives" if instance.major == 2 else "GetContinuousStateDerivatives"
        ),
        get_indicators=_address(instance, "GetEventIndicators"),
        n_states=len(instance.fmu.states),
        n_indicators=instance.fmu.event_indicators,
        every=every,
        fmi=instance.major,
        foreign=not instance.ours,
        never_returns=instance.never_returns,
    )


def _pieces(where: np.ndarray[Any, np.dtype[np.intp]], call: Call | None = None) -> tuple[Any, int]:
    """Cut indices into contiguous pieces that are handed on in the same way."""
    cut = np.diff(where) != 1
    if call is not None and call.factor is not None and call.offset is not None:
        cut = cut | (np.diff(call.factor) != 0) | (np.diff(call.offset) != 0)
        if call.mappings:
            cut = cut | np.array([a != b for a, b in zip(call.mappings, call.mappings[1:], strict=False)], bool)
    bounds = [0, *(np.flatnonzero(cut) + 1), len(where)] if len(where) else []
    pieces = [_piece(int(where[i]), int(j - i), call, int(i)) for i, j in itertools.pairwise(bounds)]
    return (_Piece * len(pieces))(*pieces), len(pieces)


def _piece(start: int, n: int, call: Call | None, first: int) -> _Piece:
    if call is None or call.factor is None or call.offset is None:
        return _Piece(start=start, n=n, factor=1.0, plain=True)
    factor, offset = float(call.factor[first]), float(call.offset[first])
    pairs = call.mappings[first] if call.mappings else ()
    plain = not pairs and (factor, offset) == (1.0, 0.0)
    mapping = (_Pair * len(pairs))(*(_Pair(*pair) for pair in pairs)) if pairs else None
    return _Piece(start, n, factor, offset, mapping, len(pairs), plain, "Int" in call.type)


def library_for(target: toolchain.Target) -> Path:
    """Return the engine for a platform, which is built unless it was, or is carried."""
    flags = ("-target", target.triple, *_FLAGS)
    read = b"".join(path.read_bytes() for path in (*_SOURCES, *_HEADERS))
    version = hashlib.sha256(read + " ".join(flags).encode()).hexdigest()[:16]
    output = BUILD / "engine" / f"engine-{version}{target.suffix}"
    if output.is_file():
        return output
    carried = compiled(output.name, target)
    if carried is not None:
        write_atomically(output, carried)
        return output
    make_folder(output.parent)
    with TemporaryDirectory(dir=output.parent) as folder:  # several processes may build it at once
        made = Path(folder) / output.name
        command = ("cc", *flags, *toolchain.own_name(output, target), *map(str, _SOURCES), "-o", str(made))
        toolchain.run_steps([toolchain.Step(made, command, (*_SOURCES, *_HEADERS))])
        made.replace(output)
    return output


@cache
def library() -> ctypes.CDLL:
    """Return the engine for this machine."""
    loaded = ctypes.CDLL(
        os.environ.get("ADCS_ENGINE") or str(library_for(toolchain.host()))
    )  # the variable: for sanitized builds
    plan, double, address, index = ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_int64
    loaded.adcs_plan_size.restype = ctypes.c_size_t
    loaded.adcs_control.restype = ctypes.c_uint32
    loaded.adcs_restore.argtypes = (ctypes.c_uint32,)
    loaded.adcs_restore.restype = ctypes.c_int32
    loaded.adcs_propagate.argtypes = (plan, index, double)
    loaded.adcs_propagate.restype = ctypes.c_bool
    loaded.adcs_move_on.argtypes = (plan, index, index, double, double)
    loaded.adcs_move_on.restype = ctypes.c_bool
    loaded.adcs_steps.argtypes = (plan, double, double, index, index, index, address, address)
    loaded.adcs_steps.restype = index
    loaded.adcs_evaluate.argtypes = (plan, double, address, address, address)
    loaded.adcs_evaluate.restype = ctypes.c_bool
    loaded.adcs_walk_size.restype = ctypes.c_size_t
    loaded.adcs_walk.argtypes = (address, double, double, address)
    loaded.adcs_walk.restype = ctypes.c_int32
    for rule in (loaded.adcs_covered, loaded.adcs_looks):
        rule.argtypes = (double, double, double)
        rule.restype = double
    loaded.adcs_between.argtypes = (address, double, address)
    loaded.adcs_between.restype = ctypes.c_bool
    loaded.adcs_shorter.argtypes = (address, address, double)
    loaded.adcs_shorter.restype = ctypes.c_bool
    assert loaded.adcs_plan_size() == ctypes.sizeof(_Plan), "engine.c and its mirror in Python differ"
    return loaded
