"""Makes small FMUs from C: what the orchestrator does is judged against values known by heart."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass, field
from math import prod
from pathlib import Path
from xml.sax.saxutils import quoteattr

import fmpy

from mocks.compiler import compile_library

TOKEN = "{mock}"


@dataclass
class Variable:
    name: str
    causality: str
    shape: tuple[int, ...] = ()
    start: float | list[float] | None = None
    unit: str | None = None
    type: str = "Float64"
    variability: str = "continuous"
    initial: str | None = None
    derivative_of: str | None = None
    depends: list[str] | None = field(default_factory=list)  # None: the attribute is left out

    @property
    def size(self) -> int:
        return prod(self.shape)

    @property
    def starts(self) -> list[float] | None:
        return (
            None
            if self.start is None
            else list(self.start)
            if isinstance(self.start, list)
            else [self.start] * self.size
        )

    @property
    def elements(self) -> list[str]:
        if not self.shape:
            return [self.name]
        if len(self.shape) == 1:
            return [f"{self.name}[{i + 1}]" for i in range(self.size)]
        return [f"{self.name}[{i // self.shape[1] + 1},{i % self.shape[1] + 1}]" for i in range(self.size)]


def parameter(name: str, start: float | list[float], shape: tuple[int, ...] = (), type: str = "Float64") -> Variable:
    return Variable(name, "parameter", shape, start, type=type, variability="fixed")


def state(name: str, start: float, shape: tuple[int, ...] = ()) -> Variable:
    return Variable(name, "local", shape, start, initial="exact")


def derivative(of: str, depends: list[str], shape: tuple[int, ...] = ()) -> Variable:
    return Variable(f"der({of})", "local", shape, derivative_of=of, depends=depends)


def models(n: int = 3) -> dict[str, list[Variable]]:
    """States first, then their derivatives."""
    a = (n,)
    return {
        "integrator": [
            state("x", 0.0, a),
            derivative("x", ["u"], a),
            Variable("u", "input", a, 0.0, "m/s"),
            Variable("y", "output", a, unit="m", depends=["x"]),
        ],
        "resizable": [
            state("x", 1.0, a),
            derivative("x", ["u", "x"], a),
            Variable("u", "input", a, 0.0),
            Variable("y", "output", a, depends=["x"]),
            Variable("z", "local", a, depends=["x"]),
        ],
        "gain": [
            Variable("u", "input", a, 0.0, "m"),
            parameter("k", 1.0),
            Variable("y", "output", a, unit="m/s", depends=["u"]),
            Variable("doubled", "output", a, unit="m", depends=["u"]),
        ],
        "source": [
            parameter("offset", 0.0, a),
            parameter("slope", 1.0),
            Variable("y", "output", a, unit="m"),
        ],
        "oscillator": [
            state("a", 1.0),
            state("b", 0.0),
            derivative("a", ["b"]),
            derivative("b", ["a", "u"]),
            Variable("u", "input", (), 0.0),
            Variable("position", "output", depends=["a"]),
        ],
        "ticker": [
            state("x", 0.0),
            derivative("x", ["count"]),
            parameter("period", 1.0),
            Variable("count", "output", variability="discrete"),
            Variable("area", "output", depends=["x"]),
        ],
        "faulty": [
            state("x", 0.0),
            derivative("x", []),
            parameter("mode", 0, type="Int32"),
            parameter("from", 0.0),
            Variable("y", "output"),
        ],
        "hostile": [state("x", 0.0), derivative("x", []), parameter("from", 0.5), Variable("y", "output")],
        "typed": [
            parameter("n", 0, type="Int32"),
            parameter("flag", 0, type="Boolean"),
            parameter("matrix", 0.0, (2, 3)),
            Variable("y", "output"),
            Variable("whole", "output", type="Int32", variability="discrete"),
        ],
    }


def build(model: str, folder: Path, version: str = "2.0", indicators: int = 0, name: str | None = None) -> Path:
    """Compile a mock and pack it as `folder/NAME.fmu` (2.0) or `folder/NAME.fmi3.fmu`."""
    variables = models()[model]
    path = folder / f"{name or model}{'.fmi3' if version == '3.0' else ''}.fmu"
    if path.exists():
        return path
    places: dict[str, int] = {}
    size = 0
    for variable in variables:
        places[variable.name] = size
        size += variable.size
    binary = folder / f"{model}{fmpy.sharedLibraryExtension}"
    if not binary.exists():
        _compile(model, variables, places, size, binary)
    xml = _xml2(model, variables, places, indicators) if version == "2.0" else _xml3(model, variables, places)
    platform = fmpy.platform if version == "2.0" else fmpy.platform_tuple
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", xml)
        archive.write(binary, f"binaries/{platform}/{binary.name}")
    return path


def _compile(model: str, variables: list[Variable], places: dict[str, int], size: int, binary: Path) -> None:
    starts = [0.0] * size
    lengths = [1] * size
    for variable in variables:
        lengths[places[variable.name]] = variable.size
        for i, value in enumerate(variable.starts or []):
            starts[places[variable.name] + i] = value
    names = {name.replace("der(", "der_").rstrip(")"): place for name, place in places.items()}
    header = (
        f'#define TOKEN "{TOKEN}"\n#define N_VALUES {size}\n'
        f"#define START {{{', '.join(map(repr, starts))}}}\n#define LENGTHS {{{', '.join(map(str, lengths))}}}\n"
        f"enum {{ {', '.join(f'{name} = {place}' for name, place in names.items())} }};\n"
    )
    compile_library(model, "unused", header, binary)


def _xml2(model: str, variables: list[Variable], places: dict[str, int], indicators: int) -> str:
    types = {"Float64": "Real", "Int32": "Integer", "Boolean": "Boolean"}
    index = {}
    for variable in variables:
        for element in variable.elements:
            index[variable.name, element] = len(index) + 1
    lines = []
    for variable in variables:
        for i, element in enumerate(variable.elements):
            attributes = _attributes(
                name=_element(element),
                valueReference=places[variable.name] + i,
                description=f"{variable.name} of {model}",
                causality=variable.causality,
                variability=variable.variability,
                initial=variable.initial,
            )
            of = variable.derivative_of
            value = _attributes(
                unit=variable.unit,
                start=None if variable.starts is None else _text(variable.starts[i], variable.type),
                derivative=None if of is None else next(k for (n, _), k in index.items() if n == of) + i,
            )
            lines.append(f"<ScalarVariable {attributes}><{types[variable.type]} {value}/></ScalarVariable>")
    size = {v.name: v.size for v in variables}

    def unknowns(chosen: list[Variable]) -> str:
        found = []
        for variable in chosen:
            for i, element in enumerate(variable.elements):
                depends = None
                if variable.depends is not None:  # element by element where the sizes agree
                    depends = " ".join(
                        str(k)
                        for name in variable.depends
                        for j, k in enumerate(k for (n, _), k in index.items() if n == name)
                        if size[name] != variable.size or i == j
                    )
                found.append(f"<Unknown {_attributes(index=index[variable.name, element], dependencies=depends)}/>")
        return "".join(found)

    outputs = [v for v in variables if v.causality == "output"]
    derivatives = [v for v in variables if v.derivative_of]
    units = "".join(f"<Unit name={quoteattr(u)}/>" for u in sorted({v.unit for v in variables if v.unit}))
    structure = f"<Outputs>{unknowns(outputs)}</Outputs>" if outputs else ""
    structure += f"<Derivatives>{unknowns(derivatives)}</Derivatives>" if derivatives else ""
    structure += f"<InitialUnknowns>{unknowns(outputs + derivatives)}</InitialUnknowns>"
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<fmiModelDescription fmiVersion="2.0" modelName="{model}" guid="{TOKEN}" '
        f'numberOfEventIndicators="{indicators}"><ModelExchange modelIdentifier="{model}"/>'
        f'<CoSimulation modelIdentifier="{model}" canHandleVariableCommunicationStepSize="true"/>'
        + (f"<UnitDefinitions>{units}</UnitDefinitions>" if units else "")
        + '<LogCategories><Category name="logStatusError"/></LogCategories>'
        + f"<ModelVariables>{''.join(lines)}</ModelVariables><ModelStructure>{structure}</ModelStructure>"
        "</fmiModelDescription>"
    )


def _xml3(model: str, variables: list[Variable], places: dict[str, int]) -> str:
    lines = [
        '<Float64 name="time" valueReference="1000" causality="independent" variability="continuous"/>',
    ]
    for variable in variables:
        attributes = _attributes(
            name=variable.name,
            valueReference=places[variable.name],
            description=f"{variable.name} of {model}",
            causality=variable.causality,
            variability=variable.variability,
            initial=variable.initial,
            unit=variable.unit,
            start=None if variable.starts is None else " ".join(_text(s, variable.type) for s in variable.starts),
            derivative=None if variable.derivative_of is None else places[variable.derivative_of],
        )
        dimensions = "".join(f'<Dimension start="{n}"/>' for n in variable.shape)
        lines.append(f"<{variable.type} {attributes}>{dimensions}</{variable.type}>")

    def unknown(tag: str, variable: Variable) -> str:
        depends = None if variable.depends is None else " ".join(str(places[d]) for d in variable.depends)
        return f"<{tag} {_attributes(valueReference=places[variable.name], dependencies=depends)}/>"

    outputs = [v for v in variables if v.causality == "output"]
    derivatives = [v for v in variables if v.derivative_of]
    structure = [unknown("Output", v) for v in outputs]
    structure += [unknown("ContinuousStateDerivative", v) for v in derivatives]
    structure += [unknown("InitialUnknown", v) for v in outputs + derivatives]
    units = "".join(f"<Unit name={quoteattr(u)}/>" for u in sorted({v.unit for v in variables if v.unit}))
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<fmiModelDescription fmiVersion="3.0" modelName="{model}" instantiationToken="{TOKEN}">'
        f'<ModelExchange modelIdentifier="{model}"/>'
        f'<CoSimulation modelIdentifier="{model}" canHandleVariableCommunicationStepSize="true"/>'
        + (f"<UnitDefinitions>{units}</UnitDefinitions>" if units else "")
        + '<LogCategories><Category name="logStatusError"/></LogCategories>'
        + f"<ModelVariables>{''.join(lines)}</ModelVariables><ModelStructure>{''.join(structure)}</ModelStructure>"
        "</fmiModelDescription>"
    )


def _element(element: str) -> str:
    """`der(x)[1]` -> `der(x[1])`, as FMI 2 writes it."""
    return element.replace(")[", "[") + ")" if ")[" in element else element


def _attributes(**attributes: object) -> str:
    return " ".join(f"{name}={quoteattr(str(value))}" for name, value in attributes.items() if value is not None)


def _text(value: float, kind: str) -> str:
    return (
        ("true" if value else "false") if kind == "Boolean" else repr(int(value) if kind == "Int32" else float(value))
    )
