"""The FMU behind a component of the structure: which variable a connector is, and whether the two agree."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from fmus.errors import AdcsError
from orchestration.fmu import Fmu, Port
from orchestration.ssp.structure import ComponentElement, Connector
from orchestration.ssp.transformation import Items
from orchestration.units import Unit, of_fmu

INTEGER_TYPES = ("Integer", *(f"{sign}Int{bits}" for bits in (8, 16, 32, 64) for sign in ("", "U")))
FLOAT_TYPES = ("Real", "Float64", "Float32")


@dataclass(frozen=True)
class Place:
    """One number: an element (flat index) of a component's variable or of a system's connector."""

    path: tuple[str, ...]
    name: str
    index: int

    def __str__(self) -> str:
        return f"{'/'.join(self.path)}.{self.name}" if self.path else self.name


@dataclass(frozen=True)
class Part:
    """A component with its FMU; `member` is the FMU's name in the archive, `path` where it lies as a file."""

    element: ComponentElement
    member: str
    path: Path
    fmu: Fmu

    @cached_property
    def variables(self) -> dict[str, tuple[Port, tuple[int, ...]]]:
        """Which elements of which port a variable of the FMU is: FMI 2 names the elements, FMI 3 the arrays."""
        found: dict[str, tuple[Port, tuple[int, ...]]] = {}
        for port in self.fmu.ports.values():
            if self.fmu.major_version == 2 and port.shape:
                found.update({name: (port, (i,)) for i, name in enumerate(port.elements)})
            else:
                found[port.name] = (port, tuple(range(port.size)))
        return found

    def unit(self, place: Place) -> Unit | None:
        """Return the unit in which the FMU takes or gives a value, else the one that a connector gives it."""
        port = self.fmu.ports[place.name]
        own = of_fmu(self.fmu, port.unit)
        connector = self.element.connectors.get(port.name) or self.element.connectors.get(port.elements[place.index])
        given = None if connector is None else connector.unit
        unit = given if own is None or (own.base is None and given is not None) else own
        return unit.of_difference() if unit is not None and port.relative else unit

    def check(self) -> None:
        """Check that each connector is a variable of the FMU, of the same kind, type, size and unit."""
        name, kind = self.element.name, self.element.implementation
        if kind != "any":
            self.fmu.interface("co-simulation" if kind == "CoSimulation" else "model-exchange")
        for connector in self.element.connectors.values():
            where = f"connector {name}.{connector.name}"
            if connector.name not in self.variables:
                raise AdcsError(
                    f"{where}: {self.member} has no such variable{hint(connector.name, self.variables)}, correct it"
                )
            port, _ = self.variables[connector.name]
            self._check_kind(connector, port, where)
            shape = port.shape if self.fmu.major_version == 3 else ()
            given = connector.dimensions
            if given and (
                len(given) != len(shape) or any(g not in (None, n) for g, n in zip(given, shape, strict=True))
            ):
                raise AdcsError(f"{where} has the dimensions {sizes(given)}, the FMU's variable {sizes(shape)}")
            unit = of_fmu(self.fmu, port.unit)
            if unit is not None and connector.unit is not None and not unit.same(connector.unit):
                if unit.name == connector.unit.name and unit.base is None:
                    continue
                what = "another definition" if unit.name == connector.unit.name else repr(unit.name)
                raise AdcsError(f"{where} has the unit {connector.unit.name!r}, the FMU's variable {what}: correct it")

    def _check_kind(self, connector: Connector, port: Port, where: str) -> None:
        causality = "constant" if connector.kind == "constant" else port.causality
        actual = "constant" if port.variability == "constant" else port.causality
        if connector.kind != "unspecified" and connector.kind not in (port.causality, actual):
            raise AdcsError(
                f"{where} is of kind {connector.kind!r}, the FMU's variable is of causality {causality!r}: correct it"
            )
        if connector.type is None:
            return
        expected: tuple[str, ...] = (port.type,)
        if port.type.startswith("Float"):
            expected = FLOAT_TYPES
        elif port.type == "Boolean":
            expected = ("Boolean", "Clock")
        elif "Int" in port.type:
            expected = (*INTEGER_TYPES, "Enumeration") if items_of(port) is not None else INTEGER_TYPES
        if connector.type not in expected:
            actual_type = "Enumeration" if items_of(port) is not None else port.type
            raise AdcsError(f"{where} is of type {connector.type}, the FMU's variable is {actual_type}: correct it")


def items_of(port: Port) -> Items | None:
    """Return the items of an enumeration, None for anything else."""
    return dict(port.items) or None


def hint(name: str, known: Iterable[str]) -> str:
    """` (did you mean x?)`, or what there is."""
    names = list(known)
    close = difflib.get_close_matches(name, names, 3, 0.5)
    if close:
        return f" (did you mean {' or '.join(close)}?)"
    return f" (there is {', '.join(names[:12]) or 'none'}{', ...' if len(names) > 12 else ''})"


def sizes(shape: Iterable[Any]) -> str:
    """`(4, 4)` -> `4 x 4`."""
    return " x ".join("?" if n is None else str(n) for n in shape) or "of a scalar"
