"""What happens to a value on its way: units, linear transformations, mapping tables, one after the other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lxml import etree

from fmus.errors import AdcsError
from orchestration.fmu.units import Scale
from orchestration.ssp.documents import local_name, tag

Items = Mapping[str, int]
"""The items of an enumeration and their values."""


@dataclass(frozen=True)
class Transformation:
    """`factor * value + offset`, or a table whose missing values stay as they are."""

    factor: float = 1.0
    offset: float = 0.0
    table: tuple[tuple[float, float], ...] = ()

    @property
    def plain(self) -> bool:
        """Whether nothing changes."""
        return (self.factor, self.offset, self.table) == (1.0, 0.0, ())

    def then(self, next_: Transformation | Scale) -> Transformation:
        """Return this transformation followed by another."""
        table = next_.table if isinstance(next_, Transformation) else ()
        if (next_.factor, next_.offset, table) == (1.0, 0.0, ()):
            return self
        if self.plain:
            return Transformation(next_.factor, next_.offset, table)
        if self.table and table:
            second = dict(table)
            both = {source: second.get(target, target) for source, target in self.table}
            return Transformation(table=tuple({**second, **both}.items()))
        if self.table or table:
            raise AdcsError("a mapping table and a linear transformation or unit conversion follow each other")
        return Transformation(self.factor * next_.factor, self.offset * next_.factor + next_.offset)

    def apply(self, value: Any) -> Any:
        """Return what becomes of a value; one that stays as it is keeps its type."""
        if self.plain or isinstance(value, str | bytes):
            return value
        if self.table:
            found = dict(self.table).get(float(value), value)
            return type(value)(found)
        return self.factor * value + self.offset


def transformation_in(
    element: etree._Element, source_items: Items | None, target_items: Items | None
) -> Transformation | None:
    """Read the transformation that an element has; item names of enumerations become their values."""
    for child in element:
        if child.tag == tag("ssc", "LinearTransformation"):
            return Transformation(float(child.get("factor", "1")), float(child.get("offset", "0")))
        if child.tag in _TABLES:
            return Transformation(table=_table(child, source_items, target_items))
    return None


_TABLES = {tag("ssc", f"{kind}MappingTransformation") for kind in ("Boolean", "Integer", "Enumeration")}


def _table(
    element: etree._Element, source_items: Items | None, target_items: Items | None
) -> tuple[tuple[float, float], ...]:
    kind = local_name(element).removesuffix("MappingTransformation")

    def number(text: str, items: Items | None) -> float:
        if kind == "Boolean":
            return float(text.strip() in ("true", "1"))
        if kind == "Integer":
            return float(int(text))
        if items is None:
            raise AdcsError("an enumeration mapping stands where no enumeration is known")
        if text not in items:
            raise AdcsError(f"an enumeration mapping has the item {text!r}, the enumeration has {', '.join(items)}")
        return float(items[text])

    pairs = [
        (number(entry.get("source"), source_items), number(entry.get("target"), target_items))
        for entry in element.iterfind(tag("ssc", "MapEntry"))
    ]
    if len(dict(pairs)) < len(pairs):
        raise AdcsError("a mapping has two entries for one source value")
    return tuple(pairs)
