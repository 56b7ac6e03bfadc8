"""The compiled stepping loop, `engine.c`: built on first use, called through ctypes."""

from __future__ import annotations

import ctypes
import hashlib
import os
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from fmus import toolchain
from fmus.paths import BUILD
from orchestration.instance import CallFailed, Instance, action_of
from orchestration.plan import Floats, Plan

_SOURCE = Path(__file__).with_name("engine.c")
_FLAGS = ("-std=c11", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-Wall", "-Wextra", "-shared")

_GET, _SET, _DO_STEP, _SET_TIME, _SET_STATES, _GET_DERIVATIVES = range(6)
_STATUS, _NOT_FINITE, _TERMINATED, _EARLY_RETURN = range(1, 5)
_ACTIONS = {
    _DO_STEP: "doStep",
    _SET_TIME: "setTime",
    _SET_STATES: "setContinuousStates",
    _GET_DERIVATIVES: "getDerivatives",
}


class _Component(ctypes.Structure):
    _fields_ = (
        ("instance", ctypes.c_void_p),
        ("get", ctypes.c_void_p),
        ("set", ctypes.c_void_p),
        ("do_step", ctypes.c_void_p),
        ("set_time", ctypes.c_void_p),
        ("set_states", ctypes.c_void_p),
        ("get_derivatives", ctypes.c_void_p),
        ("n_states", ctypes.c_size_t),
        ("fmi", ctypes.c_int32),
    )


class _Range(ctypes.Structure):
    _fields_ = (("start", ctypes.c_size_t), ("n", ctypes.c_size_t))


class _Call(ctypes.Structure):
    _fields_ = (
        ("references", ctypes.POINTER(ctypes.c_uint32)),
        ("n_references", ctypes.c_size_t),
        ("values", ctypes.c_void_p),
        ("n_values", ctypes.c_size_t),
        ("ranges", ctypes.POINTER(_Range)),
        ("n_ranges", ctypes.c_size_t),
        ("kind", ctypes.c_int32),
        ("component", ctypes.c_uint32),
    )


class _Failure(ctypes.Structure):
    _fields_ = tuple((name, ctypes.c_int32) for name in ("reason", "kind", "component", "call", "status", "element"))


class _Plan(ctypes.Structure):
    _fields_ = (
        ("components", ctypes.POINTER(_Component)),
        ("n_components", ctypes.c_size_t),
        ("calls", ctypes.POINTER(_Call)),
        ("n_calls", ctypes.c_size_t),
        ("signals", ctypes.c_void_p),
        ("record", ctypes.POINTER(_Range)),
        ("n_record", ctypes.c_size_t),
        ("failure", _Failure),
    )


class Engine:
    """A plan bound to the function pointers of its instances, which must stay open as long as it is used."""

    def __init__(self, plan: Plan, instances: Mapping[str, Instance]) -> None:
        self._plan = plan
        self._instances = list(instances.values())
        self._library = _library()
        number = {name: i for i, name in enumerate(instances)}
        components = (_Component * len(instances))(*map(_component, self._instances))
        calls = (_Call * len(plan.calls))()
        keep: list[Any] = [components, calls]  # what the C structures point to
        for call, raw in zip(plan.calls, calls, strict=True):
            raw.references = (ctypes.c_uint32 * len(call.references))(*call.references)
            raw.n_references = len(call.references)
            raw.n_values = len(call.where)
            raw.component = number[call.component]
            if call.kind == "get":  # the plan gives each get call a contiguous place
                raw.kind = _GET
                raw.values = plan.signals.ctypes.data + int(call.where[0]) * plan.signals.itemsize
            else:
                raw.kind = _SET
                staging = np.zeros(len(call.where))
                raw.values = staging.ctypes.data
                raw.ranges, raw.n_ranges = _ranges(call.where)
                keep.append(staging)
        record, n_record = _ranges(plan.row)
        self._raw = _Plan(
            components, len(components), calls, len(calls), plan.signals.ctypes.data, record, n_record, _Failure()
        )
        self._reference = ctypes.byref(self._raw)
        self._keep = keep

    def propagate(self) -> None:
        """Execute the get and set calls once."""
        if not self._library.adcs_propagate(self._reference):
            raise self._failed()

    def steps(self, start: float, step: float, first: int, last: int, rows: Floats) -> tuple[int, CallFailed | None]:
        """Co-simulate: fill `rows` (n, row size) with the rows from index `first`; do not step on from row `last`.

        Returns how many rows were written, and what failed, if so.
        """
        n = self._library.adcs_steps(self._reference, start, step, first, len(rows), last, rows.ctypes.data)
        if not self._raw.failure.reason:
            return n, None
        failed = self._failed()
        stepping = self._raw.failure.kind == _DO_STEP  # from the last row that was written
        failed.time = start + (first + n - stepping) * step
        return n, failed

    def evaluate(self, time: float, states: Floats, derivatives: Floats | None, row: Floats | None = None) -> None:
        """Coupled Model Exchange: write the derivatives and the row at a time and state vector (contiguous arrays)."""
        if not self._library.adcs_evaluate(
            self._reference,
            time,
            states.ctypes.data,
            None if derivatives is None else derivatives.ctypes.data,
            None if row is None else row.ctypes.data,
        ):
            failed = self._failed()
            failed.time = time
            raise failed

    def _failed(self) -> CallFailed:
        failure: Any = self._raw.failure
        instance: Instance = self._instances[failure.component]
        if failure.kind in _ACTIONS:
            action = _ACTIONS[failure.kind]
            elements = tuple(f"the derivative of {state}" for state in instance.fmu.states)
        else:
            call = self._plan.calls[failure.call]
            action, elements = action_of(call), call.elements
        if failure.reason == _NOT_FINITE:
            return CallFailed(instance.name, f"{elements[failure.element]} is not finite")
        if failure.reason == _TERMINATED:
            return instance.ended()
        if failure.reason == _EARLY_RETURN:
            return instance.returned_early()
        return instance.failure(action, failure.status)


def _component(instance: Instance) -> _Component:
    handle = instance.handle
    prefix, real = ("fmi2", "Real") if instance.major == 2 else ("fmi3", "Float64")

    def address(function: str) -> int | None:
        pointer = getattr(handle, "_functions").get(prefix + function)  # noqa: B009 - what fmpy loaded
        return None if pointer is None else ctypes.cast(pointer, ctypes.c_void_p).value

    return _Component(
        instance=handle.component,
        get=address(f"Get{real}"),
        set=address(f"Set{real}"),
        do_step=address("DoStep"),
        set_time=address("SetTime"),
        set_states=address("SetContinuousStates"),
        get_derivatives=address("GetDerivatives" if instance.major == 2 else "GetContinuousStateDerivatives"),
        n_states=len(instance.fmu.states),
        fmi=instance.major,
    )


def _ranges(where: np.ndarray[Any, np.dtype[np.intp]]) -> tuple[Any, int]:
    """Cut indices into contiguous ranges."""
    cuts = np.flatnonzero(np.diff(where) != 1) + 1
    parts = [part for part in np.split(where, cuts) if len(part)]
    return (_Range * len(parts))(*(_Range(int(part[0]), len(part)) for part in parts)), len(parts)


def _built() -> Path:
    target = toolchain.host()
    flags = ("-target", target.triple, *_FLAGS)
    version = hashlib.sha256(_SOURCE.read_bytes() + " ".join(flags).encode()).hexdigest()[:16]
    output = BUILD / "engine" / f"engine-{version}{target.suffix}"
    if not output.is_file():
        output.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(dir=output.parent) as folder:  # several processes may build it at once
            made = Path(folder) / output.name
            toolchain.run_steps([toolchain.Step(made, ("cc", *flags, str(_SOURCE), "-o", str(made)), (_SOURCE,))])
            made.replace(output)
    return output


@cache
def _library() -> ctypes.CDLL:
    library = ctypes.CDLL(os.environ.get("ADCS_ENGINE") or str(_built()))  # the variable: for sanitized builds
    plan, double, address, index = ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_int64
    library.adcs_plan_size.restype = ctypes.c_size_t
    library.adcs_propagate.argtypes = (plan,)
    library.adcs_propagate.restype = ctypes.c_bool
    library.adcs_steps.argtypes = (plan, double, double, index, index, index, address)
    library.adcs_steps.restype = index
    library.adcs_evaluate.argtypes = (plan, double, address, address, address)
    library.adcs_evaluate.restype = ctypes.c_bool
    assert library.adcs_plan_size() == ctypes.sizeof(_Plan), "engine.c and its mirror in Python differ"
    return library
