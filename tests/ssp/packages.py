"""Makes FMUs without binaries and `.ssp` files from text: for what is read and checked, and never run."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from xml.sax.saxutils import quoteattr

NAMESPACES = (
    'xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" '
    'xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" '
    'xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" '
    'xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping" '
    'xmlns:adcs="urn:adcs-fmus:ssp" '
    'xmlns:oms="https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd"'
)
UNITS = {"m": 'm="1"', "km": 'm="1" factor="1000"', "s": 's="1"', "rad": 'rad="1"', "rad/s": 'rad="1" s="-1"'}
UNITS |= {"deg": 'rad="1" factor="0.017453292519943295"', "K": 'K="1"', "degC": 'K="1" offset="273.15"'}
COLOURS = (("red", 1), ("green", 2), ("blue", 7))
LIGHTS = (("stop", 10), ("go", 20))


@dataclass
class Variable:
    name: str
    causality: str
    type: str = "Float64"
    shape: tuple[int | str, ...] = ()  # the name of a structural parameter where FMI 3.0 takes the size from one
    unit: str | None = None
    start: str | None = None  # one value for all elements
    items: tuple[tuple[str, int], ...] = ()
    aliases: tuple[str, ...] = ()
    interval: str | None = None  # of a clock, as it stands in the file: '"constant" intervalDecimal="0.25"'
    clock: str | None = None  # of a clocked variable


def sender() -> list[Variable]:
    return [
        Variable("y", "output", unit="m"),
        Variable("far", "output", unit="km"),
        Variable("angle", "output", unit="deg"),
        Variable("plain", "output"),
        Variable("v", "output", shape=(3,), unit="rad/s"),
        Variable("M", "output", shape=(2, 2)),
        Variable("yes", "output", "Boolean"),
        Variable("n", "output", "Int32"),
        Variable("colour", "output", "Enumeration", items=COLOURS),
        Variable("bias", "parameter", unit="m", start="0.5"),
    ]


def receiver() -> list[Variable]:
    return [
        Variable("u", "input", unit="m", start="1.25"),
        Variable("angle", "input", unit="rad", start="0"),
        Variable("plain", "input", start="0"),
        Variable("w", "input", shape=(3,), unit="rad/s", start="2"),
        Variable("M", "input", shape=(2, 2), start="0"),
        Variable("on", "input", "Boolean", start="false"),
        Variable("n", "input", "Int32", start="3"),
        Variable("light", "input", "Enumeration", items=LIGHTS, start="10"),
        Variable("shade", "input", "Enumeration", items=COLOURS, start="1"),
        Variable("z", "output", unit="m"),
        Variable("k", "parameter", start="1"),
        Variable("turn", "parameter", unit="rad", start="0"),
        Variable("temperature", "parameter", unit="K", start="300"),
        Variable("J", "parameter", shape=(2, 2), start="0"),
        Variable("seed", "parameter", "Int32", start="0"),
        Variable("fast", "parameter", "Boolean", start="false"),
        Variable("label", "parameter", "String", start=""),
        Variable("tint", "parameter", "Enumeration", items=COLOURS, start="1"),
        Variable("fixed", "constant", start="9"),
    ]


def make_fmu(path: Path, variables: list[Variable], version: str = "2.0") -> Path:
    """Write an FMU with a description and nothing else."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", (_fmi2 if version == "2.0" else _fmi3)(path.stem, variables))
    return path


def ssd(inside: str, *, version: str = "1.0", more: str = "", units: str | None = None) -> str:
    """A system structure: what is in the root system, and what stands after it in the document."""
    defined = "".join(f"<ssc:Unit name={quoteattr(n)}><ssc:BaseUnit {b}/></ssc:Unit>" for n, b in UNITS.items())
    units = f"<ssd:Units>{defined}</ssd:Units>" if units is None else units
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<ssd:SystemStructureDescription {NAMESPACES} version="{version}" '
        f'name="test"><ssd:System name="root">{inside}</ssd:System>{units}{more}</ssd:SystemStructureDescription>'
    )


def component(name: str, connectors: str = "", more: str = "", source: str | None = None) -> str:
    """`connectors` as `input u Real m; output y`: kind, name, and if wanted type, unit, dimensions.

    These are `[2,3]`, where `?` is one left open and `=n` the size that the connector n has.
    """
    source = source or f"resources/{name}.fmu"
    return f'<ssd:Component name="{name}" source="{source}">{pins(connectors)}{more}</ssd:Component>'


def system(name: str, connectors: str, inside: str, more: str = "") -> str:
    return f'<ssd:System name="{name}">{pins(connectors)}{more}{inside}</ssd:System>'


