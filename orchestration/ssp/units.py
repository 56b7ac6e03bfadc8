"""Units as SSP documents define them."""

from __future__ import annotations

from collections.abc import Mapping

from lxml import etree

from fmus.errors import AdcsError
from orchestration.fmu.units import EXPONENTS, Scale, Unit
from orchestration.ssp.documents import tag


def scale(unit: Unit, wanted: Unit) -> Scale:
    """Return how a value in one unit of a file becomes one in another."""
    return unit.to(wanted, undefined="define it", different="correct one of them")


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
