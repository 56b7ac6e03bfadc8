"""FMUs with one thing changed: in the description, in the names of files, or in the bytes of the library."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import event_fmus
import fmpy
import foreign_fmus

XML = "modelDescription.xml"


@dataclass(frozen=True)
class Odd:
    """What is changed, and what is to be said of it: `run` by a run, `check` by a check; both if only `run` is given.

    `note` says that no standard forbids it, though a run does not take it here.
    """

    name: str
    model: str
    version: str
    edit: Callable[[str], str | bytes | None] = lambda xml: xml
    library: Callable[[bytes], bytes] = lambda content: content
    path: Callable[[str], str] = lambda path: path
    files: dict[str, str] = field(default_factory=dict)
    run: str = ""
    check: str = ""
    note: bool = False

    def build(self, folder: Path) -> Path:
        builder = event_fmus if self.model in event_fmus.MODELS else foreign_fmus
        good = builder.build(self.model, folder, self.version)
        path = folder / f"{re.sub(r'[^a-z0-9]+', '-', self.name.lower())}.fmu"
        with zipfile.ZipFile(good) as old, zipfile.ZipFile(path, "w") as new:
            for name in old.namelist():
                if name == XML:
                    text = old.read(name).decode()
                    changed = self.edit(text)
                    assert changed != text or self.edit is Odd.edit, "nothing is changed"
                    if changed is not None:
                        new.writestr(name, changed)
                elif name.startswith("binaries/"):
                    new.writestr(self.path(name), self.library(old.read(name)))
                else:
                    new.writestr(name, old.read(name))
            for name, content in self.files.items():
                new.writestr(name, content)
        return path


def sub(pattern: str, replacement: str) -> Callable[[str], str]:
    return lambda text: re.sub(pattern, replacement, text, count=1, flags=re.DOTALL)


def last(name: str, inner: str) -> Callable[[str], str]:
    """Put an element into a variable of FMI 3, as the last one."""
    return sub(rf'(<(\w+) name="{re.escape(name)}"[^>]*>.*?)(</\2>)', rf"\1{inner}\3")


def after(name: str, inner: str) -> Callable[[str], str]:
    """Put an element into a variable of FMI 3, after its dimensions."""
    return sub(rf'(<\w+ name="{re.escape(name)}"[^>]*>(?:<Dimension[^>]*>)*)', rf"\1{inner}")


def both(*edits: Callable[[str], str]) -> Callable[[str], str]:
    def edit(text: str) -> str:
        for one in edits:
            text = one(text)
        return text

    return edit


def attribute(variable: str, name: str, value: str | None) -> Callable[[str], str]:
    """Give an attribute of a variable of FMI 3 another value, or none."""
    text = "" if value is None else f' {name}="{value}"'

    def inside(match: re.Match[str]) -> str:
        return re.sub(rf' {name}="[^"]*"', "", match[0])[:-1] + text + ">"

    return lambda xml: re.sub(rf'<\w+ name="{re.escape(variable)}"[^>]*>', inside, xml, count=1)


def experiment(**values: str) -> Callable[[str], str]:
    text = " ".join(f'{name}="{value}"' for name, value in values.items())
    return sub("<ModelVariables>", f"<DefaultExperiment {text}/><ModelVariables>")


def for_machine(number: int) -> Callable[[bytes], bytes]:
    """Let an ELF file say that it is for another processor."""
    return lambda content: content[:18] + number.to_bytes(2, "little") + content[20:]


CLOCK_TYPE = '<TypeDefinitions><ClockType name="Beat" intervalVariability="constant" intervalDecimal="0.25"/>'
BUILD = (
    '<?xml version="1.0" encoding="UTF-8"?><fmiBuildDescription fmiVersion="{version}">'
    '<BuildConfiguration modelIdentifier="{name}"><SourceFileSet><SourceFile name="a.c"/></SourceFileSet>'
    "</BuildConfiguration></fmiBuildDescription>"
)
HERE2, HERE3 = fmpy.platform, fmpy.platform_tuple


def _sources(version: str, name: str) -> dict[str, str]:
    return {"sources/a.c": "", "sources/buildDescription.xml": BUILD.format(version=version, name=name)}


GOOD = [
    Odd("types of FMI 2", "types", "2.0"),
    Odd("types of FMI 3", "types", "3.0"),
    Odd("clocks", "clocks", "3.0"),
    Odd("event mode only", "latch", "3.0"),
    Odd("early return only", "bouncer", "3.0"),
    Odd("one instance in a process", "single", "2.0"),
    Odd("one instance in a process of FMI 3", "single", "3.0"),
    Odd("model exchange only", "decay", "2.0"),
    Odd("model exchange only in FMI 3", "decay", "3.0"),
    Odd("alias of an output", "sizes", "3.0", last("total", '<Alias name="sum"/>')),
    Odd("alias of an array", "sizes", "3.0", last("y", '<Alias name="twice" description="two u"/>')),
    Odd("alias of an input", "sizes", "3.0", last("u", '<Alias name="in"/>')),
    Odd("alias of a text", "types", "3.0", last("word", '<Alias name="wort"/>')),
    Odd(
        "declared type of a clock",
        "clocks",
        "3.0",
        both(attribute("steady", "declaredType", "Beat"), sub("<TypeDefinitions>", CLOCK_TYPE)),
    ),
    Odd(
        "blanks in lists",
        "clocks",
        "3.0",
        sub(r'dependencies="(\d+)"', r'dependencies=" \1 "'),
    ),
    Odd("Boolean as a number", "types", "3.0", attribute("p_Boolean", "start", "1")),
    Odd(
        "a guess",
        "types",
        "3.0",
        both(attribute("q_Float64", "initial", "approx"), attribute("q_Float64", "start", "3")),
    ),
    Odd("later start", "types", "3.0", experiment(startTime="5", stopTime="6")),
    Odd("later start of FMI 2", "types", "2.0", experiment(startTime="5", stopTime="6", stepSize="0.5")),
    Odd("comments", "sizes", "3.0", sub("<ModelVariables>", "<ModelVariables><!-- here --><?and there?>")),
    Odd("comments of FMI 2", "types", "2.0", sub("<ModelVariables>", "<ModelVariables><!-- here --><?and there?>")),
    Odd("UTF-16", "sizes", "3.0", lambda xml: xml.replace("UTF-8", "UTF-16").encode("utf-16")),
    Odd("annotations", "sizes", "3.0", after("total", '<Annotations><Annotation type="x.y"/></Annotations>')),
    Odd("a folder of FMI 3 in FMI 2", "types", "2.0", path=lambda p: p.replace(HERE2, HERE3)),
    Odd("build description", "types", "3.0", files=_sources("3.0", "types")),
]
STRICTER = [
    Odd(
        "size Int32",
        "sizes",
        "3.0",
        both(sub("<UInt64( name=.n.)", r"<Int32\1"), sub("</UInt64>", "</Int32>")),
        check="u: its size n is of type Int32, expected UInt64",
    ),
    Odd(
        "size that is a parameter",
        "sizes",
        "3.0",
        attribute("n", "causality", "parameter"),
        check="y: its size n is a fixed parameter, expected",
    ),
    Odd(
        "build description of another",
        "types",
        "3.0",
        files=_sources("3.0", "other"),
        check="modelIdentifier other, expected types",
    ),
    Odd(
        "build description of another in FMI 2",
        "types",
        "2.0",
        files=_sources("3.0", "other"),
        check="modelIdentifier other, expected types",
    ),
    Odd(
        "start of another value",
        "types",
        "3.0",
        attribute("p_Int32", "start", "9"),
        check="p_Int32 starts at [100], but the XML says [9]",
    ),
    Odd(
        "start of a Boolean",
        "types",
        "3.0",
        attribute("p_Boolean", "start", "0"),
        check="p_Boolean starts at [True], but the XML says [False]",
    ),
    Odd(
        "start of an enumeration",
        "types",
        "3.0",
        attribute("phase", "start", "5"),
        check="phase starts at [2], but the XML says [5]",
    ),
    Odd(
        "start of a text",
        "types",
        "3.0",
        sub('value="three"', 'value="drei"'),
        check="words starts at ['one', 'three'], but the XML says ['one', 'drei']",
    ),
    Odd(
        "start of a text of FMI 2",
        "types",
        "2.0",
        sub('start="three"', 'start="drei"'),
        check="words[2] starts at ['three'], but the XML says ['drei']",
    ),
    Odd(
        "start of bytes",
        "types",
        "3.0",
        sub('value="00ff10"', 'value="00FF11"'),
        check="blob starts at ['00ff10'], but the XML says ['00ff11']",
    ),
    Odd(
        "start of an array",
        "sizes",
        "3.0",
        attribute("u", "start", "1 2 4"),
        check="u starts at [1.0, 2.0, 3.0], but the XML says [1.0, 2.0, 4.0]",
    ),
    Odd(
        "start below min",
        "types",
        "3.0",
        attribute("p_Int32", "min", "101"),
        check="p_Int32: start 100 is below min 101",
    ),
    Odd(
        "start below min UInt8",
        "types",
        "3.0",
        attribute("p_UInt8", "min", "101"),
        check="p_UInt8: start 100 is below min 101",
    ),
    Odd("initial unknown missing", "sizes", "3.0", sub("<InitialUnknown [^>]*/>", ""), check="InitialUnknowns"),
    Odd("output missing", "sizes", "3.0", sub("<Output [^>]*/>", ""), check="Outputs"),
    Odd(
        "name of no grammar",
        "types",
        "3.0",
        both(
            attribute("q_Int8", "name", "1 q"),
            sub("generationTool", 'variableNamingConvention="structured" generationTool'),
        ),
        check="is not a legal variable name",
    ),
]
REFUSED = [
    Odd("the tool that made it", "tool", "2.0", run="it needs the tool that made it", note=True),
    Odd("alias of the same name", "sizes", "3.0", last("total", '<Alias name="y"/>'), check='"y"'),
    Odd(
        "display unit of an alias", "sizes", "3.0", last("total", '<Alias name="sum" displayUnit="gon"/>'), check="gon"
    ),
    Odd("unit nobody defines", "types", "3.0", attribute("p_Float64", "unit", "furlong"), run="furlong"),
    Odd(
        "no size",
        "sizes",
        "3.0",
        sub(r'<Dimension valueReference="\d+"', '<Dimension valueReference="77"'),
        run="Dimension refers to the value reference 77, which no variable has",
    ),
    Odd(
        "size without a value",
        "sizes",
        "3.0",
        attribute("n", "start", None),
        run="its size n starts at nothing, expected a whole number",
    ),
    Odd(
        "size that is negative",
        "sizes",
        "3.0",
        both(sub("<UInt64( name=.n.)", r"<Int32\1"), sub("</UInt64>", "</Int32>"), attribute("n", "start", "-3")),
        run="its size n starts at -3, expected a whole number",
    ),
    Odd(
        "no such clock",
        "clocks",
        "3.0",
        attribute("u", "clocks", "777"),
        run="clocks refers to the value reference 777, which no variable has",
    ),
    Odd(
        "a clock that is none",
        "clocks",
        "3.0",
        attribute("u", "clocks", "1000"),
        run="clocks refers to time, which is no clock",
    ),
    Odd(
        "no such output",
        "sizes",
        "3.0",
        sub(r'<Output valueReference="\d+"', '<Output valueReference="777"'),
        run="no variable has the value reference 777",
    ),
    Odd(
        "no such output of FMI 2",
        "types",
        "2.0",
        sub(r'<Unknown index="\d+"', '<Unknown index="777"'),
        run="no variable has the index 777",
    ),
    Odd(
        "no such dependency",
        "types",
        "3.0",
        sub(r'dependencies="\d+"', 'dependencies="777"'),
        run="no variable has the value reference 777",
    ),
    Odd("no such type", "types", "3.0", attribute("p_Float64", "declaredType", "Ghost"), run="Ghost"),
    Odd("no such derivative", "types", "3.0", attribute("q_Float64", "derivative", "777"), run="777"),
    Odd("two starts of three", "sizes", "3.0", attribute("u", "start", "1 2"), run="u"),
    Odd("start that is no number", "types", "3.0", attribute("p_Float64", "start", "many"), run="many"),
    Odd("start that is no Boolean", "types", "3.0", attribute("p_Boolean", "start", "yes"), run="yes"),
    Odd("start beyond the type", "types", "3.0", attribute("u_Int8", "start", "300"), run="300"),
    Odd("start of an input missing", "types", "3.0", attribute("u_Float64", "start", None), run="u_Float64"),
    Odd(
        "start of an input missing in FMI 2",
        "types",
        "2.0",
        sub('(name="u_Float64".*?)start="7"', r"\1"),
        run="u_Float64",
    ),
    Odd("bytes that are none", "types", "3.0", sub('value="00ff10"', 'value="00f"'), run="00f"),
    Odd("name twice", "types", "3.0", attribute("q_Int8", "name", "q_Int16"), run="q_Int16"),
    Odd(
        "reference twice",
        "types",
        "3.0",
        sub(r'(name="q_Int8" valueReference=)"\d+"', r'\1"1"'),
        run="no variable has the value reference",
    ),
    Odd("causality nobody knows", "types", "3.0", attribute("q_Int8", "causality", "outcome"), run="outcome"),
    Odd(
        "causality that does not fit",
        "types",
        "3.0",
        attribute("p_Float64", "variability", "continuous"),
        run="p_Float64",
    ),
    Odd(
        "event mode not declared",
        "latch",
        "3.0",
        sub('hasEventMode="true"', ""),
        run="needs event mode",
        check="cannot be instantiated",
    ),
    Odd(
        "no interface",
        "types",
        "3.0",
        sub("<CoSimulation [^>]*/>", ""),
        run="has neither a co-simulation nor a model-exchange interface",
    ),
    Odd(
        "scheduled execution only",
        "types",
        "3.0",
        sub("<CoSimulation [^>]*/>", '<ScheduledExecution modelIdentifier="types"/>'),
        run="scheduled execution only",
        note=True,
    ),
    Odd("FMI 1", "types", "2.0", sub('fmiVersion="2.0"', 'fmiVersion="1.0"'), run="1.0"),
    Odd("FMI 4", "types", "3.0", sub('fmiVersion="3.0"', 'fmiVersion="4.0"'), run="4.0"),
    Odd("version missing", "types", "3.0", sub('fmiVersion="3.0"', ""), run="FMI None"),
    Odd("not well-formed", "types", "3.0", lambda xml: xml[:300], run="well-formed"),
    Odd("document type", "types", "3.0", lambda xml: xml.replace("?>", "?><!DOCTYPE x>", 1), run="document type"),
    Odd("no description", "types", "3.0", lambda xml: None, run="modelDescription.xml"),
    Odd(
        "a stop before the start",
        "types",
        "3.0",
        experiment(startTime="1", stopTime="0.5"),
        run="step = -0.0005 s: expected a positive time",
    ),
    Odd(
        "a stop at the start",
        "types",
        "3.0",
        experiment(startTime="1", stopTime="1"),
        run="step = 0.0 s: expected a positive time",
    ),
    Odd(
        "a step of none",
        "types",
        "3.0",
        experiment(stopTime="1", stepSize="0"),
        run="step = 0.0 s: expected a positive time",
    ),
    Odd("a negative step", "types", "3.0", experiment(stopTime="1", stepSize="-0.1"), run="step"),
    Odd(
        "a step too long",
        "types",
        "3.0",
        experiment(stopTime="1", stepSize="2"),
        run="takes no shorter last one",
        note=True,
    ),
    Odd("a stop that is infinite", "types", "3.0", experiment(stopTime="INF"), run="stop_time = inf s is not finite"),
    Odd(
        "library of another name",
        "types",
        "3.0",
        path=lambda p: p.replace("types", "kinds"),
        run="has no binary for this platform",
        check="types.so is missing",
    ),
    Odd(
        "library of another folder",
        "types",
        "3.0",
        path=lambda p: p.replace(HERE3, HERE2),
        run="has no binary for this platform",
        check="is a platform of FMI 2",
    ),
    Odd(
        "library for another system",
        "types",
        "3.0",
        path=lambda p: p.replace(HERE3, "x86_64-windows").replace(".so", ".dll"),
        run="has no binary for this platform",
        check="format ELF, expected PE",
    ),
    Odd(
        "library for another processor",
        "types",
        "3.0",
        library=for_machine(183),
        run="cannot instantiate",
        check="is for AARCH64, expected",
    ),
    Odd(
        "library for another processor in FMI 2",
        "types",
        "2.0",
        library=for_machine(183),
        run="cannot instantiate",
        check="is for AARCH64, expected",
    ),
    Odd(
        "library that is none",
        "types",
        "3.0",
        library=lambda content: b"nothing",
        run="cannot instantiate",
        check="is no shared library",
    ),
    Odd(
        "no library",
        "types",
        "3.0",
        path=lambda p: f"extra/{Path(p).name}",
        run="has no binary for this platform",
        check="neither binaries nor sources",
    ),
    Odd("clocks without event mode", "clocks", "3.0", sub('hasEventMode="true"', ""), run="clocks", note=True),
    Odd("clock without an interval", "rigid_clock", "3.0", attribute("steady", "intervalDecimal", None), run=""),
    Odd("clock with a negative interval", "rigid_clock", "3.0", attribute("steady", "intervalDecimal", "-1"), run=""),
    Odd("clock with a NaN", "rigid_clock", "3.0", attribute("steady", "intervalDecimal", "NaN"), run=""),
    Odd("too large", "sizes", "3.0", attribute("n", "start", "2000000"), run="2,000,000 elements, more than 1,000,000"),
]
ALL = [*GOOD, *STRICTER, *REFUSED]