def pins(connectors: str) -> str:
    found = []
    for line in filter(None, (part.split() for part in connectors.split(";"))):
        kind, name, *type_ = line
        attribute = "name" if type_[:1] == ["Enumeration"] else "unit"
        unit = f" {attribute}={quoteattr(type_[1])}" if len(type_) > 1 and not type_[1].startswith("[") else ""
        sizes = type_[-1].strip("[]").split(",") if type_ and type_[-1].startswith("[") else []
        dimensions = "".join(map(_dimension, sizes))
        inner = f"<ssc:{type_[0]}{unit}/>{dimensions}" if type_ else ""
        found.append(f'<ssd:Connector name={quoteattr(name)} kind="{kind}">{inner}</ssd:Connector>')
    return f"<ssd:Connectors>{''.join(found)}</ssd:Connectors>" if found else ""


def _dimension(size: str) -> str:
    if size == "?":
        return "<ssc:Dimension/>"
    return f'<ssc:Dimension sizeConnector="{size[1:]}"/>' if size.startswith("=") else f'<ssc:Dimension size="{size}"/>'


def elements(*inside: str) -> str:
    return f"<ssd:Elements>{''.join(inside)}</ssd:Elements>"


def connections(*lines: str) -> str:
    """`a.y -> b.u`, an end without element is the system's; then attributes and content of the element."""
    found = []
    for line in lines:
        ends, attributes, content = [*(part.strip() for part in line.split("|")), "", ""][:3]
        words = ends.split(" -> ")
        places = [word.rpartition(".") if "." in word else ("", "", word) for word in words]
        names = [
            (f'{which}Element="{place[0]}" ' if place[0] else "") + f'{which}Connector="{place[2]}"'
            for which, place in zip(("start", "end"), places, strict=True)
        ]
        found.append(f"<ssd:Connection {' '.join(names)} {attributes}>{content}</ssd:Connection>")
    return f"<ssd:Connections>{''.join(found)}</ssd:Connections>"


def parameters(values: Mapping[str, str], units: tuple[str, ...] = (), more: str = "", version: str = "1.0") -> str:
    """A parameter set: names to `Real value="1"` and the like, or to whole elements."""
    inside = "".join(
        f'<ssv:Parameter name="{name}">{value if value.startswith("<") else f"<ssv:{value}/>"}</ssv:Parameter>'
        for name, value in values.items()
    )
    defined = "".join(f'<ssc:Unit name="{name}"><ssc:BaseUnit {UNITS[name]}/></ssc:Unit>' for name in units)
    defined = f"<ssv:Units>{defined}</ssv:Units>" if units else ""
    return (
        f'<ssv:ParameterSet {NAMESPACES} version="{version}" name="set"><ssv:Parameters>{inside}</ssv:Parameters>'
        f"{more}{defined}</ssv:ParameterSet>"
    )


def mapping(*entries: str) -> str:
    """`a -> b | attributes | content`."""
    found = []
    for line in entries:
        ends, attributes, content = [*(part.strip() for part in line.split("|")), "", ""][:3]
        source, target = ends.split(" -> ")
        found.append(f'<ssm:MappingEntry source="{source}" target="{target}" {attributes}>{content}</ssm:MappingEntry>')
    return f'<ssm:ParameterMapping {NAMESPACES} version="1.0">{"".join(found)}</ssm:ParameterMapping>'


def bindings(*inside: str) -> str:
    """Each an inline parameter set, or the attributes and content of a whole binding."""
    found = []
    for text in inside:
        if text.startswith("<ssv:"):
            text = f"><ssd:ParameterValues>{text}</ssd:ParameterValues>"
        found.append(f"<ssd:ParameterBinding {text}</ssd:ParameterBinding>")
    return f"<ssd:ParameterBindings>{''.join(found)}</ssd:ParameterBindings>"


def note(name: str, attributes: str) -> str:
    """One of our annotations."""
    return (
        f'<ssd:Annotations><ssc:Annotation type="adcs-fmus"><adcs:{name} {attributes}/></ssc:Annotation>'
        "</ssd:Annotations>"
    )


def _elements(variable: Variable) -> list[str]:
    if not variable.shape:
        return [variable.name]
    return [
        f"{variable.name}[{','.join(map(str, i))}]" for i in product(*(range(1, int(n) + 1) for n in variable.shape))
    ]


def _attributes(variable: Variable, initial_for_output: str) -> str:
    causality = "local" if variable.causality == "constant" else variable.causality
    variability = {"parameter": "fixed", "structuralParameter": "fixed", "constant": "constant"}.get(
        variable.causality, "discrete"
    )
    if variable.type in ("Float64", "Real") and variability == "discrete":
        variability = "continuous"
    initial = f' initial="{initial_for_output}"' if causality == "output" else ""
    return f'causality="{causality}" variability="{variability}"{initial}'


