"""modelDescription.xml and its companions: the validator of fmpy, and what that misses."""

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import fmpy
from fmpy.model_description import ModelDescription, ModelVariable, Unknown
from fmpy.validation import validate_fmu
from lxml import etree

from fmus.archive import LARGEST_XML, Archive
from fmus.errors import AdcsError
from fmus.xml import parse

_COMPANIONS = {
    "terminalsAndIcons/terminalsAndIcons.xml": "fmi3TerminalsAndIcons.xsd",
    "sources/buildDescription.xml": "fmi3BuildDescription.xsd",
}


def check_standard(path: Path) -> Iterator[str]:
    """The XML schema, and the rules that fmpy knows."""
    yield from map(str, validate_fmu(str(path)))


def check_companions(archive: Archive, model: ModelDescription) -> Iterator[str]:
    """The other XML files: their schema, and names that the model has."""
    schemas = Path(fmpy.__file__).parent / "schema" / "fmi3"
    for name, schema_name in _COMPANIONS.items():
        if name in archive.names:
            try:
                document = parse(archive.read(name, LARGEST_XML), name)
            except AdcsError as error:
                yield str(error)
                continue
            schema = etree.XMLSchema(file=str(schemas / schema_name))
            if not schema.validate(document):
                yield from (f"{name}, line {error.line}: {error.message}" for error in schema.error_log)
            known = {v.name for v in model.modelVariables}
            for member in document.iter("TerminalMemberVariable"):
                if member.get("variableName") not in known:
                    yield f"{name}, line {member.sourceline}: {member.get('variableName')} is no variable"


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
        if v.type == "Clock" or v.name in elsewhere:  # a clock has no value
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
        elif v.min is not None and value < float(v.min):
            yield f"{v.name}: start {value:g} is below min {v.min}"
        elif v.max is not None and value > float(v.max):
            yield f"{v.name}: start {value:g} is above max {v.max}"


def _shape(v: ModelVariable) -> str:
    return f"{' x '.join(map(str, v.shape))} values" if v.shape else "1 value"
