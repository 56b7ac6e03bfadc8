"""Units as SSP documents and FMUs define them, and what a number in one is in another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite

from lxml import etree

from fmus.errors import AdcsError
from orchestration.fmu import Fmu
from orchestration.ssp.documents import tag
from orchestration.units import Scale

EXPONENTS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True)
class Unit:
    """A unit by name: `base = factor * value + offset`, exponents of the SI base units; `None` where not defined."""

    name: str
    base: tuple[tuple[int, ...], float, float] | None

    def same(self, other: Unit) -> bool:
        """Whether a number in one is the same number in the other."""
        if self.base is None or other.base is None:
            return self.name == other.name
        return self.base == other.base

    def to(self, other: Unit) -> Scale:
        """Return how a value in this unit becomes one in the other."""
        if self.same(other) or (self.name == other.name and None in (self.base, other.base)):
            return Scale()
        if self.base is None or other.base is None:
            unknown = self.name if self.base is None else other.name
            raise AdcsError(
                f"units differ, {self.name!r} and {other.name!r}, and {unknown!r} is not defined: define it"
            )
        (exponents, factor, offset), (exponents_there, factor_there, offset_there) = self.base, other.base
        if not (factor and factor_there and isfinite(factor * offset / factor_there)):
            raise AdcsError(f"units {self.name!r} and {other.name!r}: a factor is zero or not finite: correct it")
        if exponents != exponents_there:
            raise AdcsError(
                f"units differ, {self.name!r} and {other.name!r}, and do not measure the same: correct one of them"
            )
        return Scale(factor / factor_there, (offset - offset_there) / factor_there)


def of_fmu(fmu: Fmu, name: str | None) -> Unit | None:
    """Return the unit of this name in an FMU."""
    if not name:
        return None
    found = next((u for u in fmu.model.unitDefinitions if u.name == name), None)
    if found is None or found.baseUnit is None:
        return Unit(name, None)
    base = found.baseUnit
    exponents = tuple(int(getattr(base, e) or 0) for e in EXPONENTS)
    return Unit(name, (exponents, float(base.factor), float(base.offset)))


def of_document(root: etree._Element, prefix: str) -> dict[str, Unit]:
    """Return the units that an `.ssd` or `.ssv` document defines."""
    units: dict[str, Unit] = {}
    for element in root.iterfind(f"{tag(prefix, 'Units')}/{tag('ssc', 'Unit')}"):
        base = element.find(tag("ssc", "BaseUnit"))
        exponents = tuple(int(base.get(e, "0")) for e in EXPONENTS)
        values = (float(base.get("factor", "1")), float(base.get("offset", "0")))
        name = element.get("name")
        if name in units:
            raise AdcsError(f"unit {name!r} is defined twice: drop one of the definitions")
        units[name] = Unit(name, (exponents, *values))
    return units


def named(units: Mapping[str, Unit], name: str | None) -> Unit | None:
    """Return the unit of this name; many files leave the definition to the FMUs, which is enough if names agree."""
    return units.get(name, Unit(name, None)) if name else None