def _fmi2(name: str, variables: list[Variable]) -> str:
    kinds = {"Float64": "Real", "Int32": "Integer"}
    lines, outputs, number = [], [], 0
    for variable in variables:
        kind = kinds.get(variable.type, variable.type)
        type_ = f' declaredType="{variable.name}Type"' if variable.items else ""
        unit = f" unit={quoteattr(variable.unit)}" if variable.unit else ""
        start = "" if variable.start is None else f" start={quoteattr(variable.start)}"
        for element in _elements(variable):
            number += 1
            if variable.causality == "output":
                outputs.append(f'<Unknown index="{number}"/>')
            lines.append(
                f'<ScalarVariable name="{element}" valueReference="{number}" {_attributes(variable, "calculated")}>'
                f"<{kind}{type_}{unit}{start}/></ScalarVariable>"
            )
    units = "".join(f"<Unit name={quoteattr(n)}><BaseUnit {b}/></Unit>" for n, b in UNITS.items())
    types = "".join(
        f'<SimpleType name="{v.name}Type"><Enumeration>'
        + "".join(f'<Item name="{item}" value="{value}"/>' for item, value in v.items)
        + "</Enumeration></SimpleType>"
        for v in variables
        if v.items
    )
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<fmiModelDescription fmiVersion="2.0" modelName="{name}" '
        f'guid="{{x}}"><CoSimulation modelIdentifier="{name}"/><UnitDefinitions>{units}</UnitDefinitions>'
        + (f"<TypeDefinitions>{types}</TypeDefinitions>" if types else "")
        + f"<ModelVariables>{''.join(lines)}</ModelVariables><ModelStructure><Outputs>{''.join(outputs)}</Outputs>"
        f"<InitialUnknowns>{''.join(outputs)}</InitialUnknowns></ModelStructure></fmiModelDescription>"
    )


def _fmi3(name: str, variables: list[Variable]) -> str:
    lines, outputs, initial = ['<Float64 name="time" valueReference="0" causality="independent"/>'], [], []
    texts = ("String", "Binary")
    places = {variable.name: number for number, variable in enumerate(variables, 1)}
    for number, variable in enumerate(variables, 1):
        type_ = f' declaredType="{variable.name}Type"' if variable.items else ""
        unit = f" unit={quoteattr(variable.unit)}" if variable.unit else ""
        start = "" if variable.start is None or variable.type in texts else f" start={quoteattr(variable.start)}"
        clock = "" if variable.clock is None else f' clocks="{places[variable.clock]}"'
        attributes = _attributes(variable, "calculated")
        if variable.interval is not None:
            attributes = f'causality="{variable.causality}" intervalVariability={variable.interval}'
        inner = "".join(
            f'<Dimension valueReference="{places[n]}"/>' if isinstance(n, str) else f'<Dimension start="{n}"/>'
            for n in variable.shape
        )
        inner += "".join(f'<Alias name="{name}"/>' for name in variable.aliases)
        inner += f"<Start value={quoteattr(variable.start or '')}/>" if variable.type in texts else ""
        if variable.causality == "output":
            outputs.append(f'valueReference="{number}"')
        if variable.causality == "output" and variable.interval is None and variable.clock is None:
            initial.append(f'valueReference="{number}"')
        lines.append(
            f'<{variable.type} name="{variable.name}" valueReference="{number}" {attributes}'
            f"{clock}{type_}{unit}{start}>{inner}</{variable.type}>"
        )
    units = "".join(f"<Unit name={quoteattr(n)}><BaseUnit {b}/></Unit>" for n, b in UNITS.items())
    types = "".join(
        f'<EnumerationType name="{v.name}Type">'
        + "".join(f'<Item name="{item}" value="{value}"/>' for item, value in v.items)
        + "</EnumerationType>"
        for v in variables
        if v.items
    )
    structure = "".join(f"<Output {o}/>" for o in outputs) + "".join(f"<InitialUnknown {o}/>" for o in initial)
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<fmiModelDescription fmiVersion="3.0" modelName="{name}" '
        f'instantiationToken="{{x}}"><CoSimulation modelIdentifier="{name}"/>'
        f"<UnitDefinitions>{units}</UnitDefinitions>"
        + (f"<TypeDefinitions>{types}</TypeDefinitions>" if types else "")
        + f"<ModelVariables>{''.join(lines)}</ModelVariables><ModelStructure>{structure}</ModelStructure>"
        "</fmiModelDescription>"
    )
