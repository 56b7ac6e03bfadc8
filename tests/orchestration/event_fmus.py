"""Makes Model Exchange FMUs with events from C, for both standards."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import quoteattr

import fmpy
from mocks.compiler import compile_library


@dataclass(frozen=True)
class Variable:
    name: str
    causality: str = "output"
    type: str = "Float64"
    start: float | None = None
    variability: str = "continuous"
    derivative_of: str | None = None
    depends: str = ""


def state(name: str, start: float = 0.0) -> Variable:
    return Variable(name, "local", start=start)


def derivative(of: str, depends: str = "") -> Variable:
    return Variable(f"der({of})", "local", derivative_of=of, depends=depends)


def indicator(number: int) -> Variable:
    return Variable(f"z{number}", "local")


def parameter(name: str, start: float, type: str = "Float64") -> Variable:
    return Variable(name, "parameter", type, start, "fixed")


def counted(name: str, type: str = "Int32", depends: str = "") -> Variable:
    return Variable(name, "output", type, variability="discrete", depends=depends)


def hidden(name: str) -> Variable:
    return Variable(name, "local", "Boolean", variability="discrete")


MODELS: dict[str, list[Variable]] = {
    "bouncing_ball": [
        *(state("h", 1.0), state("v")),
        *(derivative("h", "v"), derivative("v")),
        indicator(1),
        *(parameter("g", 9.81), parameter("e", 0.7), parameter("rest", 0.0), parameter("lift", 1, "Boolean")),
        *(Variable("height", depends="h"), Variable("speed", depends="v")),
        *(counted("bounces"), counted("last", "Float64"), hidden("resting")),
    ],
    "stair": [
        parameter("period", 1.0),
        parameter("last", 1e300),
        parameter("nowhere", 0.0),
        counted("counter"),
        counted("late", "Float64"),
    ],
    "relay": [
        *(state("x"), derivative("x"), indicator(1), indicator(2)),
        *(parameter("low", -1.0), parameter("high", 1.0)),
        *(Variable("y", depends="x"), counted("on", "Boolean"), counted("switches")),
    ],
    "tally": [
        *(state("x"), derivative("x", "n enable level u")),
        Variable("n", "input", "Int32", 0, "discrete"),
        Variable("enable", "input", "Boolean", 1, "discrete"),
        Variable("level", "input", "Float64", 0.0, "discrete"),
        Variable("u", "input", "Float64", 0.0),
        *(Variable("total", depends="x"), counted("more", depends="n"), counted("odd", "Boolean", "n")),
        counted("updates"),
    ],
    "decay": [
        *(state("x", 1.0), derivative("x", "x")),
        *(parameter("nominal", 1.0), parameter("nominal_after", 1.0), parameter("change_at", 1e300)),
        Variable("y", depends="x"),
    ],
    "watcher": [
        *(state("x"), derivative("x")),
        *(parameter("threshold", 1.0), parameter("ends_at", 1e300), parameter("always", 0.0)),
        *(Variable("y", depends="x"), counted("steps"), counted("fired", "Boolean"), counted("fired_at", "Float64")),
    ],
    "bounded": [
        *(state("x"), derivative("x"), indicator(1)),
        *(parameter("limit", 1.0), parameter("status", 1, "Boolean")),
        *(Variable("y", depends="x"), counted("resets")),
    ],
    "peaks": [
        *(state("a", 0.0), state("b", 1.0), derivative("a", "b"), derivative("b", "a"), indicator(1)),
        parameter("level", 0.99),
        *(Variable("y", depends="a"), counted("rises"), counted("falls"), counted("last", "Float64"), hidden("above")),
    ],
    "wave": [indicator(1), counted("crossings"), counted("last", "Float64"), hidden("positive")],
    "ramp": [indicator(1), counted("events"), counted("sum", "Float64")],
    "restless": [counted("never")],
    "growing": [state("x"), derivative("x"), parameter("more", 0, "Int32")],
}


def build(model: str, folder: Path, version: str = "2.0") -> Path:
    """Compile a model and pack it as `folder/NAME.fmu` (2.0) or `folder/NAME.fmi3.fmu`."""
    variables = MODELS[model]
    path = folder / f"{model}{'.fmi3' if version == '3.0' else ''}.fmu"
    if path.exists():
        return path
    binary = folder / f"{model}{fmpy.sharedLibraryExtension}"
    if not binary.exists():
        _compile(model, variables, binary)
    watches = model == "watcher"
    with zipfile.ZipFile(path, "w") as archive:
        if version == "2.0":
            archive.writestr("modelDescription.xml", _xml2(model, variables, watches))
            archive.write(binary, f"binaries/{fmpy.platform}/{binary.name}")
        else:
            archive.writestr("modelDescription.xml", _xml3(model, variables, watches))
            archive.write(binary, f"binaries/{fmpy.platform_tuple}/{binary.name}")
    return path


def _compile(model: str, variables: list[Variable], binary: Path) -> None:
    names = [v.name.replace("der(", "der_").rstrip(")") for v in variables]
    kinds = "".join(
        "p" if v.causality == "parameter" else "d" if (v.causality, v.variability) == ("input", "discrete") else " "
        for v in variables
    )
    header = (
        f"#define N_VALUES {len(variables)}\n"
        f"#define N_STATES {sum(v.derivative_of is not None for v in variables)}\n"
        f"#define N_INDICATORS {len(_indicators(variables))}\n"
        f"#define START {{{', '.join(repr(float(v.start or 0)) for v in variables)}}}\n"
        f'#define KINDS "{kinds}"\nenum {{ {", ".join(names)} }};\n'
    )
    compile_library(model, "events_unused", header, binary)


def _indicators(variables: list[Variable]) -> list[Variable]:
    return [v for v in variables if v.name in ("z1", "z2")]


def _xml2(model: str, variables: list[Variable], watches: bool) -> str:
    types = {"Float64": "Real", "Int32": "Integer", "Boolean": "Boolean"}
    index = {v.name: i + 1 for i, v in enumerate(variables)}
    lines = []
    for v in variables:
        value = _attributes(start=_start(v), derivative=index.get(v.derivative_of or ""))
        lines.append(f"<ScalarVariable {_common(v, index[v.name] - 1)}><{types[v.type]} {value}/></ScalarVariable>")

    def unknowns(tag: str, chosen: list[Variable]) -> str:
        found = (
            f'<Unknown index="{index[v.name]}" dependencies="{" ".join(str(index[d]) for d in v.depends.split())}"/>'
            for v in chosen
        )
        return f"<{tag}>{''.join(found)}</{tag}>" if chosen else ""

    outputs, derivatives = _unknowns(variables)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<fmiModelDescription fmiVersion="2.0" modelName="{model}" guid="{{event}}" '
        f'numberOfEventIndicators="{len(_indicators(variables))}"><ModelExchange modelIdentifier="{model}" '
        f'completedIntegratorStepNotNeeded="{"false" if watches else "true"}"/>'
        '<LogCategories><Category name="logStatusError"/></LogCategories>'
        f"<ModelVariables>{''.join(lines)}</ModelVariables><ModelStructure>"
        f"{unknowns('Outputs', outputs)}{unknowns('Derivatives', derivatives)}"
        f"{unknowns('InitialUnknowns', outputs + derivatives)}</ModelStructure></fmiModelDescription>"
    )


def _xml3(model: str, variables: list[Variable], watches: bool) -> str:
    place = {v.name: i for i, v in enumerate(variables)}
    lines = ['<Float64 name="time" valueReference="1000" causality="independent" variability="continuous"/>']
    for v in variables:
        value = _attributes(start=_start(v), derivative=place.get(v.derivative_of or ""))
        lines.append(f"<{v.type} {_common(v, place[v.name])} {value}/>")

    def unknown(tag: str, v: Variable) -> str:
        depends = " ".join(str(place[d]) for d in v.depends.split())
        return f'<{tag} valueReference="{place[v.name]}" dependencies="{depends}"/>'

    outputs, derivatives = _unknowns(variables)
    structure = [unknown("Output", v) for v in outputs]
    structure += [unknown("ContinuousStateDerivative", v) for v in derivatives]
    structure += [unknown("InitialUnknown", v) for v in outputs + derivatives]
    structure += [f'<EventIndicator valueReference="{place[v.name]}"/>' for v in _indicators(variables)]
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<fmiModelDescription fmiVersion="3.0" modelName="{model}" instantiationToken="{{event}}">'
        f'<ModelExchange modelIdentifier="{model}" needsCompletedIntegratorStep="{"true" if watches else "false"}"/>'
        '<LogCategories><Category name="logStatusError"/></LogCategories>'
        f"<ModelVariables>{''.join(lines)}</ModelVariables>"
        f"<ModelStructure>{''.join(structure)}</ModelStructure></fmiModelDescription>"
    )


def _unknowns(variables: list[Variable]) -> tuple[list[Variable], list[Variable]]:
    return [v for v in variables if v.causality == "output"], [v for v in variables if v.derivative_of]


def _common(v: Variable, place: int) -> str:
    initial = "exact" if v.causality == "local" and v.start is not None else None
    return _attributes(
        name=v.name, valueReference=place, causality=v.causality, variability=v.variability, initial=initial
    )


def _start(v: Variable) -> str | None:
    if v.start is None:
        return None
    return ("true" if v.start else "false") if v.type == "Boolean" else repr(v.start)


def _attributes(**attributes: object) -> str:
    return " ".join(f"{name}={quoteattr(str(value))}" for name, value in attributes.items() if value is not None)
