"""Units of FMUs: what a number in one unit is in another, from the unit definitions that the FMUs bring."""

from __future__ import annotations

from dataclasses import dataclass

from fmus.errors import AdcsError
from orchestration.fmu import Fmu

_EXPONENTS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True)
class Scale:
    """`there = factor * here + offset`."""

    factor: float = 1.0
    offset: float = 0.0

    @property
    def plain(self) -> bool:
        """Whether nothing changes."""
        return (self.factor, self.offset) == (1.0, 0.0)


def conversion(source: Fmu, unit: str | None, target: Fmu, wanted: str | None) -> Scale:
    """Return how a value in `unit` of one FMU becomes one in the unit `wanted` of another.

    An end without a unit goes with any. AdcsError if the units measure different things, or differ and say nothing of
    what they measure.
    """
    if not unit or not wanted:
        return Scale()
    here, there = _definition(source, unit), _definition(target, wanted)
    if unit == wanted and (here is None or there is None or here == there):
        return Scale()
    if here is None or there is None:
        unknown = unit if here is None else wanted
        raise AdcsError(f"units differ, {unit!r} and {wanted!r}, and {unknown!r} is not defined: give a factor")
    if here[0] != there[0]:
        raise AdcsError(f"units differ, {unit!r} and {wanted!r}, and do not measure the same: connect something else")
    (_, factor, offset), (_, factor_there, offset_there) = here, there
    return Scale(factor / factor_there, (offset - offset_there) / factor_there)


def _definition(fmu: Fmu, name: str) -> tuple[tuple[int, ...], float, float] | None:
    """Exponents of the SI base units, factor and offset: `base = factor * value + offset`."""
    unit = next((u for u in fmu.model.unitDefinitions if u.name == name), None)
    if unit is None or unit.baseUnit is None:
        return None
    base = unit.baseUnit
    return tuple(int(getattr(base, e) or 0) for e in _EXPONENTS), float(base.factor), float(base.offset)
