"""Parameter bindings: which value each variable of each component, and each connector of a system, is given."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import prod
from typing import Any

import numpy as np
from lxml import etree

from fmus.errors import AdcsError
from orchestration.fmu.file import Port
from orchestration.fmu.units import Unit
from orchestration.ssp.archive import Home
from orchestration.ssp.documents import check, local_name, tag
from orchestration.ssp.parts import FLOAT_TYPES, INTEGER_TYPES, Part, Place, items_of
from orchestration.ssp.schemas import ROOTS, Kind
from orchestration.ssp.structure import Binding, ComponentElement, Element, SystemElement, enumerations_in
from orchestration.ssp.transformation import Items, Transformation, transformation_in
from orchestration.ssp.units import named, of_document, scale
from orchestration.ssp.wording import has, hint, sizes
from orchestration.system import checked_value

_SET = "application/x-ssp-parameter-set"
_MAPPING = "application/x-ssp-parameter-mapping"


@dataclass(frozen=True)
class Parameter:
    """A named value or array of values (row-major); `type` is the SSP name. An Enumeration's values are item names."""

    name: str
    type: str
    values: tuple[Any, ...]
    shape: tuple[int, ...]
    unit: Unit | None
    items: Items | None
    where: str  # file or binding, for messages
    transformation: etree._Element | None = None
    suppress: bool = False


@dataclass
class Values:
    """What the bindings of all levels give: values of components' variables and of systems' connectors."""

    given: dict[Place, Any] = field(default_factory=dict)
    units: dict[Place, Unit | None] = field(default_factory=dict)
    """Units of the values of systems' connectors that have none of their own."""


