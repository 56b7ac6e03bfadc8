"""Headers in few files, without comments: what they compile to is the same."""

import json
import re
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest

import fmus
from fmus.amalgamation import amalgamated, stripped
from fmus.build import ADAPTOR
from fmus.eigen import UNUSED
from fmus.paths import BUILD, EIGEN, SOURCES
from fmus.toolchain import compile_step, host, link_step, run_steps

LARGE = """\
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct Large {
    static constexpr auto kind = "controller";
    static constexpr auto summary = "A product with a large matrix";
    static constexpr auto reference = "";

    T in = 0.5;
    T out = 0.0;

    template <class V>
    void declare(V& v) {
        v.input("in", in, unit::one, "number");
        v.output("out", out, unit::one, "sum of a product");
    }

    void outputs() {
        const Eigen::Matrix<T, 12, 12> m = Eigen::Matrix<T, 12, 12>::Constant(in);
        const Eigen::Matrix<T, 12, 1> product = m * m.col(0);
        out = product.reverse().sum();
    }
};

}  // namespace adcs
"""


@pytest.mark.parametrize(
    ("code", "left"),
    [
        ("a = b; // c\n", "a = b;\n"),
        ("a = /* b */c;\n", "a =  c;\n"),
        ("   int   x;\n\n\n\tint y;\n", "int x;\nint y;\n"),
        ('s = "// no \\" /* comment */";\n', 's = "// no \\" /* comment */";\n'),
        ("c = '\"'; // \"\n", "c = '\"';\n"),
        ("n = 1'000'000; // '\n", "n = 1'000'000;\n"),
        ("u = u8'/'; v = L'\\''; /**/w = 'x';\n", "u = u8'/'; v = L'\\'';  w = 'x';\n"),
        ('r = R"x(  // )" \n\n  /* )x"; // gone\n', 'r = R"x(  // )" \n\n  /* )x";\n'),
        ("// goes on \\\n here too\nint x;\n", "int x;\n"),
        ("#define A \\\n  b /* c */\\\n\nint x;\n", "#define A \\\nb  \\\n\nint x;\n"),
        ("/* Copyright (C) 2008\n   Someone */\nint x;\n", "/* Copyright (C) 2008\n   Someone */\nint x;\n"),
        ("// Copyright\n//\n// mine\nint x; // yours\n", "// Copyright\n//\n// mine\nint x;\n"),
        ("a = b // c\n / d;\n", "a = b\n/ d;\n"),
    ],
)
def test_only_comments_and_blanks_go(code, left):
    assert stripped(code) == left


def test_each_header_goes_where_it_is_included(tmp_path):
    files = {
        "Lib/Core": '#include <cmath>\n#include "src/a.h"\n#include "src/a.h"\n#include "src/off.h"\n',
        "Lib/More": '#include "Core"\n#include "src/plain.h"\n#include "src/plain.h"\n#include "src/twice.h"\n',
        "Lib/src/a.h": '#ifndef A_H\n#define A_H\n#  include "../src/b.h"\nint a;\n#endif\n',
        "Lib/src/b.h": '#ifndef B_H\n#define B_H\n#include "a.h"\nint b;\n#endif\n',
        "Lib/src/plain.h": "int again();\n#ifndef SIZE\n#define SIZE 3\n#endif\n",
        "Lib/src/twice.h": '#ifndef SECOND\n#define SECOND\n#include "twice.h"\n#endif\n',
    }
    for name, code in files.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(code)
    made = amalgamated([tmp_path / name for name in files], tmp_path)
    plain = files["Lib/src/plain.h"]
    assert {name: content.decode() for name, content in made.items()} == {
        "Lib/Core": "#include <cmath>\n#ifndef A_H\n#define A_H\n#ifndef B_H\n#define B_H\nint b;\n#endif\n"
        'int a;\n#endif\n#include "src/off.h"\n',
        "Lib/More": f'#include "Core"\n{2 * plain}#include "src/twice.h"\n',
        "Lib/src/twice.h": files["Lib/src/twice.h"],
    }


def test_what_is_left_out_goes_nowhere(tmp_path):
    files = {"Lib/Core": '#include "src/a.h"\n#include "src/b.h"\n', "Lib/src/a.h": '#include "b.h"\nint a;\n'}
    files |= {"Lib/src/b.h": "int b;\n"}
    for name, code in files.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(code)
    made = amalgamated([tmp_path / name for name in files], tmp_path, without=frozenset({tmp_path / "Lib/src/b.h"}))
    assert made == {"Lib/Core": b"int a;\n"}


def test_each_header_that_is_left_out_is_one_of_eigen():
    assert [header.name for header in sorted(UNUSED) if not header.is_file()] == []


def test_an_fmu_of_a_header_from_elsewhere_may_use_all_of_eigen_core(tmp_path):
    """What no component of the project uses: a large matrix, and its elements in reverse order."""
    (tmp_path / "large.hpp").write_text(LARGE)
    fmu, _ = fmus.build([str(tmp_path / "large.hpp")])
    assert binary_of_sources(fmu)
    assert b"class Reverse" in (tmp_path / "sources" / "Eigen" / "Core").read_bytes()


def test_an_fmu_is_small_and_names_who_wrote_what_is_in_it(built):
    with zipfile.ZipFile(built / "RigidBody.fmu") as archive:
        eigen = [name for name in archive.namelist() if name.startswith("sources/Eigen/")]
        text = "".join(archive.read(name).decode() for name in eigen)
    assert (built / "RigidBody.fmu").stat().st_size < 350_000
    assert (built / "RigidBody.fmi3.fmu").stat().st_size < 350_000
    assert len(eigen) < 10
    record = json.loads((BUILD / "objects" / host().name / "RigidBody.o.json").read_text())
    authors = {
        line.strip(" /*\n")
        for path in record["inputs"]
        if Path(path).is_relative_to(EIGEN) and Path(path) not in UNUSED
        for line in Path(path).read_text(encoding="utf-8").splitlines()
        if re.match(r"\W*Copyright \(C\)", line, re.IGNORECASE)
    }
    assert len(authors) > 30
    assert [author for author in authors if author not in text] == []


@pytest.mark.parametrize("component", ["RigidBody", "StarTracker"])
def test_the_sources_in_an_fmu_make_the_same_binary(built, tmp_path, component):
    fmus.build([component], dist=tmp_path)
    assert binary_of_sources(tmp_path / f"{component}.fmu") == (BUILD / binary(component)).read_bytes()


def binary(component):
    """Where the binary of a component for this machine is, relative to where it was built."""
    return Path("binaries") / host().name / (component + host().suffix)


def binary_of_sources(fmu):
    """Compile the model among the sources in an FMU, with nothing from elsewhere, and link it with the adaptor."""
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(fmu.parent, [name for name in archive.namelist() if name.startswith("sources/")])
    sources, model = fmu.parent / "sources", fmu.parent / "model.o"
    step = compile_step(sources / "model.cpp", model, host(), f"-I{sources}")
    elsewhere = (f"-isystem{EIGEN}", f"-I{SOURCES}")
    run_steps([replace(step, command=tuple(part for part in step.command if part not in elsewhere))])
    adaptor = [BUILD / "objects" / host().name / f"{name}.o" for name in ADAPTOR]
    link = link_step([model, *adaptor], fmu.parent / binary(fmu.stem), host())
    run_steps([link])
    return link.output.read_bytes()
