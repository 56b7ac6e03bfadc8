"""The units and enumerations that documents refer to, and therefore have to define."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from lxml import etree

from orchestration.fmu.file import Fmu, Port
from orchestration.fmu.units import EXPONENTS, Unit, of_fmu
from orchestration.ssp.building import add


class UsedUnits:
    """Which units each document refers to; a name that two FMUs define differently is left to the FMUs."""

    def __init__(self, fmus: Iterable[Fmu]) -> None:
        self._known: dict[str, Unit] = {}
        self._ambiguous: set[str] = set()
        self._used: dict[str, set[str]] = {"ssd": set(), "ssv": set()}
        for fmu in fmus:
            for definition in fmu.model.unitDefinitions:
                unit = of_fmu(fmu, definition.name)
                if unit is None or unit.base is None:
                    continue
                if self._known.setdefault(unit.name, unit) != unit:
                    self._ambiguous.add(unit.name)

    def use(self, fmu: Fmu, port: Port, document: str) -> str | None:
        """Return the name of a variable's unit, which the document then defines, or None to say nothing of it."""
        unit = of_fmu(fmu, port.unit)
        if unit is None or unit.base is None or unit.name in self._ambiguous:
            return None
        self._used[document].add(unit.name)
        return unit.name

    def reset(self, document: str) -> None:
        """Begin a new document."""
        self._used[document] = set()

    def add_to(self, root: etree._Element, document: str) -> None:
        """Add the definitions of the units used."""
        if not self._used[document]:
            return
        units = add(root, document, "Units")
        for name in sorted(self._used[document]):
            base = self._known[name].base
            assert base is not None
            exponents, factor, offset = base
            values: dict[str, Any] = {e: n for e, n in zip(EXPONENTS, exponents, strict=True) if n}
            values |= {"factor": factor} if factor != 1 else {}
            values |= {"offset": offset} if offset != 0 else {}
            add(add(units, "ssc", "Unit", name=name), "ssc", "BaseUnit", **values)


class UsedEnumerations:
    """The enumerations that a document refers to, by names of its own where two FMUs use one name for two."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[tuple[str, int], ...]] = {}

    def use(self, fmu: Fmu, port: Port) -> str:
        """Return the name under which the document defines a variable's enumeration."""
        types = (v.declaredType for v in fmu.model.modelVariables if v.name in (port.name, port.elements[0]))
        base = next((t.name for t in types if t is not None), port.name)
        name, number = base, 1
        while self._known.setdefault(name, port.items) != port.items:
            number += 1
            name = f"{base}_{number}"
        return name

    def add_to(self, root: etree._Element, prefix: str) -> None:
        """Add the definitions."""
        if not self._known:
            return
        enumerations = add(root, prefix, "Enumerations")
        for name, items in self._known.items():
            enumeration = add(enumerations, "ssc", "Enumeration", name=name)
            for item, value in items:
                add(enumeration, "ssc", "Item", name=item, value=value)
