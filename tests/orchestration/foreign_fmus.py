"""Makes Co-Simulation FMUs with quirks from C, for both standards."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import prod
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import fmpy
from mocks.compiler import compile_library

PHASES = {"idle": 1, "run": 2, "stop": 5}
INTEGERS = [f"{sign}Int{bits}" for bits in (8, 16, 32, 64) for sign in ("", "U")]
NUMBERS = ["Float64", "Float32", *INTEGERS, "Boolean"]


@dataclass(frozen=True)
class Variable:
    name: str
    causality: str = "output"
    type: str = "Float64"
    start: Any = None
    shape: tuple[int | str, ...] = ()  # a dimension may be the name of a structural parameter
    variability: str | None = None
    depends: str | None = ""  # None: the attribute is left out
    clock: str | None = None
    more: Mapping[str, Any] = field(default_factory=dict)
    aliases: tuple[str, ...] = ()  # in FMI 2.0, where inputs have none, they are outputs

    @property
    def starts(self) -> list[Any]:
        return list(self.start) if isinstance(self.start, list | tuple) else [self.start]

    @property
    def fixed_size(self) -> int:
        return prod(n for n in self.shape if isinstance(n, int))

    @property
    def resizable(self) -> bool:
        return any(isinstance(n, str) for n in self.shape)


@dataclass(frozen=True)
class Model:
    variables: list[Variable]
    versions: tuple[str, ...] = ("2.0", "3.0")
    attributes: Mapping[str, Any] = field(default_factory=dict)  # of the interface, in both standards
    fmi2: Mapping[str, Any] = field(default_factory=dict)
    fmi3: Mapping[str, Any] = field(default_factory=dict)
    resources: Mapping[str, str] = field(default_factory=dict)


def parameter(name: str, start: Any, type: str = "Float64", **more: Any) -> Variable:
    return Variable(name, "parameter", type, start, variability="fixed", **more)


def structural(name: str, start: Any, type: str, **more: Any) -> Variable:
    return Variable(name, "structuralParameter", type, start, variability="fixed", **more)


def input_(name: str, start: Any = 0.0, type: str = "Float64", **more: Any) -> Variable:
    return Variable(name, "input", type, start, variability="continuous" if "Float" in type else "discrete", **more)


def counted(name: str, type: str = "Int32", **more: Any) -> Variable:
    return Variable(name, "output", type, variability="discrete", **more)


def clock(name: str, kind: str, causality: str = "input", **more: Any) -> Variable:
    return Variable(name, causality, "Clock", more={"intervalVariability": kind, **more})


VARIABLE_STEP = {"canHandleVariableCommunicationStepSize": "true"}
EVENTS = {**VARIABLE_STEP, "hasEventMode": "true"}
CLOCKS = [
    *(clock("steady", "constant", intervalDecimal=0.25, shiftDecimal=0.1), counted("steady_n", clock="steady")),
    *(clock("third", "constant", supportsFraction="true", resolution=3, intervalCounter=1, intervalDecimal=0.3333333),),
    counted("third_n", clock="third"),
    *(clock("given", "fixed", intervalDecimal=0.5), counted("given_n", clock="given")),
    *(clock("asked", "fixed"), parameter("period", 0.2), counted("asked_n", clock="asked")),
    *(clock("growing", "changing", supportsFraction="true"), counted("growing_n", clock="growing")),
    *(clock("alarm", "countdown"), counted("alarm_n", clock="alarm")),
    *(counted("last", "Float64", clock="steady"), counted("sampled", "Float64", clock="steady", depends="u")),
    input_("u", clock="steady"),
    Variable("told", depends=""),
]

MODELS: dict[str, Model] = {
    "types": Model(
        [
            *(parameter(f"p_{t}", True if t == "Boolean" else 100, t) for t in NUMBERS),
            *(input_(f"u_{t}", False if t == "Boolean" else 7, t) for t in NUMBERS),
            *(Variable(f"y_{t}", type=t, depends=f"u_{t}") for t in NUMBERS),
            *(Variable(f"q_{t}", type=t) for t in NUMBERS),
            *(parameter("phase", 2, "Enumeration"), Variable("phase_out", type="Enumeration")),
            *(parameter("word", "four", "String"), parameter("words", ["one", "three"], "String", shape=(2,))),
            *(parameter("blob", "00ff10", "Binary"), counted("letters"), counted("bytes")),
        ],
    ),
    "sizes": Model(
        [
            structural("n", 3, "UInt64"),
            input_("u", [1.0, 2.0, 3.0], shape=("n",)),
            Variable("y", shape=("n",), depends="u"),
            Variable("total", depends="u"),
        ],
        versions=("3.0",),
    ),
    "square": Model(
        [
            structural("rows", 2, "UInt64", more={"min": 0, "max": 4}, aliases=("height",)),
            structural("columns", 2, "UInt64", more={"min": 0}),
            *(structural("margin", 0.25, "Float64"), structural("deep", True, "Boolean")),
            *(structural("level", 3, "Int32"), structural("label", "a", "String")),
            input_("u", 1.0, shape=("rows", "columns")),
            Variable("y", shape=("rows", "columns"), depends="u"),
            *(Variable("seen", "output", shape=(4,)), Variable("entered", "output", "Int32")),
        ],
        versions=("3.0",),
    ),
    "invalid": Model(
        [
            structural("n", 2, "UInt64"),
            *(parameter("same", 2.0, shape=("n",)), parameter("each", [3.0, 4.0], shape=("n",))),
            Variable("sums", shape=(2,)),
        ],
        versions=("3.0",),
    ),
    "names": Model(
        [
            input_("u", [1.0, 2.0], shape=(2,), aliases=("uu",)),
            Variable("y", shape=(2,), depends="u", aliases=("yy",)),
        ]
    ),
    "bouncer": Model(
        [
            parameter("level", 0.3),
            parameter("period", 10.0),
            parameter("nowhere", 0.0),
            counted("hits"),
            counted("late", "Float64"),
            Variable("x"),
        ],
        versions=("3.0",),
        fmi3={**EVENTS, "canGetAndSetFMUState": "true", "canSerializeFMUState": "true"},
    ),
    "clocks": Model(
        CLOCKS, versions=("3.0",), fmi3={**EVENTS, "canGetAndSetFMUState": "true", "canSerializeFMUState": "true"}
    ),
    "rigid_clock": Model(
        [clock("steady", "constant", intervalDecimal=0.25), counted("steady_n", clock="steady")],
        versions=("3.0",),
        fmi3={"hasEventMode": "true"},
    ),
    "counter": Model(
        [
            clock("tick", "constant", intervalDecimal=0.1),
            Variable("every_third", "output", "Clock", depends="tick", more={"intervalVariability": "triggered"}),
            counted("count", clock="tick"),
            counted("held", clock="every_third", depends="tick"),
        ],
        versions=("3.0",),
        fmi3=EVENTS,
    ),
    "listener": Model(
        [
            clock("heard", "triggered"),
            input_("u", clock="heard"),
            counted("times", clock="heard", depends="heard"),
            counted("twice", "Float64", clock="heard", depends="heard u"),
        ],
        versions=("3.0",),
        fmi3=EVENTS,
    ),
    "latch": Model(
        [input_("n", 0, "Int32"), counted("sum", depends=""), counted("odd", "Boolean", depends="n")],
        versions=("3.0",),
        fmi3=EVENTS,
    ),
    "short": Model(
        [
            *(parameter("longest", 0.04), parameter("stuck", 0.0), parameter("wrong", 0, "Int32")),
            *(counted("steps"), counted("asked"), Variable("x")),
        ],
        versions=("3.0",),
        fmi3={
            **VARIABLE_STEP,
            "mightReturnEarlyFromDoStep": "true",
            "providesIntermediateUpdate": "true",
            "canReturnEarlyAfterIntermediateUpdate": "true",
        },
    ),
    "picky": Model(
        [
            *(parameter("longest", 0.03), parameter("stop", 100.0), parameter("unsavable", 0.0)),
            *(input_("u", 1.0), counted("steps"), Variable("x")),
        ],
        attributes=VARIABLE_STEP,
        fmi2={"canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true"},
        fmi3={"canGetAndSetFMUState": "true", "canSerializeFMUState": "true"},
    ),
    "strict": Model(
        [
            *(parameter("lenient", 0.0), Variable("gain", "parameter", start=1.0, variability="tunable")),
            *(input_("u", 1.0), input_("v", 0.0)),
            *(Variable("x"), Variable("w", depends="u"), Variable("unsaid", depends=None)),
        ],
        attributes=VARIABLE_STEP,
        fmi2={"canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true"},
        fmi3={"canGetAndSetFMUState": "true", "canSerializeFMUState": "true"},
    ),
    "eager": Model(
        [
            *(parameter("which", 0, "Int32"), parameter("wrong", 0, "Int32")),
            *(clock("retuned", "tunable"), clock("changed", "changing"), clock("counted", "countdown")),
            *(counted("ticks", clock="changed"),),
        ],
        versions=("3.0",),
        fmi3=EVENTS,
    ),
    "punctual": Model([Variable("off"), Variable("drift"), Variable("step_seen")], attributes=VARIABLE_STEP),
    "quitter": Model(
        [
            parameter("at", 0.5),
            parameter("how", 0, "Int32"),
            parameter("reached", 0.0),
            input_("u", 1.0),
            Variable("x"),
            Variable("y", depends="u"),
        ],
        attributes=VARIABLE_STEP,
    ),
    "lazy": Model(
        [counted("steps"), Variable("x")],
        versions=("2.0",),
        attributes=VARIABLE_STEP,
        fmi2={"canRunAsynchronuously": "true"},
    ),
    "reader": Model([counted("number")], attributes=VARIABLE_STEP, resources={"number.txt": "42\n"}),
    "single": Model([counted("instances")], attributes={"canBeInstantiatedOnlyOncePerProcess": "true"}),
    "tool": Model([Variable("y")], attributes={"needsExecutionTool": "true"}),
}


def build(model: str, folder: Path, version: str = "2.0", name: str | None = None, **changes: Any) -> Path:
    """Compile a model and pack it as `folder/NAME.fmu` (2.0) or `folder/NAME.fmi3.fmu`; `changes` of the interface."""
    what = MODELS[model]
    path = folder / f"{name or model}{'.fmi3' if version == '3.0' else ''}.fmu"
    if path.exists():
        return path
    binary = folder / f"{model}{fmpy.sharedLibraryExtension}"
    places = _places(what.variables)
    if not binary.exists():
        _compile(model, what.variables, places, binary)
    attributes = {**what.attributes, **(what.fmi2 if version == "2.0" else what.fmi3), **changes}
    attributes = {k: v for k, v in attributes.items() if v is not None}
    xml = (_xml2 if version == "2.0" else _xml3)(model, what.variables, places, attributes)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", xml)
        folder_name = fmpy.platform if version == "2.0" else fmpy.platform_tuple
        archive.write(binary, f"binaries/{folder_name}/{binary.name}")
        for file, content in what.resources.items():
            archive.writestr(f"resources/{file}", content)
    return path


def changed(path: Path, target: Path, old: str, new: str) -> Path:
    """Copy an FMU with something else in its modelDescription.xml."""
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(target, "w") as copy:
        for name in source.namelist():
            content = source.read(name)
            if name == "modelDescription.xml":
                assert old.encode() in content
                content = content.replace(old.encode(), new.encode())
            copy.writestr(name, content)
    return target


def _places(variables: list[Variable]) -> dict[str, int]:
    places, at = {}, 0
    for v in variables:
        places[v.name] = at
        at += v.fixed_size if not v.resizable else 20
    return places


def _compile(model: str, variables: list[Variable], places: dict[str, int], binary: Path) -> None:
    n = max(places.values()) + 20
    starts, texts, sizes, lengths, clocks, kinds = ["0"] * n, ["0"] * n, [0] * n, [1] * n, list(range(n)), [" "] * n
    for v in variables:
        at = places[v.name]
        lengths[at] = 0 if v.resizable else v.fixed_size
        fixed = v.causality == "parameter" and v.variability != "tunable"
        kinds[at] = "p" if fixed else "s" if v.causality == "structuralParameter" else " "
        if v.clock is not None:
            clocks[at] = places[v.clock]
        for i, value in enumerate(v.starts):
            if value is not None and v.type in ("String", "Binary"):
                content = value.encode() if v.type == "String" else bytes.fromhex(value)
                texts[at + i] = '"' + "".join(f"\\x{byte:02x}" for byte in content) + '"'
                sizes[at + i] = len(content)
            elif value is not None:
                starts[at + i] = repr(int(value) if isinstance(value, bool) else value)
    header = (
        f"#define N_VALUES {n}\n#define START {{{', '.join(starts)}}}\n#define TEXTS {{{', '.join(texts)}}}\n"
        f"#define BYTES {{{', '.join(map(str, sizes))}}}\n"
        f"#define LENGTHS {{{', '.join(map(str, lengths))}}}\n#define CLOCKS {{{', '.join(map(str, clocks))}}}\n"
        f'#define KINDS "{"".join(kinds)}"\n'
        f"enum {{ {', '.join(f'{name} = {place}' for name, place in places.items())} }};\n"
    )
    compile_library(model, "foreign_unused", header, binary)


_FMI2 = {"Float64": "Real", "Int32": "Integer"}
_ONLY_IN_3 = {"Float32", "Int8", "UInt8", "Int16", "UInt16", "UInt32", "Int64", "UInt64", "Binary", "Clock"}


def _xml2(model: str, variables: list[Variable], places: dict[str, int], attributes: Mapping[str, Any]) -> str:
    variables = [v for v in variables if v.type not in _ONLY_IN_3 and not v.resizable]
    lines: list[str] = []
    index: dict[str, list[int]] = {}
    for v in variables:
        for i in range(v.fixed_size):
            index.setdefault(v.name, []).append(len(lines) + 1)
            name = f"{v.name}[{i + 1}]" if v.shape else v.name
            start = None if v.start is None else _text(v.starts[i], v.type)
            declared = "Phase" if v.type == "Enumeration" else None
            value = _attributes(start=start, declaredType=declared)
            common = _attributes(
                name=name, valueReference=places[v.name] + i, causality=v.causality, variability=_variability(v)
            )
            lines.append(f"<ScalarVariable {common}><{_FMI2.get(v.type, v.type)} {value}/></ScalarVariable>")
    for v in variables:
        for alias in v.aliases:
            for i in range(v.fixed_size):
                index.setdefault(alias, []).append(len(lines) + 1)
                name = f"{alias}[{i + 1}]" if v.shape else alias
                common = _attributes(
                    name=name, valueReference=places[v.name] + i, causality="output", variability=_variability(v)
                )
                lines.append(f"<ScalarVariable {common}><{_FMI2.get(v.type, v.type)}/></ScalarVariable>")
    unknowns = []
    for v in variables:
        known = None if v.depends is None else " ".join(str(i) for d in v.depends.split() for i in index[d])
        for name in (v.name, *v.aliases) if v.causality == "output" else v.aliases:
            known = " ".join(map(str, index[v.name])) if v.causality == "input" else known
            unknowns += [f"<Unknown {_attributes(index=i, dependencies=known)}/>" for i in index[name]]
    items = "".join(f'<Item name="{name}" value="{value}"/>' for name, value in PHASES.items())
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<fmiModelDescription fmiVersion="2.0" modelName="{model}" guid="{{foreign}}" generationTool="Quirk Tool 1">'
        f"<CoSimulation {_attributes(modelIdentifier=model, **attributes)}/>"
        f'<TypeDefinitions><SimpleType name="Phase"><Enumeration>{items}</Enumeration></SimpleType></TypeDefinitions>'
        '<LogCategories><Category name="logStatusError"/></LogCategories>'
        f"<ModelVariables>{''.join(lines)}</ModelVariables><ModelStructure><Outputs>{''.join(unknowns)}</Outputs>"
        f"<InitialUnknowns>{''.join(unknowns)}</InitialUnknowns></ModelStructure></fmiModelDescription>"
    )


def _xml3(model: str, variables: list[Variable], places: dict[str, int], attributes: Mapping[str, Any]) -> str:
    lines = ['<Float64 name="time" valueReference="1000" causality="independent" variability="continuous"/>']
    for v in variables:
        texts = v.type in ("String", "Binary")
        common = _attributes(
            name=v.name,
            valueReference=places[v.name],
            causality=v.causality,
            variability=_variability(v),
            clocks=None if v.clock is None else places[v.clock],
            declaredType="Phase" if v.type == "Enumeration" else None,
            start=None if v.start is None or texts else " ".join(_text(s, v.type) for s in v.starts),
            **v.more,
        )
        inside = "".join(
            f'<Dimension valueReference="{places[d]}"/>' if isinstance(d, str) else f'<Dimension start="{d}"/>'
            for d in v.shape
        )
        inside += "".join(f'<Alias name="{alias}"/>' for alias in v.aliases)
        if texts and v.start is not None:
            inside += "".join(f"<Start value={quoteattr(s)}/>" for s in v.starts)
        lines.append(f"<{v.type} {common}>{inside}</{v.type}>")
    structure = {"Output": [], "InitialUnknown": []}
    for v in variables:
        if v.causality == "output":
            known = None if v.depends is None else " ".join(str(places[d]) for d in v.depends.split())
            text = _attributes(valueReference=places[v.name], dependencies=known)
            structure["Output"].append(f"<Output {text}/>")
            if v.type != "Clock" and v.clock is None:
                structure["InitialUnknown"].append(f"<InitialUnknown {text}/>")
    items = "".join(f'<Item name="{name}" value="{value}"/>' for name, value in PHASES.items())
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<fmiModelDescription fmiVersion="3.0" modelName="{model}" instantiationToken="{{foreign}}" '
        f'generationTool="Quirk Tool 1"><CoSimulation {_attributes(modelIdentifier=model, **attributes)}/>'
        f'<TypeDefinitions><EnumerationType name="Phase">{items}</EnumerationType></TypeDefinitions>'
        '<LogCategories><Category name="logStatusError"/></LogCategories>'
        f"<ModelVariables>{''.join(lines)}</ModelVariables>"
        f"<ModelStructure>{''.join(structure['Output'] + structure['InitialUnknown'])}</ModelStructure>"
        "</fmiModelDescription>"
    )


def _variability(v: Variable) -> str | None:
    if v.variability is None and v.type not in ("Float64", "Float32", "Clock"):
        return "discrete"
    return v.variability


def _text(value: Any, kind: str) -> str:
    return ("true" if value else "false") if kind == "Boolean" else str(value)


def _attributes(**attributes: object) -> str:
    return " ".join(f"{name}={quoteattr(str(value))}" for name, value in attributes.items() if value is not None)
