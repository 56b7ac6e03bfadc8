"""`adcs new`: a component of one's own to begin with, in a folder of one's own."""

from __future__ import annotations

import re
from dataclasses import asdict
from pathlib import Path
from string import Template
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from adcs.cli.beginnings import BEGINNINGS
from adcs.cli.command import command
from fmus.catalog import FILE_NAME, Kind, struct_name
from fmus.errors import AdcsError
from orchestration.process.writing import make_folder

app = command("new", "adcs new controller rate_damper", "adcs new sensor my_gyro --to sensors")

_HEADER = Template("""\
/// # $title
///
/// What it computes, and where that is from. Equations stand between dollar signs:
///
/// $equation
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct $name {
    static constexpr auto kind = "$kind";
    static constexpr auto summary = "$summary";
    static constexpr auto reference = "";  // author, title, equation

    // The values given here are the start values.
$struct};

}  // namespace adcs
""")

_TEST = Template('''\
"""The law of $name, computed a second time."""

from pathlib import Path

import numpy as np

import adcs

HEADER = Path(__file__).with_name("$file.hpp")


def test_nothing_is_wrong_with_its_fmus():
    assert adcs.check(HEADER) == []


def run(values):
    system = adcs.System("alone", stop_time="1s", step="500ms")
    system.add("law", HEADER, values)
    return adcs.run(system)


def test_it_computes_what_it_should():
$test''')

_README = Template("""\
# $title

An FMI component of the kind "$kind".

    adcs build $file.hpp     # $name.fmu and $name.fmi3.fmu, for any tool; --all-platforms for others than this
    adcs check $file.hpp     # what is wrong with them
    python -m pytest         # the law, computed a second time

`adcs info $file.hpp` lists its variables. In Python it is a component like any other, built anew when the header has
changed: `System.add("law", "$file.hpp")`.
""")


@app.default
def new(
    kind: Annotated[Kind, Parameter(help="What it is: the icon, and where it stands in lists.")],
    name: Annotated[str, Parameter(help="Its file's name, my_law; the component is called MyLaw.")],
    /,
    *,
    to: Annotated[Path, Parameter(help="The folder that is written to.")] = Path(),
) -> None:
    """Write a component of your own to begin with: a header, a test, a README; nothing that is there is replaced."""
    if not re.fullmatch(FILE_NAME, name):
        raise AdcsError(f"{name!r} is no name for a file: small letters, digits and underscores, as in my_law")
    title = name.replace("_", " ").capitalize()
    law = BEGINNINGS[kind]
    words = {"file": name, "name": struct_name(name), "kind": kind, "title": title, **asdict(law)}
    words["equation"] = f"$${law.equation}$$"
    files = {f"{name}.hpp": _HEADER, f"test_{name}.py": _TEST, "README.md": _README}
    make_folder(to, f"--to {to}")
    if (to / "README.md").exists():  # of something else, or of another component
        del files["README.md"]
    for file in files:
        if (to / file).exists():
            raise AdcsError(f"{to / file} is there already: take another name, or another folder by --to")
    for file, template in files.items():
        (to / file).write_text(template.substitute(words), encoding="utf-8")
    console = Console()
    for file in files:
        console.print(str(to / file), markup=False, highlight=False, soft_wrap=True)
    console.print(f"next: adcs build {to / name}.hpp", markup=False, highlight=False, soft_wrap=True)
