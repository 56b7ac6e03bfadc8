"""A system: components, their start values, and the connections between them. A description only; `run` runs it."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fmus.errors import AdcsError
from orchestration.fmu import FmiVersion, Fmu, Port, locate, open_fmu

Value = Any
"""What a start value may be: a number, bool or str, or nested sequences or an array of them."""


@dataclass
class Component:
    """A named FMU with the start values that were set explicitly (flat, row-major)."""

    name: str
    source: str | Path
    fmu: Fmu
    start: dict[str, tuple[Any, ...]]

    def open(self, version: FmiVersion) -> Fmu:
        """Return the FMU in the FMI version asked for; a component given by path has only one."""
        return open_fmu(locate(self.source, version))


@dataclass(frozen=True)
class Connection:
    """A value that flows from an output to an input without delay; both ends are `component.variable`."""

    source: str
    target: str


class System:
    """Components and their wiring; everything that can be checked without running is checked at once."""

    def __init__(self, name: str, description: str = "") -> None:
        self.name = name
        self.description = description
        self.components: dict[str, Component] = {}
        self.connections: list[Connection] = []

    def add(self, name: str, fmu: str | Path, start: Mapping[str, Value] | None = None) -> None:
        """Add a component.

        `fmu` is a name in `fmus/dist` or the path of any `.fmu`. `start` maps variables (parameters, inputs, states and
        outputs with a start value) to values of the variable's shape, in the variable's unit.
        """
        if not name or "." in name or not name.isprintable():
            raise AdcsError(f"component name {name!r} is not usable: give a name without dots")
        if name in self.components:
            raise AdcsError(f"system {self.name!r} already has a component {name!r}: give another name")
        # Both files of a component built here say the same: the wiring is checked on whichever exists.
        component = Component(name, fmu, open_fmu(_any_version(fmu)), {})
        values = {variable: _start(name, component.fmu, variable, value) for variable, value in (start or {}).items()}
        component.start.update(values)
        self.components[name] = component

    def set(self, name: str, value: Value) -> None:
        """Set one start value, `component.variable`; replaces one given before."""
        component, port = self.port(name)
        connected = next((c for c in self.connections if c.target == name), None)
        if connected is not None:
            raise AdcsError(f"{name} is connected to {connected.source}: a start value would have no effect")
        self.components[component].start[port.name] = _start(
            component, self.components[component].fmu, port.name, value
        )

    def connect(self, source: str, target: str) -> None:
        """Connect an output to an input of the same shape and unit, both written `component.variable`.

        An end without a unit goes with any unit; different units are refused.
        """
        _, output = self.port(source)
        component, input_ = self.port(target)
        link = f"cannot connect {source} to {target}: "
        if output.causality != "output":
            raise AdcsError(f"{link}{source} is not an output but has causality {output.causality!r}")
        if input_.causality != "input":
            raise AdcsError(f"{link}{target} is not an input but has causality {input_.causality!r}")
        for end, port in ((source, output), (target, input_)):
            if port.type != "Float64":
                raise AdcsError(f"{link}{end} is of type {port.type}, only Float64 can be connected so far")
        if output.shape != input_.shape:
            raise AdcsError(f"{link}sizes differ, {_size(output.shape)} and {_size(input_.shape)}")
        if output.unit and input_.unit and output.unit != input_.unit:
            raise AdcsError(f"{link}units differ, {output.unit!r} and {input_.unit!r}: convert between them")
        for other in self.connections:
            if other.target == target:
                raise AdcsError(f"{link}{other.source} is already connected to it, an input has one source")
        if input_.name in self.components[component].start:
            raise AdcsError(f"{link}{target} has a start value that the connection would override: drop one of them")
        self.connections.append(Connection(source, target))

    def port(self, name: str) -> tuple[str, Port]:
        """Return the component's name and the variable that `component.variable` names."""
        component, _, variable = name.partition(".")
        if component not in self.components:
            raise AdcsError(
                f"{name!r}: system {self.name!r} has no component {component!r}{_hint(component, self.components)}"
            )
        return component, _port(component, self.components[component].fmu, variable)

    def outputs(self) -> list[str]:
        """Name all outputs that can be recorded, `component.variable`."""
        return [
            f"{component.name}.{port.name}"
            for component in self.components.values()
            for port in component.fmu.ports.values()
            if port.causality == "output" and port.type == "Float64"
        ]

    def check(self) -> None:
        """Refuse an input that is neither connected nor given a start value."""
        if not self.components:
            raise AdcsError(f"system {self.name!r} has no components: add one")
        given = {c.target for c in self.connections}
        given |= {f"{c.name}.{variable}" for c in self.components.values() for variable in c.start}
        for component in self.components.values():
            for port in component.fmu.ports.values():
                name = f"{component.name}.{port.name}"
                if port.causality == "input" and name not in given:
                    raise AdcsError(f"input {name} is not connected: connect it or give it a start value")


