"""The FMU behind a component of the structure: which variable a connector is, and whether the two agree."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from fmus.errors import AdcsError
from orchestration.fmu.description import Clock
from orchestration.fmu.file import Fmu, Port
from orchestration.fmu.units import Unit, of_fmu
from orchestration.ssp.clocks import check_clock
from orchestration.ssp.structure import ComponentElement, Connector
from orchestration.ssp.transformation import Items
from orchestration.ssp.wording import has, hint, sizes

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
    """A component with its FMU; `member` is the FMU's name in the archive, `path` where it lies as a file.

    `structural` are the values of its structural parameters, as far as the document gives any; `fmu` has the sizes that
    they ask for.
    """

    element: ComponentElement
    member: str
    path: Path
    fmu: Fmu
    structural: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def variables(self) -> dict[str, tuple[Port, tuple[int, ...]]]:
        """Which elements of which port a variable of the FMU is: FMI 2 names the elements, FMI 3 the arrays.

        Of several names for what can be given a value all lead to the one under which the system keeps it.
        """
        found: dict[str, tuple[Port, tuple[int, ...]]] = {}
        for port in self.fmu.ports.values():
            each = self.fmu.major_version == 2
            for i, name in enumerate(port.elements if each else [port.name]):
                main, elements = port, [i] if each else range(port.size)
                if port.settable:
                    main, elements = self.fmu.nodes[self.fmu.nodes.place(port, i)[0]]
                found[name] = (main, tuple(elements))
        return found

    @cached_property
    def ports(self) -> list[Port]:
        """The ports, without those that are further names of others."""
        return list({port.name: port for port, _ in self.variables.values()}.values())

    @cached_property
    def clocks(self) -> dict[str, Clock]:
        """The clocks of the FMU, by the names of their ports."""
        known = {clock.reference: clock for clock in self.fmu.clocks}
        return {p.name: known[p.references[0]] for p in self.fmu.ports.values() if p.references[0] in known}

    @cached_property
    def _connectors(self) -> dict[tuple[str, int], Connector]:
        """The connector of each element of a port that has one."""
        return {
            (port.name, i): connector
            for connector in self.element.connectors.values()
            for port, elements in [self.variables[connector.name]]
            for i in elements
        }

    def shape(self, name: str) -> tuple[int, ...]:
        """Return the shape of a variable of the FMU: FMI 2 has scalars only."""
        return self.variables[name][0].shape if self.fmu.major_version == 3 else ()

    def unit(self, place: Place) -> Unit | None:
        """Return the unit in which the FMU takes or gives a value, else the one that a connector gives it."""
        port = self.fmu.ports[place.name]
        own = of_fmu(self.fmu, port.unit)
        connector = self._connectors.get((place.name, place.index))
        given = None if connector is None else connector.unit
        unit = given if own is None or (own.base is None and given is not None) else own
        return unit.of_difference() if unit is not None and port.relative else unit

    def check(self) -> None:
        """Check that each connector is a variable of the FMU, of the same kind, type and unit; not yet of its size."""
        name, kind = self.element.name, self.element.implementation
        if kind != "any":
            model = self.fmu.model
            if (model.coSimulation if kind == "CoSimulation" else model.modelExchange) is None:
                raise AdcsError(
                    f"implementation {kind!r}, which {self.member} does not have: correct it, or leave it out"
                )
        for connector in self.element.connectors.values():
            where = f"connector {name}.{connector.name}"
            if connector.name not in self.variables:
                raise AdcsError(
                    f"{where}: {self.member} has no such variable{hint(connector.name, self.variables)}, correct it"
                )
            port, _ = self.variables[connector.name]
            self._check_kind(connector, port, where)
            self._check_clocks(connector, port, where)
            unit = of_fmu(self.fmu, port.unit)
            if unit is not None and connector.unit is not None and not unit.same(connector.unit):
                if unit.name == connector.unit.name and unit.base is None:
                    continue
                what = "another definition" if unit.name == connector.unit.name else repr(unit.name)
                raise AdcsError(f"{where} has the unit {connector.unit.name!r}, the FMU's variable {what}: correct it")

    def check_sizes(self) -> None:
        """Check that each connector that has dimensions has those of the variable, as it is with these values."""
        for connector in self.element.connectors.values():
            where = f"connector {self.element.name}.{connector.name}"
            shape = self.shape(connector.name)
            given = [self._size(d, where) if isinstance(d, str) else d for d in connector.dimensions]
            if given and (
                len(given) != len(shape) or any(g not in (None, n) for g, n in zip(given, shape, strict=True))
            ):
                raise AdcsError(
                    f"{where} has the dimensions {sizes(given)}, the FMU's variable {has(shape)}: correct them"
                )

    def _size(self, name: str, where: str) -> int | None:
        """Return the size that a connector of this component holds; None if only the FMU knows it."""
        if name not in self.element.connectors:
            raise AdcsError(
                f"{where} takes its size from the connector {name!r}, which {self.element.name} does not have"
                f"{hint(name, self.element.connectors)}: correct its sizeConnector"
            )
        port, _ = self.variables[name]
        value = self.structural.get(port.name, port.start[0] if port.start is not None else None)
        if value is not None and (port.shape or "Int" not in port.type):
            raise AdcsError(f"{where} takes its size from the connector {name!r}, which is no whole number: correct it")
        return None if value is None else int(value)

    def _check_clocks(self, connector: Connector, port: Port, where: str) -> None:
        if connector.clock is not None and port.name in self.clocks:
            check_clock(connector.clock, self.clocks[port.name], where)
        belongs = self.fmu.clocked.get(port.references[0], frozenset())
        for name in connector.clocks:
            clock = self.variables.get(name)
            if clock is None or clock[0].references[0] not in belongs:
                raise AdcsError(f"{where} belongs to the clock {name!r}, the FMU's variable does not: correct it")

    def _check_kind(self, connector: Connector, port: Port, where: str) -> None:
        clock = self.clocks.get(port.name)
        own = port.causality if clock is None else clock.causality
        causality = "constant" if connector.kind == "constant" else own
        actual = "constant" if port.variability == "constant" else own
        if connector.kind != "unspecified" and connector.kind not in (own, actual):
            raise AdcsError(
                f"{where} is of kind {connector.kind!r}, the FMU's variable is of causality {causality!r}: correct it"
            )
        if connector.type is None:
            return
        expected: tuple[str, ...] = (port.type,)
        if port.type.startswith("Float"):
            expected = FLOAT_TYPES
        elif clock is not None:
            expected = ("Clock", "Boolean")  # SSP 1.0 has no clocks
        elif "Int" in port.type:
            expected = (*INTEGER_TYPES, "Enumeration") if items_of(port) is not None else INTEGER_TYPES
        if connector.type not in expected:
            actual_type = "Enumeration" if items_of(port) is not None else expected[0] if clock else port.type
            raise AdcsError(f"{where} is of type {connector.type}, the FMU's variable is {actual_type}: correct it")


def items_of(port: Port) -> Items | None:
    """Return the items of an enumeration, None for anything else."""
    return dict(port.items) or None
