"""Units of FMUs: what a number in one unit is in another, from the unit definitions that files bring."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite

from fmus.errors import AdcsError
from orchestration.fmu.file import Fmu

EXPONENTS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True)
class Scale:
    """`there = factor * here + offset`."""

    factor: float = 1.0
    offset: float = 0.0

    @property
    def plain(self) -> bool:
        """Whether nothing changes."""
        return (self.factor, self.offset) == (1.0, 0.0)


@dataclass(frozen=True)
class Unit:
    """A unit by name: `base = factor * value + offset`, exponents of the SI base units; `None` where not defined.

    Differences (`relative`) of values in it have no offset.
    """

    name: str
    base: tuple[tuple[int, ...], float, float] | None
    relative: bool = False

    def of_difference(self) -> Unit:
        """Return the unit as differences are given in it."""
        return replace(self, relative=True)

    def same(self, other: Unit) -> bool:
        """Whether a number in one is the same number in the other."""
        if self.base is None or other.base is None:
            return self.name == other.name
        if self.name != other.name and not _scales(self.base[1]):
            return False  # equal factors of 0 say nothing
        if self.relative and other.relative:
            return self.base[:2] == other.base[:2]
        return self.base == other.base

    def to(self, other: Unit, undefined: str, different: str) -> Scale:
        """Return how a value in this unit becomes one in the other.

        AdcsError, which ends with the way out that is given, if they differ and one is not defined, or if they measure
        different things.
        """
        if self.same(other):
            return Scale()
        differ = f"units differ, {self.name!r} and {other.name!r}, and"
        if self.base is None or other.base is None:
            if self.name == other.name:
                return Scale()
            unknown = self.name if self.base is None else other.name
            raise AdcsError(f"{differ} {unknown!r} is not defined: {undefined}")
        (exponents, factor, offset), (exponents_there, factor_there, offset_there) = self.base, other.base
        both = f"units {self.name!r} and {other.name!r}"
        if not (_scales(factor) and _scales(factor_there) and _scales(factor / factor_there)):
            raise AdcsError(f"{both}: a factor is zero or not finite: correct it")
        if not isfinite((offset - offset_there) / factor_there):
            raise AdcsError(f"{both}: an offset is not finite: correct it")
        if exponents != exponents_there:
            raise AdcsError(f"{differ} do not measure the same: {different}")
        if self.relative and other.relative:
            return Scale(factor / factor_there)
        if self.relative != other.relative and (offset or offset_there):
            raise AdcsError(f"{differ} only one is of a difference (relativeQuantity): give a factor and an offset")
        return Scale(factor / factor_there, (offset - offset_there) / factor_there)


def _scales(factor: float) -> bool:
    """Whether numbers can be multiplied by it and divided again."""
    return factor != 0 and isfinite(factor)


def of_fmu(fmu: Fmu, name: str | None, relative: bool = False) -> Unit | None:
    """Return the unit of this name in an FMU, for values or for differences (`relative`) of them."""
    if not name:
        return None
    found = next((u for u in fmu.model.unitDefinitions if u.name == name), None)
    if found is None or found.baseUnit is None:
        return Unit(name, None, relative)
    base = found.baseUnit
    exponents = tuple(int(getattr(base, e) or 0) for e in EXPONENTS)
    return Unit(name, (exponents, float(base.factor), float(base.offset)), relative)


def conversion(
    source: Fmu, unit: str | None, target: Fmu, wanted: str | None, relative: tuple[bool, bool] = (False, False)
) -> Scale:
    """Return how a value in `unit` of one FMU becomes one in the unit `wanted` of another.

    `relative` says of both ends whether they are differences. An end without a unit goes with any. AdcsError if the
    units measure different things, or differ and say nothing of what they measure.
    """
    here, there = of_fmu(source, unit, relative[0]), of_fmu(target, wanted, relative[1])
    if here is None or there is None:
        return Scale()
    return here.to(there, undefined="give a factor", different="connect something else")
