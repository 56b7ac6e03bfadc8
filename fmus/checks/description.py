"""modelDescription.xml and its companions: the validator of fmpy, and what that misses."""

from __future__ import annotations

import copy
import math
import re
import struct
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from lxml import etree

from fmus.archive import LARGEST_XML, Archive
from fmus.checks import Note
from fmus.errors import AdcsError
from fmus.paths import FMPY
from fmus.xml import parse

if TYPE_CHECKING:
    from fmpy.model_description import ModelDescription, ModelVariable, Unknown

_SCHEMAS = FMPY / "schema"
_COMPANIONS = {
    "terminalsAndIcons/terminalsAndIcons.xml": "fmi3TerminalsAndIcons.xsd",
    "sources/buildDescription.xml": "fmi3BuildDescription.xsd",
}
_PLAIN = r"[A-Za-z_]\w*(?:\[[0-9]+(?:,[0-9]+)*\])?"
_PLAIN_NAME = re.compile(rf"{_PLAIN}(?:\.{_PLAIN})*", re.ASCII)
"""A structured name without quotes, and no derivative: nearly all are such."""


def check_schema(root: Any) -> Iterator[str]:
    """The XML schema of the description's version of FMI."""
    major = root.get("fmiVersion", "")[:1]
    file = _SCHEMAS / f"fmi{major}" / f"fmi{'' if major == '1' else major}ModelDescription.xsd"
    if not file.is_file():  # which `check_version` tells
        return
    schema = etree.XMLSchema(file=str(file))
    if not schema.validate(root):
        for error in schema.error_log:
            yield f"{error.level_name} (line {error.line}, column {error.column}): {error.message}"  # as fmpy has it


def check_standard(model: ModelDescription) -> Iterator[str]:
    """The rules that fmpy knows."""
    from fmpy import validation
    from fmpy.model_description import Unknown

    expected = [v for v in model.modelVariables if v.alias is not None and not v.clocks and v.causality != "local"]
    named = [Unknown(variable=v) for u in model.initialUnknowns for v in expected if v.alias is u.variable]
    # fmpy asks for each alias of an initial unknown, where FMI 3 has one entry for a value reference
    whole = copy.copy(model)
    whole.initialUnknowns = [*model.initialUnknowns, *named]
    names = copy.copy(model)
    if model.variableNamingConvention == "structured":  # whose parser takes milliseconds for a name
        names.modelVariables = [v for v in model.modelVariables if not _PLAIN_NAME.fullmatch(v.name)]
    check_names = getattr(validation, "_validate_variable_names")  # noqa: B009 - it has no face of its own
    yield from map(str, check_names(names))
    yield from map(str, validation.validate_model_description(whole, False, True))


def check_companions(archive: Archive, model: ModelDescription) -> Iterator[str]:
    """The other XML files: their schema, and names that the model has."""
    known = {v.name for v in model.modelVariables}
    identifiers = {i.modelIdentifier for i in (model.modelExchange, model.coSimulation, model.scheduledExecution) if i}
    for name, schema_name in _COMPANIONS.items():
        if name in archive.names:
            try:
                document = parse(archive.read(name, LARGEST_XML), name)
            except AdcsError as error:
                yield str(error)
                continue
            schema = etree.XMLSchema(file=str(_SCHEMAS / "fmi3" / schema_name))
            if not schema.validate(document):
                yield from (f"{name}, line {error.line}: {error.message}" for error in schema.error_log)
            for member in document.iter("TerminalMemberVariable"):
                if member.get("variableName") not in known:
                    yield f"{name}, line {member.sourceline}: {member.get('variableName')} is no variable"
            for member in document.iter("TerminalStreamMemberVariable"):
                for attribute in ("inStreamVariableName", "outStreamVariableName"):
                    if member.get(attribute) not in known:
                        yield f"{name}, line {member.sourceline}: {attribute} {member.get(attribute)} is no variable"
            for configuration in document.iter("BuildConfiguration"):
                if (given := configuration.get("modelIdentifier")) is not None and given not in identifiers:
                    expected = " or ".join(sorted(identifiers))
                    yield f"{name}, line {configuration.sourceline}: modelIdentifier {given}, expected {expected}"
            versions = [version.split(".")[:2] for version in (document.get("fmiVersion", ""), model.fmiVersion)]
            if versions[0] != versions[1] and model.fmiVersion.startswith("3."):
                yield Note(f"{name}: fmiVersion {document.get('fmiVersion')}, that of the model is {model.fmiVersion}")


