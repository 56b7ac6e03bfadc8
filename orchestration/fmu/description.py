"""What fmpy leaves out of a modelDescription.xml: clocks, start values of text and binary arrays, differences."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from fmus.declared_types import carrier
from fmus.versions import major_version

TIME_BASED = ("constant", "fixed", "tunable", "changing", "countdown")
PERIODIC = ("constant", "fixed", "tunable")


@dataclass(frozen=True)
class Clock:
    """A clock of an FMU.

    `kind` is its intervalVariability; `interval` and `shift` (s) are exact where the file gives them as fractions,
    None where the FMU has to be asked. `fractional` says that the FMU can be asked for fractions.
    """

    name: str
    reference: int
    causality: str
    kind: str
    interval: Fraction | float | None
    shift: Fraction | float
    fractional: bool

    @property
    def time_based(self) -> bool:
        """Whether the importer ticks it at times that it knows beforehand."""
        return self.causality == "input" and self.kind in TIME_BASED


@dataclass(frozen=True)
class DisplayUnit:
    """A unit that values may be given in: shown = factor * value + offset, or factor / value if it is `inverse`."""

    name: str
    factor: float = 1.0
    offset: float = 0.0
    inverse: bool = False

    @property
    def plain(self) -> bool:
        """Whether a number in it is the same number in the unit itself."""
        return (self.factor, self.offset, self.inverse) == (1.0, 0.0, False)

    @property
    def sound(self) -> bool:
        """Whether a value given in it is one."""
        return self.factor != 0 and math.isfinite(self.factor) and math.isfinite(self.offset)


@dataclass(frozen=True)
class Extras:
    """What there is to know beside what fmpy knows, declared types counted in (`give_defaults`).

    `starts`: the texts of String and Binary variables by name; `clocked`: the clocks of variables, by reference;
    `relative`: the names of variables that are differences (relativeQuantity).
    """

    clocks: tuple[Clock, ...] = ()
    clocked: Mapping[int, frozenset[int]] = field(default_factory=dict)
    starts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    relative: frozenset[str] = frozenset()
    largest: Mapping[str, int] = field(default_factory=dict)
    """How many bytes a value of a Binary variable may have (maxSize)."""
    set_once: frozenset[str] = frozenset()
    """The inputs that may be set only once at an instant (canHandleMultipleSetPerTimeInstant)."""


def check_structure(root: Any) -> None:
    """Refuse by name (ValueError) a model structure that speaks of variables that are not there, or are no derivatives.

    What the schema sees, which is applied later, is not looked at here.
    """
    third = major_version(root.get("fmiVersion")) == 3
    variables = [element for element in root.iterfind("ModelVariables/*") if isinstance(element.tag, str)]
    known = (
        {e.get("valueReference"): e for e in variables} if third else {str(i): e for i, e in enumerate(variables, 1)}
    )
    what = "value reference" if third else "index"
    for unknown in root.iterfind("ModelStructure/*" if third else "ModelStructure/*/Unknown"):
        if not isinstance(unknown.tag, str):
            continue
        own = unknown.get("valueReference" if third else "index", "").strip()
        for number in (own, *unknown.get("dependencies", "").split()):
            if number.isdecimal() and str(int(number)) not in known:
                raise ValueError(f"ModelStructure, line {unknown.sourceline}: no variable has the {what} {number}")
        derivative = unknown.tag == "ContinuousStateDerivative" or unknown.getparent().tag == "Derivatives"
        if derivative and own in known and not any(e.get("derivative") for e in known[own].iter()):
            name = known[own].get("name")
            raise ValueError(
                f"ModelStructure, line {unknown.sourceline}: {name} is said to be a derivative, but of none"
            )


def read_extras(root: Any) -> Extras:
    """Find them in a description that is known to be valid."""
    if major_version(root.get("fmiVersion")) == 2:
        return Extras(relative=_saying(root, "relativeQuantity"), set_once=_set_once(root))
    variables = [element for element in root.find("ModelVariables") if isinstance(element.tag, str)]
    clocked = {}
    starts = {}
    for element in variables:
        if element.get("clocks"):
            clocked[int(element.get("valueReference"))] = frozenset(int(r) for r in element.get("clocks").split())
        texts = tuple(start.get("value", "") for start in element.findall("Start"))
        if texts:
            starts.update(dict.fromkeys(_names(element), texts))
    largest = {
        name: int(element.get("maxSize")) for element in variables if element.get("maxSize") for name in _names(element)
    }
    return Extras(
        tuple(_clock(e) for e in variables if e.tag == "Clock"),
        clocked,
        starts,
        _saying(root, "relativeQuantity"),
        largest,
        _set_once(root),
    )


def _names(element: Any) -> list[str]:
    """Return the name of a variable and its aliases."""
    return [element.get("name"), *(alias.get("name") for alias in element.findall("Alias"))]


def _saying(root: Any, attribute: str, words: tuple[str, ...] = ("true", "1")) -> frozenset[str]:
    """Find the variables that have a Boolean attribute, of themselves or of their kind, at a value."""
    return frozenset(
        name
        for element in root.find("ModelVariables")
        if isinstance(element.tag, str) and (element.get(attribute) or carrier(element).get(attribute)) in words
        for name in _names(element)
    )


def _set_once(root: Any) -> frozenset[str]:
    return _saying(root, "canHandleMultipleSetPerTimeInstant", ("false", "0"))


def display_units(root: Any) -> dict[str, tuple[DisplayUnit, ...]]:
    """Return the display units of each unit; ValueError for one that is inverse and has an offset."""
    found = {}
    for unit in root.iterfind("UnitDefinitions/Unit"):
        displays = []
        for element in unit.iterfind("DisplayUnit"):
            factor, offset = float(element.get("factor", "1")), float(element.get("offset", "0"))
            display = DisplayUnit(element.get("name"), factor, offset, element.get("inverse") in ("true", "1"))
            if display.inverse and offset:
                raise ValueError(
                    f"line {element.sourceline}: the display unit {display.name!r} of {unit.get('name')!r} is inverse "
                    f"and has the offset {offset:g}: expected none"
                )
            displays.append(display)
        found[unit.get("name")] = tuple(displays)
    return found


def directional_derivatives(root: Any) -> frozenset[str]:
    """Return the kinds of interface that offer them; of FMI 3.0, fmpy does not read this."""
    name = "providesDirectionalDerivative" + ("s" if major_version(root.get("fmiVersion")) == 3 else "")
    elements = {"model-exchange": "ModelExchange", "co-simulation": "CoSimulation"}
    return frozenset(k for k, e in elements.items() if (x := root.find(e)) is not None and x.get(name) in ("true", "1"))


def _clock(element: Any) -> Clock:
    interval: Fraction | float | None = None
    shift: Fraction | float = float(element.get("shiftDecimal", "0"))
    resolution = element.get("resolution")
    if resolution is not None and int(resolution) == 0:
        raise ValueError(f"clock {element.get('name')} has the resolution 0: expected a whole number from 1")
    if resolution is not None and element.get("intervalCounter") is not None:
        interval = Fraction(int(element.get("intervalCounter")), int(resolution))
        shift = Fraction(int(element.get("shiftCounter", "0")), int(resolution))
    elif element.get("intervalDecimal") is not None:
        interval = float(element.get("intervalDecimal"))
    return Clock(
        name=element.get("name"),
        reference=int(element.get("valueReference")),
        causality=element.get("causality", "local"),
        kind=element.get("intervalVariability"),
        interval=interval,
        shift=shift,
        fractional=element.get("supportsFraction") in ("true", "1"),
    )