class Bindings:
    """Reads the bindings of all elements, the higher levels after the lower ones, over which they take precedence."""

    def __init__(
        self,
        parts: Mapping[tuple[str, ...], Part],
        shapes: Mapping[Any, tuple[int, ...]],
        relative: Collection[Place] = (),
        *,
        structural: bool = False,
    ) -> None:
        """`relative` are the places of systems' connectors that take differences.

        With `structural` only values of structural parameters are looked at.
        """
        self.parts = parts
        self.shapes = shapes
        self.relative = relative
        self.structural = structural
        self.values = Values()
        self._by: dict[Place, str] = {}
        """Which parameter of the binding at hand has given the value of a place."""
        self._applied: dict[tuple[str, str], bool] = {}
        self._messages: dict[tuple[str, str], str] = {}

    def read(self, root: SystemElement, *, refuse_unknown: bool) -> Values:
        """Return the values; a parameter that no binding of its parameter set has a use for is refused."""
        self._visit(root)
        for key, applied in self._applied.items():
            if refuse_unknown and not applied:
                raise AdcsError(self._messages[key])
        return self.values

    def _visit(self, element: Element) -> None:
        if isinstance(element, SystemElement):
            for child in element.elements.values():
                self._visit(child)
        for number, binding in enumerate(element.bindings, 1):
            self._by = {}
            for parameter in self._parameters(element, binding, number):
                self._apply(element, parameter)

    def _parameters(self, element: Element, bound: Binding, number: int) -> list[Parameter]:
        owner, binding = element.name or "the root system", bound.xml
        where = f"parameter binding {number} of {owner}"
        root, where = _content(bound.home, binding, "ParameterValues", _SET, "ssv", where)
        prefix = binding.get("prefix", "")
        units, enumerations = of_document(root, "ssv"), enumerations_in(root, "ssv")
        if not binding.get("source"):  # what is inside of the structure knows what the structure defines
            units, enumerations = {**bound.units, **units}, {**bound.enumerations, **enumerations}
        parameters: dict[str, Parameter] = {}
        for child in root.iterfind(f"{tag('ssv', 'Parameters')}/{tag('ssv', 'Parameter')}"):
            name = f"{prefix}{child.get('name')}"
            if name in parameters:
                raise AdcsError(f"{where} has two parameters {name!r}: drop one of them")
            parameters[name] = _parameter(child, name, units, enumerations, where)
        mapping = binding.find(tag("ssd", "ParameterMapping"))
        if mapping is None:
            return list(parameters.values())
        root, mapped_in = _content(bound.home, mapping, None, _MAPPING, "ssm", f"the parameter mapping of {where}")
        return list(_mapped(root, parameters, mapped_in))

    def _apply(self, element: Element, parameter: Parameter) -> None:
        key = (parameter.where, parameter.name)
        self._applied.setdefault(key, False)
        owner = element.name or "the system"
        self._messages[key] = (
            f"{parameter.where}: {owner} has no variable for the parameter {parameter.name!r}"
            f"{hint(parameter.name, self._names(element))}: correct the name or take it out"
        )
        for target in self._targets(element, parameter.name):
            self._applied[key] = True
            if isinstance(target, _Variable):
                self._give(target, parameter)
            else:
                self._give_connector(*target, parameter)

    def _targets(self, element: Element, name: str) -> Iterator[_Variable | tuple[SystemElement, str]]:
        """Find the variables and connectors that a hierarchical name means; names may contain dots themselves."""
        if isinstance(element, ComponentElement):
            part = self.parts[element.path]
            if name in part.variables:
                yield _Variable(part, name, *part.variables[name])
        elif isinstance(element, SystemElement):
            if name in element.connectors:
                yield element, name
            for child in element.elements.values():
                prefix = f"{child.path[-1]}."
                if name.startswith(prefix):
                    yield from self._targets(child, name.removeprefix(prefix))

    def _names(self, element: Element) -> list[str]:
        if isinstance(element, ComponentElement):
            return list(self.parts[element.path].variables)
        assert isinstance(element, SystemElement)
        names = list(element.connectors)
        for child in element.elements.values():
            names += [f"{child.path[-1]}.{name}" for name in self._names(child)]
        return names

    def _give(self, target: _Variable, parameter: Parameter) -> None:
        part, port = target.part, target.port
        if self.structural and port.causality != "structuralParameter":
            return
        label = f"{parameter.where}: parameter {parameter.name!r}"
        if port.name in part.clocks:
            if any(parameter.values):
                raise AdcsError(
                    f"{label}: {target} is a clock, which has no value: connect it, or take the parameter out"
                )
            return  # that it does not tick
        places = [Place(part.element.path, port.name, i) for i in target.elements]
        unit = part.unit(Place(part.element.path, port.name, target.elements[0] if target.elements else 0))
        transformation = _transformation(parameter, unit, items_of(port), label)
        values = [transformation.apply(_item(v, parameter, items_of(port), label)) for v in parameter.values]
        shape = part.shape(target.name)
        try:
            flat = checked_value(str(target), replace(port, shape=shape), nested(values, parameter.shape))
        except AdcsError as error:
            raise AdcsError(f"{label}: {error}{_way_out(parameter.shape, shape)}") from None
        for place, value in zip(places, flat, strict=True):
            other = self._by.setdefault(place, parameter.name)
            if other != parameter.name and self.values.given[place] != value:
                raise AdcsError(
                    f"{label}: {target} is another name of what {other!r} gives a different value: leave one of them "
                    "out"
                )
            self.values.given[place] = value

    def _give_connector(self, system: SystemElement, name: str, parameter: Parameter) -> None:
        label = f"{parameter.where}: parameter {parameter.name!r}"
        connector = system.connectors[name]
        if self.structural and connector.kind != "structuralParameter":
            return
        shape = self.shapes.get((system.path, name), parameter.shape)  # of one left open, which nothing is connected to
        if shape != parameter.shape:
            raise AdcsError(
                f"{label}: connector {name} {has(shape)}, the value {has(parameter.shape)}"
                f"{_way_out(parameter.shape, shape)}"
            )
        unit, given = connector.unit, parameter.unit
        if Place(system.path, name, 0) in self.relative:
            unit, given = unit and unit.of_difference(), given and given.of_difference()
        transformation = _transformation(parameter, unit, connector.items, label)
        for index, value in enumerate(parameter.values):
            place = Place(system.path, name, index)
            number = _item(value, parameter, connector.items, label)
            self.values.given[place] = transformation.apply(number)
            self.values.units[place] = None if parameter.suppress else given


def _content(
    home: Home, binding: etree._Element, inline: str | None, kind: str, schema: Kind, where: str
) -> tuple[etree._Element, str]:
    """Return the document that a binding or mapping holds or names, and how to call it."""
    if binding.get("type", kind) != kind:
        raise AdcsError(f"{where} has the type {binding.get('type')!r}, which is not supported: only {kind!r} is")
    if binding.get("sourceBase", "SSD") != "SSD":
        raise AdcsError(f"{where} is inside its component, which is not supported: put the file into the .ssp")
    source = binding.get("source")
    if source:
        member = home.locate(source, f"the file of {where}")
        return home.archive.document(member, schema), member
    holder = binding if inline is None else binding.find(tag("ssd", inline))
    content = [] if holder is None else [child for child in holder if isinstance(child.tag, str)]
    if len(content) != 1:
        raise AdcsError(f"{where} has neither a source nor one {ROOTS[schema]} inside: give it one")
    check(content[0], where, schema)
    return content[0], where


@dataclass(frozen=True)
class _Variable:
    part: Part
    name: str  # one of its names in the FMU: of an element in FMI 2
    port: Port
    elements: tuple[int, ...]

    def __str__(self) -> str:
        return f"{self.part.element.name}.{self.name}"


def fitting(value: Any, port: Port, label: str) -> Any:
    """Return the value of one element as the type of its variable has it; AdcsError if it has none such."""
    return checked_value(label, replace(port, shape=()), value)[0]