def check_dimensions(root: Any) -> Iterator[str]:
    """Sizes of arrays in FMI 3: scalar structural parameters or constants, of type UInt64."""
    known = {element.get("valueReference"): element for element in root.iterfind("ModelVariables/*")}
    for element in known.values():
        for dimension in element.findall("Dimension"):
            if dimension.get("start") is not None and dimension.get("valueReference") is not None:
                yield f"{element.get('name')}: a Dimension has both start and valueReference, expected one of them"
            size = known.get(dimension.get("valueReference"))
            if size is None:
                continue
            causality, variability = size.get("causality", "local"), size.get("variability", "")
            of = f"{element.get('name')}: its size {size.get('name')}"
            if size.tag != "UInt64":
                yield f"{of} is of type {size.tag}, expected UInt64"
            if causality != "structuralParameter" and variability != "constant":
                what = f"{variability} {causality}".strip()
                yield f"{of} is a {what}, expected a structural parameter or a constant"
            if size.find("Dimension") is not None:
                yield f"{of} is an array, expected a scalar"


def check_variables(model: ModelDescription, root: Any) -> Iterator[str]:
    """Derivatives, starts, bounds, units. `root` is the XML, for what fmpy does not read of it."""
    elsewhere = {start.getparent().get("name") for start in root.iterfind("ModelVariables/*/Start")}  # texts, bytes
    units = {unit.name: {display.name for display in unit.displayUnits} for unit in model.unitDefinitions}
    for v in model.modelVariables:
        unit = v.unit or (v.declaredType.unit if v.declaredType else None)
        if unit is not None and unit not in units:
            yield f"{v.name}: unit {unit} is not defined"
        elif v.displayUnit is not None and v.displayUnit not in units.get(unit, ()):
            yield f"{v.name}: display unit {v.displayUnit} is not defined for {unit}"
        if v.derivative is not None:
            yield from _check_derivative(v, v.derivative)
        if v.type == "Clock" or v.name in elsewhere or v.alias is not None:  # a clock has no value
            continue
        if v.start is None:
            if v.causality in ("input", "parameter") or v.initial in ("exact", "approx"):
                yield f"{v.name}: start is missing, expected {_shape(v)}"
        elif v.type not in ("String", "Binary"):
            yield from _check_start(v)
    states = [u.variable.derivative for u in model.derivatives if u.variable.derivative is not None]
    for state in {s.name for s in states if states.count(s) > 1}:
        yield f"{state}: several variables in the model structure are its derivative"


def check_dependencies(model: ModelDescription) -> Iterator[str]:
    """Unknowns depend on knowns: time, inputs and states; before the run also on what has a given start value.

    Parameters and constants are known at any time; they say nothing in a list of dependencies, and do no harm.
    """
    states = {u.variable.derivative.name for u in model.derivatives if u.variable.derivative is not None}

    def is_known(v: ModelVariable) -> bool:
        always = v.variability == "constant" or v.causality in ("parameter", "structuralParameter")
        return always or v.causality in ("input", "independent") or v.name in states

    def is_known_at_start(v: ModelVariable) -> bool:
        return v.causality in ("input", "independent") or v.initial == "exact"

    groups: list[tuple[list[Unknown], Callable[[ModelVariable], bool], str]] = [
        (model.outputs, is_known, "during the run"),
        (model.derivatives, is_known, "during the run"),
        (model.initialUnknowns, is_known_at_start, "at the start"),
    ]
    for unknowns, allowed, when in groups:
        for unknown in unknowns:
            for known in unknown.dependencies or []:
                if not allowed(known):
                    yield (
                        f"{unknown.variable.name}: depends {when} on {known.name}, "
                        f"a {known.causality} with initial {known.initial}, which is not known then"
                    )


def _check_derivative(v: ModelVariable, state: ModelVariable) -> Iterator[str]:
    if state is v or state.causality not in ("output", "local") or state.variability != "continuous":
        yield (
            f"{v.name}: is said to be the derivative of {state.name}, "
            f"which is a {state.variability} {state.causality} and no continuous state"
        )
    elif tuple(v.shape) != tuple(state.shape):
        yield f"{v.name}: is said to be the derivative of {state.name}, which has {_shape(state)}, not {_shape(v)}"


def _check_start(v: ModelVariable) -> Iterator[str]:
    low, high = v.min, v.max
    size = math.prod(v.shape)
    values = str(v.start).split()
    if len(values) not in (size, 1):  # one value may stand for all elements
        yield f"{v.name}: start has {len(values)} values, expected {_shape(v)}"
    if v.type == "Boolean":
        return
    for text in values:
        try:
            value = float(text)
        except ValueError:
            yield f"{v.name}: start {text} is not a number"
            continue
        if not math.isfinite(value):
            yield f"{v.name}: start {value} is not finite"
        elif v.type == "Float32" and math.isinf(struct.unpack("f", struct.pack("f", value))[0]):
            yield f"{v.name}: start {text} is outside the range of Float32"
        elif low is not None and value < float(low):
            yield f"{v.name}: start {value:g} is below min {low}"
        elif high is not None and value > float(high):
            yield f"{v.name}: start {value:g} is above max {high}"


def _shape(v: ModelVariable) -> str:
    return f"{' x '.join(map(str, v.shape))} values" if v.shape else "1 value"
