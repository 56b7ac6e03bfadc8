"""What fmpy leaves out of a modelDescription.xml: clocks, start values of text and binary arrays, differences."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

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
class Extras:
    """What there is to know beside what fmpy knows.

    `starts`: the texts of String and Binary variables by name; `clocked`: the clocks of variables, by reference;
    `relative`: the names of variables that are differences (relativeQuantity), by themselves or by their type.
    """

    clocks: tuple[Clock, ...] = ()
    clocked: Mapping[int, frozenset[int]] = field(default_factory=dict)
    starts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    relative: frozenset[str] = frozenset()
    limits: Mapping[str, tuple[int | None, int | None]] = field(default_factory=dict)
    """The least and the largest value of each structural parameter of an unsigned type that declares any."""


def check_structure(root: Any) -> None:
    """Refuse by name (ValueError) a model structure that speaks of variables that are not there, or are no derivatives.

    What the schema sees, which is applied later, is not looked at here.
    """
    third = root.get("fmiVersion") == "3.0"
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
    if root.get("fmiVersion") == "2.0":
        return Extras(relative=_relative(root))
    variables = [element for element in root.find("ModelVariables") if isinstance(element.tag, str)]
    clocked = {}
    starts = {}
    for element in variables:
        if element.get("clocks"):
            clocked[int(element.get("valueReference"))] = frozenset(int(r) for r in element.get("clocks").split())
        texts = tuple(start.get("value", "") for start in element.findall("Start"))
        if texts:
            names = [element.get("name"), *(alias.get("name") for alias in element.findall("Alias"))]
            starts.update(dict.fromkeys(names, texts))
    limits = {
        element.get("name"): (_number(element.get("min")), _number(element.get("max")))
        for element in variables
        if element.get("causality") == "structuralParameter" and element.tag.startswith("UInt")
    }
    clocks = tuple(_clock(e) for e in variables if e.tag == "Clock")
    return Extras(clocks, clocked, starts, _relative(root), limits)


def _number(text: str | None) -> int | None:
    return None if text is None else int(text)


def _relative(root: Any) -> frozenset[str]:
    """Find the variables that are differences; what a variable says of itself counts more than its type."""
    definitions = root.find("TypeDefinitions")
    types = {
        element.get("name"): _says_relative(element)
        for element in (() if definitions is None else definitions)
        if isinstance(element.tag, str)
    }
    found = set()
    for element in root.find("ModelVariables"):
        if isinstance(element.tag, str):
            own, declared = _says_relative(element), _carrier(element).get("declaredType")
            if types.get(declared) if own is None else own:
                found |= {element.get("name"), *(alias.get("name") for alias in element.findall("Alias"))}
    return frozenset(found)


def _carrier(element: Any) -> Any:
    """Return the element of a variable or type that has the attributes of its kind: in FMI 2 it is inside."""
    return element[0] if element.tag in ("ScalarVariable", "SimpleType") else element


def _says_relative(element: Any) -> bool | None:
    text = _carrier(element).get("relativeQuantity")
    return None if text is None else text in ("true", "1")


def directional_derivatives(root: Any) -> frozenset[str]:
    """Return the kinds of interface that offer them; of FMI 3.0, fmpy does not read this."""
    name = "providesDirectionalDerivative" + ("s" if root.get("fmiVersion") == "3.0" else "")
    elements = {"model-exchange": "ModelExchange", "co-simulation": "CoSimulation"}
    return frozenset(k for k, e in elements.items() if (x := root.find(e)) is not None and x.get(name) in ("true", "1"))


def _clock(element: Any) -> Clock:
    interval: Fraction | float | None = None
    shift: Fraction | float = float(element.get("shiftDecimal", "0"))
    resolution = element.get("resolution")
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