def nested(values: Sequence[Any], shape: tuple[int, ...]) -> Any:
    """Return flat values (row-major) as the lists of lists that Python has for an array, a scalar as itself."""
    if not shape:
        return values[0]
    if not values:
        return np.empty(shape)  # of which lists would lose the size of all but the first dimension
    array = np.empty(len(values), dtype=object)
    array[:] = values
    return array.reshape(shape).tolist()


def _way_out(given: tuple[int, ...], wanted: tuple[int, ...]) -> str:
    """Say what to do about a value of the wrong shape; nothing if it is not wrong."""
    if given == wanted:
        return ""
    if not given:
        return ", as it has no Dimension: give it those of the variable"
    return ", as its Dimensions say: correct them" if wanted else ", as its Dimensions say: leave them out"


def _parameter(
    xml: etree._Element, name: str, units: Mapping[str, Unit], enumerations: Mapping[str, Items], where: str
) -> Parameter:
    child = next(c for c in xml if isinstance(c.tag, str))
    kind = local_name(child)
    texts = [value.get("value") for value in child.iterfind("{*}Value")]
    whole = child.get("value")
    label = f"{where}: parameter {name!r}"
    if whole is not None and texts:
        raise AdcsError(f"{label} has its value twice, as attribute and as elements: drop one")
    unit = named(units, child.get("unit"))
    items = None
    if kind == "Enumeration":
        items = enumerations.get(child.get("name", ""))
    values: tuple[Any, ...]
    if kind in FLOAT_TYPES:
        values = tuple(float(word) for word in whole.split())
    elif kind in INTEGER_TYPES:
        values = tuple(int(word) for word in whole.split())
    elif kind == "Boolean":
        values = tuple(word in ("true", "1") for word in whole.split())
    else:
        values = tuple(texts) if whole is None else (whole,)
        if kind == "Binary":
            values = tuple(bytes.fromhex(value) for value in values)
    shape = _shape(xml, label)
    if len(values) != prod(shape):
        what = f"its Dimensions say {sizes(shape)}" if shape else "without a Dimension it has a single one"
        raise AdcsError(f"{label} has {len(values)} values, {what}: correct them")
    return Parameter(name, kind, values, shape, unit, items, where)


def _shape(xml: etree._Element, label: str) -> tuple[int, ...]:
    """Return the dimensions of a value, which have to be numbers; a value without any is a scalar."""
    shape = []
    for dimension in xml.iterfind(tag("ssc", "Dimension")):
        if dimension.get("sizeConnector") is not None or dimension.get("size") is None:
            raise AdcsError(f"{label} has a Dimension without size or with a sizeConnector: give it a size alone")
        shape.append(int(dimension.get("size")))
    return tuple(shape)


def _mapped(root: etree._Element, parameters: Mapping[str, Parameter], where: str) -> Iterator[Parameter]:
    targets: set[str] = set()
    for entry in root.iterfind(tag("ssm", "MappingEntry")):
        source, target = entry.get("source"), entry.get("target")
        if source not in parameters:
            raise AdcsError(f"{where} maps the parameter {source!r}, which is not there{hint(source, parameters)}")
        if target in targets:
            raise AdcsError(f"{where} maps two parameters to {target!r}: drop one of them")
        targets.add(target)
        suppress = entry.get("suppressUnitConversion", "false").strip() in ("true", "1")
        yield replace(parameters[source], name=target, where=where, transformation=entry, suppress=suppress)


def _transformation(parameter: Parameter, unit: Unit | None, items: Items | None, label: str) -> Transformation:
    """Return conversion of units and what the mapping adds to it."""
    try:
        found = Transformation()
        if parameter.unit is not None and unit is not None and not parameter.suppress:
            given = parameter.unit.of_difference() if unit.relative else parameter.unit
            found = found.then(scale(given, unit))
        if parameter.transformation is not None:
            own = transformation_in(parameter.transformation, parameter.items or items, items)
            if own is not None:
                found = found.then(own)
    except AdcsError as error:
        raise AdcsError(f"{label}: {error}") from None
    return found


def _item(value: Any, parameter: Parameter, items: Items | None, label: str) -> Any:
    """Return the value of an enumeration's item, by the variable's own enumeration if the parameter names none."""
    if parameter.type != "Enumeration":
        return value
    # with a table the item is one of the parameter's enumeration, else the variable's own numbers count
    known = (parameter.items or items) if parameter.transformation is not None else (items or parameter.items)
    if known is None:
        raise AdcsError(
            f"{label} is an item of an enumeration, {value!r}, and goes to something else: correct the type"
        )
    if value not in known:
        raise AdcsError(f"{label} is the item {value!r}, the enumeration has {', '.join(known)}")
    return known[value]