def _any_version(fmu: str | Path) -> Path:
    try:
        return locate(fmu)
    except AdcsError as error:
        try:
            return locate(fmu, "3.0")
        except AdcsError:
            raise error from None


def _port(component: str, fmu: Fmu, variable: str) -> Port:
    if variable not in fmu.ports:
        raise AdcsError(
            f"component {component!r} ({fmu.path.name}) has no variable {variable!r}{_hint(variable, fmu.ports)}"
        )
    return fmu.ports[variable]


def _start(component: str, fmu: Fmu, variable: str, value: Value) -> tuple[Any, ...]:
    """Check a start value and return it flat."""
    port = _port(component, fmu, variable)
    name = f"{component}.{variable}"
    if not port.settable:
        raise AdcsError(f"{name} cannot be given a start value: it is a {port.variability} {port.causality}")
    if port.causality == "structuralParameter":
        raise AdcsError(f"{name} is a structural parameter: setting these is not supported")
    try:
        array = np.asarray(value)
        if array.dtype == object:
            raise ValueError
    except ValueError:
        raise AdcsError(f"{name} = {value!r}: expected {_size(port.shape)}") from None
    if array.shape != port.shape:
        raise AdcsError(f"{name}: expected {_size(port.shape)}, got {_size(array.shape)}")
    flat = array.ravel()
    if port.type.startswith("Float"):
        if array.dtype.kind not in "fiu":
            raise AdcsError(f"{name} = {value!r}: expected a number")
        if not np.isfinite(flat).all():
            raise AdcsError(f"{name} = {value!r} is not finite")
        return tuple(float(v) for v in flat)
    if port.type == "Boolean":
        if array.dtype.kind != "b":
            raise AdcsError(f"{name} = {value!r}: expected True or False")
        return tuple(bool(v) for v in flat)
    if port.type == "String":
        if array.dtype.kind != "U":
            raise AdcsError(f"{name} = {value!r}: expected a text")
        return tuple(str(v) for v in flat)
    if "Int" in port.type:
        if array.dtype.kind not in "fiu" or not np.isfinite(flat).all() or (flat != np.trunc(flat)).any():
            raise AdcsError(f"{name} = {value!r}: expected an integer")
        limits = np.iinfo(port.type.lower())
        integers = tuple(int(v) for v in flat)
        if not all(limits.min <= v <= limits.max for v in integers):
            raise AdcsError(f"{name} = {value!r} is outside the range of {port.type}")
        return integers
    raise AdcsError(f"{name} is of type {port.type}: setting these is not supported")


def _size(shape: tuple[int, ...]) -> str:
    return f"{' x '.join(map(str, shape))} values" if shape else "a single value"


def _hint(name: str, known: Iterable[str]) -> str:
    close = difflib.get_close_matches(name, list(known), 3, 0.5)
    if close:
        return f": did you mean {' or '.join(close)}?"
    names = list(known)
    return f": it has {', '.join(names[:20]) or 'none'}{', ...' if len(names) > 20 else ''}"
